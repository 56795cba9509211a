"""The study layer: drives contactstudy, and is never imported by it."""
