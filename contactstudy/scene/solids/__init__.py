"""Bodies of a scene: elastic, coated, viscoelastic and elastic-plastic half-spaces."""
