"""Terms of the study layer: axes, cases, studies, outcomes, findings. Imports nothing else of `studies`."""
