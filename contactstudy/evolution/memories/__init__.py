"""What bodies and interfaces keep from one instant to the next: creep, wear. May import `scene` and below."""
