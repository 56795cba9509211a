"""State variables of bodies and interfaces: creep, wear, plastic strain, tangential traction."""
