"""The next recording: what is in doubt, the command that settles it, and that it does so on two different plants."""

import json
from dataclasses import replace

import numpy as np
import pytest

from ema_bench_replay.bags.bag_writer import write_mcap
from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from ema_twin_sim.criteria import DECIDED, MOSTLY
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.discovery.experiment.bench_limits import Limits, driven_limits, reached, widened
from ema_twin_sim.discovery.experiment.command_grid import command_grid, round_number
from ema_twin_sim.discovery.experiment.doubts import doubts
from ema_twin_sim.discovery.experiment.suggestion import suggest
from ema_twin_sim.discovery.plan import plan
from ema_twin_sim.measured.observe import observe
from ema_twin_sim.simulation.command import in_words, parse_command, write_command
from ema_twin_sim.simulation.virtual_bench import virtual_bench
from tests.accuracy.commands import Drive
from tests.accuracy.machine import drawn_machine
from tests.accuracy.other_bench import Cause, OtherBench
from tests.command_line import MODEL, done, refused

RATIO = 124.0
LIMITS = Limits(speed=0.1, acceleration=2.0, lower=-0.1, upper=0.5, current=1.0)

ONE_RAMP = [("ramp:0.05", 12.0)]
RIPPLE = ("torque_ripple", {"fraction": 0.03, "phase": 1.0}, {})
SPRING = ("spring_load", {"stiffness": 0.15}, {})
SHORT_WAY = [("sine:0.05:0.25", 20.0), ("triangle:0.02:2", 20.0)]


class VirtualBench:
    """The twin's own plant with an effect hidden in it."""

    def __init__(self, stock, effect, parameters, options=None):
        self.model = stock.with_effect(effect, parameters, options)
        self.made = 0

    def record(self, command, seconds):
        self.made += 1
        return virtual_bench(self.model, parse_command(command), seconds, seed=self.made)


class AnotherBench:
    """The plant of the accuracy tests, which shares no code with the twin's and whose constants are a little off."""

    def __init__(self, _, effect, parameters, options=None):
        machine = drawn_machine(np.random.default_rng(3))
        self.bench = OtherBench(machine, [Cause(effect, parameters, options or {})], seed=3)

    def record(self, command, seconds):
        kind, *numbers = command.split(":")
        return self.bench.record(Drive(kind, *map(float, numbers)), seconds)


@pytest.fixture(scope="module")
def ramp(stock):
    return virtual_bench(stock, parse_command("ramp:0.05"), 8.0, seed=1)


@pytest.fixture(scope="module")
def rippled(stock):
    """One ramp of a motor with torque ripple, which could be cogging."""
    bench = VirtualBench(stock, *RIPPLE)
    return [bench.record(*run) for run in ONE_RAMP]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "hidden", "runs", "rival"),
    [
        (VirtualBench, SPRING, SHORT_WAY, "gravity_load"),
        (VirtualBench, ("sun_runout", {"torque": 0.02, "phase": 1.0}, {"kind": "conservative"}), ONE_RAMP, None),
        (AnotherBench, RIPPLE, ONE_RAMP, "cogging"),
        (AnotherBench, ("constant_load", {"torque": 0.04}, {}), [("ramp:0.03", 20.0), ("ramp:0.1", 15.0)],
         "coulomb_friction"),
        (AnotherBench, ("thermal_friction", {"fraction": 0.1, "time_constant": 12.0}, {}), [("ramp:0.1", 8.0)],
         "gravity_load"),
    ],
    ids=["spring", "run-out of either kind", "ripple", "load in one direction", "warming"],
)  # fmt: skip
def test_the_planned_recording_decides(stock, kind, hidden, runs, rival):
    effect, parameters, options = hidden
    rivals = {effect, rival} if rival else {f"{effect}(kind={each})" for each in ("conservative", "dissipative")}
    bench = kind(stock, *hidden)
    recordings = [bench.record(*run) for run in runs]
    before = plan(recordings, stock)
    assert any(rivals <= set(doubt.rivals) for doubt in before.in_doubt)
    assert before.proposal.separation and min(before.proposal.separation.values()) >= DECIDED
    assert not before.inseparable

    recordings.append(bench.record(before.proposal.command, before.proposal.seconds))
    after = discover(recordings, stock)
    assert after.added == (effect,)
    assert doubts(after.equation, after.search, after.rivalries) == ()
    found = after.parameters[effect]
    assert found["options"].items() >= options.items()
    size = next(iter(parameters))
    assert found[size]["value"] == pytest.approx(parameters[size], rel=0.15)


