"""Drawings of the studies of physical effects."""
