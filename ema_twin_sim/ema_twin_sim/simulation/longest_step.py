"""The longest integration step of a model, and what limits it."""

from __future__ import annotations

import math

import numpy as np

from ema_bench_replay.errors import InputError

from ..model import Model
from .assembly import Assembly, assemble
from .fidelity import CYCLE_SHARE, DEFAULT_STEP, FineParts, is_fine
from .unknown_controller import stepped_cycle, without_controller

COARSE = 2.0
"""Times the default step, where only differences matter. Of 36 recordings of six ``bench_cases`` it changes the current
RMSE of one by 2 %, of the others by less than 1 %."""
SAFE = 0.5
"""Share of the longest step that is used where a step that no user chose would be longer."""
Limit = tuple[float, str, str]
"""Step [s], what is too fast for a longer one, what to change."""


def longest_step(assembly: Assembly) -> Limit:
    """The shortest limit of all parts; infinite if there is none."""
    limits = [
        _of_the_train(assembly.fine) if assembly.fine.planetary else _of_the_contact(assembly.plant[0]),
        _of_the_bridge(assembly.fine),
    ]
    return min(limits)


def refuse_long_step(model: Model, assembly: Assembly, step: float) -> None:
    """Raise InputError if a step [s] exceeds the longest."""
    longest, what, remedy = longest_step(assembly)
    if step > longest:
        raise InputError(
            f"model {model.name}: {what} at a step of {step:g} s; "
            f"take {_rounded_down(longest):g} s at most, or {remedy}"
        )


def coarse_step(model: Model) -> float | None:
    """Step [s] for simulations of which only differences matter; None: the default, as the model needs it.

    In a control cycle shorter than usual there are as many steps.
    """
    if is_fine(model):
        return None
    step = COARSE * DEFAULT_STEP
    if model.units is not None:  # such steps are told as shares of the cycle, and shortened where necessary
        return step
    of_cycle = COARSE * CYCLE_SHARE * stepped_cycle(model)
    if without_controller(model):
        return min(of_cycle, SAFE * longest_step(assemble(model))[0])
    step = min(step, of_cycle)
    return step if DEFAULT_STEP < step <= longest_step(assemble(model))[0] else None


def _rounded_down(step: float) -> float:
    """A step [s] rounded down to two digits."""
    digit = 10.0 ** (math.floor(math.log10(step)) - 1)
    return math.floor(step / digit) * digit


def _of_the_contact(plant: np.void) -> Limit:
    """Limit beyond which the integration of spring and damper between two inertias becomes unstable."""
    what, remedy = "its contact is too stiff for its inertias", "give less transmission.contact_stiffness or _damping"
    if not plant["two_inertia"]:
        return math.inf, what, remedy
    softness = 1.0 / plant["motor_inertia"] + 1.0 / plant["output_inertia"]
    by_spring = 2.0 / math.sqrt(plant["contact_stiffness"] * softness)
    by_damper = 4.0 / max(plant["contact_damping"] * softness, 1e-12)
    return float(min(by_spring, by_damper)), what, remedy


def _of_the_train(parts: FineParts) -> Limit:
    """Limit beyond which the train's fastest oscillation would grow."""
    what, remedy = "its teeth are too stiff for its wheels", "give less transmission.youngs_modulus_ratio"
    return 2.0 / parts.frequency, what, remedy


def _of_the_bridge(parts: FineParts) -> Limit:
    """Limit beyond which a phase current crosses its hysteresis band within a step, so that the band does not hold.

    The DC link drives it with at most two thirds of its voltage, when the other two legs oppose the phase's.
    """
    what, remedy = "its phase currents leave their hysteresis band", "give a wider drive.hysteresis"
    if not parts.switching:
        return math.inf, what, remedy
    winding = parts.winding[0]
    steepest = winding["dc_link_voltage"] * 2.0 / 3.0 / winding["phase_inductance"]
    return float(2.0 * winding["hysteresis"] / steepest), what, remedy
