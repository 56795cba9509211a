"""The passes of an iteration: the pressure that closes the gap, the trial towards it, the line to the trial."""
