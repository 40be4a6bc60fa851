"""The moving planetary train against what is known of it: limits, equilibrium, efficiency, orders, convergence."""

from dataclasses import replace

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_twin_sim.plant.planetary.geometry import Gearing
from ema_twin_sim.plant.planetary.mesh_table import mean_stiffness, mesh_table
from ema_twin_sim.plant.planetary.position_balance import all_positions, position_balance
from ema_twin_sim.plant.planetary.quasi_static import static_forces
from ema_twin_sim.simulation.twin import Twin
from tests.run_train import planetary_model, run, teeth_alone

KT = 1.91
TURN = 2.0 * np.pi


def constant_teeth(model):
    return replace(model, choices={**model.choices, "transmission.mesh_stiffness": "constant"})


def test_the_output_turns_once_in_124_turns(tmp_path):
    twin, rows = run(teeth_alone(planetary_model(tmp_path)), 0.0, 60.0, 1.0, every=0.01)
    wheels = twin.wheels()
    assert rows[-1]["motor_position"] > 50.0
    # what they differ by is the give of the teeth, not a share of the way
    assert abs(wheels.sun_angle - 124.0 * wheels.output_angle) < 0.01
    assert abs(wheels.sun_angle - 4.0 * wheels.carrier_angle) < 0.01
    assert np.abs(wheels.planet_angles + 2.0 * wheels.carrier_angle).max() < 0.01


def test_stiffer_teeth_follow_the_rigid_transmission(tmp_path):
    lags = []
    for ratio in (0.05, 0.2):
        twin, _ = run(planetary_model(tmp_path, youngs_modulus_ratio=ratio), 0.3, 6.0, 0.5)
        wheels = twin.wheels()
        lags.append(abs(wheels.sun_angle - 124.0 * wheels.output_angle))
    assert lags[1] < 0.5 * lags[0]


def test_equilibrium_under_load(tmp_path):
    """Held at rest, forces are 1 : 41 : -42 and the sun is turned by T / K, both in closed form."""
    load = 0.4
    model = constant_teeth(teeth_alone(planetary_model(tmp_path, friction_coefficient=0.0, mesh_damping_ratio=0.3)))
    model = model.with_effect("constant_load", {"torque": load}).with_effect("viscous_friction", {"coefficient": 0.5})
    twin, _ = run(model, load / KT, 0.0, 1.0)
    wheels = twin.wheels()
    gearing = Gearing()
    assert wheels.forces.mean(axis=1) == pytest.approx(static_forces(gearing, load), rel=1e-3)
    stiffness = mean_stiffness(mesh_table(gearing, "constant", model.value("transmission.youngs_modulus_ratio")))
    softness = (np.array([1.0, 41.0, 42.0]) ** 2 / stiffness).sum() / (3.0 * gearing.sun_radius**2)
    assert wheels.sun_angle - 124.0 * wheels.output_angle == pytest.approx(load * softness, rel=1e-3)


@pytest.mark.parametrize("speed", [2.0, 150.0])  # near 10 rad/s the mesh cycle meets a resonance
@pytest.mark.parametrize("load", [0.5, -0.5])
def test_efficiency_is_that_of_the_balance_in_every_position(tmp_path, load, speed):
    model = teeth_alone(planetary_model(tmp_path))
    gearing = Gearing()
    table = mesh_table(gearing, "alternating", model.value("transmission.youngs_modulus_ratio"))
    balance = position_balance(gearing, table, np.full(3, 0.1), load, all_positions(gearing, 500))
    holding = 2.0 / speed  # a strong brake, whose motor's torque keeps the speed even
    model = model.with_effect("constant_load", {"torque": load}).with_effect(
        "viscous_friction", {"coefficient": holding}
    )
    current = (balance.sun_torque.mean() + 2.0) / KT
    twin, _ = run(model, current, speed, 0.3)
    before = twin.energies().booked
    for _ in range(round(1e3 * max(0.7, 7.0 / speed))):
        twin.advance(1_000_000, {"current": current})
    booked = {name: value - before[name] for name, value in twin.energies().booked.items()}
    rubbed = np.array([booked[f"{mesh}_mesh_friction"] for mesh in ("sun", "ring", "output")])
    done = abs(booked["load"])
    lost = rubbed.sum() + booked["mesh_damping"]
    efficiency = done / (done + lost) if load > 0.0 else 1.0 - lost / done
    assert efficiency == pytest.approx(balance.efficiency, abs=0.02)
    assert rubbed[1:].sum() > 0.85 * rubbed.sum()


