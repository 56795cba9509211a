"""Drawings of the studies of time, memory and accuracy."""
