"""Studies of periodicity, padding and discretisation."""
