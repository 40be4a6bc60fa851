"""Servos of strangers: machines of any size, told in their owners' words, units and numbers."""
