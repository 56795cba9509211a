"""Where fields are held and worked on: cores of this machine, or whatever an array library of the standard uses."""
