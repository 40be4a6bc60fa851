"""Fitting: the numbers of a given model, with standard errors, from recordings of its machine.

Behind ``measured.scales`` a machine is told in its own units: what is called s, rad/s, N m or A in this package is that
of the reference bench, so that a number here is a share of each machine's own.
"""
