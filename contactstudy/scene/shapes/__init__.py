"""Shapes of the undeformed gap; the shapes of a scene add up. May import `domain` and `analytic`."""