@pytest.mark.slow
def test_nothing_in_doubt_asks_for_nothing(stock):
    commands = (("ramp:0.1", 15.0), ("triangle:0.04:2", 8.0), ("sine:0.02:1", 8.0))
    recordings = [virtual_bench(stock, parse_command(c), s, seed=k) for k, (c, s) in enumerate(commands)]
    planned = plan(recordings, stock)
    assert planned.in_doubt == () and planned.proposal is None and planned.next_recording == ""
    found = discover(recordings, stock)
    assert suggest(found.equation, found.search, found.rivalries, recordings) == ""


def test_a_suggestion_begins_with_the_command(stock, rippled):
    found = discover(rippled, stock)
    text = suggest(found.equation, found.search, found.rivalries, rippled)
    command, _, why = text.partition(" for ")
    assert parse_command(command)
    assert "torque_ripple and cogging" in why


@pytest.mark.slow
def test_the_proposal_keeps_within_what_was_driven(stock, rippled):
    driven = driven_limits([observe(recording, stock) for recording in rippled], RATIO)
    proposal = plan(rippled, stock, limits=driven).proposal
    assert proposal.beyond == () and min(proposal.separation.values()) >= DECIDED
    done = _reached(stock, proposal)
    assert driven.effort(done) <= 1.0
    assert done.lower > driven.lower - 0.02 and done.upper < 1.03 * driven.upper


@pytest.mark.slow
def test_without_limits_nothing_beyond_is_asked_for_where_less_shows_as_much(stock):
    recording = VirtualBench(stock, *RIPPLE).record("triangle:0.1:10", 20.0)
    proposal = plan([recording], stock).proposal
    assert proposal.beyond == () and min(then for _, then in proposal.shows.values()) >= DECIDED
    assert driven_limits([observe(recording, stock)], RATIO).effort(_reached(stock, proposal)) <= 1.0


@pytest.mark.slow
def test_a_slow_recording_asks_for_what_it_would_not_show(stock):
    """Nothing of it is in doubt: an encoder that is off its centre does not show while the output hardly turns."""
    bench = AnotherBench(stock, "encoder_eccentricity", {"amplitude": 4e-4, "phase": 0.65})
    slow = bench.record("triangle:0.015:2", 20.0)
    assert discover([slow], stock).added == ()
    asked = plan([slow], stock)
    assert "would not show" in asked.in_doubt[0].reason and "encoder_eccentricity" in asked.in_doubt[0].rivals
    so_far, then = asked.proposal.shows["encoder_eccentricity"]
    assert so_far < 1.0 and then >= DECIDED
    further = bench.record(asked.proposal.command, asked.proposal.seconds)
    assert discover([slow, further], stock).added == ("encoder_eccentricity",)


@pytest.mark.slow
def test_what_goes_beyond_is_told_and_a_limit_forbids_it(stock):
    bench = VirtualBench(stock, *SPRING)
    recordings = [bench.record(command, 10.0) for command, _ in SHORT_WAY]
    free = plan(recordings, stock)
    assert any(text.startswith("travel") for text in free.proposal.beyond)
    driven = driven_limits([observe(recording, stock) for recording in recordings], RATIO)
    held = plan(recordings, stock, limits=driven)
    assert held.inseparable == (("spring_load", "gravity_load"),)
    further = plan(recordings, stock, limits=replace(driven, lower=-1.6, upper=1.6))
    assert further.proposal.beyond == ()
    done = _reached(stock, further.proposal)
    assert done.lower > -1.65 and done.upper < 1.65 and done.speed < 1.1 * driven.speed


def _reached(model, proposal):
    bench = virtual_bench(model, parse_command(proposal.command), proposal.seconds, seed=None)
    return reached(observe(bench, model), RATIO)


