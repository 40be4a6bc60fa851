"""What repeats with the position: the wave of one wavelength, as a phasor, and the search for that wavelength."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

FEWEST_CYCLES = 4  # minimum number of cycles of a wave in a stroke
_FINER = 4  # wavelengths tried within the width of a spectral line
_NEIGHBOURS = 10.0  # line widths on either side against which a line must stand out


def wave_phasor(strokes: Sequence[tuple[np.ndarray, np.ndarray]], wavelength: float) -> complex | None:
    """Phasor of the wave that strokes of (values (n,), position (n,)) share; None if they do not show it.

    It is fitted together with its second harmonic and a parabola for each stroke, so a stroke counts by what it tells.
    Its real and imaginary parts are the amplitudes of cosine and sine of 2π position / wavelength: the same wave has
    the same phasor in every run that counts its position from the same place. Units are those of the values.

    A stroke of little more than one wavelength looks like a parabola. So at least half of what its samples tell of a
    wave must be left beside that.
    """
    told, asked, samples = np.zeros((4, 4)), np.zeros(4), 0
    for values, position in strokes:
        columns = _columns(position, wavelength)
        waves = columns[:, 3:] - columns[:, :3] @ np.linalg.lstsq(columns[:, :3], columns[:, 3:], rcond=None)[0]
        told, asked, samples = told + waves.T @ waves, asked + waves.T @ values, samples + len(values)
    alone = 0.5 * samples  # the sum of squares of a cosine
    if not samples or np.linalg.eigvalsh(told)[0] < 0.5 * alone:
        return None
    found = np.linalg.solve(told, asked)
    return complex(found[0], found[1])


def beside_wave(values: np.ndarray, position: np.ndarray, wavelength: float) -> np.ndarray:
    """Residual of values (n,) or (n, k) after the fit of ``wave_phasor`` to one stroke; of a parabola for ``inf``."""
    columns = _columns(position, wavelength)
    return np.asarray(values - columns @ np.linalg.lstsq(columns, values, rcond=None)[0])


def _columns(position: np.ndarray, wavelength: float) -> np.ndarray:
    place = 2.0 * (position - position.mean()) / max(float(np.ptp(position)), 1e-12)
    parabola = [np.ones_like(place), place, place**2]
    if np.isinf(wavelength):
        return np.column_stack(parabola)
    angle = 2.0 * np.pi * position / wavelength
    waves = [function(order * angle) for order in (1, 2) for function in (np.cos, np.sin)]
    return np.column_stack([*parabola, *waves])


def found_wavelength(strokes: Sequence[tuple[np.ndarray, np.ndarray]]) -> float:
    """The wavelength that stands out most over its neighbours, from strokes of (values (n,), position (n,)); else NaN.

    Powers of all strokes are added, so positions may begin anywhere. The search goes from four cycles per stroke to the
    shortest wave that the samples resolve.
    """
    travel = float(np.median([np.ptp(position) for _, position in strokes]))
    samples = float(np.median([len(position) for _, position in strokes]))
    if not travel > 0.0 or samples < 4 * FEWEST_CYCLES:
        return np.nan
    cycles = np.arange(FEWEST_CYCLES, 0.5 * samples, 1.0 / _FINER)
    power = np.zeros(len(cycles))
    for values, position in strokes:
        rest = values - np.polyval(np.polyfit(position, values, 2), position)
        power += np.abs(np.exp(-2j * np.pi * np.outer(cycles / travel, position)) @ rest) ** 2 / max(rest @ rest, 1e-30)
    near = np.abs(cycles[:, None] - cycles[None, :])
    level = [float(np.median(power[(row > 2.0) & (row < _NEIGHBOURS)])) for row in near]
    return travel / float(cycles[int(np.argmax(power / np.maximum(level, 1e-30)))])
