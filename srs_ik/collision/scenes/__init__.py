"""What stands around an arm: scenes, their objects, and where these come from."""
