"""The other bench (make accuracy): its physics by formulas of its own, its recordings, and how answers are judged."""

import math
from dataclasses import replace

import numpy as np
import pytest

from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.virtual_bench import virtual_bench
from tests.accuracy.cases import drawn_case, drawn_cases
from tests.accuracy.commands import Drive
from tests.accuracy.folders import save, saved_and_read
from tests.accuracy.hide import UNKNOWN
from tests.accuracy.judge import judge
from tests.accuracy.machine import stock_machine
from tests.accuracy.other_bench import Cause, OtherBench
from tests.accuracy.tables import totals
from tests.accuracy.unkind import COUNTERS_AND_CURRENT, Unkind

MACHINE = stock_machine()
LEVEL = MACHINE.motor_level + MACHINE.output_level
VISCOUS = MACHINE.motor_viscous + MACHINE.output_viscous
INERTIA = MACHINE.motor_inertia + MACHINE.output_inertia
RATIO = 124.0
RAMP, SLOW, SINE, BACK_AND_FORTH = (
    Drive("ramp", 0.1),
    Drive("ramp", 0.02),
    Drive("sine", 0.05, 0.25),
    Drive("triangle", 0.04, 2.5),
)


def recorded(drive, *causes, unkind=Unkind(), seconds=10.0, **more):  # noqa: B008 frozen
    return OtherBench(MACHINE, causes, unkind, seed=3, **more).record(drive, seconds)


def smooth(values, width=21):
    return np.convolve(values, np.ones(width) / width, "same")


class Seen:
    """A recording's motion as one would take it from the trace: smoothed over 40 ms, the drive's 4 ms undone."""

    def __init__(self, recording):
        signals = recording.signals
        self.t = recording.time
        raw = signals["speed"] + MACHINE.smoothing * np.gradient(smooth(signals["speed"], 5), self.t)
        self.w = smooth(raw)
        self.a = np.gradient(self.w, self.t)
        self.torque = smooth(MACHINE.torque_constant * signals["current"])
        self.motor = recording.motor_angle_origin + signals["motor_position"]
        self.travel = signals["output_position"]
        self.output = recording.output_angle_origin + self.travel
        # away from standstill, from reversals and from the ends, whose smoothing is one-sided
        moving = smooth((np.abs(self.w) > 0.5).astype(float), 101) > 0.999
        self.steady = moving & (self.t > 0.5) & (self.t < self.t[-1] - 0.1)

    @property
    def left(self):
        """N m that inertia and the stock friction leave."""
        return self.torque - INERTIA * self.a - VISCOUS * self.w - LEVEL * np.sign(self.w)


def test_friction_balances_the_motor_on_a_ramp():
    seen = Seen(recorded(RAMP))
    assert np.mean(seen.torque[seen.steady]) == pytest.approx(LEVEL + VISCOUS * 12.4, rel=0.003)


def test_what_the_motor_does_is_what_friction_takes():
    seen = Seen(recorded(SINE, seconds=20.0))
    whole = (seen.t >= 4.0) & (seen.t < 16.0)
    work = np.mean((seen.torque * seen.w)[whole])
    assert work == pytest.approx(np.mean((VISCOUS * seen.w**2 + LEVEL * np.abs(seen.w))[whole]), rel=0.01)


@pytest.mark.parametrize("cycle", [4, 16])
def test_the_twin_of_a_bench_without_effects_needs_the_same_current(stock, cycle):
    bench = OtherBench(replace(MACHINE, cycle=cycle)).record(Drive("ramp", 0.05), 6.0)
    twin = virtual_bench(stock, parse_command("ramp:0.05"), 6.0)
    steady = bench.time > 1.0
    means = [np.mean(r.signals["current"][: steady.size][steady]) for r in (bench, twin)]
    assert means[0] == pytest.approx(means[1], rel=0.01)
    assert bench.signals["output_position"][-1] == pytest.approx(twin.signals["output_position"][-2], abs=2e-4)


