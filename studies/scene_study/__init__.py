"""Studies made from a scene and fields of it that are varied. Imports `model`, `advice.reference_error`, the core."""
