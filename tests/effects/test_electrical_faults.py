"""Faults of winding and rotor as effects: torques of the averaged drive, turns and gap of a switching one."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from ema_bench_replay.bags.bag_writer import write_mcap
from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.effects import catalogue
from ema_twin_sim.identification.candidates import candidates
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from ema_twin_sim.model import load_model, save_model
from ema_twin_sim.simulation.assembly import assemble
from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.simulate import simulate
from ema_twin_sim.simulation.virtual_bench import virtual_bench
from tests.fidelities import LONGEST
from tests.recorded import record

pytestmark = pytest.mark.timeout(LONGEST)

FAULTS = {
    "phase_short": ({"fraction": 0.3}, {"phase": "v"}, 8.0),
    "rotor_eccentricity": ({"amplitude": 0.2, "phase": 1.1}, {}, 9.0),
}
"""Parameters, options, and the order of the ripple with four pole pairs."""

faults = pytest.mark.parametrize("id", FAULTS)


@pytest.fixture(scope="module")
def switching():
    """The switching drive with a narrow band, so that it imposes its currents as theory has it."""
    return load_model("polito_hf").with_value("drive.hysteresis", 0.02)


def faulty(model, id):
    parameters, options, _ = FAULTS[id]
    return model.with_effect(id, parameters, options)


def mean_and_ripple(recording, order):
    """The current's mean [A] and its complex amplitude [A] at an order, over whole turns after the first second."""
    angle = recording.signals["motor_position"]
    settled = recording.time > 1.0
    turns = (angle[-1] - angle[settled][0]) // (2.0 * math.pi)
    rows = settled & (angle <= angle[settled][0] + 2.0 * math.pi * turns)
    waves = np.stack([np.ones(rows.sum()), np.cos(order * angle[rows]), np.sin(order * angle[rows])], 1)
    mean, cosine, sine = np.linalg.lstsq(waves, recording.signals["current"][rows])[0]
    return mean, complex(cosine, -sine)


@faults
def test_both_drives_need_the_same_mean_current_and_show_the_same_ripple(stock, switching, id):
    """Under a load that no hysteresis hides; speed controllers answer the ripple in both alike."""
    found = []
    for model in (stock, switching):
        loaded = faulty(model, id).with_effect("constant_load", {"torque": 1.0})
        recording = virtual_bench(loaded, parse_command("ramp:0.05"), 5.0, seed=None)
        found.append(mean_and_ripple(recording, FAULTS[id][2]))
    (mean, ripple), (switched_mean, switched_ripple) = found
    assert switched_mean == pytest.approx(mean, rel=0.003)
    assert abs(ripple) > 0.05
    assert abs(switched_ripple - ripple) < 0.06 * abs(ripple)


@faults
def test_a_simulated_winding_has_the_fault_and_no_torque_stands_for_it(switching, id):
    healthy, sick = assemble(switching), assemble(faulty(switching, id))
    assert len(sick.acting[0]) == len(healthy.acting[0])
    assert len(sick.effects[0]) == len(healthy.effects[0]) + 1
    assert sick.fine.winding["magnet_strength"] == 1.0
    changed = {n for n in sick.fine.winding.dtype.names if sick.fine.winding[n] != healthy.fine.winding[n]}
    assert changed == ({"active_turns_v"} if id == "phase_short" else {"eccentricity", "eccentricity_phase"})


@faults
def test_driven_by_the_measured_current_both_drives_are_the_same(stock, switching, id):
    """No winding is simulated then: the fault is a torque in both, in the mechanics and where torques are balanced."""
    bench = virtual_bench(faulty(stock, id), parse_command("ramp:0.08"), 1.5, seed=None)
    one, two = (simulate(faulty(model, id), bench, "current").signals for model in (stock, switching))
    for name in ("speed", "unexplained_torque"):
        assert np.nanmax(np.abs(one[name] - two[name])) < 2e-3 * np.nanmax(np.abs(bench.signals["speed"]))
    healthy = simulate(stock, bench, "current").signals["unexplained_torque"]
    settled = bench.time > 0.5
    assert np.std(two["unexplained_torque"][settled]) < 0.1 * np.std(healthy[settled])


