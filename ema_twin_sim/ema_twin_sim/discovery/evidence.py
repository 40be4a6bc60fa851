"""Evidence: named series with units, ready to plot, that let a person check a verdict.

Each step of a discovery is shown by the residuals of the torque balance and of the encoders: before it, after it, and
with the runner-up instead. They are given against every quantity that an effect may depend on. The step that the search
refused at its end is shown in the same way.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from ..comparison.binning import bin_edges, quartiles, rows_by_bin
from ..comparison.orders import ORDERS, Periodicity, amplitude_spectrum, find_order
from ..criteria import MOSTLY, STANDSTILL
from ..effects import catalogue
from ..identification.equation import EquationErrorProblem
from ..identification.fit import Fit
from ..identification.generic_bases import dependence
from ..model import Model
from ..model.own_units import shown
from ..plant.measured_motion import REQUIRED
from ..plant.motion import ACCELERATION, MOTOR_ANGLE, OUTPUT_ANGLE, SPEED, TIME
from .discover import Discovery
from .search.trace import Round, Trial, new_names

BINS = 24
FEWEST = 5  # rows that a bin needs for a median
BANDS = 150  # bands of an order spectrum
LEAST_SHOWN = 10.0  # orders
SHOWN = 1.33  # times the highest order that the model names
NEAR = 0.03  # orders within this distance of a named one are taken to be it
NARROW_AT_ZERO = ("speed", "transmitted_torque", "acceleration")  # bins are narrow near zero for these
_SHOWN_OVER = {
    "speed": "speed",
    "direction": "speed",
    "output_position": "output_position",
    "order": "motor_angle",
    "load": "transmitted_torque",
    "time": "time",
    "acceleration": "acceleration",
}
"""By the quantity on which an effect depends: that of its view."""
Kind = Literal["torque", "encoder_difference"]
_UNITS: dict[Kind, str] = {"torque": "N m", "encoder_difference": "rad"}


@dataclass(frozen=True, eq=False)
class Compared:
    """The fits that a step compares, by the names of their curves."""

    title: str  # what was added, or would have been added
    taken: bool  # False: the search refused it, and ended
    runner_up: str  # the next best trial; empty if nothing else was tried
    fits: Mapping[str, Fit]  # before, after, runner_up


@dataclass(frozen=True, eq=False)
class Curve:
    """Medians and quartiles (b,) of the residual, in bins of a quantity."""

    name: str  # before, after or runner_up
    direction: str  # forward, backward or both
    x: np.ndarray
    median: np.ndarray
    lower: np.ndarray
    upper: np.ndarray


@dataclass(frozen=True, eq=False)
class View:
    """Residual against one quantity; ``share`` is the part of the step's change that this quantity explains."""

    kind: Kind
    against: str
    unit: str  # of the quantity
    size_unit: str  # of the residual
    order: float | None  # of an angle that is folded by that order
    share: float
    curves: tuple[Curve, ...]


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Order spectra of the residual torque; each value is the largest of its band."""

    friction: bool  # the torque is counted as opposing the motion
    unit: str  # of the amplitudes
    orders: np.ndarray
    amplitudes: Mapping[str, np.ndarray]
    named: tuple[tuple[float, str, Mapping[str, float]], ...]


@dataclass(frozen=True, eq=False)
class StepEvidence:
    """All views of one step, the most informative first."""

    compared: Compared
    views: tuple[View, ...]
    spectrum: Spectrum | None


def evidence_json(found: Discovery) -> dict[str, object]:
    """Plot data behind a discovery, for ``--json``: up to about 200 points a curve, five digits each."""
    unseen = found.unseen
    return {
        "steps": [_step_as_json(_evidence_of(found.equation, compared)) for compared in compared_fits(found)],
        "rmse": {
            "signal": unseen.signal,
            "unit": unseen.unit,
            "noise_floor": unseen.noise_floor,
            "recordings": {name: _digits(values) for name, values in unseen.recordings},
        },
        "tried": [
            {"names": [" and ".join(t.names) for t in turn.tried], "gain": _digits([t.gain for t in turn.tried])}
            for turn in found.search.rounds
            if turn.tried
        ],
    }


def compared_fits(found: Discovery) -> list[Compared]:
    """The fits that each step of a discovery compares, plus those of the step refused at the end."""
    steps: dict[tuple[str, ...], Compared] = {}
    for turn in found.search.changes:
        names = new_names(turn.before, turn.after)
        if names:  # otherwise the added effect was pruned at once
            steps[names] = _compared(turn, names, turn.after, taken=True)  # added again, it is compared as it stays
    last = found.search.stopped
    refused = []
    if last is not None and last.tried:
        refused.append(_compared(last, last.tried[0].names, last.tried[0].fit, taken=False))
    return [*steps.values(), *refused]


def _compared(turn: Round, names: Sequence[str], after: Fit, *, taken: bool) -> Compared:
    fits = {"before": turn.before, "after": after}
    rival = _runner_up(turn, names)
    if rival is not None:
        fits["runner_up"] = rival.fit
    return Compared(_title(names), taken, _title(rival.names) if rival else "", fits)


def _title(names: Sequence[str]) -> str:
    """Names of effects, and the quantity that a generic basis stands for."""
    generic_bases = [f"dependence on {dependence(name)}" for name in names if "#" in name]
    return " and ".join([*(name for name in names if "#" not in name), *dict.fromkeys(generic_bases)])


def _runner_up(turn: Round, names: Sequence[str]) -> Trial | None:
    """The best trial that does not contain what was added."""
    return next((trial for trial in turn.tried if not set(trial.names) & set(names)), None)


@dataclass(frozen=True, eq=False)
class _Torques:
    """Torque rows: the residual of each fit, and the state of the machine."""

    left: Mapping[str, np.ndarray]  # N m (m,)
    speed: np.ndarray
    motor_angle: np.ndarray
    output_angle: np.ndarray
    time: np.ndarray
    transmitted: np.ndarray
    change: Periodicity | None  # strongest order in what the step changed


def _evidence_of(problem: EquationErrorProblem, compared: Compared) -> StepEvidence:
    base = compared.fits["after"].hypothesis.base
    residuals = {name: f.problem.left_over(f.predicted) for name, f in compared.fits.items()}
    torques = _torques(problem, compared.fits["after"], residuals)
    views = _torque_views(torques)
    if problem.rows > problem.size:
        views += _encoder_views(problem, residuals)
    moved = (residuals["before"] - residuals["after"]) ** 2
    main = "encoder_difference" if moved[problem.size :].sum() > moved[: problem.size].sum() else "torque"
    own = _own_quantities(compared.fits["before"], compared.fits["after"])
    best = max((view.share for view in views if view.kind == main), default=0.0)
    telling = {view.against for view in views if view.against in own and view.share >= MOSTLY * best}
    views.sort(key=lambda view: (view.kind != main, view.against not in telling, -view.share))
    views = [_as_people_know_it(view, base) for view in views]
    return StepEvidence(compared, tuple(views), _spectrum(problem, torques, base))


def _own_quantities(before: Fit, after: Fit) -> frozenset[str]:
    """The quantities on which the effects that a step added depend.

    What the train transmits has every load in it, a magnet over a place as well, so that a load shows over it, too.
    """
    came = {n: held for n, held in after.hypothesis.added.items() if n not in before.hypothesis.added}
    return frozenset(
        _SHOWN_OVER[over] for held in came.values() if (over := catalogue()[held.effect].depends_on) in _SHOWN_OVER
    )


def _torques(problem: EquationErrorProblem, after: Fit, residuals: Mapping[str, np.ndarray]) -> _Torques:
    motions = [o.motion[o.rows] for o in problem.observations]
    at = np.concatenate(motions)
    origins = np.concatenate(
        [np.tile((o.motor_origin, o.output_origin), (len(o.rows), 1)) for o in problem.observations]
    )
    column = REQUIRED.index("transmitted")
    every = zip(problem.observations, after.predicted.required_by_recording, strict=True)
    left = {name: r[: problem.size] * problem.noise for name, r in residuals.items()}
    speed, angle = at[:, SPEED], at[:, MOTOR_ANGLE] + origins[:, 0]
    change = _periodicity(problem, left["before"] - left["after"], speed, angle)
    output = at[:, OUTPUT_ANGLE] + origins[:, 1]
    transmitted = np.concatenate([required[o.rows, column] for o, required in every])
    return _Torques(left, speed, angle, output, at[:, TIME], transmitted, change)


def _periodicity(
    problem: EquationErrorProblem, torque: np.ndarray, speed: np.ndarray, angle: np.ndarray
) -> Periodicity | None:
    """Strongest order of a torque (m,) while the machine moves."""
    return find_order([(torque[p], angle[p], np.sign(speed[p])) for p in _moving(problem, speed)])


def _moving(problem: EquationErrorProblem, speed: np.ndarray) -> list[np.ndarray]:
    """Torque rows of each recording at which the machine moves."""
    moving = np.abs(speed) > STANDSTILL
    return [p.start + np.flatnonzero(moving[p]) for p in problem.torque_parts]


def _torque_views(at: _Torques) -> list[View]:
    views = [
        _view("torque", "speed", "rad/s", at.speed, at.left),
        _view("torque", "output_position", "rad", at.output_angle, at.left, at.speed),
        _view("torque", "time", "s", at.time, at.left, at.speed),
        _view("torque", "transmitted_torque", "N m", at.transmitted, at.left),
    ]
    if at.change is not None:
        folded = np.mod(at.change.order * at.motor_angle, 2.0 * np.pi)
        views.append(_view("torque", "motor_angle", "rad", folded, at.left, at.speed, order=at.change.order))
    return views


def _encoder_views(problem: EquationErrorProblem, residuals: Mapping[str, np.ndarray]) -> list[View]:
    left = {name: r[problem.size :] * problem.encoder_noise for name, r in residuals.items()}
    motion = np.concatenate([o.motion[o.encoder_rows] for o in problem.observations])
    origins = np.concatenate([np.full(len(o.encoder_rows), o.output_origin) for o in problem.observations])
    speed = motion[:, SPEED]
    return [
        _view("encoder_difference", "speed", "rad/s", speed, left),
        _view("encoder_difference", "output_position", "rad", motion[:, OUTPUT_ANGLE] + origins, left, speed),
        _view("encoder_difference", "time", "s", motion[:, TIME], left, speed),
        _view("encoder_difference", "acceleration", "rad/s^2", motion[:, ACCELERATION], left),
    ]


def _view(
    kind: Kind,
    against: str,
    unit: str,
    x: np.ndarray,
    left: Mapping[str, np.ndarray],
    speed: np.ndarray | None = None,
    *,
    order: float | None = None,
) -> View:
    """Curves of the residual (m,) against ``x`` (m,); one for each direction if the ``speed`` (m,) is given."""
    edges = bin_edges(x, BINS, narrow=against in NARROW_AT_ZERO)
    if speed is None:
        directions = {"both": np.ones(len(x), bool)}
    else:
        directions = {"forward": speed > STANDSTILL, "backward": speed < -STANDSTILL}
    curves = []
    change = left["before"] - left["after"]
    explained = 0.0
    for direction, chosen in directions.items():
        along, fell = x[chosen], change[chosen]
        rows = rows_by_bin(along, edges, FEWEST)
        explained += sum(len(found) * float(np.mean(fell[found])) ** 2 for found in rows)
        _, centres, _ = quartiles(along, rows)
        for name, values in left.items():
            lower, median, upper = quartiles(values[chosen], rows)
            curves.append(Curve(name, direction, centres, median, lower, upper))
    total = float(change @ change)
    return View(kind, against, unit, _UNITS[kind], order, explained / total if total > 0.0 else 0.0, tuple(curves))


def _as_people_know_it(view: View, base: Model) -> View:
    """A view in the units of the machine's file."""
    folded = view.order is not None
    along, unit = (1.0, view.unit) if folded else shown(base, 1.0, view.unit)
    size, size_unit = shown(base, 1.0, view.size_unit)
    curves = tuple(
        replace(c, x=along * c.x, median=size * c.median, lower=size * c.lower, upper=size * c.upper)
        for c in view.curves
    )
    return replace(view, unit=unit, size_unit=size_unit, curves=curves)


