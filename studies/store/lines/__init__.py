"""What the lines of a journal are made of."""
