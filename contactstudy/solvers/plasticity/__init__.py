"""Contact and plastic strain, found together. May import `solve` and below."""
