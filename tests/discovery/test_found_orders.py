"""Orders found, not assumed; and named where the model knows what repeats so."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from ema_bench_replay.recording import Recording
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.discovery.search.found_orders import (
    highest_order,
    is_bend,
    order_candidates,
    resolved,
    written_order,
)
from ema_twin_sim.identification.candidates import Candidate, candidates
from ema_twin_sim.identification.fit import fit
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from ema_twin_sim.measured.scales import to_own_units
from ema_twin_sim.model import load_model, save_model
from ema_twin_sim.plant.motion import MOTOR_ANGLE, SPEED
from ema_twin_sim.words.sentences import order_sentences
from tests.problems import problem_of
from tests.recorded import record

ORDER = 7.4286  # of a mesh that no catalogue knows
TORQUE_MOTOR = """
version: 1
machine:
  name: torque_motor
  inertia: {value: 0.4, unit: kg m^2, tolerance: 0.05}
  torque_constant: {value: 8.0, unit: N m/A, tolerance: 0.0}
sensors:
  motor_encoder_counts: {value: 4194304, unit: 1/rev}
  speed_noise: {value: 2.0e-4, unit: rad/s}
  current_noise: {value: 0.01, unit: A}
effects:
  viscous_friction: {effect: viscous_friction, options: {side: motor}, parameters: {coefficient: 0.15}}
  coulomb_friction: {effect: coulomb_friction, options: {side: motor}, parameters: {torque: 1.0, static_ratio: 1.0}}
"""


@pytest.fixture(scope="module")
def gearbox(unnamed):
    """The same with another gearbox."""
    return unnamed.with_value("machine.gear_ratio", 31.0)


@pytest.fixture(scope="module")
def unnamed(stock):
    """The stock machine, of whose orders nothing is said."""
    return replace(stock, orders={}, other_orders=True)


@pytest.fixture(scope="module")
def direct(unnamed):
    """The same without a gearbox."""
    return unnamed.with_value("machine.gear_ratio", 1.0).with_value("drive.position_gain", 20.0)


@pytest.fixture(scope="module")
def recordings(gearbox):
    hidden = gearbox.with_effect("mesh_ripple", {"torque": 0.03, "phase": 0.4}, {"order": str(ORDER)})
    return record(hidden, ("ramp:0.3", "sine:0.4:0.3", "triangle:0.5:1.5"), seconds=10.0)


def test_an_order_of_the_gears_is_found(recordings, gearbox):
    found = discover(recordings, gearbox)
    assert (found.verdict, found.added) == ("explained", ("mesh_ripple",))
    ripple = found.model.effects["mesh_ripple"]
    assert float(ripple.options["order"]) == pytest.approx(ORDER, abs=2e-3)
    assert ripple.parameters["torque"] == pytest.approx(0.03, rel=0.03)
    (sentence,) = order_sentences(found.model, found.added)
    assert f" {ripple.options['order']} times" in sentence and "names no orders" in sentence


def test_an_order_is_written_as_exactly_as_it_is_known(gearbox, tmp_path):
    """Behind ten thousand turns five digits of it would be cycles off; a model's file keeps all that are known."""
    order, turns = 15.75321846, 10_000.0
    text = written_order(order, 1e-7)
    assert text == "15.75321846"
    assert abs(float(f"{order:.5g}") - order) * turns > 1.0 > 1e3 * abs(float(text) - order) * turns
    assert written_order(7.42857142857, 2e-3) == "7.4286"  # no more than it is known by
    assert float(written_order(1.0 / 3.0, 0.0)) == pytest.approx(1.0 / 3.0, abs=1e-14)
    save_model(gearbox.with_effect("mesh_ripple", {}, {"order": text}), tmp_path / "found.yaml")
    assert load_model(tmp_path / "found.yaml").effects["mesh_ripple"].options["order"] == text


def test_where_all_orders_are_known_it_is_unknown(recordings, gearbox):
    found = discover(recordings, replace(gearbox, other_orders=False))
    assert (found.verdict, found.depends_on) == ("unknown", ("order",))


def test_the_teeth_of_another_gearbox_are_not_looked_for(gearbox, stock):
    """Their orders follow from its numbers of teeth; those of this machine are found, or told by its model."""

    def orders(model):
        return {c.options["order"] for c in candidates(null_hypothesis(model)) if c.effect == "tooth_fault"}

    assert orders(gearbox) == {"1"}
    assert orders(stock) == {"1", "2.25", "0.75", "0.7258"}
    assert orders(replace(gearbox, orders={"damaged tooth": 2.25})) == {"1", "2.25"}


