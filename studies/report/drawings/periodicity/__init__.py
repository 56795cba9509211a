"""Drawings of the studies of periodicity, padding and discretisation."""
