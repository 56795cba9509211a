"""The error for input that cannot be used."""


class InvalidInput(ValueError):
    """Error for a value that cannot be used; the message names the field, the value and the remedy."""
