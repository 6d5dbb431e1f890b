"""The counter where Python meets kernels; nothing outside imports any kernel but these, and `layout`."""
