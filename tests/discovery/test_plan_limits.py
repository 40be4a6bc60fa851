"""Limits of a plan: told and given in the machine's own quantities, and no wider than its model knows of the bench."""

from dataclasses import replace

import numpy as np
import pytest

from ema_bench_replay.bags.bag_writer import write_mcap
from ema_twin_sim.criteria import LARGEST_EFFECT, SEARCHED_UP_TO
from ema_twin_sim.discovery.experiment.bench_limits import Limits, recorded_limits, widened
from ema_twin_sim.discovery.plan import plan
from ema_twin_sim.measured.scales import to_own_units
from ema_twin_sim.model import load_model, save_model
from ema_twin_sim.model.model_file import ABSENT
from ema_twin_sim.simulation.command import in_words, parse_command
from tests.command_line import MODEL, done, refused
from tests.model.test_linear_machine import carriage
from tests.recorded import changed, record, with_signals

LIMITS = Limits(speed=0.1, acceleration=2.0, lower=-0.1, upper=0.5, current=1.0)


def by_torque(recording, model):
    """The same recording, with the motor's torque in place of its current."""
    signals = dict(recording.signals)
    signals["motor_torque"] = signals.pop("current") * model.value("machine.torque_constant")
    return with_signals(recording, signals)


def test_what_a_torque_recording_reached_is_told_as_a_torque(stock):
    recordings = record(stock, seconds=4.0)
    driven = recorded_limits(recordings, stock)
    of_torque = recorded_limits([by_torque(recording, stock) for recording in recordings], stock)
    name, torque, unit = of_torque.load
    assert (name, unit) == ("torque", "N m") and driven.load == ("current", driven.current, "A")
    assert torque == pytest.approx(stock.value("machine.torque_constant") * driven.current, rel=0.02)
    for reached in ("speed", "lower", "upper", "current"):
        assert getattr(of_torque, reached) == pytest.approx(getattr(driven, reached), rel=0.02, abs=1e-5), reached
    (beyond,) = of_torque.exceeded(replace(of_torque, current=2.0 * of_torque.current))
    assert beyond.startswith("torque ") and " N m (so far" in beyond


def test_what_a_carriage_reached_is_told_in_metres_and_newtons():
    run = carriage()
    driven = recorded_limits([run], load_model("emps"))
    way, force = (run.signals[name] for name in ("motor_position", "motor_torque"))
    assert driven.speed == pytest.approx(np.abs(np.gradient(way, 1e-3)).max(), rel=0.02)
    assert (driven.lower, driven.upper) == pytest.approx((way.min(), way.max()), abs=1e-4)
    assert driven.load[1] == pytest.approx(np.abs(force).max(), rel=0.05)
    done_there = replace(driven, speed=2 * driven.speed, upper=25 * driven.upper, current=200 * driven.current)
    speed, load, travel = driven.exceeded(done_there)
    assert " m/s (so far" in speed and load.startswith("force ") and " N (so far" in load and " m (so far" in travel
    assert "e+" not in load and "rad" not in "".join((speed, load, travel))
    assert {"speed", "travel", "force"} < {*driven.as_json()}


def test_a_given_limit_holds_for_a_carriage_that_is_told_by_its_force():
    run, model = carriage(4.0), load_model("emps")
    noise = np.random.default_rng(5).normal(0.0, 30.0, len(run))  # N, so that effects hide in it
    runs = [changed(run, motor_torque=run.signals["motor_torque"] + noise)]
    driven = recorded_limits(runs, model)
    asked = plan(runs, model, limits=replace(driven, lower=-0.02, upper=0.02))
    assert asked.limits.load[1] == pytest.approx(driven.load[1]) and asked.limits.load[2] == "N"
    assert (asked.limits.lower, asked.limits.upper) == pytest.approx((-0.02, 0.02))
    command = parse_command(asked.proposal.command)
    values = command(np.arange(0.0, asked.proposal.seconds, 1e-3))
    way = np.cumsum(values) * 1e-3 if command.speed else values
    assert 0.002 < np.abs(way).max() < 0.021
    assert asked.proposal.beyond == ()


def test_a_bench_whose_drive_is_not_stated_is_asked_for_twice_at_most(stock):
    limit = replace(stock.constants["drive.speed_limit"], source=ABSENT)
    unstated = replace(stock, constants={**stock.constants, "drive.speed_limit": limit})
    assert widened(LIMITS, stock, 0.0, SEARCHED_UP_TO).speed == SEARCHED_UP_TO * LIMITS.speed
    wide = widened(LIMITS, unstated, 0.0, SEARCHED_UP_TO)
    assert (wide.speed, wide.current) == (LARGEST_EFFECT * LIMITS.speed, LARGEST_EFFECT * LIMITS.current)
    travel = LIMITS.upper - LIMITS.lower
    assert (wide.lower, wide.upper) == pytest.approx((-travel, travel))


def test_a_carriage_keeps_to_the_way_it_went_unless_its_stops_are_known():
    _, carried = to_own_units([carriage()], load_model("emps"))
    wide = widened(LIMITS, carried, 0.0)
    assert (wide.lower, wide.upper) == (LIMITS.lower, LIMITS.upper)
    stopped = carried.with_value("transmission.end_stop_upper", 1.0)
    wide = widened(LIMITS, stopped, 0.0)
    assert wide.lower == LIMITS.lower and LIMITS.upper < wide.upper < 1.0


def test_a_command_of_a_carriage_is_put_in_metres():
    assert in_words("speed-sine:1.2:0.0625", "linear") == "speed of the output: a sine of ±1.2 m/s at 0.0625 Hz"
    assert in_words("speed-triangle:0.2:5", "linear").endswith("±0.2 m/s² that turns every 5 s")
    assert in_words("step:0.2:5", "linear").endswith("steps between 0 and 0.2 m every 5 s")


@pytest.mark.slow
def test_a_limit_that_says_nothing_for_these_recordings_is_refused(tmp_path, stock):
    (run,) = record(stock, ("triangle:0.06:1",), seconds=4.0)
    write_mcap(run, tmp_path / "current.mcap")
    write_mcap(carriage(4.0), tmp_path / "force.mcap")
    own = tmp_path / "current.mcap", *MODEL, "--max-torque", "2"
    refused("plan", *own, naming=("--max-torque", "--max-current"))
    bare = tmp_path / "force.mcap", "--model", "emps", "--max-current", "2"
    refused("plan", *bare, naming=("--max-current", "no torque constant", "--max-torque, in N"))


@pytest.mark.slow
def test_only_a_model_that_can_follow_a_command_is_simulated_first(tmp_path, stock):
    (run,) = record(stock, ("triangle:0.015:2",), seconds=12.0)
    write_mcap(by_torque(run, stock), tmp_path / "run.mcap")
    save_model(stock.with_value("drive.speed_gain", 0.0), tmp_path / "driven.yaml")
    limits = ("--max-torque", "0.4", "--max-speed", "0.04")
    follows = done("plan", tmp_path / "run.mcap", *MODEL, *limits).stdout
    assert "Record next" in follows and "ema-twin simulate" in follows
    cannot = done("plan", tmp_path / "run.mcap", "--model", tmp_path / "driven.yaml", *limits).stdout
    assert "Record next" in cannot and "no speed controller" in cannot and "ema-twin simulate" not in cannot
