"""One story: what discover, diagnose, compare, fit, the report and live say of the same recordings is told alike."""

import math
from dataclasses import replace

import pytest

from ema_bench_replay.errors import InputError
from ema_twin_msgs.msg import Diagnosis
from ema_twin_sim.commands.live_keys import told
from ema_twin_sim.comparison.beyond_noise import told_share
from ema_twin_sim.comparison.compare import compare
from ema_twin_sim.comparison.running_comparison import RunningComparison, share_removed
from ema_twin_sim.criteria import TOO_MUCH
from ema_twin_sim.fitting.doubts import still_far
from ema_twin_sim.live.diagnosing.judge import settings_between
from ema_twin_sim.measured.noise import noise_of
from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.virtual_bench import virtual_bench
from ema_twin_sim.words.findings import Findings, UnseenErrors
from ema_twin_sim.words.sentences import LARGER, refit_sentence, removed_words, verdict_of
from tests.accuracy.contradictions import contradictions, told_of

FAR_OFF = {"machine.motor_inertia": 1.5, "machine.output_inertia": 1.5}
"""Times the true value, where a start value is somebody's guess."""


@pytest.fixture(scope="module")
def guessed(stock):
    """The stock machine as somebody drafts it: inertia and friction open, their start values wrong."""
    constants = dict(stock.constants)
    for path, factor in FAR_OFF.items():
        constants[path] = replace(constants[path], value=factor * constants[path].value, tolerance=math.inf)
    gearbox = constants["machine.gearbox_inertia"]
    constants["machine.gearbox_inertia"] = replace(gearbox, tolerance=math.inf)
    effects = {name: replace(held, open=True) for name, held in stock.effects.items()}
    return replace(stock, constants=constants, effects=effects)


def recorded(machine, *commands, setpoint=True):
    runs = [virtual_bench(machine, parse_command(command), 8.0, seed=k) for k, command in enumerate(commands)]
    if setpoint:
        return runs
    return [replace(r, signals={n: v for n, v in r.signals.items() if n != "speed_setpoint"}) for r in runs]


@pytest.fixture(scope="module")
def of_guessed(stock, guessed):
    """What is said where a load is hidden and the constants are guesses."""
    machine = stock.with_effect("gravity_load", {"torque": 0.05, "angle": 0.4})
    commands = ("sine:0.05:0.5", "sine:0.2:0.25", "triangle:0.1:1")
    return told_of(recorded(machine, *commands, setpoint=False), guessed, fitted=True)


def test_all_is_told_alike_where_constants_are_guesses(of_guessed):
    assert of_guessed.findings.added == ("gravity_load",)
    assert contradictions(of_guessed) == []


def test_the_constants_own_fit_is_no_merit_of_the_effect(of_guessed):
    unseen, (step, *_) = of_guessed.content["discover"]["unseen"], of_guessed.content["discover"]["steps"]
    given = unseen["as_given"]["rmse"]
    assert given > 1.2 * unseen["rmse"][0] and step["rmse_before"] == unseen["rmse"][0]
    assert 0.0 < unseen["refit_removed"] < 1.0
    assert "refitted" in of_guessed.texts["discover"]
    assert "alone changes the error of the unexplained torque from" in of_guessed.texts["report"]


def test_all_is_told_alike_where_nothing_is_hidden(stock):
    told_of_none = told_of(recorded(stock, "ramp:0.05", "sine:0.05:0.25"), stock, fitted=True)
    assert told_of_none.findings.verdict == "none" and contradictions(told_of_none) == []


def test_one_noise_floor_whatever_the_start_values_are(stock, guessed):
    runs = recorded(stock, "ramp:0.05", "sine:0.1:1", "triangle:0.05:0.5", setpoint=False)
    true = {path: replace(guessed.constants[path], value=stock.value(path)) for path in FAR_OFF}
    gearbox = "machine.gearbox_inertia"
    true[gearbox] = guessed.constants[gearbox].at(guessed.value(gearbox) / 1.5)
    other = replace(guessed, constants={**guessed.constants, **true})
    assert noise_of(runs, other) == pytest.approx(noise_of(runs, guessed), rel=1e-9)
    for model in (guessed, other):
        floor = compare(runs, model).overall["unexplained_torque"]["noise_floor"]
        assert floor == noise_of(runs, guessed)["unexplained_torque"]


