"""Uncertainty of how inertia and friction, whose sums are known, are shared between motor and output.

With backlash, the contact of the teeth determines the split. At a sample period of a few milliseconds the fitted
contact is softer than the machine's, which moves a few per cent of the sum from one side to the other. Neither
curvature nor jackknife shows this error, because it is the same in every recording.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from ..criteria import NEGLIGIBLE
from ..identification.equation import EquationErrorProblem
from ..identification.fit import Fit
from ..identification.hypothesis import dry_friction
from ..identification.uncertainty import covariance
from ..listing import listed
from ..measured.scales import INERTIAS
from ..model import Model
from ..model.own_units import shown_entry
from ..model.roles import DRY_FRICTION
from ..quantities import estimate


class _Sum(NamedTuple):
    """A sum over both sides: its name and unit, the paths of the free shares, and the values that these scale."""

    name: str
    unit: str
    paths: tuple[str, str]  # motor, output
    sizes: tuple[float, float]  # values in the base model, at a scale of one


def with_division(errors: Mapping[str, float], f: Fit, left: float) -> dict[str, float]:
    """Standard errors by path, those of the two sides' shares increased for what no model explains.

    ``left`` is the remaining error as a multiple of the sensors' noise. The standard errors of the shares are
    multiplied by it, and an error of the split is added.
    """
    told = dict(errors)
    if not f.hypothesis.parted:
        return told
    times, now = max(1.0, left), f.hypothesis.by_path
    for both in _sums(f):
        whole = sum(now[path] * size for path, size in zip(both.paths, both.sizes, strict=True))
        for path, size in zip(both.paths, both.sizes, strict=True):
            if path in told:
                told[path] = math.hypot(times * told[path], NEGLIGIBLE * times * whole / size)
    return told


def of_sums(problem: EquationErrorProblem, f: Fit, left: float) -> tuple[str, ...]:
    """Warnings where recordings determine the sum of both sides, but its split poorly or not at all."""
    if f.hypothesis.parted:
        known, places = covariance(problem, f), {free.path: k for k, free in enumerate(f.hypothesis.free)}
        now, base, told = f.hypothesis.by_path, f.hypothesis.base, []
        for both in _sums(f):
            where = [places[path] for path in both.paths]
            sizes = np.array(both.sizes)
            std = max(1.0, left) * math.sqrt(max(float(sizes @ known[np.ix_(where, where)] @ sizes), 0.0))
            whole = float(sizes @ [now[path] for path in both.paths])
            told.append(_told(base, both, whole, std))
        if not told:
            return ()
        return (
            "the split between motor and output comes from the tooth impacts and is less certain than the sums: "
            f"{listed(told)}",
        )
    halves = [both for both in _sums(f, parted=False)]
    if not halves or not f.hypothesis.base.is_open:
        return ()
    return (
        "without play or compliance these recordings determine only sums: "
        f"{listed(both.name for both in halves)} of motor and output are split as in your model; each ± is "
        "that of the sum",
    )


def _sums(f: Fit, *, parted: bool = True) -> Iterator[_Sum]:
    """The sums whose two sides are both free; if not ``parted``, the sums that have two sides."""
    base, free = f.hypothesis.base, {one.path for one in f.hypothesis.free}
    dry = dry_friction(base.active.values())
    inertia = sum(base.value(path) for path in INERTIAS[:-1]), base.value(INERTIAS[-1])
    for both in (
        _Sum("inertia", "kg m^2", ("scale.inertia", "scale.output_inertia"), inertia),
        _Sum("dry friction", "N m", (f"scale.{DRY_FRICTION}", "scale.output_coulomb"), (dry["motor"], dry["output"])),
    ):
        if min(both.sizes) > 0.0 and free.issuperset(both.paths if parted else both.paths[:1]):
            yield both


def _told(base: Model, both: _Sum, value: float, std: float) -> str:
    entry = shown_entry(base, value, std, both.unit)
    return f"{both.name} {estimate(entry['value'], entry['std'], entry['unit'])}"
