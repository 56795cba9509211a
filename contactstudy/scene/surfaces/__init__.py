"""Measured surfaces: reading, missing points, trend, seam, resampling. May import `scene.shapes` and `domain`."""
