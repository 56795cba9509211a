"""Studies made from a scene and the fields of it that are varied. May import `model` and the core."""
