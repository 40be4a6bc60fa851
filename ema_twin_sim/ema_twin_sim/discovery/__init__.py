"""Discovery: which physical effect a model lacks, how sure that is, and what the data cannot tell.

Behind ``measured.scales`` a machine is told in its own units: what is called s, rad/s, N m or A in this package is that
of the reference bench, so that a number here is a share of each machine's own.
"""