def bristle(seen, stiffness):
    """Friction of a bristle that is dragged along, less the Coulomb friction it replaces."""
    bend = 0.0
    torque = np.empty_like(seen.w)
    for k, (w, h) in enumerate(zip(seen.w, np.diff(seen.t, prepend=0.0), strict=True)):
        bend = (bend + h * w) / (1.0 + h * stiffness * abs(w) / LEVEL)
        torque[k] = stiffness * bend
    return torque - LEVEL * np.sign(seen.w)


def pulse(seen, torque, position, order):
    turn = (order * seen.motor - position) / (2.0 * np.pi)
    away = np.abs(turn - np.round(turn)) / (order / 15.75)
    return np.where(away < 0.5, 0.5 * torque * (1.0 + np.cos(2.0 * np.pi * away)), 0.0)


def teeth(s, order):
    return sum(np.sin(k * (order * s.motor + 0.7)) / k for k in (1, 3, 5))


def passed_on(s):
    return MACHINE.output_inertia * s.a + MACHINE.output_level * np.sign(s.w) + gravity(s)


def gravity(s):
    return 0.06 * np.sin(s.output + 0.4)


GRAVITY = Cause("gravity_load", {"torque": 0.06, "angle": 0.4})
THEORY = {
    "stribeck_friction": lambda s: 0.08 * np.exp(-np.abs(s.w) / 2.0) * np.sign(s.w),
    "stribeck_friction gaussian": lambda s: 0.08 * np.exp(-((s.w / 2.0) ** 2)) * np.sign(s.w),
    "stribeck_friction lorentzian": lambda s: 0.08 / (1.0 + (s.w / 2.0) ** 2) * np.sign(s.w),
    "smooth_friction": lambda s: LEVEL * (np.tanh(s.w / 2.0) - np.sign(s.w)),
    "smooth_friction arctangent": lambda s: LEVEL * (np.arctan(np.pi / 4.0 * s.w) * 2.0 / np.pi - np.sign(s.w)),
    "smooth_friction root": lambda s: LEVEL * (s.w / np.hypot(s.w, 2.0) - np.sign(s.w)),
    "asymmetric_friction": lambda s: -0.2 * (LEVEL + VISCOUS * np.abs(s.w)),
    "quadratic_drag": lambda s: 8e-4 * s.w * np.abs(s.w),
    "shear_thinning": lambda s: -0.5 * VISCOUS * s.w * np.abs(s.w) / (np.abs(s.w) + 5.0),
    "thermal_friction": lambda s: -0.3 * VISCOUS * s.w * (1.0 - np.exp(-s.t / 4.0)),
    "sun_runout": lambda s: 0.03 * np.sin(s.motor + 0.7) * np.sign(s.w),
    "sun_runout conservative": lambda s: 0.03 * np.sin(s.motor + 0.7),
    "mesh_ripple": lambda s: 0.03 * teeth(s, 15.75),
    "mesh_ripple 15.0": lambda s: 0.03 * teeth(s, 15.0),
    "cogging": lambda s: 0.03 * np.sin(24.0 * s.motor + 0.7),
    "cogging 12": lambda s: 0.03 * np.sin(12.0 * s.motor + 0.7),
    "torque_ripple": lambda s: -s.torque * 0.2 * np.sin(24.0 * s.motor + 0.7),
    "phase_short v": lambda s: s.torque * 0.1 * (1.0 - np.cos(8.0 * s.motor - 4.0 * np.pi / 3.0)),
    "rotor_eccentricity": lambda s: s.torque * 0.1 * np.cos(9.0 * s.motor + 0.7),
    "current_offset": lambda s: 0.03 * np.sin(4.0 * s.motor + 0.7),
    "tooth_fault": lambda s: pulse(s, 0.09, 1.0, 1.0) * np.sign(s.w),
    "tooth_fault 2.25 conservative": lambda s: pulse(s, 0.09, 1.0, 2.25),
    "torque_constant_error": lambda s: 0.2 * s.torque,
    "added_inertia": lambda s: 8e-3 * s.a,
    "constant_load": lambda s: np.full_like(s.t, 0.05),
    "gravity_load": gravity,
    "spring_load": lambda s: 0.1 * s.travel,
}
"""Torque [N m] against the motion, by the equations of the catalogue; effect, then its options."""
VALUES = {
    "stribeck_friction": {"torque": 0.08, "speed": 2.0},
    "smooth_friction": {"speed": 2.0},
    "asymmetric_friction": {"fraction": -0.2},
    "quadratic_drag": {"coefficient": 8e-4},
    "shear_thinning": {"fraction": 0.5, "speed": 5.0},
    "thermal_friction": {"fraction": 0.3, "time_constant": 4.0},
    "torque_ripple": {"fraction": 0.2, "phase": 0.7},
    "phase_short": {"fraction": 0.3},
    "rotor_eccentricity": {"amplitude": 0.2, "phase": 0.7},
    "tooth_fault": {"torque": 0.09, "position": 1.0},
    "torque_constant_error": {"scale": 0.8},
    "added_inertia": {"inertia": 8e-3},
    "constant_load": {"torque": 0.05},
    "gravity_load": GRAVITY.values,
    "spring_load": {"stiffness": 0.1},
}
OF_AN_ANGLE = {"torque": 0.03, "phase": 0.7}
DRIVES = {
    "stribeck_friction": SLOW,
    "smooth_friction": SLOW,
    "asymmetric_friction": BACK_AND_FORTH,
    "thermal_friction": RAMP,
    "sun_runout": BACK_AND_FORTH,
    "current_offset": BACK_AND_FORTH,
    "tooth_fault": BACK_AND_FORTH,
    "mesh_ripple": SLOW,
    "cogging": SLOW,
    "torque_ripple": SLOW,
    "phase_short": SLOW,
    "rotor_eccentricity": SLOW,
    "constant_load": BACK_AND_FORTH,
    "gravity_load": RAMP,
    "spring_load": RAMP,
}


