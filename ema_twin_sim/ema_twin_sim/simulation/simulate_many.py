"""Simulate many models on one recording, for fits and campaigns: several times faster than one after the other."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ema_bench_replay.recording import Recording

from ..model import Model
from ..parallel import simulations
from ..plant.layout import BENCH, CURRENT, OUT, SETPOINT, TWIN
from ..plant.many import LANE, advance_many
from .divergence import looks_lost
from .simulate import BY_MOTOR, POINTWISE, bench_of, choose_input, followed, seen, simulate, started
from .twin import ROWS_AT_A_TIME, Twin, hold_input

FEWEST = 5
"""Number of models that take as long sequentially as ``LANE`` of them in parallel."""

_NOT_NEEDED = [BENCH.index("speed"), BENCH.index("motor_position")]
"""Columns used only by the unexplained torque."""


def simulate_many(
    models: Sequence[Model], recording: Recording, source: str | None = None, *, step: float | None = None
) -> list[Recording]:
    """The twins' recordings, one per model: as ``simulate`` of each, without the unexplained torque.

    Averaged drives driven by a recorded setpoint or current whose effects only change constants run in parallel lanes
    (``plant/many.py``), all others one by one; both on all cores.
    """
    if not models:
        return []
    chosen = choose_input(recording, models[0], source)
    if chosen in (POINTWISE, BY_MOTOR):
        return [simulate(model, recording, chosen) for model in models]
    found: dict[int, Recording] = {}
    bench = bench_of(recording)
    twins = [started(model, recording, bench, chosen, step) for model in models]
    bench[:, _NOT_NEEDED] = math.nan
    hold_input(bench, twins[0].source)
    groups: dict[tuple[float, ...], list[int]] = {}
    for k, twin in enumerate(twins):
        groups.setdefault(_kind(twin), []).append(k)
    jobs = []
    for kind, members in groups.items():
        for first in range(0, len(members), LANE):
            together = members[first : first + LANE]
            jobs += [together] if kind and len(together) > FEWEST else [[k] for k in together]

    def run(job: list[int]) -> None:  # both kernels release the interpreter lock
        if len(job) > 1:
            rows = _side_by_side([twins[k] for k in job], recording.stamps, bench)
        else:
            rows = [followed(twins[job[0]], recording, bench)]
        for k, of_one in zip(job, rows, strict=True):
            lost = any(map(looks_lost, (*of_one[ROWS_AT_A_TIME::ROWS_AT_A_TIME], of_one[-1])))
            found[k] = seen(models[k], recording, alone(models[k]) if lost else of_one)

    def alone(model: Model) -> np.ndarray:
        """Rows of one that diverged: run again by itself to report when and in which state, or to be brought back."""
        whole = bench_of(recording)
        rows = followed(started(model, recording, whole, chosen, step), recording, whole)
        rows[:, OUT.unexplained_torque] = math.nan
        return rows

    list(simulations(run, jobs))
    return [found[k] for k in range(len(models))]


def _kind(twin: Twin) -> tuple[float, ...]:
    """Key of twins that can run in parallel lanes; empty if a twin cannot."""
    plant, parts = twin.assembly.plant[0], twin.assembly.fine
    plain = (
        not (parts.switching or parts.planetary or len(twin.assembly.acting[0]))
        and plant["asymmetry"] == 0.0
        and math.isinf(plant["end_stop_lower"])
        and math.isinf(plant["end_stop_upper"])
        and twin.source in (SETPOINT, CURRENT)
    )
    bristled = float(plant["bristle_stiffness"] > 0.0)
    return (float(plant["two_inertia"]), bristled, float(plant["control_cycle"]), twin.step) if plain else ()


def _side_by_side(twins: list[Twin], stamps: np.ndarray, bench: np.ndarray) -> list[np.ndarray]:
    """Rows (n, signals) for each of at most LANE twins of one kind; unused lanes repeat the last twin."""
    filled = twins + [twins[-1]] * (LANE - len(twins))
    plants = np.concatenate([twin.assembly.plant for twin in filled])
    states = np.concatenate([twin.state for twin in filled])
    rows = np.full((LANE, len(stamps), len(TWIN)), math.nan)
    for twin, of_one in zip(filled, rows, strict=True):
        of_one[0] = twin.last_row
    advance_many(plants, states, twins[0].source, np.ascontiguousarray(stamps), bench, rows, twins[0].step)
    return list(rows[: len(twins)])
