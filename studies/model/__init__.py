"""What all of the study layer speaks of: axes, cases, studies, outcomes, findings. Imports nothing else of `studies`."""
