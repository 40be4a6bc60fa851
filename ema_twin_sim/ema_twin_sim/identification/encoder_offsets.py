"""Offsets of the encoders' rows: compiled, since every prediction of a search needs them removed."""

from numba import float64, int64, njit, void

from ..plant.signatures import RANGES


@njit(error_model="numpy")
def _at_place(values, place):
    """The value that sorting would put at index ``place``; reorders ``values`` (n,). Hoare's selection."""
    low, high = 0, values.shape[0] - 1
    while low < high:
        pivot = values[place]
        left, right = low, high
        while left <= right:
            while values[left] < pivot:
                left += 1
            while pivot < values[right]:
                right -= 1
            if left <= right:
                values[left], values[right] = values[right], values[left]
                left += 1
                right -= 1
        if right < place:
            low = left
        if place < left:
            high = right
    return values[place]


@njit(error_model="numpy")
def _median(values):
    """Median of one value or more (n,); reorders them. Numba's own loads a library of linear algebra at each start."""
    middle = values.shape[0] // 2
    upper = _at_place(values, middle)
    if values.shape[0] % 2:
        return upper
    lower = values[0]
    for k in range(1, middle):
        lower = max(lower, values[k])
    return 0.5 * (lower + upper)


@njit(
    void(float64[::1], RANGES, int64, float64[::1], float64[::1]),
    cache=True,
    nogil=True,
    error_model="numpy",
)
def remove_offsets(rows, pieces, size, noise, scale):
    """Subtract from each of the ``pieces`` (p, 2) of encoder ``rows`` (m,) its offset, robustly, in place.

    Encoder rows follow ``size`` torque rows; ``noise`` (m - size,) [rad] is theirs, and rows are in units of it. The
    offset is the median [rad], then the mean weighted by ``scale`` (m,), where outliers begin.
    """
    for k in range(pieces.shape[0]):
        first, end = pieces[k]
        part, sigma = rows[first:end], noise[first - size : end - size]
        median = _median(part * sigma)
        weighted = total = 0.0
        for row in range(end - first):
            part[row] -= median / sigma[row]
            weight = 1.0 / (1.0 + (part[row] / scale[first + row]) ** 2)
            weighted += weight * part[row] / sigma[row]
            total += weight / sigma[row] ** 2
        for row in range(end - first):
            part[row] -= weighted / total / sigma[row]


@njit(
    void(float64[::1], RANGES, int64, float64[::1], float64[::1]),
    cache=True,
    nogil=True,
    error_model="numpy",
)
def remove_means(rows, pieces, size, noise, weights):
    """Subtract from each of the ``pieces`` (p, 2) of encoder ``rows`` (m,) its mean weighted by ``weights`` (m,)²."""
    for k in range(pieces.shape[0]):
        first, end = pieces[k]
        weighted = total = 0.0
        for row in range(first, end):
            weight, sigma = weights[row] ** 2, noise[row - size]
            weighted += weight * rows[row] / sigma
            total += weight / sigma**2
        if total > 0.0:  # otherwise only the torque counts
            for row in range(first, end):
                rows[row] -= weighted / total / noise[row - size]
