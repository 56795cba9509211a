"""What is stored: files replaced as a whole, digests of values, the version of this program."""
