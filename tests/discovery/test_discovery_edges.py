"""Discovery where recordings or models are not as usual: coarse currents, standstills, jumps, gaps, one side."""

import re

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording
from ema_twin_sim.discovery import unmoved
from ema_twin_sim.discovery.diagnose import diagnose
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.discovery.evidence import evidence_json
from ema_twin_sim.fitting.fit import fit_model
from ema_twin_sim.identification.compliance import structural_fits
from ema_twin_sim.measured.observe import observe
from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.simulate import simulate
from ema_twin_sim.simulation.virtual_bench import virtual_bench
from tests.large_arm import open_arm
from tests.problems import fit_of
from tests.recorded import COMMANDS, changed, record, with_signals


@pytest.fixture(scope="module")
def heavy(stock):
    """The stock machine with an arm."""
    return stock.with_effect("gravity_load", {"torque": 0.09, "angle": 0.5})


@pytest.mark.parametrize("step", [0.01, 0.02])
def test_a_coarse_current_hides_no_load_and_invents_nothing(step, stock, heavy):
    coarse = [changed(r, current=step * np.round(r.signals["current"] / step)) for r in record(heavy)]
    found = discover(coarse, stock)
    assert (found.verdict, found.added) == ("explained", ("gravity_load",))


@pytest.mark.slow
def test_a_recording_at_standstill_among_others_is_no_error(stock, heavy):
    still = virtual_bench(heavy, parse_command("ramp:1e-9"), 4.0, seed=9, name="still")
    recordings = [*record(heavy, COMMANDS[:2]), still]
    found = discover(recordings, stock)
    assert found.added == ("gravity_load",)
    assert evidence_json(found)["steps"]
    assert diagnose(recordings, stock, without=["gravity_load", "constant_load"]).verdict == "unknown"


@pytest.mark.parametrize("period", [0.001, 0.008, 0.016, 0.02, 0.03])
def test_no_row_stands_on_samples_at_rest(period):
    """However long the kernel is: a motor held at rest holds any torque up to its break-away, and none of it slides."""
    arm = open_arm()
    time = np.arange(int(40.0 / period)) * period
    speed = np.where(time > 20.0, np.sin(2.0 * np.pi * 0.2 * (time - 20.0)), 0.0)
    torque = np.where(time > 20.0, np.sign(speed), 0.05 * time)
    signals = {"speed": speed, "motor_position": np.cumsum(speed) * period, "motor_torque": torque, "current": torque}
    run = Recording("held", np.rint(time * 1e9).astype(np.int64), signals)
    seen = observe(run, arm)
    assert (seen.motion[seen.rows, 0] > 19.5).all()
    assert len(seen.rows) * np.diff(seen.rows).min() * period > 14.0  # s of 20: the rest are its reversals


def test_constants_that_all_moved_for_sure_stay_where_they_are(stock, heavy, monkeypatch):
    monkeypatch.setattr(unmoved, "LIKELY", 0.0)  # standard errors: whatever is not exactly at its file's value
    found = discover(record(heavy), stock)
    assert (found.verdict, found.added) == ("explained", ("gravity_load",))
    assert {"inertia", "motor inertia", "motor_inertia"} & {*found.constants["machine"]}


def test_a_model_with_play_is_fitted_without_an_output_encoder(stock):
    bare = [
        with_signals(r, {n: v for n, v in r.signals.items() if n != "output_position"})
        for r in record(stock, seconds=10.0)
    ]
    fitted = fit_model(bare, stock.with_effect("backlash", {"width": 0.002}), method="equation")
    width = fitted.parameters["backlash"]["width"]
    assert 0.0 < width["value"] < 0.0025 and width["std"] > 1e-5  # the torque has none to show


def test_counts_that_a_counter_lost_are_no_play(stock):
    """An output encoder loses 2 mrad on its way."""
    recording, *others = record(stock)
    jumped = changed(recording, output_position=recording.signals["output_position"] - 0.002 * (recording.time > 4.0))
    whole, broken = observe(recording, stock), observe(jumped, stock)
    assert whole.encoder_piece.max() == 0 and broken.encoder_piece.max() == 1
    found = discover([jumped, *others], stock)
    assert (found.verdict, found.added) == ("none", ())


def test_a_long_gap_is_refused_with_its_place(stock):
    recording = record(stock)[0]
    stamps = recording.stamps + np.where(recording.time > 5.0, 90 * 10**9, 0)
    with pytest.raises(InputError, match=r"run0: 90 s are missing at 5\.?\d* s; cut it there"):
        observe(with_signals(recording, dict(recording.signals), stamps), stock)


