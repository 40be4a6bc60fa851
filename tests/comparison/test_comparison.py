"""Comparison of models with recordings: the numbers, where a model fails, and the error that falls."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from ema_bench_replay.recording import Recording
from ema_twin_sim.commands.shown_comparison import show_comparison
from ema_twin_sim.comparison.compare import compare, compare_all
from ema_twin_sim.comparison.running_comparison import RunningComparison
from ema_twin_sim.comparison.where import Dependence, Stretch, find_dependences
from ema_twin_sim.quantities import signal_words
from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.compared_signals import UNITS, noise_floors
from ema_twin_sim.simulation.simulate import simulate
from ema_twin_sim.simulation.virtual_bench import virtual_bench
from tests.recorded import benched, with_signals


@pytest.fixture(scope="module")
def recordings(traces):
    return [load(path) for path in traces]


def excess_removed(before, after, signal):
    floor = before[signal]["noise_floor"] ** 2
    return (before[signal]["rmse"] ** 2 - after[signal]["rmse"] ** 2) / (before[signal]["rmse"] ** 2 - floor)


def test_adding_the_hidden_effects_removes_nine_tenths_of_the_excess_error(stock, recordings):
    better = stock.with_effect("stribeck_friction", {"torque": 0.08, "speed": 2.0})
    better = better.with_effect("backlash", {"width": 0.004})
    before, after = (compare(recordings, model) for model in (stock, better))
    for signal in ("current", "output_position"):
        assert excess_removed(before.overall, after.overall, signal) > 0.9


def test_the_same_on_the_held_out_recordings_of_another_virtual_bench(bench_cases, stock):
    case = bench_cases / "dev10"
    answer = json.loads((case / "answer.json").read_text())["parameters"]
    held_out = [load(path) for path in sorted((case / "holdout").glob("*.CSV"))]
    better = stock
    for effect, parameters in answer.items():
        better = better.with_effect(effect, parameters)
    before, after = (compare(held_out, model) for model in (stock, better))
    for signal in ("current", "output_position"):
        assert excess_removed(before.overall, after.overall, signal) > 0.9


def test_a_drive_that_tells_its_torque_is_told_where_that_fails(stock):
    hidden = stock.with_effect("stribeck_friction", {"torque": 0.08, "speed": 2.0})
    bench = benched(hidden, "sine:0.02:1", 5.0, name="by torque", seed=1)
    signals = dict(bench.signals)
    signals["motor_torque"] = stock.value("machine.torque_constant") * signals.pop("current")
    del signals["current_setpoint"]
    by_torque, by_current = compare([with_signals(bench, signals)], stock), compare([bench], stock)
    told, other = (
        {d.variable: d for d in c.where if d.signal == s}
        for c, s in ((by_torque, "motor_torque"), (by_current, "current"))
    )
    assert "current" not in {d.signal for d in by_torque.where} and told.keys() == other.keys()
    for variable, dependence in told.items():
        assert dependence.unit == "N m" and dependence.share == pytest.approx(other[variable].share)
        assert dependence.rmse_there == pytest.approx(1.91 * other[variable].rmse_there)


def test_the_numbers_are_those_of_their_definition(stock, recordings):
    recording = recordings[0]
    twin = simulate(stock, recording)
    result = compare([recording], stock).recordings[0]
    assert result.samples == len(recording) and result.duration == recording.duration
    for name in ("current", "speed", "motor_position", "output_position"):
        residual = recording.signals[name] - twin.signals[name]
        assert result.signals[name]["rmse"] == pytest.approx(np.sqrt(np.mean(residual**2)))
        relative = np.linalg.norm(residual) / np.linalg.norm(recording.signals[name])
        assert result.signals[name]["relative"] == pytest.approx(relative)
        assert result.signals[name]["unit"] == UNITS[name]
    assert not any(signal["driven"] for signal in result.signals.values())


def test_overall_pools_all_samples(stock, recordings):
    comparison = compare(recordings, stock)
    squares = [r.signals["current"]["rmse"] ** 2 * r.samples for r in comparison.recordings]
    samples = sum(r.samples for r in comparison.recordings)
    assert comparison.overall["current"]["rmse"] == pytest.approx(math.sqrt(sum(squares) / samples))


def test_under_current_the_current_is_marked_as_driven(stock, recordings):
    comparison = compare(recordings[:1], stock, "current")
    assert comparison.input == "current"
    assert comparison.overall["current"]["driven"] and comparison.overall["current"]["rmse"] == 0.0
    assert comparison.overall["unexplained_torque"]["rmse"] < 0.05


def test_a_recording_without_a_setpoint_is_driven_by_its_current(stock, recordings):
    bare = recordings[0]
    counters = {n: bare.signals[n] for n in ("current", "motor_position", "output_position")}
    comparison = compare([Recording("bare", bare.stamps, counters)], stock)
    assert comparison.input == "current"
    assert set(comparison.overall) == {*counters, "unexplained_torque", "encoder_difference"}
    with pytest.raises(InputError, match="speed_setpoint"):
        compare([Recording("bare", bare.stamps, counters)], stock, "setpoint")


def test_sample_by_sample_and_whole_give_the_same_statistics(stock, recordings):
    recording = recordings[1].between(0.0, 4.0)
    twin = simulate(stock, recording)
    whole, single = RunningComparison(stock, "setpoint"), RunningComparison(stock, "setpoint")
    whole.add_rows(recording.signals, twin.signals)
    for k in range(len(recording)):
        single.add(
            {n: float(v[k]) for n, v in recording.signals.items()}, {n: float(v[k]) for n, v in twin.signals.items()}
        )
    for name, signal in whole.result().items():
        for key in ("rmse", "relative", "noise_floor"):
            assert single.result()[name][key] == pytest.approx(signal[key], rel=1e-9)
    assert single.rmse_window == pytest.approx(whole.rmse_window, nan_ok=True)


def test_samples_without_a_value_do_not_count(stock):
    running = RunningComparison(stock, "setpoint")
    assert math.isnan(running.rmse["current"]) and running.result() == {}
    residual = running.add({"current": 1.0, "speed": math.nan}, {"current": 0.5, "speed": 2.0})
    assert residual["current"] == 0.5 and math.isnan(residual["speed"]) and math.isnan(residual["output_position"])
    assert set(running.result()) == {"current"}


def test_the_noise_floor_is_what_remains_of_a_right_twin(stock):
    """Measured on noise alone: the virtual bench with and without its sensors' noise, turning steadily."""
    command = parse_command("ramp:0.05")
    noisy = virtual_bench(stock, command, 20.0, seed=5)
    running = RunningComparison(stock, "setpoint")
    settled = noisy.between(1.0)
    twin = simulate(stock, noisy).between(1.0)
    running.add_rows(settled.signals, twin.signals)
    floors = noise_floors(stock)
    for name in ("current", "speed", "unexplained_torque"):
        assert running.rmse[name] == pytest.approx(floors[name], rel=0.05), name


