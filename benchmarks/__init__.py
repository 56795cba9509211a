"""Benchmarks of speed, beside bare transforms and other programs, in the form of asv."""