@pytest.mark.parametrize("name", THEORY)
def test_a_torque_is_what_its_equation_says(name):
    id, *chosen = name.split()
    names = {"u": "phase", "v": "phase", "w": "phase", "conservative": "kind"}
    names |= dict.fromkeys(("gaussian", "lorentzian", "arctangent", "root"), "law")
    options = {names.get(choice, "order"): choice for choice in chosen}
    cause = Cause(id, VALUES.get(id, OF_AN_ANGLE), options)
    seen = Seen(recorded(DRIVES.get(id, SINE), cause, motor_origin=-2.0, output_origin=0.5))
    wanted = smooth(THEORY[name](seen))[seen.steady]
    left = seen.left[seen.steady]
    size = np.sqrt(np.mean(wanted**2))
    assert np.sqrt(np.mean((left - wanted) ** 2)) < 0.12 * size + 1e-3
    assert np.sum(left * wanted) / np.sum(wanted**2) == pytest.approx(1.0, abs=0.04)


def test_mesh_friction_follows_the_load():
    alone, loaded = (
        Seen(recorded(RAMP, GRAVITY, *more)) for more in ((), (Cause("mesh_friction", {"coefficient": 0.3}),))
    )
    steady = alone.steady & loaded.steady
    more = np.mean((loaded.left - alone.left)[steady])
    assert more == pytest.approx(0.3 * np.mean(np.abs(passed_on(alone)[steady])), rel=0.02)


def test_a_bristle_turns_over_a_way_at_a_reversal():
    seen = Seen(recorded(BACK_AND_FORTH, Cause("presliding_friction", {"stiffness": 1.0, "damping": 0.005})))
    wanted = bristle(seen, 1.0)
    turning = (np.abs(wanted) > 0.01) & (seen.t > 0.5) & (seen.t < 9.5)
    assert turning.mean() > 0.01
    assert np.sum((seen.left * wanted)[turning]) / np.sum(wanted[turning] ** 2) == pytest.approx(1.0, abs=0.1)
    assert np.abs(np.mean(seen.left[seen.steady & (np.abs(wanted) < 1e-3)])) < 1e-3


def twist(recording):
    """Motor less output angle, at the fast shaft."""
    return recording.signals["motor_position"] - RATIO * recording.signals["output_position"]


def test_backlash_opens_between_the_encoders():
    recording = recorded(BACK_AND_FORTH, Cause("backlash", {"width": 0.004}))
    seen = Seen(recording)
    ways = [np.median(twist(recording)[seen.steady & (sense * seen.w > 1.0)]) for sense in (1.0, -1.0)]
    assert (ways[0] - ways[1]) / RATIO == pytest.approx(0.004, rel=0.01)


