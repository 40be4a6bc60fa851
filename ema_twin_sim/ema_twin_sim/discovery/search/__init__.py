"""The search: effects are added, removed and swapped until none is worth its complexity penalty."""
