"""The cases: benches with hidden effects, drawn reproducibly from a seed.

from tests.accuracy.cases import drawn_cases
for case in drawn_cases(seed=1, count=60): case.train, case.holdout, case.hidden
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any, TypeVar

import numpy as np

from ema_bench_replay.recording import Recording
from ema_twin_sim.effects import catalogue
from ema_twin_sim.model import Model, load_model
from ema_twin_sim.model.own_units import OwnUnits, model_in, recording_in

from .commands import Drive, drawn_drives
from .hide import CATALOGUE, UNKNOWN
from .machine import Machine, described, drawn_machine, stock_machine
from .other_bench import Cause, OtherBench
from .sizes import OF_THE_STOCK_MODEL, drawn_causes
from .unkind import COUNTERS_AND_CURRENT, Unkind

Drawn = TypeVar("Drawn")
KINDS = ("plain", "pairs", "triples", "none", "unknown", "small", "extreme")

_TURNS = (
    *("plain", "pairs", "plain", "none", "triples", "plain"),
    *("unknown", "pairs", "small", "extreme", "plain", "extreme"),
)
"""The kinds in the order that they are drawn in: of sixty cases twenty are plain."""

_TOGETHER = {"pairs": 2, "triples": 3}
_LOADS = ("gravity_load", "spring_load")
"""What makes friction in proportion to load visible: alone it is Coulomb friction."""

_NOT_TOGETHER = (
    ("viscous_friction", "thermal_friction"),
    ("viscous_friction", "shear_thinning"),
    ("viscous_friction", "quadratic_drag"),
    ("coulomb_friction", "presliding_friction"),
    ("quadratic_drag", "shear_thinning"),
    ("torque_constant_error", "added_inertia"),
    ("torque_constant_error", "phase_short"),
    ("torque_constant_error", "coulomb_friction"),
    ("torque_constant_error", "viscous_friction"),
    ("torque_constant_error", "mesh_friction"),
    ("spring_load", "gravity_load", "constant_load"),
)
"""Effects of which no recording of the set could tell the parts, or that would overrule each other."""
LOOK_ALIKE = (
    ("constant_load", "asymmetric_friction"),
    ("shaft_compliance", "backlash"),
    ("backlash", "presliding_friction"),
    ("stribeck_friction", "presliding_friction"),
    ("gravity_load", "constant_load"),
    ("spring_load", "thermal_friction"),
    ("cogging", "torque_ripple"),
    ("phase_short", "rotor_eccentricity"),
    ("encoder_delay", "backlash"),
    ("encoder_delay", "shaft_compliance"),
    ("quadratic_drag", "thermal_friction"),
    ("added_inertia", "shaft_compliance"),
    ("sun_runout", "tooth_fault"),
)
"""Pairs of effects that are easily taken for each other, or for one."""

NOT_SMALL = (*OF_THE_STOCK_MODEL, "torque_constant_error", "added_inertia")
"""Effects that constants known to 5 % hide where they are small: nothing could name them."""

ANGLES = ("phase", "angle", "position")
"""Parameters that are angles: their errors are taken round the circle, and are no relative ones."""

_TORQUES = ("torque", "coefficient", "stiffness", "damping", "inertia")
"""Parameters that are torques over something: a trace tells them in ampere."""


@dataclass(frozen=True, eq=False)
class Case:
    """A bench with something hidden, and what its drive is commanded. The recordings are made when asked for."""

    name: str
    kind: str
    seed: tuple[int, ...]
    machine: Machine
    causes: tuple[Cause, ...]
    train_drives: tuple[Drive, ...]
    holdout_drives: tuple[Drive, ...]
    seconds: float = 20.0
    unkind: Unkind = field(default_factory=Unkind)
    motor_origin: float = -math.pi
    output_origin: float = 1.276
    moved: bool = False
    held: float = 0.0
    nominal: Machine | None = None  # what the start model says of the machine; None: what the stock model says
    told_in: OwnUnits = OwnUnits()  # noqa: RUF009 frozen; the machine's s, N m and A in the bench's

    @property
    def start_model(self) -> Model:
        """The model that discovery begins with."""
        model = load_model("polito_bench")
        if self.nominal is not None:
            model = described(model, self.nominal)
        for id in self.remove_from_stock_model:
            model = model.without_effect(id)
        return model if self.told_in == OwnUnits() else replace(model_in(model, self.told_in), units=None)

    @property
    def hidden(self) -> tuple[str, ...]:
        """What is to be named: catalogue ids, and ``unknown`` where a cause is in no catalogue."""
        return tuple("unknown" if cause.id in UNKNOWN else cause.id for cause in self.causes)

    @property
    def parameters(self) -> Mapping[str, Mapping[str, float]]:
        """True values by effect; of ``coulomb_friction`` and ``viscous_friction`` the sum over both sides.

        Torques are as a trace shows them to who believes the drive's torque constant: ampere times that constant.
        """
        shown = 1.0
        if "torque_constant_error" not in self.hidden:
            shown = (self.nominal or stock_machine()).torque_constant / self.machine.torque_constant
        units = {id: {p.name: p.unit for p in catalogue()[id].parameters} for id in self.hidden if id != "unknown"}
        return {
            cause.id: {
                name: value
                * (shown if name in _TORQUES and cause.id != "mesh_friction" else 1.0)
                / (1.0 if name in ANGLES else self.told_in.factor(units[cause.id][name]))
                for name, value in cause.values.items()
            }
            for cause in self.causes
            if cause.id not in UNKNOWN
        }

    @property
    def remove_from_stock_model(self) -> tuple[str, ...]:
        """Effects to take out of the stock model first."""
        return tuple(id for id in self.hidden if id in OF_THE_STOCK_MODEL)

    @property
    def tolerated(self) -> tuple[str, ...]:
        """Effects that the unkind bench truly has besides: right where they are named, no loss where they are not."""
        rings = ("shaft_compliance",) if self.unkind.gear_resonance else ()
        bends = ("presliding_friction",) if self.machine.elastic_share < 0.0 else ()
        warms = ("thermal_friction",) if self.unkind.warming else ()
        return tuple(id for id in (*rings, *bends, *warms) if id not in self.hidden)

    @property
    def restless(self) -> bool:
        """Whether something in no catalogue is there besides: then ``unknown`` is as right as what is named."""
        return self.unkind.wander > 0.0

    @cached_property
    def recordings(self) -> tuple[tuple[Recording, ...], tuple[Recording, ...]]:
        """(train, holdout), made in one day at the bench."""
        origins = self.motor_origin, self.output_origin
        bench = OtherBench(self.machine, self.causes, self.unkind, self.seed, *origins, self.moved, self.held)
        train, holdout = (
            tuple(recording_in(bench.record(drive, self.seconds), self.told_in) for drive in drives)
            for drives in (self.train_drives, self.holdout_drives)
        )
        return train, holdout

    @property
    def train(self) -> tuple[Recording, ...]:
        """Recordings for discovery."""
        return self.recordings[0]

    @property
    def holdout(self) -> tuple[Recording, ...]:
        """Recordings for judging only."""
        return self.recordings[1]


def drawn_case(
    name: str,
    kind: str,
    effects: Sequence[str],
    seed: Sequence[int],
    *,
    size: float = 1.0,
    company: Sequence[Cause] = (),
    unkind: Unkind | None = None,
    seconds: float = 20.0,
    off: float = 0.05,
    train: Sequence[Drive] = (),
) -> Case:
    """A case with these effects, all else drawn from the seed.

    ``company`` are causes hidden as they are; ``off`` is by how much the machine's constants are off at most; ``train``
    takes the place of the drawn commands.
    """
    random = np.random.default_rng(seed)
    machine = drawn_machine(random, off)
    train_drives, holdout_drives = drawn_drives(random)
    own_zero = random.random() < 0.5
    return Case(
        name=name,
        kind=kind,
        seed=(*seed, 1),
        machine=machine,
        causes=(*drawn_causes(effects, machine, random, size), *company),
        train_drives=tuple(train) or train_drives,
        holdout_drives=holdout_drives,
        seconds=seconds,
        unkind=unkind or Unkind(),
        motor_origin=float(random.uniform(-math.pi, math.pi)) if own_zero else -math.pi,
        output_origin=float(random.uniform(-math.pi, math.pi)) if own_zero else 1.276,
        moved=bool(random.random() < 0.3),
        held=0.5 if random.random() < 0.3 else 0.0,
    )


def drawn_cases(seed: int, count: int = 60, kinds: Sequence[str] = KINDS) -> tuple[Case, ...]:
    """Cases of these kinds in turn; the same seed gives the same cases. ``plain`` goes through the whole catalogue."""
    random = np.random.default_rng((seed, 77))
    plain = in_turn(CATALOGUE, random)
    small = (id for id in in_turn(CATALOGUE, random) if id not in NOT_SMALL)
    unknown = in_turn(UNKNOWN, random)
    extreme = in_turn(range(len(_EXTREMES)), random)
    turns = itertools.cycle([kind for kind in _TURNS if kind in kinds])
    cases = []
    for number, kind in enumerate(itertools.islice(turns, count)):
        more: dict[str, Any] = {}
        if kind == "small":
            wanted, *loads = in_company([next(small)], random)
            more = {"size": 0.2, "company": drawn_causes(loads, stock_machine(), random)}
            effects: Sequence[str] = [wanted]
        elif kind == "extreme":
            effects, more = _EXTREMES[next(extreme)](random)
        else:
            effects = effects_of(kind, plain, unknown, random)
        cases.append(drawn_case(f"{number:03d}_{kind}", kind, effects, (seed, number), **more))
    return tuple(cases)


def in_turn(values: Iterable[Drawn], random: np.random.Generator) -> Iterator[Drawn]:
    """These over and over, in an order that is drawn."""
    return itertools.cycle(random.permutation([*values]).tolist())


def effects_of(kind: str, plain: Iterator[str], unknown: Iterator[str], random: np.random.Generator) -> list[str]:
    """What a case hides that is nothing but plain, a pair, a triple, unknown, or none."""
    if kind == "plain":
        return in_company([next(plain)], random)
    if kind in _TOGETHER:
        return drawn_effects(_TOGETHER[kind], random)
    return [next(unknown)] if kind == "unknown" else []


def in_company(effects: list[str], random: np.random.Generator) -> list[str]:
    """The effects, with the load that one of them needs to be seen at all."""
    if "mesh_friction" in effects and not set(_LOADS) & set(effects):
        return [*effects, str(random.choice(_LOADS))]
    return effects


def drawn_effects(count: int, random: np.random.Generator) -> list[str]:
    """So many effects that go together."""
    while True:
        effects = in_company(random.choice(CATALOGUE, count, replace=False).tolist(), random)
        if not any(len({*group} & {*effects}) > 1 for group in _NOT_TOGETHER):
            return effects


_Extreme = tuple[Sequence[str], dict[str, Any]]


def _look_alikes(random: np.random.Generator) -> _Extreme:
    return LOOK_ALIKE[random.integers(len(LOOK_ALIKE))], {}


def _drawn_with(count: int, more: dict[str, Any], random: np.random.Generator) -> _Extreme:
    return drawn_effects(count, random), more


def _noisy_controller(random: np.random.Generator) -> _Extreme:
    noise = float(random.choice([0.004, 0.02]))
    effects = drawn_effects(int(random.integers(1, 3)), random) if random.random() < 0.7 else []
    return effects, {"unkind": Unkind(controller_noise=noise)}


def _ringing(random: np.random.Generator) -> _Extreme:
    frequency = float(random.uniform(50.0, 150.0))
    ringing = Unkind(gear_resonance=frequency) if random.random() < 0.5 else Unkind(load_resonance=frequency)
    return [id for id in drawn_effects(1, random) if id != "shaft_compliance"], {"unkind": ringing}


def _wandering(random: np.random.Generator) -> _Extreme:
    effects = drawn_effects(1, random) if random.random() < 0.5 else []
    return effects, {"unkind": Unkind(wander=float(random.uniform(0.05, 0.1)))}


_BAD_TRACE = Unkind(spikes=3e-4, uneven=0.2, dropped=0.01, interpolation=1e-5, counter_jump=True)
_EXTREMES = (
    *(_look_alikes, partial(_drawn_with, 1, {"unkind": Unkind(signals=COUNTERS_AND_CURRENT)}), _noisy_controller),
    *(partial(_drawn_with, 2, {"seconds": 10.0}), _ringing, _wandering),
    *(partial(_drawn_with, 1, {"unkind": _BAD_TRACE}), _look_alikes),
)