def test_displacements_of_the_rotor_add_up_as_arrows(switching):
    model = switching.with_value("machine.eccentricity", 0.3).with_value("machine.eccentricity_phase", 0.5 * math.pi)
    winding = assemble(model.with_effect("rotor_eccentricity", {"amplitude": 0.4, "phase": 0.0})).fine.winding
    assert winding["eccentricity"][0] == pytest.approx(0.5)
    assert winding["eccentricity_phase"][0] == pytest.approx(math.atan2(0.3, 0.4))


@faults
def test_a_motor_of_unknown_pole_pairs_has_no_electrical_angle(id):
    model = load_model("kuka_axis1")
    with pytest.raises(InputError, match=r"needs machine\.pole_pairs"):
        assemble(model.with_effect(id))
    assert id not in {c.effect for c in candidates(null_hypothesis(model))}
    for known in (load_model("polito_bench"), replace(model, orders={"pole pairs": 3.0})):
        assert id in {c.effect for c in candidates(null_hypothesis(known))}


def test_pole_pairs_are_saved_with_a_model_of_any_drive_and_needed_by_a_switching_one(tmp_path, stock):
    saved = save_model(stock, tmp_path / "averaged.yaml")
    assert load_model(saved).value("machine.pole_pairs") == 4.0
    text = save_model(load_model("polito_hf"), tmp_path / "switching.yaml").read_text("utf-8")
    rows = [line for line in text.splitlines(keepends=True) if "pole_pairs" not in line]
    (tmp_path / "without.yaml").write_text("".join(rows), "utf-8")
    with pytest.raises(InputError, match=r"machine\.pole_pairs: is missing"):
        load_model(tmp_path / "without.yaml")


def test_phase_currents_of_a_simulated_recording_are_read_back(tmp_path, switching):
    bench = virtual_bench(switching, parse_command("ramp:0.05"), 0.05)
    write_mcap(bench, tmp_path / "run.mcap")
    read = load(tmp_path / "run.mcap")
    for name in ("direct_current", "phase_current_u", "phase_current_v", "phase_current_w"):
        np.testing.assert_array_equal(read.signals[name], bench.signals[name])


def recorded(model):
    """Slow, fast and back and forth; a drive that switches in its usual band makes noise of its own."""
    return record(model, ("ramp:0.02", "ramp:0.08", "triangle:0.04:2"), seed=0)


@pytest.mark.slow
@faults
def test_a_fault_of_a_switching_bench_is_discovered_by_the_averaged_model(stock, id):
    found = discover(recorded(faulty(load_model("polito_hf"), id)), stock)
    parameters, options, _ = FAULTS[id]
    assert found.added == (id,)
    assert found.model.effects[id].options == options
    for name, value in parameters.items():
        assert found.model.effects[id].parameters[name] == pytest.approx(value, rel=0.05)


def test_of_a_healthy_switching_bench_no_fault_is_named(stock):
    assert not discover(recorded(load_model("polito_hf")), stock).added


@pytest.mark.parametrize(
    ("other", "parameters"),
    [("torque_constant_error", {"scale": 0.8}), ("torque_ripple", {"fraction": 0.1}), ("current_offset", {})],
)
def test_what_looks_like_a_fault_is_not_taken_for_one(stock, other, parameters):
    assert discover(recorded(stock.with_effect(other, parameters)), stock).added == (other,)


@pytest.mark.parametrize(("effect", "times"), [("current_offset", 1.0), ("torque_ripple", 6.0)])
def test_waves_of_the_electrical_angle_follow_the_machines_pole_pairs(effect, times):
    """A model that names no pole pairs has the four of the bench's motor."""
    act, angle = catalogue()[effect].act, 0.37
    for pole_pairs, known in ((5.0, 5.0), (math.nan, 4.0)):
        at = SimpleNamespace(motor_angle=angle, electrical_angle=pole_pairs * angle, motor_torque=-1.0)
        assert act(at, (0.02, 0.4, 0.0, 0.0)) == pytest.approx(0.02 * math.sin(times * known * angle + 0.4))
