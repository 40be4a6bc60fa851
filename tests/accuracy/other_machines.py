"""A second bench, unkind, of machines that are not the stock one: other proportions, other scales, and all that real
machines do besides.

Every machine has LuGre friction that wanders and warms up; it rings somewhere; its output encoder interpolates, its
stamps are uneven, rows are missing. Its constants are known to five per cent. Then it is told in seconds, newton metres
and amperes that are from a tenth to many times those of the bench. Something is honestly left over, so that a right
name beside *unknown* counts.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ema_twin_sim.model.own_units import OwnUnits

from .cases import Case, effects_of, in_turn
from .commands import Drive, drawn_drives
from .hide import CATALOGUE, UNKNOWN
from .machine import Machine, near, stock_machine
from .sizes import drawn_causes
from .unkind import Unkind

_TURNS = ("plain", "pairs", "plain", "none", "plain", "plain", "pairs", "plain", "unknown", "plain")
"""The kinds in the order that they are drawn in."""
_RATIOS = (30.0, 51.0, 80.0, 100.0, 124.0, 160.0)
_STOCK_RATIO = 124.0
"""The gear ratio that the commands are for."""


def other_machine_cases(seed: int, count: int) -> list[Case]:
    """Cases on machines of all sizes; the same seed gives the same cases."""
    random = np.random.default_rng((seed, 5000))
    plain, unknown = in_turn(CATALOGUE, random), in_turn(UNKNOWN, random)
    return [
        other_machine_case(f"{number:03d}_{kind}", kind, effects_of(kind, plain, unknown, random), (seed, 5001, number))
        for number, kind in enumerate(itertools.islice(itertools.cycle(_TURNS), count))
    ]


def other_machine_case(name: str, kind: str, effects: Sequence[str], seed: Sequence[int]) -> Case:
    """A case with these effects on a machine that is drawn from the seed, as its traces are."""
    random = np.random.default_rng(seed)
    nominal = _drawn(random)
    machine = near(nominal, random, 0.05)
    train, holdout = drawn_drives(random)
    slower = _STOCK_RATIO / nominal.gear_ratio
    rings = {"gear_resonance": random.uniform(60.0, 150.0)}, {"load_resonance": random.uniform(60.0, 150.0)}
    return Case(
        name=name,
        kind=kind,
        seed=(*seed, 1),
        machine=machine,
        causes=tuple(drawn_causes(effects, machine, random)),
        train_drives=tuple(_times(drive, slower) for drive in train),
        holdout_drives=tuple(_times(drive, slower) for drive in holdout),
        seconds=float(random.choice([10.0, 15.0, 20.0])),
        unkind=Unkind(
            **rings[int(random.integers(2))],
            wander=float(random.uniform(0.02, 0.04)),
            warming=float(random.uniform(0.02, 0.06)),
            interpolation=float(random.uniform(3e-6, 1e-5)),
            uneven=float(random.uniform(0.0, 0.2)),
            dropped=float(random.choice([0.0, 0.005])),
            spikes=float(random.choice([0.0, 1e-4])),
        ),
        motor_origin=float(random.uniform(-math.pi, math.pi)),
        output_origin=float(random.uniform(-math.pi, math.pi)),
        nominal=nominal,
        told_in=_units(random),
    )


def _drawn(random: np.random.Generator) -> Machine:
    """A machine of other proportions than the stock one."""

    def times(value: float, low: float, high: float) -> float:
        return value * math.exp(random.uniform(math.log(low), math.log(high)))

    stock = stock_machine()
    motor, output = times(stock.motor_inertia, 0.5, 2.0), times(stock.output_inertia, 0.3, 2.0)
    return replace(
        stock,
        motor_inertia=motor,
        output_inertia=output,
        motor_viscous=times(stock.motor_viscous, 0.5, 2.0),
        motor_level=times(stock.motor_level, 0.7, 2.0),
        output_level=times(stock.output_level, 0.5, 1.5),
        bristle_travel=random.uniform(6e-4, 3e-3),
        elastic_share=-1.0,
        gear_ratio=float(random.choice(_RATIOS)),
        speed_gain=(motor + output) / (stock.motor_inertia + stock.output_inertia),
    )


def _times(drive: Drive, factor: float) -> Drive:
    """A command that turns the motor as far through another gear."""
    return replace(drive, size=drive.size * factor)


def _units(random: np.random.Generator) -> OwnUnits:
    """Such that the bench's s, N m and A are from a tenth to many times the machine's."""
    time, torque = math.exp(random.uniform(math.log(0.25), math.log(10.0))), 10.0 ** random.uniform(-2.0, 2.0)
    return OwnUnits(time, torque, torque ** random.uniform(0.3, 0.8))