def test_all_long_gaps_are_told_at_once_with_the_longest_part_between_them(stock):
    """Each cut showed the next gap."""
    recording = record(stock)[0]
    late = sum(np.where(recording.time > at, gap * 10**9, 0) for at, gap in ((1.0, 90), (1.5, 70), (5.0, 100)))
    with_gaps = with_signals(recording, dict(recording.signals), recording.stamps + late)
    with pytest.raises(InputError, match=r"100 s are missing at 165 s, the longest of 3 gaps over 60 s; .*") as said:
        observe(with_gaps, stock)
    with pytest.raises(InputError) as same:
        simulate(stock, with_gaps)
    assert str(same.value) == str(said.value)
    found = re.search(r"3\.\d+ s, is --from ([\d.]+) --to ([\d.]+)$", str(said.value))
    start, end = map(float, found.groups())
    part = with_gaps.between(start, end)
    assert part.duration == pytest.approx(3.5, abs=0.05) and not [gap for gap in part.gaps if gap.duration > 60.0]
    observe(part, stock)


def test_an_effect_that_is_switched_off_can_be_found(stock, heavy):
    model = stock.with_effect("gravity_load", {"torque": 0.05, "angle": 0.0}).with_enabled("gravity_load", False)
    assert discover(record(heavy), model).added == ("gravity_load",)


@pytest.mark.slow
def test_coulomb_friction_is_found_on_both_sides_of_play(stock):
    start = stock.without_effect("coulomb_friction")
    recordings = record(stock.with_effect("backlash", {"width": 0.003}), ("sine:0.05:0.4", *COMMANDS[:2]))
    found = discover(recordings, start)
    assert sorted(found.added) == ["backlash", "coulomb_friction"]
    sides = {entry["options"]["side"]: entry for entry in found.parameters.values() if "torque" in entry}
    assert sides["output"]["torque"]["value"] == pytest.approx(0.045, rel=0.15)
    assert sides["motor"]["torque"]["value"] == pytest.approx(0.0676, rel=0.15)


def test_play_that_is_barred_leaves_the_spring_to_be_tried(stock):
    f = fit_of(record(stock.with_effect("backlash", {"width": 0.003})), stock)
    tried = structural_fits(f.problem, f, frozenset({"backlash"}))
    assert [f.hypothesis.effects for f in tried] == [("shaft_compliance",)]


@pytest.mark.slow
def test_the_numbers_of_teeth_that_were_fitted_are_told(stock):
    found = discover(record(stock.with_effect("backlash", {"width": 0.003})), stock)
    assert found.added == ("backlash",)
    stiffness, nominal = (m.value("transmission.contact_stiffness") for m in (found.model, stock))
    if stiffness == nominal:  # the file's follows the recordings better: held, and no estimate
        assert "transmission" not in found.constants
    else:
        told = found.constants["transmission"]["contact_stiffness"]
        assert (told["value"], told["nominal"]) == (stiffness, nominal)
    sure = [held for part in found.constants.values() for held in part.values()]
    assert sure and all(0.0 < held["std"] < held["nominal"] for held in sure)


def test_in_one_direction_play_is_not_named_but_not_overlooked_either(stock):
    """The output hangs back by half the gap from the start on, and nothing else ever shows."""
    found = discover(record(stock.with_effect("backlash", {"width": 0.004}), ("ramp:0.05",)), stock)
    assert (found.verdict, found.added, found.depends_on) == ("unknown", (), ("encoders",))
    assert "2.00 mrad off the motor" in found.stopped and "reversals" in found.stopped


@pytest.mark.parametrize("hidden", [False, True])
def test_a_missing_sample_does_not_hide_how_coarse_a_current_is(hidden, stock, heavy):
    """Values that are filled in between lie on no step of the current's resolution."""
    runs = []
    for r in record(heavy if hidden else stock):
        kept = np.arange(len(r)) != 1000
        current = 0.02 * np.round(r.signals["current"] / 0.02)
        signals = {name: values[kept] for name, values in {**r.signals, "current": current}.items()}
        runs.append(with_signals(r, signals, r.stamps[kept]))
    found = discover(runs, stock)
    assert found.added == (("gravity_load",) if hidden else ())
    assert found.verdict == ("explained" if hidden else "none")


def test_what_comes_and_goes_is_told_with_its_times(stock):
    """For a while the machine needs more torque: no lasting dependence, and an outlier to any fit."""
    runs = []
    for k, run in enumerate(record(stock)):
        shaken = run.signals["current"].copy()
        there = (run.time > 3.0 + k) & (run.time < 3.8 + k)
        shaken[there] += 0.08 * np.sign(run.signals["speed"][there])
        runs.append(changed(run, current=shaken))
    found = discover(runs, stock)
    assert (found.verdict, found.added, found.depends_on) == ("unknown", (), ("time",))
    assert "run0 from 3.0" in found.stopped and "against the motion" in found.stopped


def test_a_current_that_does_not_change_is_refused(stock):
    (run,) = record(stock, COMMANDS[:1])
    with pytest.raises(InputError, match="0 A all along"):
        observe(changed(run, current=np.zeros(len(run))), stock)
