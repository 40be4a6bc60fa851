"""The search: effects added, dropped and swapped, until none is worth its price."""
