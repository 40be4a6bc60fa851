"""How the functions of a step are compiled: into their caller.

A step is some hundred operations; a call that hands over its constants and state through memory would double its time.
"""

from numba import njit

compiled = njit(error_model="numpy", forceinline=True, fastmath={"contract"})
"""Products and sums fuse where the processor can, whoever calls."""

inlined = njit(error_model="numpy", inline="always")
"""Part of the caller's own text: products and sums fuse where the caller's do."""
