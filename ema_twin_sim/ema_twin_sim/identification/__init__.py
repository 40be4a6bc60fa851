"""Identification: a model's free parameters, the equation error they are fitted to, its weighting and its solver."""
