"""A recording that is compared piece by piece gives the figures of the whole, in memory that does not grow with it."""

import math
import os
import subprocess
import sys

import numpy as np
import pytest

from ema_bench_replay import long_columns
from ema_bench_replay.bags.bag_writer import write_bag
from ema_bench_replay.load import load
from ema_bench_replay.recording import Recording
from ema_twin_sim.commands import output
from ema_twin_sim.comparison.compare import compare
from ema_twin_sim.measured import order_spectrum
from ema_twin_sim.model import load_model
from ema_twin_sim.simulation.simulate import simulate
from tests.recorded import benched, with_signals


@pytest.fixture(scope="module")
def bench(stock):
    hidden = stock.with_effect("stribeck_friction", {"torque": 0.08, "speed": 2.0})
    hidden = hidden.with_effect("backlash", {"width": 0.004})
    return benched(hidden, "triangle:0.06:1", 12.0, name="run", seed=1)


@pytest.fixture
def by_pieces(monkeypatch):
    """What makes recordings long from 2001 samples on; cuts of an angle are short in any case."""
    monkeypatch.setattr(order_spectrum, "_LARGEST", 1 << 14)

    def begin():
        monkeypatch.setattr(long_columns, "WHOLE", 2000)
        monkeypatch.setattr(long_columns, "PIECE", 1000)

    return begin


def less(bench, *names):
    return with_signals(bench, {name: values for name, values in bench.signals.items() if name not in names})


def gapped(bench):
    """The recording without some of its samples."""
    kept = np.flatnonzero(np.arange(len(bench)) % 1500 > 30)
    stamps = bench.stamps[kept] - bench.stamps[kept[0]]
    signals = {name: values[kept] for name, values in bench.signals.items()}
    return Recording("run", stamps, signals).from_zero()


def turned(bench):
    """The recording with a motor that goes so far that its turns are taken in several cuts, of 32 turns each."""
    way = 2.0 * math.pi * 200.0 * np.linspace(0.0, 1.0, len(bench))
    ways = {"motor_position": way, "output_position": way / 124.0}
    return with_signals(bench, bench.signals | {name: bench.signals[name] + more for name, more in ways.items()})


def at_rest(bench):
    """The recording of a machine that is not moved: its positions never change, its current and speed are noise."""
    still, noise = np.zeros(len(bench)), np.random.default_rng(2).normal(size=(2, len(bench)))
    at = dict.fromkeys(("motor_position", "output_position", "output_command", "speed_setpoint"), still)
    return with_signals(bench, {**at, "current": 0.05 * noise[0], "speed": 0.01 * noise[1]})


VARIANTS = {
    "as it came": lambda bench: bench,
    "without speed": lambda bench: less(bench, "speed"),
    "without output": lambda bench: less(bench, "output_position"),
    "speed alone": lambda bench: less(bench, "motor_position", "output_position"),
    "by torque": lambda bench: with_signals(
        bench, {"motor_torque": 0.4 * bench.signals["current"], **less(bench, "current", "current_setpoint").signals}
    ),
    "samples missing": gapped,
    "many turns": turned,
    "at rest": at_rest,
    "at rest, output alone": lambda bench: less(at_rest(bench), "speed", "motor_position"),
}


def assert_alike(one, other, place=""):
    """Texts and lists equal, numbers to a millionth; shares, which are differences, to a billionth of the whole."""
    assert type(one) is type(other), place
    if isinstance(one, dict):
        assert one.keys() == other.keys(), place
        for key in one:
            assert_alike(one[key], other[key], f"{place}/{key}")
    elif isinstance(one, list):
        assert len(one) == len(other), place
        for k, pair in enumerate(zip(one, other, strict=True)):
            assert_alike(*pair, f"{place}/{k}")
    elif isinstance(one, float):
        assert one == pytest.approx(other, rel=1e-6, abs=1e-9, nan_ok=True), place
    else:
        assert one == other, place


def without_encoder_difference(told):
    """What ``compare`` tells of a recording too long for that."""
    for signals in (told["overall"], *(recording["signals"] for recording in told["recordings"])):
        signals.pop("encoder_difference", None)
    return {**told, "where": [place for place in told["where"] if place["signal"] != "encoder_difference"]}


@pytest.mark.parametrize("source", ["setpoint", "current"])
@pytest.mark.parametrize("variant", VARIANTS)
def test_figures_of_pieces_are_those_of_the_whole(variant, source, bench, stock, by_pieces):
    recording = VARIANTS[variant](bench)
    whole = compare([recording], stock, source)
    by_pieces()
    told = compare([recording], stock, source)
    for one, other in zip(whole.recordings, told.recordings, strict=True):
        independent = {**one.independent, "encoder_difference": 0.0}
        assert independent == pytest.approx(dict(other.independent), rel=1e-6)
    wholes, tolds = without_encoder_difference(whole.as_json()), told.as_json()
    for one, other in zip(wholes["recordings"], tolds["recordings"], strict=True):
        # smoothed and filtered by pieces, which have ends
        errors = [side.pop("torque_error", None) for side in (one, other)]
        assert (errors[0] is None) == (errors[1] is None)
        if errors[0]:
            near = 0.4 if variant == "samples missing" else 0.1
            assert errors[1]["relative"] == pytest.approx(errors[0]["relative"], rel=near)
    assert_alike(wholes, tolds)


