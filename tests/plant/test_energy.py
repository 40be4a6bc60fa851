"""Where the energy goes: every work and loss is booked from its own equation, and together they balance."""

from dataclasses import replace

import pytest

from ema_twin_sim.model import load_model
from ema_twin_sim.simulation.twin import Twin
from tests.fidelities import LONGEST
from tests.run_train import planetary_model, teeth_alone

pytestmark = pytest.mark.timeout(LONGEST)

TOLERANCE = 1e-6  # of the throughput
LOSSES = (
    "effects", "motor_viscous", "motor_dry", "shaft", "mesh_damping", "sun_mesh_friction", "ring_mesh_friction",
    "output_mesh_friction", "output_viscous", "output_dry", "load",
)  # fmt: skip


def mechanical_balance(before, after):
    """(what is missing from the balance of the mechanics, what went through) [J] between two bookings."""
    booked = {name: after.booked[name] - before.booked[name] for name in after.booked}
    stored = {name: after.stored[name] - before.stored[name] for name in after.stored}
    put_in = booked["motor"] + booked["stiffness_change"]
    taken = sum(booked[name] for name in LOSSES) + stored["kinetic"] + stored["springs"]
    return put_in - taken, abs(booked["motor"]) + abs(booked["load"])


def started(model, source, sample):
    twin = Twin(model, source, accounting=True)
    twin.start(sample)
    return twin, twin.energies()


@pytest.mark.slow
@pytest.mark.parametrize(
    "load, current, speed, soft",
    [
        *((0.5, 0.6, 6.0, {}), (-2.0, -0.3, 60.0, {}), (0.0, 0.3, 0.0, {})),
        # what the shaft's spring holds is booked with its damper's loss: it swings, so it ends within what it can hold
        (0.5, 0.6, 6.0, {"shaft_stiffness": 700.0}),
    ],
)
def test_train_and_load_balance(tmp_path, load, current, speed, soft):
    model = planetary_model(tmp_path, **soft).with_effect("constant_load", {"torque": load})
    twin, before = started(model, "current", {"current": current, "speed": speed})
    for _ in range(200):
        twin.advance(1_000_000, {"current": current})
    missing, through = mechanical_balance(before, twin.energies())
    assert through > 0.05
    assert abs(missing) <= TOLERANCE * through


@pytest.mark.slow
def test_drive_train_and_load_balance():
    model = load_model("polito_hff").with_effect("constant_load", {"torque": 0.5})
    twin, before = started(model, "setpoint", {"speed": 10.0, "current": 0.5, "speed_setpoint": 10.0})
    for _ in range(100):
        twin.advance(2_000_000, {"speed_setpoint": 10.0})
    after = twin.energies()
    missing, through = mechanical_balance(before, after)
    assert abs(missing) <= TOLERANCE * through
    booked = {name: after.booked[name] - before.booked[name] for name in after.booked}
    magnetic = after.stored["magnetic"] - before.stored["magnetic"]
    electrical = booked["link"] - booked["winding"] - booked["air_gap"] - magnetic
    assert abs(electrical) <= TOLERANCE * booked["link"]
    # the air gap's work is the motor's: within a step the one takes its speed before, the other the mean
    assert booked["motor"] == pytest.approx(booked["air_gap"], rel=1e-4)


def test_no_friction_wastes_nothing(tmp_path):
    # teeth of constant stiffness: changing ones without any damper would be shaken up without end
    model = teeth_alone(planetary_model(tmp_path, friction_coefficient=0.0, mesh_damping_ratio=0.0))
    model = replace(model, choices={**model.choices, "transmission.mesh_stiffness": "constant"})
    twin, before = started(
        model.with_effect("constant_load", {"torque": 0.4}), "current", {"current": 0.3, "speed": 8.0}
    )
    for _ in range(100):
        twin.advance(1_000_000, {"current": 0.3})
    missing, through = mechanical_balance(before, twin.energies())
    assert abs(missing) <= TOLERANCE * through
    booked = twin.energies().booked
    assert [name for name in LOSSES if booked[name] != 0.0] == ["load"]
    assert booked["stiffness_change"] == pytest.approx(0.0, abs=1e-12)


def test_energies_are_those_of_a_twin_that_books_them():
    with pytest.raises(ValueError, match="accounting"):
        Twin(load_model("polito_bench")).energies()