def test_friction_that_recordings_do_not_show_makes_no_noise_floor(stock, guessed):
    """The guess of a viscous friction that is not there is no property of the sensors."""
    still = stock.without_effect("viscous_friction")
    runs = recorded(still, "ramp:0.05", "sine:0.1:1", setpoint=False)
    floors = []
    for factor in (1.0, 1e5):
        viscous = guessed.effects["viscous_friction"]
        much = {"coefficient": factor * viscous.parameters["coefficient"]}
        model = replace(guessed, effects={**guessed.effects, "viscous_friction": viscous.at(much)})
        floors.append(noise_of(runs, model)["unexplained_torque"])
    assert floors[1] == pytest.approx(floors[0], rel=0.2)


def test_a_perfect_twin_stands_at_the_noise_floor_however_long_its_recordings_are(stock):
    command = parse_command("sine:0.05:0.5")
    long, short = (virtual_bench(stock, command, seconds, seed=3) for seconds in (20.0, 2.0))
    short = replace(short, signals={n: v for n, v in short.signals.items() if n != "speed"})
    both, alone = noise_of([long, short], stock), [noise_of([r], stock) for r in (long, short)]
    for name, floor in both.items():
        squares = sum(len(r) * of[name] ** 2 for r, of in zip((long, short), alone, strict=True))
        assert floor**2 == pytest.approx(squares / (len(long) + len(short)))


def test_nothing_is_missing_is_not_said_beside_what_stands_out():
    said = verdict_of(Findings("none", (), beyond_noise={"speed": 6.04, "current": 1.3}))
    assert said == (
        "These recordings show no missing effect, but the speed's error is 6.0 times the sensors' noise and the "
        "current's 1.3 times."
    )
    quiet = verdict_of(Findings("none", (), beyond_noise={"motor_torque": math.inf}))
    assert quiet.endswith("but the noise of the motor torque is not known, so nothing says how large an error may be.")
    assert verdict_of(Findings("none", ())) == "These recordings show nothing missing."


def test_live_does_not_say_to_its_noise_where_health_warns(stock):
    found = Diagnosis(verdict="none", window=12.0)
    assert told(found, {})[0].startswith("Nothing is missing: all errors are within the sensors' noise.")
    running = RunningComparison(stock, "setpoint")
    noise = running.noise_floor
    for sign in (1.0, -1.0) * 100:
        running.add(dict.fromkeys(noise, 0.0) | {"speed": sign * 6.0 * noise["speed"]}, dict.fromkeys(noise, 0.0))
    assert running.beyond_noise == {"speed": pytest.approx(6.0)}
    (first, *_) = told(found, running.beyond_noise)
    assert "within the sensors' noise" not in first and "the speed's error is 6.0 times the sensors' noise" in first


def test_fit_leaves_it_to_diagnose_what_is_missing():
    error = {"rmse": 11.0, "noise_floor": 1.0, "unit": "A", "driven": False, "relative": 0.1}
    assert error["rmse"] > TOO_MUCH
    (note,) = still_far({"speed": error}, False)
    left, what_to_do = note.split(": ")
    assert left == "what is left of the speed is 11 times the sensors' noise"
    assert what_to_do == "compare tells what it depends on, diagnose whether an effect is missing"


def test_as_many_constants_are_refitted_as_a_difference_shows(stock):
    name = "coulomb_friction"
    after = stock.with_value("machine.motor_inertia", 9e-4).with_value(f"effects.{name}.torque", 0.2)
    after = after.with_value("machine.output_inertia", stock.value("machine.output_inertia") * (1.0 + 1e-9))
    assert settings_between(stock, after) == {"machine.motor_inertia": 9e-4, f"effects.{name}.torque": 0.2}


@pytest.mark.parametrize(("before", "after"), [(10.0, 0.5), (10.0, 1.0), (10.0, 30.0), (1.1, 9.0)])
def test_no_share_is_more_than_all_or_less_than_nothing(before, after):
    share = told_share(share_removed(before, after, 1.0))
    assert 0.0 <= share <= 1.0
    assert (removed_words(share, before, after) == LARGER) == (after > before)


def test_a_search_that_tells_of_no_start_is_told_without():
    assert refit_sentence(UnseenErrors("current", "A", 0.003, (0.03, 0.003), ())) == ""


def test_a_model_that_cannot_follow_is_driven_by_the_current(stock):
    """A twin that stands still beside its setpoint looks like a machine that lacks everything."""
    (run,) = recorded(stock, "ramp:0.05")
    idle = stock.with_value("drive.speed_gain", 0.0)
    assert compare([run], idle).input == "current"
    with pytest.raises(InputError, match="speed"):
        compare([run], idle, "setpoint")