def test_a_compliant_shaft_twists_with_the_torque_it_passes_on():
    soft = Cause("shaft_compliance", {"stiffness": 15.0, "damping": 0.02})
    recording = recorded(SINE, soft, seconds=20.0)
    seen = Seen(recording)
    column = (MACHINE.output_inertia * seen.a + MACHINE.output_level * np.sign(seen.w))[seen.steady]
    slope = np.polyfit(column, smooth(twist(recording))[seen.steady], 1)[0]
    assert 1.0 / slope == pytest.approx(15.0, rel=0.03)


def test_a_late_encoder_lags_with_speed():
    late, prompt = (twist(recorded(RAMP, *causes)) for causes in ((Cause("encoder_delay", {"delay": 0.005}),), ()))
    assert np.mean((late - prompt)[1000:]) / 12.4 == pytest.approx(0.005, rel=0.01)


def test_an_eccentric_encoder_swings_with_its_own_angle():
    recording = recorded(RAMP, Cause("encoder_eccentricity", {"amplitude": 8e-4, "phase": 0.5}))
    output = recording.signals["motor_position"] / RATIO
    start = recording.output_angle_origin + 0.5
    wanted = 8e-4 * (np.sin(start + output) - math.sin(start))
    assert np.abs(smooth(-twist(recording) / RATIO - wanted)[300:-50]).max() < 2e-5


@pytest.mark.slow
@pytest.mark.parametrize("id", sorted(UNKNOWN))
def test_causes_of_no_catalogue_leave_torque(id):
    case = drawn_case("x", "unknown", [id], (1, 2), off=0.0)
    quiet = drawn_case("x", "none", [], (1, 2), off=0.0)

    def left(c):
        return max(np.std(Seen(recording).left[Seen(recording).steady]) for recording in c.train[:5])

    assert left(case) > 5e-3 > 3.0 * left(quiet)


def test_unkind_traces():
    whole = recorded(RAMP, seconds=4.0)
    assert whole.gaps == () and len(whole) == 2000
    part = recorded(RAMP, unkind=Unkind(signals=COUNTERS_AND_CURRENT), seconds=4.0)
    assert set(part.signals) == set(COUNTERS_AND_CURRENT)
    lossy = recorded(RAMP, unkind=Unkind(dropped=0.05), seconds=4.0)
    assert 0.05 <= 1.0 - len(lossy) / 2000 < 0.08 and lossy.gaps
    uneven = np.diff(recorded(RAMP, unkind=Unkind(uneven=0.3), seconds=4.0).stamps)
    assert uneven.min() < 1.7e6 < 2.3e6 < uneven.max()
    noisy = recorded(RAMP, unkind=Unkind(controller_noise=0.02), seconds=4.0)
    ripple = [np.std(np.diff(recording.signals["current_setpoint"][500:])) for recording in (noisy, whole)]
    assert ripple[0] > 1e-3 > ripple[1]


def test_friction_that_wanders_moves_the_current_between_recordings():
    bench = OtherBench(MACHINE, unkind=Unkind(wander=0.1), seed=1)
    torques = [Seen(bench.record(Drive("ramp", 0.05), 4.0)) for _ in range(6)]
    means = [np.mean(seen.torque[seen.steady]) for seen in torques]
    assert 0.02 < (max(means) - min(means)) / np.mean(means) < 0.2


def test_the_same_seed_draws_the_same_cases():
    one, two = (drawn_cases(5, 14) for _ in range(2))
    assert [case.hidden for case in one] == [case.hidden for case in two]
    assert {case.kind for case in one} == {"plain", "pairs", "triples", "none", "unknown", "small", "extreme"}
    first, second = one[0].train[0], two[0].train[0]
    assert all(np.array_equal(first.signals[name], second.signals[name]) for name in first.signals)
    assert one[0].hidden != drawn_cases(6, 14)[0].hidden
    parameters = drawn_case("x", "plain", ["quadratic_drag"], (1, 1)).parameters["quadratic_drag"]
    smaller = drawn_case("x", "plain", ["quadratic_drag"], (1, 1), size=0.2).parameters["quadratic_drag"]
    assert smaller["coefficient"] == pytest.approx(0.2 * parameters["coefficient"])


