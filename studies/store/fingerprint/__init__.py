"""Fingerprints of code: modules, functions and study files that a number was computed with. May import `model`."""
