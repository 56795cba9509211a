"""Errors due to the cells: at the edges of the contact, within it, from heights inside them, and from coarser cells."""
