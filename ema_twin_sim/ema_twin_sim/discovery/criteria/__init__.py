"""Criteria: what an effect must gain to be named, and what an explanation must be to be believed."""
