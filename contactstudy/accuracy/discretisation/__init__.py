"""Errors by the cells: at the edges of the contact, within it, by heights inside the cells, and from coarser cells."""
