"""The search for the best path through whole poses: strips of postures, ways through them, and what is near one."""
