"""Sets of cases that ask one question each: detection limits, false alarms, robustness."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ema_twin_sim.effects import catalogue

from .cases import LOOK_ALIKE, NOT_SMALL, Case, drawn_case, drawn_cases, in_company
from .commands import Drive
from .hide import CATALOGUE
from .machine import stock_machine
from .other_bench import Cause
from .other_machines import other_machine_case, other_machine_cases
from .sizes import SIZE_OF, drawn_causes, middling_cause
from .unkind import COUNTERS_AND_CURRENT, Unkind
from .work import Solvers

SIZES = (0.025, 0.05, 0.1, 0.2, 0.4, 0.8)
"""Sizes of the detection limit's ladder, over the middle of an effect's usual range."""
TRIES = 10
ENOUGH = 9
"""Named so often of TRIES, a size counts as detected."""

SWEPT = tuple(id for id in CATALOGUE if id in SIZE_OF)
"""The effects that have a size."""

UNKIND_NULLS = (
    Unkind(),
    Unkind(),
    Unkind(controller_noise=0.01),
    Unkind(wander=0.08),
    Unkind(load_resonance=90.0),
    Unkind(spikes=3e-4, uneven=0.2, dropped=0.01, interpolation=1e-5),
    Unkind(signals=COUNTERS_AND_CURRENT),
    Unkind(power_cycled=True),
)
"""Benches on which nothing is hidden: a quarter of them kind."""


def null_cases(seed: int, count: int) -> list[Case]:
    """Cases with nothing hidden, constants off, on benches that go through UNKIND_NULLS."""
    nulls = itertools.islice(itertools.cycle(UNKIND_NULLS), count)
    return [drawn_case(f"{k:03d}_none", _words(u), (), (seed, 1000, k), unkind=u) for k, u in enumerate(nulls)]


ALONE = (1.0, 0.5, 0.3)
"""Shares of their usual length that recordings last which come alone."""


def alone_cases(seed: int, count: int) -> list[Case]:
    """Cases of one recording each, some of them short: half on other machines, a quarter with nothing hidden."""
    quarter = count // 4
    others = other_machine_cases(seed, count - 2 * quarter)
    every = [*others, *null_cases(seed, quarter), *drawn_cases(seed, quarter)]
    return [
        replace(
            case,
            name=f"{k:03d}_{case.kind}",
            seconds=case.seconds * ALONE[k % len(ALONE)],
            train_drives=(case.train_drives[k % len(case.train_drives)],),
        )
        for k, case in enumerate(every)
    ]


def law_cases(seed: int, count: int) -> list[Case]:
    """Cases that hide one effect under each of its laws in turn, on the stock bench and on other machines."""
    laws = [(id, law) for id, e in catalogue().items() if e.law for law in e.options[e.law]]
    both = itertools.product((drawn_case, other_machine_case), laws)
    cases = []
    for k, (make, (id, law)) in enumerate(itertools.islice(itertools.cycle(both), count)):
        case = make(f"{k:03d}_{law}", law, [id], (seed, 6000, k))
        cases.append(replace(case, causes=tuple(replace(cause, options={"law": law}) for cause in case.causes)))
    return cases


def left_out_cases(seed: int, count: int) -> list[Case]:
    """One hidden effect each, in turn, which is to be left out of the catalogue (the stock model's own are not)."""
    return [
        drawn_case(f"{k:03d}_{id}", id, (id,), (seed, 2000, k), company=_company(id, seed, k))
        for k, id in enumerate(itertools.islice(itertools.cycle(SWEPT), count))
    ]


def sweep(seed: int, effects: Sequence[str], solve: Solvers, say: Callable[[str], None]) -> dict[str, dict[str, Any]]:
    """The smallest size of each effect that is named in ENOUGH of TRIES cases, by going up or down the ladder."""
    limits = {}
    for id in effects:
        limits[id] = _limit(id, seed, solve)
        say(_limit_line(id, limits[id]))
    return limits


def _limit(id: str, seed: int, solve: Solvers) -> dict[str, Any]:
    tried: dict[float, int] = {}

    def named(step: int) -> bool:
        size = SIZES[step]
        tried[size] = sum(verdict.found for verdict in solve([_sized(id, size, seed, k) for k in range(TRIES)]))
        return tried[size] >= ENOUGH

    step = len(SIZES) // 2
    if named(step):
        while step > 0 and named(step - 1):
            step -= 1
    else:
        step += 1
        while step < len(SIZES) and not named(step):
            step += 1
    parameter, usual = SIZE_OF[id]
    size = value = None
    if step < len(SIZES):
        size = SIZES[step]
        value = abs(middling_cause(id, np.random.default_rng(0), size).values[parameter] - usual.zero)
    return {"size": size, "parameter": parameter, "value": value, "named": dict(sorted(tried.items()))}


def _limit_line(id: str, limit: dict[str, Any]) -> str:
    tried = "  ".join(f"{size:g}: {count}/{TRIES}" for size, count in limit["named"].items())
    smallest = f"{limit['parameter']} {limit['value']:.3g}" if limit["value"] is not None else "not at any size tried"
    return f"{id:24s} {smallest:28s} ({tried})"


def _sized(id: str, size: float, seed: int, number: int) -> Case:
    random = np.random.default_rng((seed, 3000, CATALOGUE.index(id), number))
    company = (middling_cause(id, random, size), *_company(id, seed, number))
    return drawn_case(f"{id}_{size:g}_{number}", id, (), (seed, 3001, number), company=company)


def _company(id: str, seed: int, number: int) -> tuple[Cause, ...]:
    """The load that an effect needs to be seen at all, of its usual size."""
    random = np.random.default_rng((seed, 3500, number))
    return tuple(drawn_causes(in_company([id], random)[1:], stock_machine(), random))


def robustness_cases(seed: int, count: int) -> list[Case]:
    """``count`` cases with one hidden effect under each condition; a case's kind is the condition's name.

    The effects and the machines are the same under each condition, as far as it leaves them: only it differs.
    """
    cases = []
    for name, more in CONDITIONS.items():
        ids = [id for id in CATALOGUE if "size" not in more or id not in NOT_SMALL]
        for k in range(count):
            hidden: tuple[str, ...] = (ids[(seed + 5 * k) % len(ids)],)
            if name == "look-alike pairs":
                hidden = LOOK_ALIKE[k % len(LOOK_ALIKE)]
            company = _company(hidden[0], seed, k)
            cases.append(drawn_case(f"{k:02d} {name}", name, hidden, (seed, 4001, k), company=company, **more))
    return cases


CONDITIONS: dict[str, dict[str, Any]] = {
    "as it is": {},
    "counters and current": {"unkind": Unkind(signals=COUNTERS_AND_CURRENT)},
    "controller noise 0.004": {"unkind": Unkind(controller_noise=0.004)},
    "controller noise 0.02": {"unkind": Unkind(controller_noise=0.02)},
    "look-alike pairs": {},
    "a fifth of the size": {"size": 0.2},
    "5 s": {"seconds": 5.0},
    "10 s": {"seconds": 10.0},
    "60 s": {"seconds": 60.0},
    "120 s": {"seconds": 120.0},
    "one triangle only": {"train": (Drive("triangle", 0.04, 2.5),)},
    "one ramp only": {"train": (Drive("ramp", 0.05),)},
    "counter jump": {"unkind": Unkind(counter_jump=True)},
    "5 % of rows dropped": {"unkind": Unkind(dropped=0.05)},
    "uneven stamps": {"unkind": Unkind(uneven=0.3)},
    "spikes": {"unkind": Unkind(spikes=5e-4)},
    "interpolation error": {"unkind": Unkind(interpolation=1.5e-5)},
    "gearbox rings at 90 Hz": {"unkind": Unkind(gear_resonance=90.0)},
    "load rings at 90 Hz": {"unkind": Unkind(load_resonance=90.0)},
    "friction wanders 8 %": {"unkind": Unkind(wander=0.08)},
    "power cycled": {"unkind": Unkind(power_cycled=True)},
    "constants off by 10 %": {"off": 0.1},
}
"""What robustness is measured under: arguments of ``drawn_case``."""


def _words(unkind: Unkind) -> str:
    """The switches that are on."""
    on = [name for name, usual in vars(Unkind()).items() if getattr(unkind, name) != usual]
    return " ".join(on).replace("_", " ") or "kind bench"
