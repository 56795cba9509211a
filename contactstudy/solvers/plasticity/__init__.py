"""Contact and plastic strain, solved together."""
