"""Generic bases: dependences of a residual that need no effect of the catalogue. They prevent false names.

A basis is a set of columns, linear in their coefficients, for *any* dependence on one quantity: hat functions over
speed, time or load, waves over the output position or the motor angle.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..criteria import NEGLIGIBLE
from ..measured.order_spectrum import largest_in_cells, refined
from ..plant.measured_motion import REQUIRED
from ..plant.motion import MOTOR_ANGLE, OUTPUT_ANGLE, SPEED, TIME
from .basis_columns import at_rows, at_rows_of, hat_columns
from .equation import EquationErrorProblem
from .fit import Fit, fit

KNOTS = 9  # for a dependence on speed or position
LEAST_KNOTS = 3  # with fewer hats there is only a straight line
KNOT = 2.5  # own s between the knots of a dependence on time
MOST_KNOTS = 24
LONGEST_WAVE, SHORTEST_WAVE = 0.5, 30.0  # cycles over the output's travel: half a swing, and a fine ripple
WAVES = 48  # spaced by factors of 1.09: midway, five cycles are off by a quarter of one
ORDERS = np.arange(0.1, 60.0, 0.03)  # cycles per motor turn; ``refined`` finds those between
BASIS_STEPS = 3  # of a fit with one more basis, which is linear


def beside_generic_bases(problem: EquationErrorProblem, f: Fit) -> EquationErrorProblem:
    """The problem with all generic bases except orders, with the load of a fit; unchanged if it has bases already."""
    if problem.generic_bases:
        return problem
    return problem.with_generic_bases({**_bases(problem), **load_bases(problem, f)})


def fit_with_basis(problem: EquationErrorProblem, known: Fit, name: str) -> Fit:
    """Refit a known fit's hypothesis with one more generic basis of the problem."""
    h = known.hypothesis.with_generic_basis(name, problem.generic_bases[name].shape[1])
    return fit(problem, h, BASIS_STEPS, known=known)


def _bases(problem: EquationErrorProblem) -> Mapping[str, np.ndarray]:
    """All bases that do not depend on a fit.

    They are cached for the next weighting with the same wander, under which they are identical.
    """
    kept, wander = problem.kept_bases, problem.weighting.wander
    bases = kept.get(wander)  # one lookup, since another thread may clear them meanwhile
    if bases is None:
        bases = {**_by_speed(problem), **_by_position(problem), **_by_time(problem)}
        kept.clear()
        kept[wander] = bases
    return bases


def dependence(name: str) -> str:
    """The quantity that a generic basis stands for."""
    return name.partition("#")[0]


def _by_speed(problem: EquationErrorProblem) -> dict[str, np.ndarray]:
    speeds = np.concatenate([np.abs(o.motion[o.rows, SPEED]) for o in problem.observations])
    knots = np.unique(np.quantile(speeds, np.linspace(0, 1, KNOTS)))
    if len(knots) < LEAST_KNOTS:
        return {}
    hats = [hat_columns(np.abs(o.motion[:, SPEED]), knots) for o in problem.observations]
    sense = [np.sign(o.motion[:, SPEED])[:, None] for o in problem.observations]
    found = {"speed": at_rows(problem, [h * s for h, s in zip(hats, sense, strict=True)])}
    ways = np.concatenate([s[o.rows] for s, o in zip(sense, problem.observations, strict=True)])
    forward, backward = np.count_nonzero(ways > 0.0), np.count_nonzero(ways < 0.0)
    if min(forward, backward) > NEGLIGIBLE * (forward + backward):  # in one direction both are the same
        found["direction"] = at_rows(problem, hats)
    return found