@pytest.mark.parametrize(
    "limits",
    [
        LIMITS,
        replace(LIMITS, lower=0.0, upper=2.0),
        replace(LIMITS, lower=-0.4, upper=0.0),
        replace(LIMITS, lower=-0.003, upper=0.003, speed=0.4),
    ],
)
@pytest.mark.parametrize("few", [False, True])
def test_every_command_of_the_grid_keeps_within_limits(limits, few):
    time = np.linspace(0.0, 20.0, 20_001)
    trials = command_grid(limits, 0.005, 16.67, few=few)
    assert len({trial.command for trial in trials}) == len(trials) > 1
    for trial in trials:
        command = parse_command(trial.command)
        within = time <= trial.seconds
        values = command(time)[within]
        position = np.cumsum(values) * 1e-3 if command.speed else values
        assert position.min() > 1.01 * limits.lower - 1e-3 and position.max() < 1.01 * limits.upper + 1e-3
        if trial.kind != "step":
            speed = values if command.speed else np.gradient(values, time[within])
            assert np.abs(speed).max() < 1.01 * limits.speed


@pytest.mark.parametrize("longest", [0.5, 3.0, 8.0])
def test_a_shorter_recording_still_has_whole_periods(longest):
    trials = command_grid(LIMITS, 0.005, 16.67, few=True, longest=longest)
    assert {"ramp", "triangle", "sine"} <= {trial.kind for trial in trials}
    assert all(0.2 * longest <= trial.seconds <= longest for trial in trials)
    assert all(trial.turns >= 2 for trial in trials if trial.kind != "ramp")


def test_round_numbers_do_not_round_up():
    values = 10.0 ** np.random.default_rng(0).uniform(-6, 3, 200)
    assert all(0.7 * value < round_number(value) <= value * (1.0 + 1e-9) for value in values)
    assert round_number(0.0) == round_number(-1.0) == 0.0


def test_limits_know_what_exceeds_them():
    inside = replace(LIMITS, speed=0.05, lower=0.0, upper=0.3, current=0.5)
    assert LIMITS.effort(inside) == pytest.approx(1.0 / 1.15)  # the acceleration
    assert LIMITS.exceeded(inside) == ()
    for name, value in (("speed", 0.12), ("acceleration", 3.0), ("current", 2.0)):
        beyond = replace(inside, **{name: value})
        assert LIMITS.effort(beyond) > 1.0
        assert [text.split()[0] for text in LIMITS.exceeded(beyond)] == [name]
    assert LIMITS.effort(replace(inside, upper=0.6)) > 1.0
    assert "travel" in LIMITS.exceeded(replace(inside, lower=-0.2))[0]


def test_wider_limits_stop_before_the_stops_and_the_drive(stock):
    free = widened(LIMITS, stock, 0.0)
    assert free.speed == 2.0 * LIMITS.speed and free.upper == pytest.approx(20.0 * free.speed) == -free.lower
    assert free.current == 2.0 * LIMITS.current
    fast = widened(LIMITS, stock, 0.0, 10.0)
    assert fast.speed == 10.0 * LIMITS.speed and fast.current == free.current
    assert (fast.lower, fast.upper) == (free.lower, free.upper)  # stops may be where nothing has been
    slow = widened(replace(LIMITS, speed=0.01), stock, 0.0, 10.0)
    assert slow.upper == pytest.approx(LIMITS.upper - LIMITS.lower) == -slow.lower
    stopped = stock.with_value("transmission.end_stop_upper", 1.0).with_value("transmission.end_stop_lower", -0.05)
    held = widened(LIMITS, stopped, 0.2)
    assert held.upper == pytest.approx(0.9 * 0.8)
    assert held.lower == pytest.approx(-0.9 * 0.25)
    driven = replace(LIMITS, lower=-0.24)
    assert widened(driven, stopped, 0.2).lower == driven.lower
    weak = stock.with_value("drive.speed_limit", 0.15 * RATIO).with_value("drive.current_limit", 0.8)
    assert widened(LIMITS, weak, 0.0).speed == pytest.approx(MOSTLY * 0.15)
    assert widened(LIMITS, weak, 0.0).current == pytest.approx(MOSTLY * 0.8)


