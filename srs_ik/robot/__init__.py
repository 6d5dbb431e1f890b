"""From whatever names or describes a robot to the seven axes of a limb."""
