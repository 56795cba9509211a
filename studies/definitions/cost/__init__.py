"""Studies of time, memory and their trade against accuracy."""
