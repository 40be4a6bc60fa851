"""The turning gearbox: sun, planets, carrier and both rings, coloured by the torque on their teeth."""

from __future__ import annotations

import math

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from ..plant.planetary.geometry import PLANETS, Gearing
from .palette import BENCH, TEXT, Colour
from .stream import TIMELINE, send, style
from .train_motion import TrainMotion
from .wheel_mesh import WheelMesh, wheel_meshes

ROOT = "gear_train"
_APART = 3.0  # face widths between the two stages, drawn apart so that both can be seen
_FORWARD: Colour = (255, 130, 40)
_BACKWARD: Colour = (60, 140, 255)
_IDLE: Colour = (140, 148, 158)
_CARRIER: Colour = (92, 100, 110)
_TORQUES = (
    ("sun", "on the sun", (240, 242, 244)),
    ("fixed_ring", "on the fixed ring", (199, 155, 230)),
    ("output_ring", "on the output ring", (90, 208, 122)),
)
_TURN = 2.0 * math.pi
_WAYS = [_TURN * k / PLANETS for k in range(PLANETS)]
"""Directions [rad] of the planets, seen from the centre, at the start."""
_EYE = (0.44, -0.84, 0.80)
"""Position of the camera, in diameters of the fixed ring."""
_RIGHT = (0.886, 0.464)
"""Direction to the right as seen from there, in the plane of the wheels."""


def log_train(stream: rr.RecordingStream, gearing: Gearing) -> None:
    """Send the wheels and the words next to them."""
    meshes = wheel_meshes(gearing)
    for name, mesh in _parts(meshes).items():
        solid = rr.Mesh3D(
            vertex_positions=mesh.positions, vertex_normals=mesh.normals, triangle_indices=mesh.triangles,
        )  # fmt: skip
        stream.log(f"{ROOT}/wheels/{name}", solid, static=True)
        if "ring" not in name:  # a mark, so that the eye can follow its turns
            high = 0.52 * gearing.face_width
            mark = [[0.45 * mesh.radius, 0.0, high], [0.92 * mesh.radius, 0.0, high]]
            stream.log(
                f"{ROOT}/wheels/{name}/mark", rr.LineStrips3D([mark], colors=[BENCH], radii=[0.0012]), static=True
            )
    _log_carrier(stream, gearing)
    _log_words(stream, gearing, meshes)
    for name, title, colour in _TORQUES:
        style(stream, f"{ROOT}/torque/{name}", f"{title} [N m]", colour, 2.0)


def _parts(meshes: dict[str, WheelMesh]) -> dict[str, WheelMesh]:
    """The mesh of every wheel, by its entity."""
    found = {name: meshes[name] for name in ("sun", "fixed_ring", "output_ring")}
    for k in range(PLANETS):
        found[f"planet_{k + 1}"] = meshes["planet"]
        found[f"second_planet_{k + 1}"] = meshes["second_planet"]
    return found


def _log_carrier(stream: rr.RecordingStream, gearing: Gearing) -> None:
    """Send the carrier: three arms in front of the first stage, and the planets' shafts through both stages."""
    stage = _APART * gearing.face_width
    near = 0.85 * gearing.face_width
    pins = [gearing.centre_distance * np.array([math.cos(a), math.sin(a), 0.0]) for a in _WAYS]
    arms = [[[0.0, 0.0, near], [*pin[:2], near]] for pin in pins]
    shafts = [[[*pin[:2], near], [*pin[:2], -stage - 0.6 * gearing.face_width]] for pin in pins]
    arm = 0.16 * gearing.planet_radius
    drawn = rr.LineStrips3D([*arms, *shafts], colors=[_CARRIER], radii=[arm] * PLANETS + [1.3 * arm] * PLANETS)
    stream.log(f"{ROOT}/wheels/carrier", drawn, static=True)


def _log_words(stream: rr.RecordingStream, gearing: Gearing, meshes: dict[str, WheelMesh]) -> None:
    g, stage = gearing, _APART * gearing.face_width
    aside = 1.35 * meshes["fixed_ring"].radius * np.array([*_RIGHT, 0.0])
    below = np.array([0.0, 0.0, -stage])
    words = [
        (f"fixed ring, {g.ring_teeth} teeth", aside),
        (f"output ring, {g.output_ring_teeth} teeth: 1 turn in {abs(g.ratio):.4g} of the sun", 1.45 * aside + below),
        (f"sun, {g.sun_teeth} teeth: on the motor's shaft", np.array([0.0, 0.0, 3.0 * g.face_width])),
        (f"planets, {g.planet_teeth} teeth, on the carrier", -aside),
        (f"second toothing of the planets, {g.second_planet_teeth} teeth", below - 1.25 * aside),
    ]
    places = [place for _, place in words]
    texts = [text for text, _ in words]
    drawn = rr.Points3D(places, labels=texts, colors=[TEXT], radii=[0.0], show_labels=True)
    stream.log(f"{ROOT}/words", drawn, static=True)


