"""What a study's file holds: which points, and their numbers in one Dataset."""
