"""Figures, findings, tables, and the page made of them. May import everything but `cli`."""
