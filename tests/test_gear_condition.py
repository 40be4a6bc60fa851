"""A gearbox that is worn: each damage shows in the current at the order where theory puts it."""

from dataclasses import replace

import numpy as np
import pytest
from run_train import planetary_model, teeth_alone

from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.virtual_bench import virtual_bench

SLOW_ORDERS = (0.25, 45.0 / 62.0, 0.75, 1.0, 2.25)  # carrier, tooth of the output ring, planet, sun, tooth of the sun
MESH_ORDERS = (15.0, 15.75, 31.5, 45.0)
SPEED = 0.08  # rad/s of the slow shaft
HEALTHY = 0.02  # mA, at any slow order


def amplitudes(model, seconds=22.0):
    """Amplitudes [mA] of the quadrature current at the orders, by order, of a ramp under load."""
    recording = virtual_bench(
        model.with_effect("constant_load", {"torque": 0.3}), parse_command(f"ramp:{SPEED}"), seconds, seed=None
    )
    settled = recording.time > 2.0
    current, angle = recording.signals["current"][settled], recording.signals["motor_position"][settled]
    orders = (*SLOW_ORDERS, *MESH_ORDERS)
    waves = [wave(order * angle) for order in orders for wave in (np.sin, np.cos)]
    sizes = np.linalg.lstsq(np.column_stack([np.ones_like(angle), *waves]), current, rcond=None)[0][1:]
    return dict(zip(orders, 1e3 * np.hypot(sizes[::2], sizes[1::2]), strict=True))


def test_a_healthy_gearbox_shows_its_first_mesh_only(tmp_path):
    """Sun and ring meshes are in phase (15.75 adds up), output meshes a third apart (15 cancels, 45 stays)."""
    found = amplitudes(planetary_model(tmp_path))
    assert max(found[order] for order in SLOW_ORDERS) < HEALTHY
    assert found[15.75] > 5.0
    assert found[45.0] > 0.5
    assert found[15.0] < 0.01 * found[15.75]


@pytest.mark.parametrize(
    "condition, order",
    [
        ({"sun_tooth_damage": 0.5}, 2.25),
        ({"planet_tooth_damage": 0.5, "planet_damaged_tooth": 7.0}, 0.75),
        ({"ring_tooth_damage": 0.5, "ring_damaged_tooth": 20.0}, 0.75),
        ({"output_ring_tooth_damage": 0.5}, 45.0 / 62.0),
        ({"planet_runout": 2e-5}, 0.75),
        ({"sun_runout": 2e-5}, 0.75),
        ({"output_ring_runout": 2e-5}, 45.0 / 62.0),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else f"{value:.3g}",
)
def test_damage_shows_at_its_order(tmp_path, condition, order):
    found = amplitudes(planetary_model(tmp_path, **condition))
    slow = {o: size for o, size in found.items() if o in SLOW_ORDERS}
    harmonics = [o for o in slow if abs(o / order - round(o / order)) < 1e-6]
    assert max(slow[o] for o in harmonics) > 5.0 * HEALTHY
    assert slow[order] > 3.0 * max(size for o, size in slow.items() if o not in harmonics)


def test_a_planet_with_a_bad_tooth_shows_the_second_mesh_too(tmp_path):
    """Planets are no longer alike, so that the output meshes' order 15 no longer cancels."""
    assert amplitudes(planetary_model(tmp_path, planet_tooth_damage=0.5))[15.0] > 0.5


def test_a_cold_lubricant_rubs_less(tmp_path):
    """ISO/TS 6336-4: the coefficient goes with viscosity^-0.25, so a thicker film carries more."""
    model = teeth_alone(planetary_model(tmp_path)).with_effect("constant_load", {"torque": 0.5})
    model = replace(model, choices={**model.choices, "transmission.mesh_friction": "iso_ts_6336_4"})
    means = []
    for temperature in (263.15, 333.15):
        cold = model.with_value("transmission.lubricant_temperature", temperature)
        recording = virtual_bench(cold, parse_command(f"ramp:{SPEED}"), 4.0, seed=None)
        means.append(recording.signals["current"][recording.time > 2.0].mean())
    assert means[0] < 0.98 * means[1]
