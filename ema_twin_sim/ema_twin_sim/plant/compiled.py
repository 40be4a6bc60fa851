"""Decorators that compile the functions of a step into their caller.

A step is some hundred operations; a call that passes constants and state through memory would double its time.
"""

from numba import njit

compiled = njit(error_model="numpy", forceinline=True, fastmath={"contract"})
"""Products and sums are fused if the processor can, in any caller."""

inlined = njit(error_model="numpy", inline="always")
"""Inlined in the caller's source: products and sums are fused only if the caller's are."""
