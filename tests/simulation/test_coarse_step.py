"""The step of simulations of which only differences matter: twice the default, where the model allows it.

That this is converged is a test of the plant.
"""

import numpy as np
import pytest
import yaml

from ema_bench_replay.recording import Recording
from ema_twin_sim.model import load_model, save_model
from ema_twin_sim.simulation.fidelity import DEFAULT_STEP
from ema_twin_sim.simulation.longest_step import coarse_step
from ema_twin_sim.simulation.simulate import simulate
from ema_twin_sim.simulation.twin import Twin


def test_it_is_twice_the_default(stock):
    assert coarse_step(stock) == 2.0 * DEFAULT_STEP


def test_a_shorter_control_cycle_has_as_many_steps(stock):
    assert coarse_step(stock.with_value("drive.control_cycle", 1e-4)) == pytest.approx(4e-5)
    assert coarse_step(stock.with_value("drive.control_cycle", 5e-5)) is None


def test_stiff_teeth_and_fine_models_keep_their_own(stock):
    geared = stock.with_effect("backlash", {"width": 1e-3})
    assert coarse_step(geared) == 2.0 * DEFAULT_STEP
    stiff = geared.with_value("transmission.contact_stiffness", 300.0 * geared.value("transmission.contact_stiffness"))
    assert coarse_step(stiff) is None
    assert coarse_step(load_model("polito_hf")) is None


def without_drive(tmp_path, period, **effects):
    """A motor of which only currents are recorded, once in a ``period`` [s]; it stops within a second."""
    model = {
        "version": 1,
        "machine": {
            "inertia": {"value": 0.1, "unit": "kg m^2", "source": "made up"},
            "torque_constant": {"value": 1.0, "unit": "N m/A", "source": "made up"},
        },
        "sensors": {"sample_period": {"value": period, "unit": "s", "source": "made up"}},
        "effects": {"viscous_friction": {"effect": "viscous_friction", "parameters": {"coefficient": 0.2}}, **effects},
    }
    place = tmp_path / "logged.yaml"
    place.write_text(yaml.safe_dump(model))
    return load_model(place)


COGGING = {"effect": "cogging", "options": {"order": "12"}, "parameters": {"torque": 0.05, "phase": 0.0}}


@pytest.mark.parametrize(("period", "step"), [(0.2, 5e-3), (2e-3, 5e-5), (1e-3, DEFAULT_STEP), (1e-4, DEFAULT_STEP)])
def test_a_slow_log_without_a_drive_takes_forty_steps_a_sample(tmp_path, period, step):
    """No controller runs between its samples. A fast one keeps the usual step."""
    model = without_drive(tmp_path, period)
    assert Twin(model, "current").step == pytest.approx(step)
    assert coarse_step(model) == pytest.approx(2.0 * step)


RIPPLE = {"effect": "output_ripple", "options": {"order": "12"}, "parameters": {"torque": 0.05, "phase": 0.0}}
GRAVITY = {"effect": "gravity_load", "parameters": {"torque": 0.05, "angle": 0.0}}


@pytest.mark.parametrize("wave", [COGGING, RIPPLE])
def test_a_torque_that_repeats_with_the_angle_keeps_the_usual_step(tmp_path, wave):
    """Within a long step a fast motor turns by whole waves, and the torque would stand still."""
    model = without_drive(tmp_path, 0.2, **{wave["effect"]: wave})
    assert Twin(model, "current").step == pytest.approx(DEFAULT_STEP)
    assert coarse_step(model) == pytest.approx(2.0 * DEFAULT_STEP)


def test_a_weight_repeats_too_seldom_to_matter(tmp_path):
    assert Twin(without_drive(tmp_path, 0.2, gravity_load=GRAVITY), "current").step == pytest.approx(5e-3)


def test_a_written_model_takes_the_same_steps(tmp_path):
    model = without_drive(tmp_path, 0.01).with_value("sensors.sample_period", 0.2)
    written = load_model(save_model(model, tmp_path / "written.yaml"))
    assert Twin(written, "current").step == Twin(model, "current").step == pytest.approx(5e-3)


def test_such_steps_are_converged(tmp_path):
    model = without_drive(tmp_path, 0.2)
    time = 0.2 * np.arange(200)
    signals = {"current": 2.0 * np.sin(0.8 * time), "motor_position": np.zeros(200), "speed": np.zeros(200)}
    recording = Recording("log", np.round(time * 1e9).astype(np.int64), signals)
    usual, coarse, fine = (simulate(model, recording, step=step).signals for step in (None, coarse_step(model), 1e-4))
    for name in ("speed", "motor_position"):
        assert np.ptp(fine[name]) > 1.0
        for found in (usual, coarse):
            assert found[name] == pytest.approx(fine[name], abs=5e-3 * np.ptp(fine[name]))
