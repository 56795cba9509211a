"""One bonded layer on a half-space: frequency response, image below the surface, and the rest."""