def _spectrum(problem: EquationErrorProblem, at: _Torques, model: Model) -> Spectrum | None:
    """Order spectra of the residual torque: as a torque, or as friction if that is what the step changed.

    The orders that the model names are listed with them.
    """
    friction = at.change is not None and bool(at.change.dissipative)
    sense = np.sign(at.speed) if friction else np.ones(len(at.speed))
    lines: dict[str, np.ndarray] = {}
    for name, torque in at.left.items():
        torque = torque * sense
        line = amplitude_spectrum([(torque[p], at.motor_angle[p]) for p in _moving(problem, at.speed)])
        if line is None:
            return None
        lines[name] = line
    highest = max(LEAST_SHOWN, SHOWN * max(model.orders.values(), default=ORDERS[-1]))
    bands = np.array_split(np.flatnonzero(highest >= ORDERS), BANDS)
    size, unit = shown(model, 1.0, "N m")
    lines = {name: size * line for name, line in lines.items()}
    largest = {name: np.array([line[band].max() for band in bands]) for name, line in lines.items()}
    named = [
        (order, label, {name: float(line[np.abs(ORDERS - order) <= NEAR].max()) for name, line in lines.items()})
        for label, order in model.orders.items()
        if ORDERS[0] <= order <= ORDERS[-1]
    ]
    return Spectrum(friction, unit, np.array([ORDERS[band].mean() for band in bands]), largest, tuple(named))


def _step_as_json(step: StepEvidence) -> dict[str, object]:
    compared, spectrum = step.compared, step.spectrum
    content: dict[str, object] = {
        "title": compared.title,
        "taken": compared.taken,
        "runner_up": compared.runner_up,
        "views": [
            {
                "left_over": view.kind,
                "unit": view.size_unit,
                "against": view.against,
                "against_unit": view.unit,
                "order": None if view.order is None else round(view.order, 3),
                "share": round(view.share, 4),
                "curves": [
                    {
                        "name": curve.name,
                        "direction": curve.direction,
                        **{field: _digits(getattr(curve, field)) for field in ("x", "median", "lower", "upper")},
                    }
                    for curve in view.curves
                ],
            }
            for view in step.views
        ],
    }
    if spectrum is not None:
        content["orders"] = {
            "unit": spectrum.unit,
            "friction": spectrum.friction,
            "order": _digits(spectrum.orders),
            "amplitude": {name: _digits(line) for name, line in spectrum.amplitudes.items()},
            "named": [{"order": order, "name": label, "amplitude": line} for order, label, line in spectrum.named],
        }
    return content


def _digits(values: Sequence[float] | np.ndarray) -> list[float]:
    return [float(f"{value:.5g}") for value in values]