def test_a_linear_machine_is_compared_by_pieces_as_whole(by_pieces):
    model = load_model("emps")
    recording = benched(model, "sine:0.05:0.5", 12.0, name="run", seed=1)
    worse = model.with_setting("effects.coulomb_friction.torque", 0.5)
    whole = compare([recording], worse).as_json()
    by_pieces()
    told = compare([recording], worse).as_json()
    wheres = [side.pop("where") for side in (whole, told)]
    assert_alike(whole, told)
    # what is open in it is estimated of pieces that are spread over a recording, and that tells what standstill is
    for one, other in zip(*wheres, strict=True):
        assert (one["signal"], one["variable"]) == (other["signal"], other["variable"])
        assert one["share"] == pytest.approx(other["share"], abs=0.01)


def test_a_twin_goes_on_from_piece_to_piece_to_the_bit(bench, stock, by_pieces):
    model = stock.with_effect("backlash", {"width": 0.004})
    load_torque = np.where(np.arange(len(bench)) % 700 < 690, 0.01, np.nan)  # where it is missing, the last one holds
    recording = with_signals(bench, {**bench.signals, "load_torque": load_torque})
    whole = simulate(model, recording)
    by_pieces()
    shares = []
    told = simulate(model, recording, progress=shares.append)
    assert told.signals.keys() == whole.signals.keys()
    for name, values in whole.signals.items():
        np.testing.assert_array_equal(values, told.signals[name], err_msg=name)
    assert len(shares) == 6
    assert shares[-1] == 1.0
    assert shares == sorted(shares)
    wanted = simulate(model, recording, wanted=("current", "speed"))
    assert sorted(wanted.signals) == ["current", "speed"]


def test_a_signal_of_the_wrong_unit_is_named_once(bench, stock, by_pieces):
    wrong = with_signals(bench, {**bench.signals, "speed": bench.signals["speed"] * 60.0 / (2.0 * math.pi)})
    whole = compare([wrong], stock).warnings
    by_pieces()
    told = compare([wrong], stock).warnings
    assert len(told) == len(whole) > 0
    assert "rpm" in told[0]


def test_a_log_tells_how_much_of_a_long_recording_was_compared(monkeypatch, capsys):
    for name in ("_SECONDS_BETWEEN_LOG_LINES", "_SECONDS_BETWEEN_SHARES"):
        monkeypatch.setattr(output, name, 0.0)
    with output.counted(2, "comparing") as done:
        done.within("night", 0.25)
        done.within("night", 0.5)
        done("night")
        done.within("day", 0.5)
        done("day")
    told = capsys.readouterr().err.splitlines()
    wanted = ("25 % of night", "50 % of night", "comparing: 1 of 2 done (night)", "50 % of day")
    assert [words in line for words, line in zip(wanted, told, strict=True)] == [True] * 4
    assert all("left" in line for line in told[:2])  # beyond, once as much time has passed as the first took


MEASURE = """
import sys
from pathlib import Path
from ema_bench_replay import long_columns
from ema_bench_replay.load import load
from ema_twin_sim.comparison.compare import compare
from ema_twin_sim.model import load_model
long_columns.WHOLE, long_columns.PIECE = 1 << 16, 1 << 15
compare([load(sys.argv[1])], load_model("polito_bench"))
# of this process alone: ru_maxrss holds what its parent had, too
print(Path("/proc/self/status").read_text().partition("VmHWM:")[2].split()[0])
"""


@pytest.mark.slow
def test_memory_does_not_grow_with_the_recording(bench, tmp_path):
    """The largest resident size of processes that compare a recording, and one four times as long.

    In one piece, the longer one takes 230 bytes a sample more.
    """
    sizes = {}
    for times in (40, 160):
        count = times * (len(bench) - 1)
        signals = {name: np.resize(values[:-1], count) for name, values in bench.signals.items()}
        bag = write_bag(Recording(f"run{times}", np.arange(count) * 2_000_000, signals), tmp_path)
        child = subprocess.run(
            [sys.executable, "-c", MEASURE, str(bag)], capture_output=True, text=True, check=True, env=os.environ
        )
        sizes[count] = int(child.stdout) << 10
    (less_samples, small), (samples, large) = sizes.items()
    assert (large - small) / (samples - less_samples) < 20.0
    assert load(bag).duration > 1900.0
