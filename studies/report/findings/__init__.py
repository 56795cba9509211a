"""What stored studies show, in sentences and tables."""
