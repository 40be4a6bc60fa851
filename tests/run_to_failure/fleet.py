"""Units over their lives, as the numbers that a campaign keeps of them: healthy ones, and ones of which a number wears.

A history has what makes real ones hard: recordings come in test days that differ among themselves more than repeats do;
the standard errors that are told are wrong by up to a half either way, and hold a tolerance that all recordings of a
unit share; days come unevenly; wear begins at some time, follows a law of its own (slower or faster than in proportion
to time) and goes on in random steps (a gamma process).
"""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime, timedelta, timezone
from typing import Any

import numpy as np

from ema_twin_sim.campaign.results import DONE, SCHEMA
from ema_twin_sim.campaign.units import Unit, units_of

LIMITS = {
    "coulomb_friction.torque": (0.10, 0.20, "N m"),
    "backlash.width": (1.0e-3, 4.0e-3, "rad"),
    "drive.torque_constant": (1.91, 1.53, "N m/A"),
    "sun_runout.amplitude": (0.010, 0.060, "N m"),
}
"""Of each number that is followed: healthy value, limit, unit."""
WEARS = (*LIMITS, None)
"""What may wear of a unit; one in five stays healthy."""
HEALTHY_DAYS = 12
"""Test days before anything wears: those that are declared healthy."""
TESTS = 140
"""Test days of a life."""
REPEATS = 3
"""Recordings of a test day."""
BEGUN = datetime(2024, 1, 8, tzinfo=timezone.utc)


@dataclass(frozen=True, eq=False)
class WornUnit:
    """One unit: its ``rows`` as a campaign keeps them, and what is true of it."""

    rows: list[dict[str, Any]]
    wears: str | None  # path of the number that wears
    law: str
    days: np.ndarray  # (n,) of each test
    truth: np.ndarray  # (n,) share of the margin that is lost, of that number
    onset: float  # day; infinite where nothing wears
    life: float  # day on which the limit is reached; infinite where it is not

    def until(self, day: float, path: str | None = None) -> Unit:
        """What is known of the unit on a day; of one number only, where one is asked for."""
        rows = [row for row in self.rows if _day(row["time"]) <= day]
        if path is not None:
            rows = [
                {**row, "parameters": [p for p in row["parameters"] if f"{p['owner']}.{p['name']}" == path]}
                for row in rows
            ]
        return units_of(rows)[0]


def drawn_unit(seed: int, number: int) -> WornUnit:
    """A unit of a fleet."""
    random = np.random.default_rng((seed, 77, number))
    worn = WEARS[number % len(WEARS)]
    days = np.cumsum(7.0 + random.integers(-2, 3, size=TESTS).astype(float)) - 7.0
    onset = float(random.uniform(days[HEALTHY_DAYS], days[HEALTHY_DAYS + 25]))
    length = float(random.uniform(300.0, 600.0))
    lost, law, life = np.zeros(TESTS), "none", np.inf
    if worn is not None:
        lost, law, life = _lost_margin(random, days, onset, length)
    rows = []
    held = {path: _values(random, path, lost if path == worn else np.zeros(TESTS)) for path in LIMITS}
    for k, day in enumerate(days):
        if lost[k] > 1.05:
            break  # it has failed
        for repeat in range(REPEATS):
            rows.append(_row(number, day, repeat, {path: of[k, repeat] for path, of in held.items()}))
    return WornUnit(rows, worn, law, days, lost, onset if worn else np.inf, life)


def _lost_margin(
    random: np.random.Generator, days: np.ndarray, onset: float, length: float
) -> tuple[np.ndarray, str, float]:
    """Share of the margin that is lost on each day (n,), the law, and the day on which nothing is left."""
    fine = np.arange(0.0, days[-1] + 1.0)
    since = np.maximum(0.0, fine - onset) / length
    kind = random.choice(["power", "exponential"])
    if kind == "power":
        power = float(np.exp(random.uniform(np.log(0.7), np.log(1.8))))
        mean, law = since**power, f"power {power:.2f}"
    else:
        rate = float(random.uniform(0.5, 2.0))
        mean, law = np.expm1(rate * since) / np.expm1(rate), f"exponential {rate:.2f}"
    shape = 200.0  # of the gamma process over the whole life: its end is random by 7 %
    steps = np.diff(mean, prepend=mean[0]) * shape
    path = np.cumsum(np.where(steps > 0.0, random.gamma(np.maximum(steps, 1e-12)), 0.0)) / shape
    beyond = np.flatnonzero(path >= 1.0)
    life = float(fine[beyond[0]]) if len(beyond) else np.inf
    return np.interp(days, fine, path), law, life


def _values(random: np.random.Generator, path: str, lost: np.ndarray) -> np.ndarray:
    """(tests, repeats, 2) values with the standard errors that are told of them."""
    healthy, limit, _ = LIMITS[path]
    margin = limit - healthy
    own = abs(margin) * random.uniform(0.01, 0.03)  # of a recording
    between = abs(margin) * random.uniform(0.01, 0.03)  # of a test day
    shared = abs(margin) * random.uniform(0.0, 0.05)  # of the unit: a tolerance, the same in all recordings
    offset = shared * random.normal()
    told = np.hypot(own * random.uniform(0.6, 1.5), shared)
    truth = healthy + offset + margin * lost + between * random.normal(size=len(lost))
    values = truth[:, None] + own * random.normal(size=(len(lost), REPEATS))
    return np.stack([values, np.full_like(values, told)], axis=2)


def _row(number: int, day: float, repeat: int, held: dict[str, np.ndarray]) -> dict[str, Any]:
    time = BEGUN + timedelta(days=day, minutes=5 * repeat)
    name = f"{time:%Y-%m-%d} {repeat}"
    parameters = []
    for path, (value, std) in held.items():
        owner, _, of = path.partition(".")
        parameters.append({"owner": owner, "name": of, "value": value, "std": std, "unit": LIMITS[path][2]})
    row = {"key": name, "unit": f"EMA-{number:03}", "name": name, "task": "fit", "status": DONE, "duration": 20.0}
    return {**dict.fromkeys(SCHEMA.names), **row, "time": time, "parameters": parameters}


def _day(time: datetime) -> float:
    return (time - BEGUN).total_seconds() / 86400.0
