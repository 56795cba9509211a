"""What each study sweeps and measures. Imports no drawing code."""
