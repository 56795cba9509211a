"""Integration in time: the method, its steps and their length, checkpoints."""
