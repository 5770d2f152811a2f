"""A place out of the user's own file: its floor, the robot's way over it, and the discs beside that way."""