def test_a_saved_case_reads_back_with_its_counters_jump_repaired(tmp_path):
    case = drawn_case("jumps", "extreme", ["coulomb_friction"], (1, 4), unkind=Unkind(counter_jump=True), seconds=4.0)
    read = saved_and_read(case, tmp_path)
    assert len(read) == len(case.train) and all(any("jumped" in w for w in r.warnings) for r in read)
    by_name = {recording.name: recording for recording in case.train}
    for recording in read:
        for name, values in by_name[recording.name].signals.items():
            assert recording.signals[name] == pytest.approx(values, abs=1e-4), name
    answer = (save(case, tmp_path) / "answer.json").read_text()
    assert '"remove_from_stock_model": [\n  "coulomb_friction"\n ]' in answer


def answer(added, verdict, groups=(), parameters=None):
    return {"added": added, "verdict": verdict, "groups": groups, "parameters": parameters or {}}


def test_answers_are_judged():
    case = drawn_case("x", "plain", ["gravity_load"], (1, 5))
    true = case.parameters["gravity_load"]
    reported = {
        "effect": "gravity_load",
        "options": {},
        "torque": {"value": 1.02 * true["torque"], "std": 0.01 * true["torque"], "unit": "N m"},
        "angle": {"value": true["angle"] - 2.0 * math.pi + 0.04, "std": 0.01, "unit": "rad"},
    }
    right = judge(case, answer(["gravity_load"], "explained", parameters={"gravity_load": reported}), 1.0)
    assert right.found and right.first and not right.wrong
    assert right.errors == {"gravity_load.torque": pytest.approx(0.02)}
    assert right.within == {"gravity_load.torque": True, "gravity_load.angle": False}

    grouped = judge(case, answer(["spring_load"], "explained", [["gravity_load", "spring_load"]]), 1.0)
    assert not grouped.found and not grouped.wrong and grouped.undecided
    wrong = judge(case, answer(["gravity_load", "backlash"], "explained"), 1.0)
    assert not wrong.found and wrong.first and wrong.wrong == ("backlash",) and not wrong.undecided
    assert not judge(case, answer(["gravity_load"], "unknown"), 1.0).found

    nothing = drawn_case("y", "none", [], (1, 6))
    assert judge(nothing, answer([], "none"), 1.0).found
    assert not judge(nothing, answer([], "unknown"), 1.0).found
    alarm = judge(nothing, answer(["cogging"], "explained"), 3.0)
    unknown = drawn_case("z", "unknown", ["bursts"], (1, 7))
    assert judge(unknown, answer([], "unknown"), 1.0).found
    assert judge(unknown, answer(["cogging"], "unknown"), 1.0).wrong == ("cogging",)

    sums = totals([right, wrong, alarm])
    assert (sums["found"], sums["first"], sums["wrong"], sums["false_alarms"]) == (1, 2, 2, 1)
    assert (sums["median_seconds"], sums["worst_seconds"], sums["within_three_errors"]) == (1.0, 3.0, 0.25)


def test_a_softish_gearbox_is_rightly_named_and_no_loss():
    ringing = drawn_case("r", "extreme", ["cogging"], (1, 8), unkind=Unkind(gear_resonance=60.0))
    assert judge(ringing, answer(["cogging"], "explained"), 1.0).found
    assert judge(ringing, answer(["cogging", "shaft_compliance"], "explained"), 1.0).found


def test_friction_that_warms_up_by_itself_is_rightly_named_and_no_loss():
    warming = drawn_case("w", "extreme", ["cogging"], (1, 9), unkind=Unkind(warming=0.04))
    assert judge(warming, answer(["cogging"], "explained"), 1.0).found
    assert judge(warming, answer(["cogging", "thermal_friction"], "explained"), 1.0).found
    assert not judge(warming, answer(["thermal_friction"], "explained"), 1.0).found
    steady = drawn_case("s", "extreme", ["cogging"], (1, 9))
    assert judge(steady, answer(["cogging", "thermal_friction"], "explained"), 1.0).wrong == ("thermal_friction",)
