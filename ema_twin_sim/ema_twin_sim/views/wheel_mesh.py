"""Toothed wheels as meshes: involute flanks from a gearbox's own teeth, radii and addendum, extruded along the axis."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..plant.planetary.contact import Mesh
from ..plant.planetary.geometry import OUTPUT_MESH, RING_MESH, SUN_MESH, Gearing

_FLANK = 6  # points of a flank
_CLEARANCE = 0.25  # of the addendum, below the other wheel's tips
_RIM = 2.2  # addenda of material behind the roots of a ring
_BORE = 0.22  # of the pitch radius


@dataclass(frozen=True, eq=False)
class WheelMesh:
    """A wheel about the z axis, one of its teeth along x: positions and normals (n, 3) [m], triangles (t, 3)."""

    positions: np.ndarray
    normals: np.ndarray
    triangles: np.ndarray
    radius: float  # m, of its outermost point


def wheel_meshes(gearing: Gearing) -> dict[str, WheelMesh]:
    """The five kinds of wheel, by name."""
    sun, ring, output = (gearing.meshes[kind] for kind in (SUN_MESH, RING_MESH, OUTPUT_MESH))
    width = gearing.face_width
    return {
        "sun": _wheel(sun, sun.first_teeth, sun.first_base_radius, False, width),
        "planet": _wheel(ring, ring.first_teeth, ring.first_base_radius, False, width),
        "fixed_ring": _wheel(ring, ring.second_teeth, ring.second_base_radius, True, width),
        "second_planet": _wheel(output, output.first_teeth, output.first_base_radius, False, width),
        "output_ring": _wheel(output, output.second_teeth, output.second_base_radius, True, width),
    }


def _wheel(mesh: Mesh, teeth: int, base: float, inner: bool, width: float) -> WheelMesh:
    pitch = base / math.cos(mesh.pressure_angle)
    side = -1.0 if inner else 1.0  # a ring's teeth point inwards
    tip, root = pitch + side * mesh.addendum, pitch - side * (1.0 + _CLEARANCE) * mesh.addendum
    rim = root + _RIM * mesh.addendum if inner else _BORE * pitch
    return _extruded(outline(teeth, base, mesh.pressure_angle, root, tip, inner=inner), rim, width)


def outline(teeth: int, base: float, pressure_angle: float, root: float, tip: float, *, inner: bool) -> np.ndarray:
    """The toothing of a wheel as a closed polygon (n, 2) [m], counter-clockwise, with a tooth centred on the x axis.

    At the pitch circle, teeth and gaps are equally wide; below the base circle, flanks are radial. Radii in m,
    ``pressure_angle`` in rad; in an ``inner`` toothing the tips are inside the roots.
    """
    radii = np.linspace(root, tip, _FLANK)
    half = half_thickness(radii, teeth, base, pressure_angle, inner=inner)
    middles = 2.0 * math.pi * np.arange(teeth)[:, None] / teeth
    angles = np.concatenate([middles - half, middles + half[::-1]], axis=1).ravel()
    all_radii = np.tile(np.concatenate([radii, radii[::-1]]), teeth)
    return np.column_stack([all_radii * np.cos(angles), all_radii * np.sin(angles)])


def half_thickness(radii: np.ndarray, teeth: int, base: float, pressure_angle: float, *, inner: bool) -> np.ndarray:
    """The half angle [rad] (n,) of a tooth at radii [m] (n,): pi / 2 z at the pitch circle, else by the involute."""
    bent = np.arccos(np.clip(base / np.maximum(radii, base), -1.0, 1.0))
    involute = np.tan(bent) - bent
    at_pitch = math.tan(pressure_angle) - pressure_angle
    half = math.pi / (2 * teeth) + (involute - at_pitch if inner else at_pitch - involute)
    return np.clip(half, 0.05 * math.pi / teeth, 0.95 * math.pi / teeth)


def _extruded(toothing: np.ndarray, rim: float, width: float) -> WheelMesh:
    """A polygon (n, 2) and the circle of radius ``rim`` as a solid from -width/2 to width/2."""
    angle = np.arctan2(toothing[:, 1], toothing[:, 0])
    circle = rim * np.column_stack([np.cos(angle), np.sin(angle)])
    up = 0.5 * width
    reach = float(np.hypot(*toothing.T).max())
    outward = 1.0 if rim < reach else -1.0
    faces = [
        *(_face(toothing, circle, sign * up, sign) for sign in (1.0, -1.0)),
        _wall(toothing, up, outward),
        _wall(circle, up, -outward),
    ]
    firsts = np.cumsum([0, *(len(positions) for positions, *_ in faces[:-1])])
    return WheelMesh(
        np.concatenate([positions for positions, *_ in faces]),
        np.concatenate([normals for _, normals, _ in faces]),
        np.concatenate([triangles + first for (*_, triangles), first in zip(faces, firsts, strict=True)]),
        max(reach, rim),
    )


def _face(toothing: np.ndarray, circle: np.ndarray, z: float, sign: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The plane between polygon and circle at a height."""
    count = len(toothing)
    flat = np.concatenate([toothing, circle])
    positions = np.column_stack([flat, np.full(len(flat), z)])
    normals = np.tile([0.0, 0.0, sign], (len(flat), 1))
    here, following = np.arange(count), np.roll(np.arange(count), -1)
    first = np.column_stack([here, following, here + count])
    second = np.column_stack([following, following + count, here + count])
    return positions, normals, np.concatenate([first, second])


def _wall(polygon: np.ndarray, up: float, outward: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The wall along a closed polygon, every piece with a normal of its own."""
    following = np.roll(polygon, -1, axis=0)
    along = following - polygon
    length = np.maximum(np.hypot(*along.T), 1e-12)
    normal = outward * np.column_stack([along[:, 1], -along[:, 0], np.zeros(len(along))]) / length[:, None]
    low, high = np.full(len(polygon), -up), np.full(len(polygon), up)
    corners = [
        np.column_stack([ends, z]) for ends, z in ((polygon, low), (following, low), (following, high), (polygon, high))
    ]
    positions = np.stack(corners, axis=1).reshape(-1, 3)
    firsts = 4 * np.arange(len(polygon))[:, None]
    triangles = np.concatenate([firsts + np.array([0, 1, 2]), firsts + np.array([0, 2, 3])])
    return positions, np.repeat(normal, 4, axis=0), triangles
