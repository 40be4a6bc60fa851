"""A slide whose positions are lengths, moved by a motor that turns: its way per turn makes forces of torques.

Without that way, a number given as the torque constant is read as a force per ampere, as of a linear motor.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording
from ema_bench_replay.units import unit_in

from ..measured.usual_sizes import largest_of, looks_too_small_for_a_winding
from ..model.check_comment import ASSUMED
from ..quantities import quantity
from .given import Given
from .shaft import ALIKE
from .torque_constant import GIVEN, TorqueConstant, question_about

HOW_TO_GIVE = "as in --travel-per-turn '5 mm'"
READ_AS_FORCE = "read as a force per ampere"
"""Begins the doubt about a torque constant that may be a rotary motor's."""


def in_mm(travel: float) -> str:
    """A way per turn [m], in words."""
    return f"{1e3 * travel:.6g} mm"


def refuse_what_does_not_fit(given: Given, recording: Recording) -> None:
    """Raise InputError for a gear ratio of a slide without a motor's position, or a way per turn without a slide."""
    travel, ratio = given.travel_per_turn, given.gear_ratio
    if recording.motion == "rotary":
        if travel is not None:
            raise InputError(
                f"--travel-per-turn: no position or speed of {recording.name} is in a unit of length; name it in the "
                "header, as in 'position [mm]', or leave the option out if all is told of the motor's turns"
            )
        return
    if ratio in (None, 1.0):
        return
    if travel is not None:
        raise InputError(
            f"--gear-ratio: the way per turn of the motor, {in_mm(travel)}, has the gear in it; leave the ratio out "
            f"(if that is the lead of a screw behind the gear, give --travel-per-turn '{in_mm(travel / ratio)}')"
        )
    if not recording.has("motor_position", "output_position"):
        raise InputError(
            f"--gear-ratio: positions in a unit of length, as {recording.name} has, are no turns; give the slide's way "
            f"per turn of the motor in its place, {HOW_TO_GIVE} (the lead of the screw divided by the gear ratio)"
        )


def force_constant(given: float, travel: float | None, *, likely: bool) -> TorqueConstant:
    """The force per ampere [N/A] of a given constant: N m/A of a motor with this ``travel`` [m] per turn, else N/A.

    If it is not ``likely`` one in N/A, its source says that nobody knows it, which a search tells.
    """
    if travel is not None:
        source = f"'{GIVEN}: {given:g} N m/A of the motor, {in_mm(travel)} per turn'"
        return TorqueConstant(given * 2.0 * math.pi / travel, source)
    doubt = f"{READ_AS_FORCE}; if it is in N m/A, of a motor that turns, give its way per turn too, {HOW_TO_GIVE}"
    return TorqueConstant(given, GIVEN if likely else f"{GIVEN}; {ASSUMED} to be in N/A", doubt)


def question_about_turning(given: Given, fastest: float) -> str:
    """A question about a torque constant [N m/A] that hardly any motor has behind a slide; empty if there is none.

    ``fastest`` is the slide's highest speed [m/s]. Raises InputError if no motor has it.
    """
    speed = fastest * 2.0 * math.pi / (given.travel_per_turn or math.inf)
    short = "if the slide goes farther per turn of the motor, correct --travel-per-turn"
    return question_about(given.torque_constant, 1.0, speed, at_joint=False, motion="rotary", if_turning=short)


def doubt_of_travel(travel: float, ratio: float) -> str:
    """What to check of a way per turn [m] if motor and slide show another; ``ratio``: motor's way by the slide's."""
    if abs(ratio - 1.0) < ALIKE:
        return ""
    return f"both positions give {in_mm(travel / ratio)} per turn of the motor, --travel-per-turn says {in_mm(travel)}"


def question_about_force(given: Given, fastest: float, recordings: Sequence[Recording]) -> str:
    """A question about a constant read as a force per ampere that is far too small for one; empty if there is none.

    ``fastest`` is the highest speed [m/s]. What the motor would induce then is compared with the current.
    """
    if given.torque_constant is None or given.travel_per_turn is not None:
        return ""
    current = max(
        (largest_of(recording, "current") for recording in recordings if recording.has("current")), default=0.0
    )
    if not looks_too_small_for_a_winding(given.torque_constant, fastest, current):
        return ""
    unit = unit_in("N m/A", "linear")
    return (
        f"--torque-constant: with {quantity(given.torque_constant, unit)} the motor would do next to no work: it would "
        f"induce {quantity(given.torque_constant * fastest, 'V')} at {quantity(fastest, 'm/s')}, and takes up "
        f"to {quantity(current, 'A')}. Is it in N m/A, of a motor that turns? Then give its way per turn too, "
        f"{HOW_TO_GIVE}"
    )
