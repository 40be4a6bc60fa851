"""Fitting: the parameters of a given model, with standard errors, from recordings of its machine.

After ``measured.scales`` a machine is expressed in its own units: s, rad/s, N m and A in this package refer to a
machine scaled to the reference bench. A threshold here is therefore a fraction of each machine's own size and speed.
"""
