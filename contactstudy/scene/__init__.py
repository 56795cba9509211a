"""What a user names of a contact, and the scene that makes a problem of it. May import `problem` and below."""