@pytest.mark.parametrize("text", ["ramp:-0.05", "triangle:0.025:2.5", "sine:0.02:0.2", "speed-sine:0.1:0.1"])
def test_a_command_file_reads_back(tmp_path, text):
    path = tmp_path / "next.yaml"
    path.write_bytes(write_command(text, 12.0, "two effects: one 'may' be true # indeed"))
    command = parse_command(str(path))
    assert (command.text, command.seconds) == (text, 12.0)
    time = np.linspace(0.0, 12.0, 100)
    assert np.array_equal(command(time), parse_command(text)(time))
    assert path.read_text("utf-8").startswith(f"# {in_words(text)}\n")


def test_commands_in_words():
    assert in_words("triangle:0.04:2") == "position of the output: a triangle of ±0.04 rad/s that turns every 2 s"
    assert in_words("triangle:-0.15:4") == "position of the output: a triangle of ±0.15 rad/s that turns every 4 s"
    assert in_words("ramp:-0.15") == "position of the output: a ramp of -0.15 rad/s"
    assert in_words("speed-ramp:0.01") == "speed of the output: a ramp of 0.01 rad/s²"


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("", "command"),
        ("version: 2\ncommand: ramp:0.05\n", "version"),
        ("version: 1\n", "command"),
        ("version: 1\ncommand: other.yaml\n", "other.yaml"),
        ("version: 1\ncommand: ramp\n", "ramp"),
        ("version: 1\ncommand: 5\n", "command"),
        ("version: 1\ncommand: ramp:0.05\nseconds: long\n", "seconds"),
        ("version: 1\ncommand: ramp:0.05\nseconds: -1\n", "seconds"),
        ("version: 1\ncommand: ramp:0.05\nspeed: 1\n", "speed"),
        ("version: [\n", "line"),
    ],
)
def test_a_bad_command_file_is_named_with_its_place(tmp_path, text, named):
    path = tmp_path / "bad.yaml"
    path.write_text(text)
    with pytest.raises(InputError, match=r"bad\.yaml") as refused:
        parse_command(str(path))
    assert named in str(refused.value) and "\n" not in str(refused.value)


@pytest.mark.slow
def test_the_command_line_plans_writes_and_simulates(tmp_path, ramp):
    """One direction asks for a reversal; with that, what both would not show is asked for."""
    write_mcap(ramp, tmp_path / "ramp.mcap")
    planned = done("plan", "ramp.mcap", *MODEL, "-o", "next.yaml", "--json", "plan.json", cwd=tmp_path)
    content = json.loads((tmp_path / "plan.json").read_text())
    proposal = content["proposal"]
    for word in ("In doubt", "No recording reverses", f"Record next: {proposal['command']}", "rad/s", "next.yaml"):
        assert word in planned.stdout
    assert content["verdict"] == "none" and content["in_doubt"][0]["rivals"] == ["none", "constant_load"]
    assert "reverses" in proposal["why"] and content["next_recording"].startswith(proposal["command"])
    assert content["limits"]["speed"]["value"] == pytest.approx(0.05, rel=0.05)
    made = done("simulate", *MODEL, "--command", "next.yaml", "-o", "next.CSV", cwd=tmp_path)
    assert f"{proposal['seconds']:.2f} s" in made.stdout
    speed = load(tmp_path / "next.CSV").signals["speed"]
    assert speed.max() > 0.5 and speed.min() < -0.5
    again = done("plan", "ramp.mcap", "next.CSV", *MODEL, "-o", "more.yaml", cwd=tmp_path)
    assert "These recordings would not show" in again.stdout and "Stribeck" not in again.stdout
    assert (tmp_path / "more.yaml").exists()
    refusals = {
        ("-o", "next.yaml"): "--force",
        ("-o", "next.txt"): ".yaml",
        ("--max-speed", "nan"): "--max-speed",
        ("--without", "backlashh"): "backlash",
    }
    for options, word in refusals.items():
        refused("plan", "ramp.mcap", *MODEL, *options, cwd=tmp_path, naming=(word,))


def test_recordings_that_cannot_be_judged_are_refused(stock, ramp):
    with pytest.raises(InputError, match="current"):
        plan([replace(ramp, signals={"motor_position": ramp.signals["motor_position"]})], stock)
    still = virtual_bench(stock, parse_command("ramp:0"), 4.0)
    with pytest.raises(InputError, match="motion"):
        plan([still], stock)
