"""Scene files: keys, units, materials, and writing."""
