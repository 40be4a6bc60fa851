"""Fleets that run to failure: how early wear is named, how often a healthy unit is called off, what is left."""
