"""Different fidelities of one machine against each other: what they share, they must agree on."""

import numpy as np
import pytest

from ema_twin_sim.model import load_model
from ema_twin_sim.simulation.assembly import assemble
from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.simulate import simulate
from ema_twin_sim.simulation.virtual_bench import virtual_bench
from tests.fidelities import LONGEST
from tests.run_train import planetary_model

pytestmark = pytest.mark.timeout(LONGEST)


def settled(recording, name, since=0.5):
    return recording.signals[name][recording.time > since]


@pytest.mark.parametrize("command", ["ramp:0.02", "ramp:0.1"])
def test_switching_and_averaged_drive_agree_in_the_mean(command):
    averaged, switching = (
        virtual_bench(load_model(name), parse_command(command), 3.0, seed=None)
        for name in ("polito_bench", "polito_hf")
    )
    means = [settled(recording, "current").mean() for recording in (averaged, switching)]
    assert means[1] == pytest.approx(means[0], rel=0.01)
    assert settled(switching, "speed").mean() == pytest.approx(settled(averaged, "speed").mean(), rel=1e-3)


def test_the_drives_voltages_differ_by_a_third_of_the_resistance():
    """The averaged drive has two phases in series carry its ampere; sinusoidal phases carry peaks of 4/3 of it."""
    averaged, switching = (
        # under load, and every control cycle, since a trace of 2 ms folds down the ripple of 380 V
        load_model(name).with_effect("constant_load", {"torque": 2.0}).with_value("sensors.sample_period", 1.25e-4)
        for name in ("polito_bench", "polito_hf")
    )
    runs = [virtual_bench(model, parse_command("ramp:0.1"), 2.0, seed=None) for model in (averaged, switching)]
    means = [settled(run, "voltage").mean() for run in runs]
    of_phase = switching.value("machine.phase_resistance")
    more = 4.0 / 3.0 * (of_phase + switching.value("drive.switch_resistance")) - of_phase
    assert means[1] - means[0] == pytest.approx(more * settled(runs[1], "current").mean(), rel=0.05)


def test_phase_currents_are_three_of_a_star():
    recording = virtual_bench(load_model("polito_hf"), parse_command("ramp:0.1"), 1.0, seed=None)
    phases = np.array([recording.signals[f"phase_current_{phase}"] for phase in "uvw"])
    assert np.abs(phases.sum(axis=0)).max() < 1e-9
    # 4/3 of the trace's ampere is the sinusoidal phases' peak; the band is 0.1 A to either side
    peak = 4.0 / 3.0 * settled(recording, "current").mean()
    assert np.abs(phases[:, recording.time > 0.5]).max() == pytest.approx(peak, abs=0.25)


def test_the_lumped_train_loses_what_the_train_loses(tmp_path):
    model = planetary_model(tmp_path).with_effect("constant_load", {"torque": 0.4})
    train = virtual_bench(model, parse_command("ramp:0.05"), 4.0, seed=None)
    loss = float(assemble(model).effects[2][0, 0])
    assert len(assemble(model).acting[0]) == len(assemble(model).effects[0]) - 1  # the train itself has its own
    stand_in = load_model("polito_bench").with_effect("constant_load", {"torque": 0.4})
    rigid = virtual_bench(
        stand_in.with_effect("mesh_friction", {"coefficient": loss}), parse_command("ramp:0.05"), 4.0, seed=None
    )
    assert settled(rigid, "current").mean() == pytest.approx(settled(train, "current").mean(), rel=0.03)


def test_the_unexplained_torque_of_a_train_beside_itself_is_small(tmp_path):
    model = planetary_model(tmp_path)
    bench = virtual_bench(model, parse_command("ramp:0.05"), 3.0, seed=None)
    beside = simulate(model, bench)
    unexplained = settled(beside, "unexplained_torque")
    # the lumped train that stands for it knows no mesh cycle: the means agree, the ripple stays
    assert abs(unexplained.mean()) < 0.005
    assert settled(beside, "current") == pytest.approx(settled(bench, "current"), abs=2e-3)
