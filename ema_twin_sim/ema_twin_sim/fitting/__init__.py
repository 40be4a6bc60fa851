"""Fitting: the numbers of a given model, with standard errors, from recordings of its machine."""