def test_what_never_came_a_second_time_is_not_seen_to_repeat(stock, unnamed):
    """Over half a turn of the motor nothing repeats once a turn; what repeats six times a turn does."""
    one, six = Candidate("cogging", {"order": "1"}), Candidate("cogging", {"order": "6"})
    for amplitude, shown in ((0.25 / 124.0, [six]), (2.0 / 124.0, [one, six])):
        problem = problem_of(record(unnamed, (f"sine:{2.0 * math.pi * amplitude:g}:0.5",)), unnamed)
        assert resolved(problem, [one, six], unnamed) == shown
        assert resolved(problem, [one, six], stock) == [one, six]  # whose orders are known


def test_orders_are_named_by_what_the_model_says(tmp_path):
    model = replace(load_model("laas_motor"), orders={"slots": 18.0, "pole pairs": 12.0})
    assert model.order_names(18.0) == ["slots"]
    assert model.order_names(72.0) == ["4 × slots", "6 × electrical (12 pole pairs)"]
    assert model.order_names(7.0) == []
    save_model(model, tmp_path / "named.yaml")
    assert load_model(tmp_path / "named.yaml").orders == model.orders


@pytest.mark.parametrize(("ratio", "effect", "shaft"), [(12.0, "output_ripple", "output"), (1.0, "cogging", "motor")])
def test_orders_of_the_output_are_found(stock, ratio, effect, shaft):
    """Seven times in a turn of the slow shaft: behind a gearbox no whole order of the motor; of a direct drive one."""
    geared = stock.with_value("machine.gear_ratio", ratio).with_value("drive.position_gain", 20.0 * ratio)
    machine = replace(geared, orders={"rollers": 7.0 / ratio}, other_orders=True)
    hidden = machine.with_effect("output_ripple", {"torque": 0.05, "phase": 0.4}, {"order": "7"})
    found = discover(record(hidden, ("ramp:1.5", "sine:2.5:0.2", "triangle:2:3"), seconds=10.0), machine)
    assert (found.verdict, found.added) == ("explained", (effect,))
    ripple = found.model.effects[effect]
    assert ripple.options["order"] == "7"
    assert ripple.parameters == pytest.approx({"torque": 0.05, "phase": 0.4}, rel=0.03)
    assert order_sentences(found.model, found.added) == [
        f"{effect.replace('_', ' ')}: order 7 of the {shaft} matches rollers."
    ]
    (unnamed,) = order_sentences(replace(found.model, orders={}), found.added)
    assert f"7 times per turn of the {shaft}" in unnamed


@pytest.mark.slow
@pytest.mark.parametrize("angle", [0.4, -1.9])
def test_a_pendulum_at_the_motor_is_gravity_before_it_is_the_best_of_many_waves(angle, direct):
    """Without a gearbox a torque once per turn is the weight of an arm: there is no sun gear, and no magnet does it."""
    hidden = direct.with_effect("gravity_load", {"torque": 0.2, "angle": angle})
    found = discover(record(hidden, ("ramp:4", "sine:5:0.2", "triangle:4:2"), seconds=7.0), direct)
    assert (found.verdict, found.added) == ("explained", ("gravity_load",))
    assert found.groups == ()


def test_a_bearing_of_a_direct_drive_is_found(direct):
    """It turns at a speed of its own: its order is no whole number."""
    hidden = direct.with_effect("cogging", {"torque": 0.05, "phase": 0.4}, {"order": "3.57"})
    found = discover(record(hidden, ("ramp:8", "sine:8:0.2", "triangle:10:3"), seconds=10.0), direct)
    assert found.added == ("cogging",)
    assert float(found.model.effects["cogging"].options["order"]) == pytest.approx(3.57, abs=5e-3)
    (sentence,) = order_sentences(found.model, found.added)
    assert "gears, belts or bearings" in sentence and "and so of the output" in sentence


def test_the_benchs_orders_are_all_known(stock, tmp_path):
    assert stock.order_names(15.75) == ["first mesh"]
    save_model(stock, tmp_path / "whole.yaml")
    written = load_model(tmp_path / "whole.yaml")
    assert written.orders == stock.orders and not written.other_orders


def bends(model, command, effect, *options, seconds):
    """Whether each of the waves of these options is a bend, over the way that the model goes under a command."""
    h = null_hypothesis(model)
    for option in options:
        h = h.with_effect(effect, option, {"torque": 0.02, "phase": 0.3})
    f = fit(problem_of(record(model, (command,), seconds), model), h, 0)
    return [is_bend(f.problem, f, name) for name in f.hypothesis.added]


@pytest.mark.parametrize(
    ("turns", "bent"),
    [(0.8, [True, False]), (1.01, [False, False]), (1.5, [False, False])],  # a sweep of one turn stops 1 % short of it
)
def test_a_few_cycles_within_a_part_of_a_turn_are_a_bend(turns, bent, unnamed):
    """Whatever bends the torque over the angle looks like them, until the same comes again."""
    orders = {"order": "6"}, {"order": "12"}
    assert bends(unnamed, f"sine:{math.pi * turns / 124.0:g}:0.5", "cogging", *orders, seconds=6.0) == bent


