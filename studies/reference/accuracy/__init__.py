"""Contacts of every kind with a truth, against which error estimates and plans are judged."""