def test_sun_meshes_are_thrown_about(tmp_path):
    """The sun's meshes carry less than friction throws planets about with: a third of the time they push back."""
    gearing = Gearing()
    table = mesh_table(gearing, "alternating", 0.1)
    balance = position_balance(gearing, table, np.full(3, 0.1), 0.5, all_positions(gearing))
    assert np.mean(balance.forces[:, 0] < 0.0) == pytest.approx(0.31, abs=0.02)
    smooth = position_balance(gearing, table, np.zeros(3), 0.5, all_positions(gearing))
    assert smooth.efficiency == pytest.approx(1.0, abs=1e-9)
    assert smooth.forces.mean(axis=(0, 2)) == pytest.approx(static_forces(gearing, 0.5), rel=1e-9)


def test_a_self_locking_train_holds_a_load(tmp_path):
    model = teeth_alone(planetary_model(tmp_path, friction_coefficient=0.35))
    model = model.with_effect("constant_load", {"torque": -0.5}).with_effect("viscous_friction", {"coefficient": 0.1})
    twin, _ = run(model, 0.0, 0.0, 0.5)
    settled = twin.wheels().output_angle
    for _ in range(500):
        twin.advance(1_000_000, {"current": 0.0})
    assert abs(twin.wheels().output_angle - settled) < 1e-8  # it does not creep
    twin, _ = run(model.with_value("transmission.friction_coefficient", 0.1), 0.0, 0.0, 0.5)
    assert twin.wheels().output_speed > 0.01


def test_play_is_lost_motion(tmp_path):
    play = 1e-4
    model = teeth_alone(planetary_model(tmp_path, output_mesh_play=play))
    lost = []
    for torque in (0.05, -0.05):
        held = model.with_effect("constant_load", {"torque": torque})
        twin, _ = run(held.with_effect("viscous_friction", {"coefficient": 0.5}), torque / KT, 0.0, 0.6)
        wheels = twin.wheels()
        lost.append(wheels.sun_angle / 124.0 - wheels.output_angle)
    give = 2.0 * 0.05 / 25.0 / 124.0  # of the teeth, at some 25 N m/rad
    assert lost[0] - lost[1] == pytest.approx(play / Gearing().output_ring_radius, abs=2.0 * give)


def test_step_halving_converges_at_second_order(tmp_path):
    """Drift, kick, drift is of second order; dampers, taken at the speed before the kick, are left out."""
    soft = planetary_model(tmp_path, friction_coefficient=0.0, mesh_damping_ratio=0.0, youngs_modulus_ratio=1e-3)
    model = constant_teeth(teeth_alone(soft)).with_effect("constant_load", {"torque": 0.3})
    where = []
    for step in (1.6e-6, 0.8e-6, 0.4e-6, 0.1e-6):
        twin, _ = run(model, 0.3 / KT, 5.0, 2e-3, step=step, every=1e-3)
        wheels = twin.wheels()
        where.append(np.array([wheels.sun_angle, 124.0 * wheels.output_angle]))
    errors = [np.abs(at - where[-1]).max() for at in where[:-1]]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.35)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.35)


def test_step_halving_moves_nothing_with_friction_and_play(tmp_path):
    model = planetary_model(tmp_path, output_mesh_play=5e-5).with_effect("constant_load", {"torque": 0.2})
    speeds = []
    for step in (1e-6, 0.5e-6):
        _, rows = run(model, 0.4, 6.0, 0.3, step=step)
        speeds.append(np.array([row["speed"] for row in rows]))
    assert np.sqrt(np.mean((speeds[0] - speeds[1]) ** 2)) < 0.01 * speeds[0].std()


def test_a_step_too_long_names_the_longest(tmp_path):
    with pytest.raises(InputError, match=r"teeth are too stiff .* take [0-9.e-]+ s at most"):
        Twin(planetary_model(tmp_path), step=25e-6)
