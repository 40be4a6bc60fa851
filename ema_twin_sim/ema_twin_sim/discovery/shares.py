"""How sure the shares of motor and output are of an inertia and a friction whose sum the recordings tell.

Beside play, how teeth meet divides both: its contact, sampled every few milliseconds, is a softer one than the
machine's, which moves a few hundredths of the sum from one side to the other. No curvature and no jackknife shows that,
since every recording is off alike.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from ..criteria import NEGLIGIBLE
from ..identification.equation import EquationErrorProblem
from ..identification.fit import Fit
from ..identification.uncertainty import covariance
from ..listing import listed
from ..measured.scales import INERTIAS
from ..model import Model
from ..model.own_units import shown_entry
from ..model.roles import DRY_FRICTION
from ..quantities import estimate


class _Sum(NamedTuple):
    """What both sides have together: its name and unit, the paths of the free shares, and what these are factors of."""

    name: str
    unit: str
    paths: tuple[str, str]  # motor, output
    sizes: tuple[float, float]  # of the base, at a factor of one


def with_division(errors: Mapping[str, float], f: Fit, left: float) -> dict[str, float]:
    """Standard errors by path, those of the two sides' shares with what no model explains.

    ``left`` is the error that remains, in times the sensors' noise: as many times less sure is each number beside it,
    and the division of the sum.
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
    """What to say where recordings tell a sum of both sides, and hardly or not at all how it is divided."""
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
            f"how motor and output share what they have together is told by how their teeth meet, less surely than the "
            f"sums: {listed(told)}",
        )
    halves = [both for both in _sums(f, parted=False)]
    if not halves or not f.hypothesis.base.is_open:
        return ()
    return (
        f"without play or a spring these recordings tell only sums: {listed(both.name for both in halves)} of motor "
        "and output are divided as in your model, each ± is that of the sum",
    )


def _sums(f: Fit, *, parted: bool = True) -> Iterator[_Sum]:
    """The sums whose two sides are free by themselves; where not ``parted``, those that have two sides."""
    base, free = f.hypothesis.base, {one.path for one in f.hypothesis.free}
    dry = {"motor": 0.0, "output": 0.0}
    for instance in base.active.values():
        if instance.effect == DRY_FRICTION:
            dry[instance.options["side"]] += instance.parameters["torque"]
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
