"""Identification: a model's free numbers, the equation error that tells them, its weighting, and its solution."""
