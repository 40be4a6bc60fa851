"""Table of stiffness and friction arms of a mesh over its cycle, for the compiled step.

Both depend only on the position of contact, so the step needs just a table over one cycle.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ema_bench_replay.errors import InputError

from .contact import Mesh
from .geometry import Gearing
from .stiffness import constant_stiffness, pair_stiffness, printed_series

POINTS = 256
SAMPLES = 16  # for each point of the table, even
STIFFNESS_KINDS = ("alternating", "fourier", "constant")
ENTERING, AHEAD, FIRST_ARM, SECOND_ARM = range(4)

Array = NDArray[np.float64]


def mesh_table(gearing: Gearing, stiffness: str = "alternating", youngs_modulus_ratio: float = 1.0) -> Array:
    """Array (3 meshes, POINTS + 1, 4) over one cycle u from 0 to 1, to be interpolated linearly; the last is the first.

    Columns: stiffness [N/m] of the pair at u base pitches from first contact, and of the pair one base pitch ahead of
    it (0 once it has separated); then the arms of friction [m] about the first and the second wheel's axis,

        B_j = sum over the pairs of (stiffness / stiffness of all) * sgn(s - s_C) * rho_j,

    s_C being the pitch point, where sliding reverses. With them the sliding speeds weighted by load are
    V_s = (w_s - w_c) B1 - W B2 at the sun, W B1 - w_c B2 at the fixed ring and W B1 - (w_c - w_o) B2 at the output ring
    (W: planet relative to carrier), and friction's generalised force is -mu |F| sgn(V) dV/dw. It always dissipates.
    The thesis's eqs 3.40 to 3.47 subtract w_c from a speed that is already relative, omit the ring in 3.41 and give the
    planet the sun's arm; friction then adds power.

    ``stiffness`` is alternating (Kuang and Yang's pairs), fourier (the thesis's series) or constant; the last two put
    all of it into the first column. The arms are weighted by Kuang and Yang's stiffness in all three.

    Raises InputError for any other kind of stiffness, and for a modulus ratio that is not positive.
    """
    if stiffness not in STIFFNESS_KINDS:
        raise InputError(f"mesh stiffness {stiffness!r}: choose {', '.join(STIFFNESS_KINDS)}")
    if not 0.0 < youngs_modulus_ratio < np.inf:
        raise InputError(f"youngs_modulus_ratio is {youngs_modulus_ratio!r}: give a positive number")
    table = np.empty((len(gearing.meshes), POINTS + 1, 4))
    for columns, mesh in zip(table, gearing.meshes, strict=True):
        columns[:] = _cycle_of_pairs(gearing, mesh, youngs_modulus_ratio)
        if stiffness != "alternating":
            constant = constant_stiffness(gearing, mesh, youngs_modulus_ratio)
            cycle = np.arange(POINTS + 1) % POINTS / POINTS
            columns[:, ENTERING] = constant if stiffness == "constant" else printed_series(constant, cycle)
            columns[:, AHEAD] = 0.0
    return table


def _cycle_of_pairs(gearing: Gearing, mesh: Mesh, youngs_modulus_ratio: float) -> Array:
    """One mesh's columns, (POINTS + 1, 4), of alternating pairs.

    Each point holds the mean over the grid step around it: so means over the cycle are correct, wherever between points
    a pair enters, separates or passes the pitch point.
    """
    u = (np.arange(POINTS * SAMPLES) + 0.5 * (1 - SAMPLES)) / (POINTS * SAMPLES) % 1.0
    position = mesh.base_pitch * (u[:, np.newaxis] + np.arange(2))  # (samples, pairs)
    sample = mesh.base_pitch / (POINTS * SAMPLES)
    touching = np.clip((mesh.contact_length - position) / sample + 0.5, 0.0, 1.0)
    way = np.clip(2.0 * (position - mesh.approach) / sample, -1.0, 1.0)
    within = np.minimum(position, mesh.contact_length)
    pairs = touching * pair_stiffness(gearing, mesh, within, youngs_modulus_ratio)
    signed_share = way * pairs / pairs.sum(axis=1, keepdims=True)
    arms = [(signed_share * arm).sum(axis=1) for arm in mesh.curvature_radii(position)]
    points = np.column_stack([pairs, *arms]).reshape(POINTS, SAMPLES, 4).mean(axis=1)
    return np.concatenate([points, points[:1]])


def mean_stiffness(table: Array) -> Array:
    """Mean stiffness [N/m] of the three kinds of mesh over their cycle."""
    return table[:, :-1, [ENTERING, AHEAD]].sum(axis=2).mean(axis=1)


def mean_arms(table: Array) -> Array:
    """Mean arms of friction [m] of the three kinds of mesh (3, 2) over their cycle."""
    return table[:, :-1, [FIRST_ARM, SECOND_ARM]].mean(axis=1)