def _by_position(problem: EquationErrorProblem) -> dict[str, np.ndarray]:
    angles = [o.output_origin + o.motion[:, OUTPUT_ANGLE] for o in problem.observations]
    lowest, highest = min(a.min() for a in angles), max(a.max() for a in angles)
    span = highest - lowest
    if span <= 0.0:
        return {}
    sense = [np.sign(o.motion[:, SPEED])[:, None] for o in problem.observations]
    knots = np.linspace(lowest, highest, KNOTS)
    hats = [hat_columns(a, knots) for a in angles]
    found = {
        "output_position#load": at_rows(problem, hats),
        "output_position#friction": at_rows(problem, [h * s for h, s in zip(hats, sense, strict=True)]),
    }
    for k, order in enumerate(2.0 * np.pi / span * np.geomspace(LONGEST_WAVE, SHORTEST_WAVE, WAVES)):
        waves = [np.stack([np.sin(order * a), np.cos(order * a)], 1) for a in angles]
        found[f"output_position#{k}"] = at_rows(problem, [w * s for w, s in zip(waves, sense, strict=True)])
        if round(order) > 1:
            found[f"output_position#load{k}"] = at_rows(problem, waves)
    return found


def _by_time(problem: EquationErrorProblem) -> dict[str, np.ndarray]:
    found = {}
    for k, chosen in enumerate(problem.observations):
        if chosen.of_points:  # operating points have no time between them
            continue
        lasts = chosen.motion[-1, TIME]
        knots = np.linspace(0.0, lasts, min(max(LEAST_KNOTS, round(lasts / KNOT)), MOST_KNOTS))
        hats = hat_columns(chosen.motion[:, TIME], knots) * np.sign(chosen.motion[:, SPEED])[:, None]
        columns = np.zeros((problem.rows, len(knots)))
        columns[problem.torque_parts[k]] = at_rows_of(chosen, hats)
        found[f"time#{k}"] = problem.whitened(columns)
    return found


def load_bases(problem: EquationErrorProblem, f: Fit) -> dict[str, np.ndarray]:
    """Friction as a function of the torque that a fit transmits to the output.

    Empty with backlash or compliance, where the transmitted torque comes only from the model.
    """
    if f.parted:
        return {}
    passed_on = REQUIRED.index("transmitted")
    sizes = [np.abs(required[:, passed_on]) for required in f.predicted.required_by_recording]
    judged = np.concatenate([size[o.rows] for size, o in zip(sizes, problem.observations, strict=True)])
    knots = np.unique(np.quantile(judged, np.linspace(0, 1, KNOTS))) if len(judged) else judged
    if len(knots) < LEAST_KNOTS:
        return {}
    sense = [np.sign(o.motion[:, SPEED])[:, None] for o in problem.observations]
    return {"load": at_rows(problem, [hat_columns(a, knots) * s for a, s in zip(sizes, sense, strict=True)])}


def order_bases(problem: EquationErrorProblem, f: Fit) -> dict[str, np.ndarray]:
    """Waves over the motor angle at the strongest order in a fit's residual, as a torque and as friction."""
    found = {}
    for kind in ("torque", "friction"):
        parts = []
        for o, part in zip(problem.observations, problem.torque_parts, strict=True):
            angle = o.motor_origin + o.motion[o.rows, MOTOR_ANGLE]
            if len(angle) and np.ptp(angle) >= 2.0 * np.pi:
                sense = np.sign(o.motion[o.rows, SPEED]) if kind == "friction" else 1.0
                parts.append((f.residual[part] * sense, angle))
        power = sum((largest_in_cells(ORDERS, *part) for part in parts), np.zeros(len(ORDERS)))
        if not power.any():
            continue
        order = refined(float(ORDERS[int(np.argmax(power))]), ORDERS[1] - ORDERS[0], parts)
        columns = []
        for o in problem.observations:
            angle = order * (o.motor_origin + o.motion[:, MOTOR_ANGLE])
            waves = np.stack([np.sin(angle), np.cos(angle)], 1)
            columns.append(waves * np.sign(o.motion[:, SPEED])[:, None] if kind == "friction" else waves)
        found[f"order#{kind}{order:.6f}".replace(".", "_")] = at_rows(problem, columns)
    return found
