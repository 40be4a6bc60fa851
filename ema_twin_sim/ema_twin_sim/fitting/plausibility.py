"""Plausibility: fitted values that no machine has, which suggest that another effect is missing.

The rules of an effect are in its file (``effects/``); this module computes the data that they use.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ema_bench_replay.recording import Recording

from ..criteria import NEGLIGIBLE
from ..effects import Circumstances, catalogue
from ..model import Model
from ..model.own_units import shown
from ..model.roles import DRY_FRICTION, VISCOUS_FRICTION
from ..reading_noise import reading_noise
from ..simulation.operating_points import directed
from ..simulation.sensor_noise import counter_noise


def circumstances(recordings: Sequence[Recording], model: Model) -> Circumstances:
    """The circumstances given by these recordings and a fitted model."""
    positions = [r.signals["motor_position"] for r in recordings if r.has("motor_position")]
    travel = max((float(np.nanmax(position) - np.nanmin(position)) for position in positions), default=0.0)
    held = [instance for instance in model.effects.values() if instance.enabled]
    return Circumstances(
        duration=max(recording.duration for recording in recordings),
        sample_period=max(recording.sample_period for recording in recordings),
        top_speed=max(top_speed(recording, model) for recording in recordings),
        travel=travel,
        output_travel=travel / model.value("machine.gear_ratio"),
        dry_level=sum(i.parameters["torque"] for i in held if i.effect == DRY_FRICTION),
        viscous=sum(i.parameters["coefficient"] for i in held if i.effect == VISCOUS_FRICTION),
        motor_inertia=model.value("machine.motor_inertia") + model.value("machine.gearbox_inertia"),
        output_inertia=model.value("machine.output_inertia"),
        torque_limit=model.value("drive.torque_limit"),
        limit_in_words="{:g} {}".format(*shown(model, model.value("drive.torque_limit"), "N m")),
    )


def top_speed(recording: Recording, model: Model) -> float:
    """The largest speed [rad/s] of a recording: measured, or from the motor counter.

    From one sample to the next a coarse counter steps by zero or one, whatever the speed. So the displacement is taken
    over as many samples as make its steps negligible.
    """
    if recording.of_points:
        return float(np.nanmax(np.abs(directed(recording, model.value("sensors.speed_noise")).signals["speed"])))
    if recording.has("speed"):
        return float(np.nanmax(np.abs(recording.signals["speed"])))
    known = np.isfinite(recording.signals["motor_position"])
    time, position = recording.time[known], recording.signals["motor_position"][known]
    reading = max(counter_noise(model, "motor"), reading_noise(position))
    lag, found = 1, 0.0
    while lag < len(position):
        way = np.abs(position[lag:] - position[:-lag])
        found = float(np.max(way / (time[lag:] - time[:-lag])))
        if reading <= NEGLIGIBLE * float(np.max(way)):
            break
        lag *= 2
    return found


def implausible(id: str, values: Mapping[str, float], c: Circumstances) -> list[tuple[str, str]]:
    """(parameter, reason) for each implausible value of an effect."""
    effect = catalogue()[id]
    known = (rule for rule in effect.implausible if rule.parameter in values)  # the others are of another law
    found = [(rule.parameter, rule.reason) for rule in known if rule.when(values, c)]
    for p in (one for one in effect.parameters if one.name in values):
        if p.unit == "N m" and abs(values[p.name]) > c.torque_limit:
            found.append((p.name, f"more than the drive's limit of {c.limit_in_words}: it could not move"))
    return found
