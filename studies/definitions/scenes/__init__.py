"""Studies of particular kinds of scenes."""
