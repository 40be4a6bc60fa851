"""Units that wear, simulated down to their recordings, and judged from these alone by `campaign` and `units`.

Health is judged from every recording beside the unit's own healthy tests, and so are the numbers of a model that has
the effects which may wear, fitted test by test; what a model lacks, from the recordings of the last test. Units of a
fleet differ (friction, by 5 %), and so do a unit's tests (by 2 %).
"""

from __future__ import annotations

import io
import json
import sys
from contextlib import redirect_stdout
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ema_bench_replay.bags.bag_writer import write_mcap
from ema_twin_sim.identification.hypothesis import INERTIAS
from ema_twin_sim.model import Model, load_model, save_model
from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.virtual_bench import virtual_bench
from tests.command_line import done_here

WEARS: dict[str, tuple[str, str, float, float] | None] = {
    "friction": None,
    "play": ("backlash", "width", 0.0, 4.0e-3),
    "torque constant": ("torque_constant_error", "scale", 1.0, 0.8),
    "run-out": ("sun_runout", "torque", 0.0, 0.06),
    "nothing": None,
}
"""By what wears: the effect that the model then lacks, its number, that of a healthy unit and the limit."""
MOST_FRICTION = 1.6
"""Limit of friction, in times of a healthy unit's: what it does, no effect is missing for."""
FRICTIONS = (
    ("coulomb_friction", "torque"),
    ("coulomb_friction_2", "torque"),
    ("viscous_friction", "coefficient"),
)
HEALTHY_TESTS, TESTS, REPEATS = 8, 18, 3
LOST_AT_LAST = 0.5
EARLY = 0.2
SEEN = 0.02
"""Share of the way to its limit at which the fit of a number starts: at nothing, some have no slope."""
COMMAND, SECONDS = "triangle:0.15:1.5", 9.0


@dataclass(frozen=True)
class SimulatedUnit:
    """What was told of one unit."""

    name: str
    wears: str
    lost_when_off: float  # share of the margin at the first test that is off; infinite: none was
    tests_before: int  # healthy tests that were judged
    false_alarms: int  # of these
    lost_when_changed: float  # the same share at the first test after which a number is told changed
    changed: str | None  # that number
    false_changes: int  # numbers that are told changed after a healthy test
    families: tuple[str | None, ...]  # of the tests that are off
    missing: tuple[str, ...]  # in the last test, by discovery

    @property
    def early(self) -> bool:
        """Whether its wear was told before a fifth of the margin was lost: by its health, or by a number."""
        return min(self.lost_when_off, self.lost_when_changed) <= EARLY


def simulate_units(folder: Path, count: int, seed: int) -> None:
    """Write the recordings: UNIT/TEST/RUN.mcap below ``runs``, those of each last test below ``last`` too."""
    stock = load_model("polito_bench")
    for number in range(count):
        print(f"simulating unit {number + 1} of {count}", file=sys.stderr, flush=True)
        random = np.random.default_rng((seed, 88, number))
        kind = [*WEARS][number % len(WEARS)]
        own = _unlike(stock, random, 0.05)
        for test in range(TESTS):
            worn = _worn(_unlike(own, random, 0.02), kind, lost(test))
            for repeat in range(REPEATS):
                bench = virtual_bench(worn, parse_command(COMMAND), SECONDS, seed=int(random.integers(2**31)))
                for of in ("runs", "last") if test == TESTS - 1 else ("runs",):
                    write_mcap(bench, folder / of / _name(number, kind) / f"test {test:02}" / f"{repeat}.mcap")


def lost(test: int) -> float:
    """Share of the margin that is lost in a test: nothing in the first two after the healthy ones."""
    begin = HEALTHY_TESTS + 2
    return LOST_AT_LAST * max(0.0, (test - begin + 1) / (TESTS - begin))


def judge_units(folder: Path, workers: int) -> list[SimulatedUnit]:
    """The units of a folder, judged by the two verbs."""
    common = ["--model", "polito_bench", "--workers", str(workers)]
    _run("campaign", folder / "runs", "--do", "health", "-o", folder / "health", *common)
    _run("campaign", folder / "last", "--do", "discover", "--together", "unit", "-o", folder / "found", *common)
    watched = ["--model", save_model(_watched(), folder / "watched.yaml"), "--workers", str(workers)]
    _run("campaign", folder / "runs", "--do", "fit", "--together", "folder", "-o", folder / "numbers", *watched)
    healthy = rf"/test 0[0-{HEALTHY_TESTS - 1}](/|$)"
    told = []
    for what, given in (("health", ["--healthy", healthy]), ("numbers", ["--healthy", healthy]), ("found", [])):
        _run("units", folder / what, *given, "--json", folder / f"{what}.json")
        told.append({one["unit"]: one for one in json.loads((folder / f"{what}.json").read_text())})
    health, numbers, found = told
    return [_told(health[name], numbers[name], found[name]) for name in sorted(health)]


