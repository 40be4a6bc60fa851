"""What to record next, and what that recording would show."""
