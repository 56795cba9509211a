"""What a user names: load, solids, shapes, outputs; a scene makes a problem of them. May import `problem` and below."""
