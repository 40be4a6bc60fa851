"""Discovery: which physical effect a model lacks, how certain that is, and what the data cannot decide.

After ``measured.scales`` a machine is expressed in its own units: s, rad/s, N m and A in this package refer to a
machine scaled to the reference bench. A threshold here is therefore a fraction of each machine's own size and speed.
"""
