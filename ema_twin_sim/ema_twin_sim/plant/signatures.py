"""Argument types of the compiled loops: records of ``layout.py``, stamps, effects."""

from numba import float64, from_dtype, int64, types

from .layout import PLANT, STATE
from .operating_point import PARAMETER_SLOTS
from .planetary.layout import TRAIN, TRAIN_STATE
from .switching.layout import WINDING, WINDING_STATE

assert PARAMETER_SLOTS == 4  # evaluate.py writes them out

PLANTS = from_dtype(PLANT)[::1]
STATES = from_dtype(STATE)[::1]
STAMPS = types.Array(int64, 1, "C", readonly=True)
TABLE = float64[:, ::1]
"""Rows of samples of a bench, a twin, or a measured motion."""
INDICES = int64[::1]
RANGES = int64[:, ::1]
"""First and end of ranges of rows."""
EFFECTS = types.Tuple((int64[::1], int64[::1], float64[:, ::1]))
"""Type of ``layout.Effects``."""
FINE = types.Tuple(
    (
        from_dtype(WINDING)[::1],
        from_dtype(WINDING_STATE)[::1],
        from_dtype(TRAIN)[::1],
        from_dtype(TRAIN_STATE)[::1],
        float64[::1],
        float64[:, :, ::1],
        float64[::1],
    )
)
"""Type of ``layout.Fine`` as a plain tuple, which is passed in half the time."""
