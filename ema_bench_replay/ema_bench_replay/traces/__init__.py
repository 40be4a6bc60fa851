"""Text traces: the drive's CSV, through an import map, and back."""
