"""What studies refer to: the smooth line contact with its errors, and paddings by name. May import `model`."""