def table(units: list[SimulatedUnit]) -> str:
    """The units and their figures."""
    lines = []
    for unit in units:
        off = "never off" if np.isinf(unit.lost_when_off) else f"off from {100 * unit.lost_when_off:.0f} % lost"
        families = ", ".join(f"{family} {unit.families.count(family)}" for family in dict.fromkeys(unit.families))
        change = (
            "no number changed"
            if unit.changed is None
            else f"{unit.changed} changed from {100 * unit.lost_when_changed:.0f} % lost"
        )
        if unit.false_changes:
            change += f", {unit.false_changes} while healthy"
        lines.append(
            f"{unit.name:26s} {off:20s} {change}; named {families or 'nothing'}; lacks {', '.join(unit.missing) or '-'}"
        )
    worn = [unit for unit in units if unit.wears != "nothing"]
    lacking = [(unit, of[0]) for unit in worn if (of := WEARS[unit.wears]) is not None]
    right = [effect in unit.missing for unit, effect in lacking]
    for what, early in (
        ("told", [unit.early for unit in worn]),
        ("off", [unit.lost_when_off <= EARLY for unit in worn]),
        ("with a number changed", [unit.lost_when_changed <= EARLY for unit in worn]),
    ):
        lines.append(f"{what} before {100 * EARLY:.0f} % of the margin was lost: {sum(early)} of {len(worn)} units")
    before = sum(u.tests_before for u in units)
    lines.append(f"false alarms: {sum(u.false_alarms for u in units)} of {before} tests")
    lines.append(f"numbers changed in healthy tests: {sum(u.false_changes for u in units)} of {len(units)} units")
    lines.append(f"what wears is among what the model lacks: {sum(right)} of {len(right)}")
    return "\n".join(lines)


def _told(health: dict, numbers: dict, found: dict) -> SimulatedUnit:
    wears = health["unit"].partition(" ")[2]
    at = {test["test"]: test for test in health["health"]["tests"]}
    off = [name for name, test in at.items() if 2 * test["detected"] > test["judged"]]
    truly = {name: 0.0 if wears == "nothing" else lost(int(name.partition(" ")[2])) for name in at}
    changes = sorted(
        (one["change"]["told_at"].rpartition("/")[2], one["number"]) for one in numbers["numbers"] if one["change"]
    )
    right = [(truly[test], number) for test, number in changes if truly[test] > 0.0]
    return SimulatedUnit(
        name=health["unit"],
        wears=wears,
        lost_when_off=min((truly[name] for name in off if truly[name] > 0.0), default=np.inf),
        tests_before=sum(share == 0.0 for share in truly.values()),
        false_alarms=sum(truly[name] == 0.0 for name in off),
        lost_when_changed=right[0][0] if right else np.inf,
        changed=right[0][1] if right else None,
        false_changes=len(changes) - len(right),
        families=tuple(at[name]["family"] for name in off),
        missing=tuple(entry["effect"] for entry in found["missing"]),
    )


def _watched() -> Model:
    """What is fitted test by test: friction, of which no day tells the next one's, and the effects that may wear.

    A unit's inertias are the same in all its tests, so they are held: a fit would trade a torque constant for them.
    """
    model = load_model("polito_bench")
    held = {path: replace(model.constants[path], tolerance=0.0) for path in INERTIAS}
    model = replace(model, constants={**model.constants, **held})
    effects = {name: replace(held, open=name in dict(FRICTIONS)) for name, held in model.effects.items()}
    model = replace(model, effects=effects)
    for effect, number, healthy, limit in filter(None, WEARS.values()):
        model = model.with_effect(effect, {number: healthy + SEEN * (limit - healthy)})
    return model


def _name(number: int, kind: str) -> str:
    return f"EMA-{number:02} {kind}"


def _unlike(model: Model, random: np.random.Generator, by: float) -> Model:
    """Another unit, or the same on another day: each friction is a little other."""
    for name, parameter in FRICTIONS:
        model = _times(model, name, parameter, float(np.exp(by * random.normal())))
    return model


def _times(model: Model, name: str, parameter: str, factor: float) -> Model:
    return model.with_value(f"effects.{name}.{parameter}", factor * model.effects[name].parameters[parameter])


def _worn(model: Model, kind: str, share: float) -> Model:
    if kind == "friction":
        for name, parameter in FRICTIONS:
            model = _times(model, name, parameter, 1.0 + share * (MOST_FRICTION - 1.0))
        return model
    wear = WEARS[kind]
    if wear is None or share == 0.0:
        return model
    effect, number, healthy, limit = wear
    return model.with_effect(effect, {number: healthy + share * (limit - healthy)})


def _run(*arguments: object) -> None:
    """One of the two verbs, here: its table is not shown, since what is told of it is read from its JSON."""
    print("ema-twin", *arguments[:4], "…", file=sys.stderr, flush=True)
    with redirect_stdout(io.StringIO()):
        done_here(*arguments)