@pytest.mark.parametrize(("turns", "bent"), [(0.5, [True, False]), (1.5, [False, False])])
def test_a_wave_of_the_output_repeats_with_the_turns_of_the_output(turns, bent, unnamed):
    """Half a turn of a joint is many turns of its motor; what its arm or other joints do there is no ripple."""
    orders = {"order": "6"}, {"order": "18"}
    assert bends(unnamed, f"sine:{math.pi * turns:g}:0.05", "output_ripple", *orders, seconds=20.0) == bent


def test_over_part_of_a_turn_neighbouring_orders_are_one(tmp_path):
    """The load of a joint goes with its angle as its arm's other joints move; no two orders of it tell that."""
    place = tmp_path / "joint.yaml"
    place.write_text(TORQUE_MOTOR)
    model = load_model(place)
    for turns, others in ((0.58, False), (1.2, True)):
        time = np.arange(8_000) * 2e-3
        angle = math.pi * turns * (1.0 - np.cos(0.9 * time))
        speed = 0.9 * math.pi * turns * np.sin(0.9 * time)
        torque = 0.4 * np.gradient(speed, time) + np.sign(speed) + 0.15 * speed + 0.4 * np.sin(5.0 * angle)
        noise = np.random.default_rng(1).normal(0.0, 1.0, (3, len(time)))
        signals = {
            "motor_position": angle + 5e-7 * noise[0],
            "speed": speed + 2e-4 * noise[1],
            "current": torque / 8.0 + 0.01 * noise[2],
        }
        runs = [Recording("run", np.rint(time * 1e9).astype(np.int64), signals)]
        own, its_model = to_own_units(runs, model)
        h = null_hypothesis(its_model).with_effect("cogging", {"order": "4"}, {"torque": 0.0, "phase": 0.3})
        f = fit(problem_of(own, its_model), h, 0)
        orders = [c.options["order"] for c in order_candidates(f.problem, f) if c.effect == "cogging"]
        assert ("5" in orders) is others


def test_a_torque_motor_of_many_poles_cogs_in_slow_motion(tmp_path):
    """22 pole pairs and 24 slots; most of the torque turns the inertia, which sets the machine's own pace."""
    rng = np.random.default_rng(4)
    time = np.arange(16_000) * 5e-4
    recordings = []
    for number, (swing, rate) in enumerate(((1.0, 0.8), (2.0, 4.0), (1.2, 6.0))):
        angle = 0.3 + swing * (1.0 - np.cos(rate * time))
        speed = swing * rate * np.sin(rate * time)
        torque = 0.4 * swing * rate**2 * np.cos(rate * time) + np.sign(speed) + 0.15 * speed
        torque += 0.15 * np.sin(264.0 * angle + 0.5)
        signals = {
            "motor_position": angle - angle[0] + rng.normal(0.0, 5e-7, len(time)),
            "speed": speed + rng.normal(0.0, 2e-4, len(time)),
            "current": torque / 8.0 + rng.normal(0.0, 0.01, len(time)),
        }
        stamps = np.rint(time * 1e9).astype(np.int64)
        recordings.append(Recording(f"run{number}", stamps, signals, motor_angle_origin=float(angle[0])))
    place = tmp_path / "torque_motor.yaml"
    place.write_text(TORQUE_MOTOR)
    found = discover(recordings, load_model(place))
    assert (found.verdict, found.added) == ("explained", ("cogging",))
    cogging = found.model.effects["cogging"]
    assert cogging.options["order"] == "264"
    assert cogging.parameters["torque"] == pytest.approx(0.15, rel=0.03)


@pytest.mark.parametrize("scatter", [0.0, 1e-3])
def test_points_that_scatter_about_a_degree_resolve_no_finer_wave(scatter):
    """Sweeps in steps of one degree, up and down: what is between the steps was never measured."""
    places = np.repeat(np.radians(np.arange(0.0, 200.0)), 8)
    angle = places + scatter * np.random.default_rng(1).uniform(-1.0, 1.0, len(places))
    o = SimpleNamespace(
        of_points=True, rows=np.arange(len(angle)), motion=np.zeros((len(angle), max(MOTOR_ANGLE, SPEED) + 1))
    )
    o.motion[:, MOTOR_ANGLE] = angle
    assert highest_order(o) == pytest.approx(180.0, rel=0.15)


@pytest.mark.parametrize(("turns", "bent"), [(0.5, True), (3.0, False)])
def test_over_half_a_turn_a_run_out_of_the_sun_gear_is_a_bend(turns, bent, stock):
    command, option = f"sine:{math.pi * turns / 124.0:g}:0.2", {"kind": "conservative"}
    assert bends(stock, command, "sun_runout", option, seconds=10.0) == [bent]
