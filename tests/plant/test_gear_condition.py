"""A gearbox that is worn: each damage shows in the current at the order where theory puts it."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from ema_twin_sim.plant.planetary.layout import LANE, ROW
from ema_twin_sim.plant.planetary.mesh_state import mesh_cycles, read_meshes
from ema_twin_sim.plant.planetary.train_constants import train_constants
from ema_twin_sim.simulation.assembly import assemble
from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.fidelity import resting_state
from ema_twin_sim.simulation.virtual_bench import virtual_bench
from tests.run_train import planetary_model, teeth_alone

OUTPUT_TOOTH = 45.0 / 62.0
SLOW_ORDERS = (0.25, OUTPUT_TOOTH, 0.75, 1.0, 2.0 * OUTPUT_TOOTH, 1.5, 2.25)
"""Carrier, a tooth of the output ring, planet, sun, twice that tooth, twice the planet, a tooth of the sun."""
MESH_ORDERS = (15.0, 15.75, 31.5, 45.0)
SPEED = 0.08  # rad/s of the slow shaft
HEALTHY = 0.02  # mA, at any slow order


@pytest.fixture(scope="module")
def amplitudes(tmp_path_factory):
    """Of a gearbox's condition the amplitudes [mA] of the quadrature current, by order, on a ramp under load."""
    folder = tmp_path_factory.mktemp("condition")

    @cache
    def measured(**condition):
        model = planetary_model(folder, **condition).with_effect("constant_load", {"torque": 0.3})
        recording = virtual_bench(model, parse_command(f"ramp:{SPEED}"), 22.0, seed=None)
        settled = recording.time > 2.0
        current, angle = recording.signals["current"][settled], recording.signals["motor_position"][settled]
        orders = (*SLOW_ORDERS, *MESH_ORDERS)
        waves = [wave(order * angle) for order in orders for wave in (np.sin, np.cos)]
        sizes = np.linalg.lstsq(np.column_stack([np.ones_like(angle), *waves]), current, rcond=None)[0][1:]
        return dict(zip(orders, 1e3 * np.hypot(sizes[::2], sizes[1::2]), strict=True))

    return measured


@pytest.mark.slow
def test_a_healthy_gearbox_shows_its_first_mesh_only(amplitudes):
    """Sun and ring meshes are in phase (15.75 adds up), output meshes a third apart (15 cancels, 45 stays)."""
    found = amplitudes()
    assert max(found[order] for order in SLOW_ORDERS) < HEALTHY
    assert found[15.75] > 5.0
    assert found[45.0] > 0.5
    assert found[15.0] < 0.01 * found[15.75]


@pytest.mark.slow
@pytest.mark.parametrize(
    "condition, order",
    [
        ({"sun_tooth_damage": 0.5}, 2.25),
        ({"planet_tooth_damage": 0.5, "planet_damaged_tooth": 7.0}, 0.75),
        ({"ring_tooth_damage": 0.5, "ring_damaged_tooth": 20.0}, 0.75),
        ({"output_ring_tooth_damage": 0.5}, OUTPUT_TOOTH),
        ({"planet_runout": 2e-5}, 0.75),
        ({"sun_runout": 2e-5}, 0.75),
        ({"output_ring_runout": 2e-5}, OUTPUT_TOOTH),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else f"{value:.3g}",
)
def test_damage_shows_at_its_order(amplitudes, condition, order):
    found = amplitudes(**condition)
    slow = {o: size for o, size in found.items() if o in SLOW_ORDERS}
    harmonics = [o for o in slow if abs(o / order - round(o / order)) < 1e-6]
    assert max(slow[o] for o in harmonics) > 5.0 * HEALTHY
    assert slow[order] > 3.0 * max(size for o, size in slow.items() if o not in harmonics)


@pytest.mark.parametrize("wheel", ["sun", "planet"])
def test_a_run_out_shows_doubled_where_it_presses_more_than_the_load(amplitudes, wheel):
    """Friction follows the size of a mesh's force, which then has two maxima in a turn."""
    found = amplitudes(**{f"{wheel}_runout": 2e-5})
    assert found[1.5] > 1.2 * found[0.75] > 50.0 * HEALTHY


@pytest.mark.slow
@pytest.mark.parametrize("carrier", np.linspace(0.0, 3.0, 7))
def test_an_eccentric_planet_moves_along_both_lines_of_action(tmp_path, carrier):
    """The sun's teeth push a planet forward and outwards, the ring's forward and inwards: it moves away from both."""
    size, phase = 2e-5, 0.4
    model = planetary_model(tmp_path, planet_runout=size, planet_runout_phase=phase)
    assembly = assemble(model)
    _, _, trains, states, lanes, table, *_ = resting_state(assembly.fine)
    train, pressure = trains[0], model.value("transmission.pressure_angle")
    sun, output = 4.0 * carrier, 4.0 * carrier / 124.0
    read_meshes(train, states[0], lanes, table, mesh_cycles(train_constants(train, 0.0, 1e-6), sun, carrier, output))
    spin = -2.0 * carrier  # absolute; so is the direction of the eccentricity, seen from the carrier's radius
    direction = spin - carrier - phase - pressure
    moved = size * np.array([np.cos(direction), np.sin(direction)])
    from_sun, from_ring = (np.array([out, np.cos(pressure)]) for out in (np.sin(pressure), -np.sin(pressure)))
    runout = lanes[ROW["RUNOUT_SUN"] :][: 3 * LANE].reshape(3, LANE)
    assert runout[:, 0] == pytest.approx([-moved @ from_sun, -moved @ from_ring, 0.0], abs=1e-12)
    assert not runout[:, 1:].any()


def test_a_planet_with_a_bad_tooth_shows_the_second_mesh_too(amplitudes):
    """Planets are no longer alike, so that the output meshes' order 15 no longer cancels."""
    assert amplitudes(planet_tooth_damage=0.5, planet_damaged_tooth=7.0)[15.0] > 0.5


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