@pytest.mark.parametrize(
    ("effect", "parameters", "options", "command", "signal", "variable"),
    [
        ("sun_runout", {"torque": 0.03}, {}, "ramp:0.05", "current", "order"),
        ("viscous_friction", {"coefficient": 0.02}, {}, "triangle:0.06:2", "current", "speed"),
        ("backlash", {"width": 0.004}, {}, "triangle:0.04:2", "output_position", "direction"),
    ],
)
def test_where_a_model_fails_is_told(stock, effect, parameters, options, command, signal, variable):
    bench = benched(stock.with_effect(effect, parameters, options), command, 12.0)
    found = [d for d in compare([bench], stock).where if d.signal == signal]
    shares = {d.variable: d.share for d in found}
    assert shares[variable] > 0.3
    assert shares[variable] > 0.9 * max(shares.values())
    if variable == "order":
        (order,) = (d for d in found if d.variable == "order")
        assert order.lower == pytest.approx(1.0, abs=0.05)
        assert order.place == "once per motor revolution" and "repeats once per" in order.sentence()


def dependence(variable, share, there, elsewhere, place):
    means = ((-2e-3, place), (-2e-3, place))
    return Dependence("current", "A", variable, share, 0.0, 1.0, "", there, elsewhere, (1.0,), place, means)


@pytest.mark.parametrize(
    ("found", "where", "end"),
    [
        (
            dependence("speed", 0.05, 0.125, 0.0274, "at 1 to 2 rad/s"),
            "at 1 to 2 rad/s",
            "it is largest at 1 to 2 rad/s: 125 mA there, 27.4 mA elsewhere.",
        ),
        (
            dependence("speed", 0.05, 1.08e-3, 8.01e-3, "at 1 to 2 rad/s"),
            "about the same everywhere",
            "alone explains much of the error of the current (speed 5 % of its power); about the same everywhere.",
        ),
        (
            dependence("order", 0.05, 1.08e-3, 8.01e-3, "24 times per motor revolution"),
            "1.08 mA of it repeat 24 times per motor revolution",
            "(repetition with the motor's angle 5 % of its power); 1.08 mA of it repeat 24 times per motor revolution.",
        ),
        (
            dependence("speed", 0.004, 1.08e-3, 8.01e-3, "at 1 to 2 rad/s"),
            "about the same everywhere",
            "depends on neither speed, direction, position nor time alone; about the same everywhere.",
        ),
        (
            dependence("constant", 0.05, 8.01e-3, 8.01e-3, "everywhere"),
            "-2.00 mA everywhere, on average",
            "(constant offset 5 % of its power); -2.00 mA everywhere, on average.",
        ),
    ],
)
def test_an_error_is_largest_only_where_it_is(found, where, end):
    assert found.where == where and found.sentence().endswith(end)
    assert found.is_largest_there == ("there" in found.sentence())


