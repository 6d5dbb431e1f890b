"""What callers give, checked: poses, joint angles, tasks."""
