"""How the wheels of the gearbox turn in a recording, and the torques on their teeth."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ema_bench_replay.recording import Recording

from ..model import Model
from ..plant.planetary.geometry import PLANETS, Gearing
from ..plant.planetary.quasi_static import static_forces
from ..simulation.fidelity import gearing_of
from ..simulation.simulate import bench_of, choose_input, started

PICTURES = 50.0  # per second, at most
LONGEST = 60.0  # s that are shown at most
_SAME_RATIO = 1e-3
_USUAL = 0.9  # the quantile of torques at which colours are strongest


@dataclass(frozen=True, eq=False)
class TrainMotion:
    """Angles [rad] since the first sample at times [s] (n,), and torques [N m] of the planets' teeth on the wheels.

    A planet's angle is absolute. Torques are those on the sun, the fixed ring and the output ring, each the sum over
    the planets, positive in the motor's direction; at rest the three add up to zero.
    """

    time: np.ndarray
    sun: np.ndarray
    carrier: np.ndarray
    planets: np.ndarray  # (n, 3)
    output: np.ndarray
    torques: np.ndarray  # (3, n)
    simulated: bool  # else from the ratios

    @property
    def strongest(self) -> np.ndarray:
        """The largest torques [N m] (3,), without rare peaks."""
        return np.asarray(np.nanquantile(np.abs(self.torques), _USUAL, axis=1))


def gearing_shown(model: Model) -> Gearing | None:
    """The gearbox to show: a planetary model's own; for a lumped model, which has no teeth, the Politecnico's.

    None if the model's ratio is not that of these teeth, or if the machine is linear.
    """
    if model.motion != "rotary":
        return None
    gearing = gearing_of(model) if model.kinds["transmission"] == "planetary" else Gearing()
    return gearing if math.isclose(gearing.ratio, model.value("machine.gear_ratio"), rel_tol=_SAME_RATIO) else None


def train_motion(model: Model, gearing: Gearing, recording: Recording, source: str | None = None) -> TrainMotion | None:
    """The wheels' motion in a recording; None if the recording has no motor position, or consists of operating points.

    A planetary model is simulated. A lumped model's wheels follow from the measured motor angle by the ratios, and
    their teeth carry the motor's torque without friction or inertia.
    """
    if recording.of_points or not recording.has("motor_position"):
        return None
    recording = recording.between(recording.time[0], recording.time[0] + LONGEST)
    every = max(1, math.ceil(1.0 / (PICTURES * recording.sample_period)))
    if model.kinds["transmission"] == "planetary":
        return _simulated(model, gearing, recording, every, source)
    rows = slice(None, None, every)
    torque = np.zeros(len(recording.time[rows]))
    if recording.has("current"):
        torque = recording.signals["current"][rows] * model.value("machine.torque_constant")
    return by_ratios(gearing, recording.time[rows], recording.signals["motor_position"][rows], torque)


def by_ratios(gearing: Gearing, time: np.ndarray, sun: np.ndarray, torque: np.ndarray) -> TrainMotion:
    """The wheels' motion in a rigid train, from the sun's angles [rad] (n,) and the torque on it [N m] (n,)."""
    carrier = gearing.carrier_ratio * sun
    planet = carrier - gearing.planet_ratio * sun
    torques = _torques(gearing, PLANETS * static_forces(gearing, 1.0) * torque[:, None])
    planets = np.repeat(planet[:, None], PLANETS, axis=1)
    return TrainMotion(time, sun, carrier, planets, sun / gearing.ratio, torques, simulated=False)


def _torques(gearing: Gearing, forces: np.ndarray) -> np.ndarray:
    """Torques (3, n) on sun, fixed ring and output ring from the forces (n, 3) [N] of their meshes with all planets."""
    radii = np.array([gearing.sun_radius, gearing.ring_radius, gearing.output_ring_radius])
    return -(forces * radii).T


def _simulated(model: Model, gearing: Gearing, recording: Recording, every: int, source: str | None) -> TrainMotion:
    bench = bench_of(recording)
    twin = started(model, recording, bench, choose_input(recording, model, source), None)
    shown = range(0, len(recording), every)
    found = []
    for first in shown:
        if first:
            twin.follow(recording.stamps[first - every : first + 1], bench[first - every : first + 1])
        found.append(twin.wheels())
    wheels = [each for each in found if each is not None]
    forces = np.array([each.forces.sum(axis=1) for each in wheels])
    return TrainMotion(
        recording.time[list(shown)],
        np.array([each.sun_angle for each in wheels]),
        np.array([each.carrier_angle for each in wheels]),
        np.array([each.planet_angles for each in wheels]),
        np.array([each.output_angle for each in wheels]),
        _torques(gearing, forces),
        simulated=True,
    )