def send_motion(stream: rr.RecordingStream, gearing: Gearing, motion: TrainMotion, strongest: np.ndarray) -> None:
    """Turn the wheels; colours are strongest at the ``strongest`` torques [N m] (3,), as in ``TrainMotion``."""
    times = [rr.TimeColumn(TIMELINE, duration=motion.time)]
    stage = -_APART * gearing.face_width
    sun, planets, seconds, ring, output = starting_angles(gearing)
    on_sun, on_ring, on_output = (
        _colours(torque / most if most else torque) for torque, most in zip(motion.torques, strongest, strict=True)
    )
    still = np.zeros_like(motion.time)

    def turn(
        name: str, angle: np.ndarray, colours: np.ndarray | None, at: np.ndarray | None = None, z: float = 0.0
    ) -> None:
        place = np.zeros((len(angle), 3)) if at is None else np.column_stack([at, np.zeros(len(angle))])
        place[:, 2] += z
        quaternion = np.column_stack([np.zeros((len(angle), 2)), np.sin(0.5 * angle), np.cos(0.5 * angle)])
        entity = f"{ROOT}/wheels/{name}"
        stream.send_columns(entity, times, rr.Transform3D.columns(translation=place, quaternion=quaternion))
        if colours is not None:
            stream.send_columns(entity, times, rr.Mesh3D.columns(albedo_factor=colours))

    turn("sun", sun + motion.sun, on_sun)
    turn("fixed_ring", ring + still, on_ring)
    turn("output_ring", output + motion.output, on_output, z=stage)
    turn("carrier", motion.carrier, None)
    for k, start in enumerate(_WAYS):
        way = start + motion.carrier
        at = gearing.centre_distance * np.column_stack([np.cos(way), np.sin(way)])
        turn(f"planet_{k + 1}", planets[k] + motion.planets[:, k], on_ring, at)
        turn(f"second_planet_{k + 1}", seconds[k] + motion.planets[:, k], on_output, at, stage)
    for (name, _, _), torque in zip(_TORQUES, motion.torques, strict=True):
        send(stream, f"{ROOT}/torque/{name}", motion.time, torque)


def starting_angles(gearing: Gearing) -> tuple[float, list[float], list[float], float, float]:
    """Angles [rad] at which all teeth mesh: sun, planets, second planets, fixed ring, output ring.

    A wheel's phase in a direction is the number of its teeth from there to its own x axis. Wheels that turn in opposite
    directions mesh if their phases add up to a half; wheels that turn in the same direction, if they differ by a half.
    """
    g = gearing
    planets = [way + math.pi - (0.5 - g.sun_teeth * way / _TURN) * _TURN / g.planet_teeth for way in _WAYS]
    ring = (0.5 + g.planet_teeth * planets[0] / _TURN) * _TURN / g.ring_teeth
    seconds = [way - (0.5 + g.output_ring_teeth * way / _TURN) * _TURN / g.second_planet_teeth for way in _WAYS]
    return 0.0, planets, seconds, ring, 0.0


def _colours(share: np.ndarray) -> np.ndarray:
    """Colours (n, 4): grey without torque, orange for a torque in the motor's direction, blue for one against it."""
    share = np.clip(np.nan_to_num(share), -1.0, 1.0)[:, None]
    full = np.where(share >= 0.0, _FORWARD, _BACKWARD)
    mixed = np.asarray(_IDLE) + np.abs(share) * (full - np.asarray(_IDLE))
    return np.column_stack([mixed, np.full(len(mixed), 255.0)]).round().astype(np.uint8)


def train_tab(of: str, strongest: np.ndarray, gearing: Gearing, *, simulated: bool) -> rrb.Container:
    """The train in 3D, and below it the torques over time; ``of`` says whose motion it shows."""
    reach = 2.0 * gearing.ring_radius
    eye = rrb.EyeControls3D(
        position=[share * reach for share in _EYE],
        look_target=[0.0, 0.0, -0.5 * _APART * gearing.face_width],
        eye_up=[0.0, 0.0, 1.0],
    )
    colours = "orange: torque in the motor's direction, blue: against it"
    most = ", ".join(
        f"{words.removeprefix('on the ')} {torque:.3g}"
        for (_, words, _), torque in zip(_TORQUES, strongest, strict=True)
    )
    how = "" if simulated else ", from the motor's by the ratios"
    return rrb.Vertical(
        rrb.Spatial3DView(
            origin=f"/{ROOT}",
            contents=["$origin/wheels/**", "$origin/words"],
            name=f"gear train, {of}; {colours}",
            eye_controls=eye,
            line_grid=False,
        ),
        rrb.TimeSeriesView(
            origin=f"/{ROOT}/torque",
            name=f"torque of the teeth{how} [N m]; full colour: {most}",
            plot_legend=rrb.PlotLegend(rrb.Corner2D.RightTop),
        ),
        row_shares=[3, 1],
        name="gear train",
    )