def test_noise_depends_on_nothing(stock):
    bench = benched(stock, "triangle:0.04:2", 12.0)
    for dependence in compare([bench], stock).where:
        if dependence.signal == "current":
            assert dependence.share < 0.05


def test_the_json_has_the_keys_that_others_rely_on(stock, recordings):
    content = compare(recordings, stock).as_json()
    assert list(content) == ["model", "input", "recordings", "overall", "where", "warnings"]
    assert list(content["recordings"][0]) == ["name", "samples", "duration", "signals"]
    assert list(content["overall"]["current"]) == ["rmse", "relative", "noise_floor", "unit", "driven"]
    json.dumps(content, allow_nan=False)


def test_a_wrong_unit_is_told_once_for_all_recordings_and_first(stock, recordings):
    amperes = ("current", "current_setpoint")
    wrong = [
        with_signals(r, {name: (1e3 if name in amperes else 1.0) * values for name, values in r.signals.items()})
        for r in recordings[:2]
    ]
    found = compare(wrong, stock)
    (said,) = found.misread
    assert said.startswith("2 of 2 recordings, the worst is ") and "mA and read as A" in said
    assert found.warnings[0] == said
    assert compare(recordings[:1], stock).misread == ()


def test_models_share_the_noise_floor_of_the_best_whatever_their_order(stock, recordings):
    """A first model whose sensors are off by far had set the floor that its successor was measured by."""
    noisy = stock.with_value("sensors.current_noise", 1e3 * stock.value("sensors.current_noise"))
    noisy = noisy.with_value("machine.motor_inertia", 50.0 * noisy.value("machine.motor_inertia"))
    alone = compare(recordings[:2], stock).overall
    for models in ((noisy, stock), (stock, noisy)):
        for comparison in compare_all(recordings[:2], models):
            for name, error in comparison.overall.items():
                assert error["noise_floor"] == alone[name]["noise_floor"]
            for recording in comparison.recordings:
                assert {name: e["noise_floor"] for name, e in recording.signals.items()} == {
                    name: alone[name]["noise_floor"] for name in recording.signals
                }


def test_an_axis_without_a_gear_has_no_speed_of_the_motor_shaft():
    """Whoever records a direct axis has no motor shaft to look for."""
    time = np.arange(20_000) * 1e-3
    speed = np.sin(time)
    stretch = Stretch(speed**3, speed, -np.cos(time), -np.cos(time), time)
    for direct in (True, False):
        found = find_dependences("current", "A", [stretch], direct=direct)
        where = next(dependence.where for dependence in found if dependence.variable == "speed")
        assert where.endswith("rad/s" if direct else "rad/s of the motor shaft")


@pytest.mark.parametrize(("motion", "driving"), [("rotary", "torque"), ("linear", "force")])
def test_what_was_recorded_is_named_as_what_drives_the_twin(stock, recordings, motion, driving, capsys):
    found = compare(recordings[:1], stock, "current")
    show_comparison([found])
    assert "(input: current)" in (told := capsys.readouterr().out) and "The current drives the twin" in told
    overall = {"motor_torque" if name == "current" else name: error for name, error in found.overall.items()}
    shown = replace(found, overall=overall, motion=motion)
    for comparisons in ([shown], [shown, replace(shown, model="other")]):
        show_comparison(comparisons)
        told = " ".join(capsys.readouterr().out.split())
        assert f"The {driving} drives the twin" in told and "input current" not in told and "input: current" not in told


@pytest.mark.parametrize(("unit", "words"), [("N m", "motor torque"), ("N", "motor force"), ("", "motor torque")])
def test_a_carriage_has_a_force(unit, words):
    assert signal_words("motor_torque", unit) == words
    stretch = Stretch(np.sign(np.sin(np.arange(9000.0))), *(np.sin(1e-3 * np.arange(9000.0)) for _ in range(4)))
    told = [found.sentence() for found in find_dependences("motor_torque", unit, [stretch])]
    assert told and all(words in sentence for sentence in told)
