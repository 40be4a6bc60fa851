"""Stiffness of the three kinds of mesh over their cycle: alternating pairs, the printed series, one constant."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from ema_twin_sim.plant.planetary.mesh_table import AHEAD, ENTERING, STIFFNESS_KINDS, mean_stiffness, mesh_table
from ema_twin_sim.plant.planetary.torsional_stiffness import torsional_stiffness

from .bench import GEARING, TABLE, YOUNGS_RATIO
from .number import Number
from .style import BLUE, GREY, ORANGE, sheet

MESHES = ("sun", "ring", "output")
LOOKS = {
    "alternating": ("Kuang and Yang's pairs, 3.48 to 3.51", BLUE, "-"),
    "fourier": ("series as printed, 3.55", ORANGE, "--"),
    "constant": ("constant, 3.61", GREY, ":"),
}


def curves() -> dict[str, np.ndarray]:
    """Stiffness (3 meshes, points) [N/um] over one cycle by kind of stiffness."""
    tables = {kind: mesh_table(GEARING, kind, YOUNGS_RATIO) for kind in STIFFNESS_KINDS}
    return {kind: 1e-6 * table[:, :-1, [ENTERING, AHEAD]].sum(axis=2) for kind, table in tables.items()}


def numbers() -> dict[str, Number]:
    """What the page quotes of it."""
    found = {f"stiffness_{mesh}": Number(1e-6 * k, 1) for mesh, k in zip(MESHES, mean_stiffness(TABLE), strict=True)}
    alternating, printed = curves()["alternating"], curves()["fourier"]
    fast, slow = torsional_stiffness(GEARING, TABLE)
    return found | {
        "stiffness_one_pair": Number(float(alternating[0].min()), 1),
        "stiffness_two_pairs": Number(float(alternating[0].max()), 1),
        "printed_lowest": Number(float(printed[0].min()), 1),
        "printed_highest": Number(float(printed[0].max()), 1),
        "two_pairs_share_sun": Number(100.0 * (GEARING.meshes[0].contact_ratio - 1.0)),
        "two_pairs_share_ring": Number(100.0 * (GEARING.meshes[1].contact_ratio - 1.0)),
        "stiffness_fast_shaft": Number(fast, 1),
        "stiffness_slow_shaft": Number(1e-3 * slow),
        **{f"contact_ratio_{name}": Number(m.contact_ratio, 3) for name, m in zip(MESHES, GEARING.meshes, strict=True)},
        "centre_distance": Number(1e3 * GEARING.centre_distance, 3),
        "module": Number(1e3 * GEARING.module, 3),
    }


def draw() -> Figure:
    """Three panels, one a mesh, two cycles each."""
    figure, axes = sheet(3, height=5.6, sharex=True, sharey=True)
    cycles = np.linspace(0.0, 2.0, 2 * len(curves()["constant"][0]), endpoint=False)
    titles = [f"{mesh.name}, contact ratio {mesh.contact_ratio:.2f}" for mesh in GEARING.meshes]
    for mesh, (axis, title) in enumerate(zip(axes, titles, strict=True)):
        axis.set_title(title)
        for kind, values in curves().items():
            label, colour, dashes = LOOKS[kind]
            axis.plot(cycles, np.tile(values[mesh], 2), dashes, color=colour, label=label)
    axes[0].set_ylim(10.0, 52.0)
    axes[1].set_ylabel("mesh stiffness [N/µm]")
    axes[2].set_xlabel("mesh cycles [1]  (one tooth passes)")
    axes[2].set_xlim(0.0, 2.0)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=1, frameon=False)
    return figure
