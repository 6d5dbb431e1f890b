"""The meshes that robot files name: where they lie, what may be read of them, and what is in them."""
