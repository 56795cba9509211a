"""Loops over fields, compiled for processors and for GPUs."""
