"""What recordings can show of a machine: limits of operating points, and of two encoders without torque data."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from ema_bench_replay.recording import Recording

from ..criteria import NEGLIGIBLE
from ..effects import Trait, catalogue, effects_with
from ..effects.catalogue import is_own
from ..model import Model
from ..model.own_units import is_linear
from ..simulation.behind_motor import of_encoders_alone
from ..simulation.operating_points import moves
from .load_sensor import load_varies

ENDLESS = 50.0
"""Turns of an output, one way, that no spring follows."""
PLACES = frozenset({"order", "output_position", "encoders"})
"""Quantities whose effects do not show if no position is known."""


def not_shown(recordings: Sequence[Recording], model: Model) -> frozenset[str]:
    """Effects that the recordings cannot show: none holds a torque, all are of operating points, or all turn on and on.

    The recordings are in the units of the ``model``, whose sensors say which points are at rest.
    """
    if all(map(of_encoders_alone, recordings)):
        return frozenset(id for id, effect in catalogue().items() if effect.depends_on != "encoders")
    endless = bool(recordings) and all(_turns_on(recording, model) for recording in recordings)
    return _not_at_points(recordings, model) | (effects_with(Trait.WOUND_UP) if endless else frozenset())


def _turns_on(recording: Recording, model: Model) -> bool:
    """Whether an output makes turns one way and never comes back, as that of a fan does.

    What grows with its travel then is what grows with time: no spring is wound up by so many turns in every recording,
    not even that of a screw or a valve. A carriage makes no turns.
    """
    if recording.of_points or not recording.has("motor_position") or is_linear(model):
        return False
    turned = recording.signals["motor_position"] / (model.turn * model.value("machine.gear_ratio"))
    turned = turned[np.isfinite(turned)]
    on = abs(float(turned[-1] - turned[0])) if len(turned) else 0.0
    return on > ENDLESS and float(np.ptp(turned)) <= (1.0 + NEGLIGIBLE) * on


def own_not_shown(recordings: Sequence[Recording], model: Model, without: Collection[str]) -> tuple[str, ...]:
    """One sentence if users' own effects (except ``without``) were not searched for, as no torque was measured."""
    hidden = not_shown(recordings, model) - {*without} if all(map(of_encoders_alone, recordings)) else frozenset()
    own = sorted(id for id in hidden if is_own(catalogue()[id]))
    if not own:
        return ()
    return (
        f"{', '.join(own)}: your own effects on the torque do not show between two encoders alone, and were not looked "
        "for; record the drive's torque or current as well",
    )


def _not_at_points(recordings: Sequence[Recording], model: Model) -> frozenset[str]:
    """Effects that operating points cannot show, if all recordings are of this kind."""
    if not all(recording.of_points for recording in recordings):
        return frozenset()
    hidden = effects_with(Trait.TRANSIENT) | effects_with(Trait.BY_CURRENT)
    fed = [recording for recording in recordings if recording.has("current") and recording.signals["current"].any()]
    if any(map(load_varies, fed)):
        hidden -= effects_with(Trait.TORQUE_FACTOR)  # the load sensor tells how much torque an ampere gives
    if not any(moves(recording, model.value("sensors.speed_noise")) for recording in recordings):
        hidden |= effects_with(Trait.NOT_AT_REST)
    positions = [r.signals["motor_position"] for r in recordings if r.has("motor_position")]
    if not any(float(np.nanmax(position) - np.nanmin(position)) > 0.0 for position in positions):
        hidden |= {id for id, effect in catalogue().items() if effect.depends_on in PLACES}
    return hidden


def at_rest(model: Model, recordings: Sequence[Recording]) -> Model:
    """Disable the effects that operating points at rest cannot show; ``restored`` enables them again."""
    hidden = _not_at_points(recordings, model)
    sleeping = {
        name: replace(instance, enabled=False) for name, instance in model.active.items() if instance.effect in hidden
    }
    return replace(model, effects={**model.effects, **sleeping}) if sleeping else model


def restored(found: Model, given: Model) -> Model:
    """Enable the effects that are enabled in the ``given`` model."""
    on = {name: replace(found.effects[name], enabled=True) for name in given.active if name in found.effects}
    return replace(found, effects={**found.effects, **on})
