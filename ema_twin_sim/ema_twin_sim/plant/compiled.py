"""How the functions of a step are compiled: into their caller, products and sums fused where the processor can.

A step is some hundred operations; a call that hands over its constants and state through memory would double its time.
"""

from numba import njit

compiled = njit(error_model="numpy", forceinline=True, fastmath={"contract"})
