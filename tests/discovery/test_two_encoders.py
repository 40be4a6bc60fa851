"""Recordings of two encoders and no torque: what parts them is named, on machines of any size."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_twin_sim.commands.init import run as init
from ema_twin_sim.comparison.compare import compare
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.discovery.flanks_under_load import of_unseen_load, with_play_between_flanks
from ema_twin_sim.discovery.search.removing import less
from ema_twin_sim.discovery.search.rivals import other_structures, swapped
from ema_twin_sim.fitting.fit import fit_model
from ema_twin_sim.identification.fit import fit
from ema_twin_sim.model import ConstantValue
from ema_twin_sim.simulation.behind_motor import refuse_encoders_alone
from ema_twin_sim.simulation.simulate import simulate
from tests.by_draft import by_draft
from tests.play import behind_play
from tests.recorded import changed
from tests.trace_text import write_columns

COUNTS = 2**18
RATIO = 50.0
SAMPLES = 5000


def moved(time, quicker):
    """Output angle [rad] if nothing parted it from the motor: two sines, with reversals near and far."""
    return 0.8 * np.sin(1.1 * quicker * time) + 0.25 * np.sin(3.9 * quicker * time + 1.0)


def behind_spring(angle, period, rings, damped):
    """A heavy output on a spring that rings at ``rings`` rad/s, with no friction: fine steps of its own equation."""
    fine = 20
    time = np.arange(len(angle))
    driven = np.interp(np.arange(len(angle) * fine) / fine, time, angle)
    rate = np.gradient(driven, period / fine)
    output, speed, shown = driven[0], rate[0], []
    for wanted, moving in zip(driven, rate, strict=True):
        shown.append(output)
        speed += period / fine * (rings**2 * (wanted - output) + 2.0 * damped * rings * (moving - speed))
        output += period / fine * speed
    return np.array(shown[::fine])


def behind_teeth(angle, period, width):
    """An output that friction and drag hold behind stiff teeth, which ring at 90 Hz and hardly bounce: wound up by
    less than 1 % of their play.
    """
    fine, rings, damped, held, drag = 10, 566.0, 0.8, 3.33, 8.0
    step = period / fine
    driven = np.interp(np.arange(len(angle) * fine) / fine, np.arange(len(angle)), angle)
    rate = np.gradient(driven, step)
    output, speed, shown = driven[0], 0.0, []
    for wanted, moving in zip(driven, rate, strict=True):
        shown.append(output)
        apart = wanted - output
        bent = apart - min(max(apart, -0.5 * width), 0.5 * width)
        push = rings**2 * bent + 2.0 * damped * rings * (moving - speed)
        speed += step * ((push if push * bent > 0.0 else 0.0) - drag * speed)  # teeth do not pull
        speed -= min(max(speed, -held * step), held * step)
        output += step * speed
    return np.array(shown[::fine])


def shown(kind, time, quicker):
    """The output's angle (n,) as its encoder shows it."""
    angle = moved(time, quicker)
    if kind == "play":
        return behind_play(angle, 2e-3)
    if kind == "spring":
        return behind_spring(angle, time[1], 60.0 * quicker, 0.1)
    if kind == "late":
        return moved(time - 3e-3 / quicker, quicker)
    if kind == "play beside a larger angle error":
        angle = behind_play(angle, 3e-4)
        return angle + 3e-3 * np.sin(7.0 * angle + 0.7)
    orders = {"off centre": 1.0, "oval": 2.0, "resolver of the motor": 3.0 * RATIO}
    return angle + (4e-4 * np.sin(orders[kind] * angle + 0.7) if kind in orders else 0.0)


def drafted(tmp_path, kind, quicker, gear_ratio=None, samples=SAMPLES):
    """Recording and ``init``'s draft of a machine that moves ``quicker`` than another."""
    time = np.arange(samples) * 2e-3 / quicker
    return recorded(tmp_path, time, moved(time, quicker), shown(kind, time, quicker), gear_ratio)


def recorded(tmp_path, time, driven, seen, gear_ratio=None):
    """Recording and draft of a machine whose motor goes as ``driven`` [rad, slow shaft], its output as ``seen``."""
    noise = np.random.default_rng(1)
    columns = {"time [s]": time}
    for side, angle, turns in (("motor", driven, RATIO), ("output", seen, 1.0)):
        step = 2.0 * np.pi / COUNTS
        read = turns * (angle - angle[0]) + noise.normal(0.0, 0.3 * step, len(time))
        columns[f"{side} position [rad]"] = np.round(read / step) * step
    (recording,), model = of_columns(tmp_path, [columns], gear_ratio)
    return recording, model


def of_columns(folder, runs, gear_ratio=None):
    """Recordings of these columns, and their draft."""
    folder.mkdir(exist_ok=True)
    traces = [write_columns(folder / f"run_{k}.csv", columns) for k, columns in enumerate(runs)]
    return by_draft(folder, traces, gear_ratio=gear_ratio)


@pytest.fixture(scope="module")
def discovered(tmp_path_factory):
    """Recording, draft and answer of a machine as ``drafted`` makes it; those who ask for the same one share them."""

    @cache
    def of(kind, quicker):
        recording, model = drafted(tmp_path_factory.mktemp("machine"), kind, quicker)
        return recording, model, discover([recording], model)

    return of


WHAT = {
    "play": ("backlash", "width", 2e-3, 0.1),
    "spring": ("shaft_compliance", None, None, None),
    "late": ("encoder_delay", "delay", 3e-3, 0.02),
    "off centre": ("encoder_eccentricity", "amplitude", 4e-4, 0.02),
    "oval": ("encoder_eccentricity", "amplitude", 4e-4, 0.02),
    "resolver of the motor": ("encoder_eccentricity", "amplitude", 4e-4, 0.02),
}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "quicker"), [*((kind, 1.0) for kind in WHAT), ("play", 12.0), ("spring", 12.0), ("late", 12.0)]
)
def test_what_parts_two_encoders_is_named(kind, quicker, discovered):
    effect, parameter, size, within = WHAT[kind]
    recording, model, found = discovered(kind, quicker)
    assert (found.verdict, found.added) == ("explained", (effect,))
    if parameter is not None:
        told = found.parameters[effect][parameter]
        true = size / quicker if parameter == "delay" else size
        assert told["value"] == pytest.approx(true, rel=within)
        assert abs(told["value"] - true) < 4.0 * told["std"]
    before, after = (compare([recording], m).overall["output_position"] for m in (model, found.model))
    excess = [error["rmse"] ** 2 - error["noise_floor"] ** 2 for error in (before, after)]
    assert excess[1] < 0.02 * excess[0]


@pytest.mark.slow
def test_play_behind_a_late_encoder_is_told_apart_from_it(tmp_path):
    recording, model = drafted(tmp_path, "play", 1.0)
    time = recording.time
    late = np.interp(time - 2e-3, time, recording.signals["output_position"])
    found = discover([changed(recording, output_position=late)], model)
    assert {*found.added} == {"backlash", "encoder_delay"}
    assert found.parameters["backlash"]["width"]["value"] == pytest.approx(2e-3, rel=0.1)
    assert found.parameters["encoder_delay"]["delay"]["value"] == pytest.approx(2e-3, rel=0.02)


@pytest.mark.slow
def test_a_carriage_has_play_too(tmp_path):
    time = np.arange(SAMPLES) * 2e-3
    way = 0.15 * moved(time, 1.0)
    sides = {"motor": way, "output": behind_play(way, 1.6e-4)}
    columns = {f"{side} position [m]": np.round((x - x[0]) / 1e-6) * 1e-6 for side, x in sides.items()}
    found = discover(*of_columns(tmp_path, [{"time [s]": time, **columns}]))
    assert (found.verdict, found.added) == ("explained", ("backlash",))
    width = found.parameters["backlash"]["width"]
    assert width["unit"] == "m" and width["value"] == pytest.approx(1.6e-4, rel=0.15)


@pytest.mark.slow
def test_encoders_that_agree_lack_nothing(discovered):
    _, _, found = discovered("nothing", 1.0)
    assert (found.verdict, found.added) == ("none", ())
    assert found.next_recording.startswith("the same motion with the drive's torque")


def test_a_fit_moves_what_the_encoders_show(tmp_path):
    recording, model = drafted(tmp_path, "late", 1.0)
    late = model.with_effect("encoder_delay", {"delay": 1e-3})
    found = fit_model([recording], late)
    assert [*found.paths] == ["effects.encoder_delay.delay"]
    assert found.parameters["encoder_delay"]["delay"]["value"] == pytest.approx(3e-3, rel=0.02)


def test_no_live_twin_runs_behind_two_encoders(tmp_path):
    recording, _ = drafted(tmp_path, "nothing", 1.0)
    with pytest.raises(InputError, match="holds no current, torque or setpoint"):
        refuse_encoders_alone(recording)


def test_recordings_with_and_without_a_torque_are_judged_apart(tmp_path):
    recording, model = drafted(tmp_path, "nothing", 1.0)
    driven = replace(changed(recording, current=np.ones(len(recording))), name="driven")
    with pytest.raises(InputError, match="run_0: hold two encoders and no torque, beside recordings that hold one"):
        discover([recording, driven], model)


def test_an_output_that_never_moves_is_refused(tmp_path):
    recording, model = drafted(tmp_path, "nothing", 1.0)
    with pytest.raises(InputError, match="output_position never changes while the motor turns"):
        discover([changed(recording, output_position=np.zeros(len(recording)))], model)


@pytest.mark.slow
def test_a_fit_stays_by_the_spring_that_was_found(discovered):
    recording, _, found = discovered("spring", 1.0)
    fitted = fit_model([recording], found.model)
    before, after = (i.parameters["shaft_compliance"]["stiffness"]["value"] for i in (found, fitted))
    assert after == pytest.approx(before, rel=0.05)


def test_a_draft_without_any_gearbox_effect_cannot_be_fitted_to_two_encoders(tmp_path):
    recording, model = drafted(tmp_path, "nothing", 1.0)
    with pytest.raises(InputError, match="has no play, spring, delay or angle error"):
        fit_model([recording], model)


@pytest.mark.slow
def test_no_more_angle_errors_are_tried_than_a_plant_takes(tmp_path):
    recording, model = drafted(tmp_path, "off centre", 1.0)
    for order in range(3, 11):
        model = model.with_effect("encoder_eccentricity", {"amplitude": 1e-9}, {"order": str(order)})
    found = discover([recording], model)
    assert "encoder_eccentricity" not in found.added
    assert sum(held.effect == "encoder_eccentricity" for held in found.model.active.values()) == 8


def triangle(time):
    """Angle [rad] of an output that goes to and fro at one speed, 0.12 rad/s."""
    return 0.3 * (1.0 - 4.0 * np.abs(np.mod(0.1 * time, 1.0) - 0.5))


@pytest.mark.slow
def test_slow_motion_does_not_tell_play_from_a_shaft_that_friction_winds_up(tmp_path):
    time = np.arange(8000) * 2e-3
    slow, fast = triangle(time), moved(time, 1.0)
    groups = {}
    for name, angle in (("slow", slow), ("fast", fast)):
        recording, model = recorded(tmp_path / name, time, angle, behind_play(angle, 2e-3), RATIO)
        found = discover([recording], model)
        assert (found.verdict, found.added) == ("explained", ("backlash",))
        assert found.parameters["backlash"]["width"]["value"] == pytest.approx(2e-3, rel=0.02)
        groups[name] = found.groups
    assert groups == {"slow": (("backlash", "shaft_compliance"),), "fast": ()}


@pytest.mark.slow
def test_play_between_stiff_teeth_keeps_its_place_against_a_spring(tmp_path):
    time = np.arange(4000) * 1e-3
    slow = 0.25 * 2.0 / np.pi * np.arcsin(np.sin(2.0 * np.pi * 0.12 * time))
    quick = [size * np.sin(2.0 * np.pi * f * time) * np.minimum(1.0, f * time) for size, f in ((0.4, 0.4), (0.05, 1.3))]
    runs = []
    for angle in (quick[0], slow, quick[1]):
        columns = {"time [s]": time}
        read = ("motor", 80.0 * angle, 2**13), ("output", behind_teeth(angle, time[1], 2.5e-3), 2**19)
        for side, a, counts in read:
            columns[f"{side} position [rad]"] = np.round(a / (2.0 * np.pi) * counts) / counts * 2.0 * np.pi
        runs.append(columns)
    found = discover(*of_columns(tmp_path, runs, 80.0))
    assert (found.verdict, found.added, found.groups) == ("explained", ("backlash",), ())
    assert found.parameters["backlash"]["width"]["value"] == pytest.approx(2.5e-3, rel=0.02)
    assert found.unseen.rmse[-1] < 0.05 * found.unseen.rmse[0]


@pytest.mark.slow
def test_a_spring_that_is_dropped_gives_play_its_place_back(discovered):
    end = discovered("play", 1.0)[2].search
    (spring,) = other_structures(end.fit, "backlash", frozenset())
    replaced = swapped(end, spring)
    assert replaced.fit.hypothesis.effects == ("shaft_compliance",)
    back = less(replaced, ["shaft_compliance"], "it does not follow")
    assert back.fit is end.fit
    assert less(back, ["backlash"], "nor does this").fit.hypothesis.effects == ()


@pytest.mark.slow
def test_the_next_recording_is_of_the_motion_that_was_not_driven(tmp_path):
    time = np.arange(SAMPLES) * 2e-3
    driven = {
        "reversals as fast as": triangle(time),
        "a slow triangle": 0.05 * np.sin(20.0 * time),
        "the same motion with the drive's torque": moved(time, 1.0),
    }
    for number, (asked, angle) in enumerate(driven.items()):
        recording, model = recorded(tmp_path / str(number), time, angle, angle, RATIO)
        assert discover([recording], model).next_recording.startswith(asked)


@pytest.mark.slow
def test_play_is_found_beside_a_larger_angle_error(tmp_path):
    recording, model = drafted(tmp_path, "play beside a larger angle error", 1.0, RATIO, 8000)
    found = discover([recording], model)
    assert (found.verdict, {*found.added}) == ("explained", {"backlash", "encoder_eccentricity"})
    assert found.parameters["backlash"]["width"]["value"] == pytest.approx(3e-4, rel=0.1)
    error = found.parameters["encoder_eccentricity"]
    assert error["options"]["order"] == "7" and error["amplitude"]["value"] == pytest.approx(3e-3, rel=0.02)


@pytest.mark.slow
def test_where_the_motor_is_not_known_nothing_is_judged(tmp_path):
    recording, model = drafted(tmp_path, "late", 1.0)
    late = model.with_effect("encoder_delay", {"delay": 3e-3})
    motor = recording.signals["motor_position"].copy()
    motor[3000:3200] = motor[:7] = motor[500::700] = np.nan
    holed = changed(recording, motor_position=motor)
    output = simulate(late, holed).signals["output_position"]
    assert (np.isnan(output) == np.isnan(motor)).all()
    whole, beside_holes = (compare([r], late).overall["output_position"]["rmse"] for r in (recording, holed))
    assert beside_holes < 1.5 * whole
    found = discover([holed], model)
    assert found.parameters["encoder_delay"]["delay"]["value"] == pytest.approx(3e-3, rel=0.01)


def test_a_motor_that_is_never_known_is_refused(tmp_path):
    recording, model = drafted(tmp_path, "late", 1.0)
    unknown = changed(recording, motor_position=np.full(len(recording), np.nan))
    for verb in (compare, discover):
        with pytest.raises(InputError, match="its motor_position holds no number"):
            verb([unknown], model)


@pytest.mark.parametrize("kind", [pytest.param("late", marks=pytest.mark.slow), "nothing"])
def test_without_play_or_a_spring_friction_stays_as_it_was_given(kind, discovered):
    _, model, found = discovered(kind, 12.0)
    assert found.model.constants == model.constants
    assert {name: found.model.effects[name] for name in model.effects} == model.effects


@pytest.mark.slow
def test_what_a_file_knows_stays_beside_play(tmp_path):
    recording, model = drafted(tmp_path, "play", 1.0)
    inertia = model.value("machine.output_inertia")
    contact = {"stiffness": inertia * 1200.0**2, "damping": 2.0 * inertia * 1200.0}
    known = {f"transmission.contact_{name}": ConstantValue(value, 0.0, "measured") for name, value in contact.items()}
    closed = {name: replace(effect, open=False) for name, effect in model.effects.items()}
    holding = {"torque": inertia * 1000.0, "static_ratio": 1.0}  # the motion asks for 240 rad/s2 at the motor
    closed["coulomb_friction_2"] = closed["coulomb_friction_2"].at(holding)
    file = replace(model, constants={**model.constants, **known}, effects=closed)
    found = discover([recording], file)
    assert found.added == ("backlash",)
    assert found.parameters["backlash"]["width"]["value"] == pytest.approx(2e-3, rel=0.1)
    assert found.model.constants == file.constants
    assert {name: found.model.effects[name] for name in file.effects} == file.effects


@pytest.mark.slow
def test_how_stiff_teeth_are_is_not_told_as_fitted(discovered):
    _, model, answer = discovered("play", 1.0)
    found = answer.model
    moved = [held.source for path, held in found.constants.items() if held.value != model.value(path)]
    assert moved and not any("fitted" in source for source in moved)


def test_an_order_that_samples_do_not_resolve_is_not_named(tmp_path):
    time = np.arange(SAMPLES) * 10e-3
    angle = 200.0 / RATIO * time  # a third of a turn of the motor from sample to sample: 1.57 orders are resolved
    recording, model = recorded(tmp_path, time, angle, angle + 4e-4 * np.sin(2.0 * angle), RATIO)
    named = [d.periodicity.order for d in compare([recording], model).where if d.periodicity is not None]
    assert all(order < 1.57 for order in named)
    resolver = angle + 4e-4 * np.sin(RATIO * angle)
    recording, model = recorded(tmp_path / "resolver", time, angle, resolver, RATIO)
    best = compare([recording], model).where[0]
    assert best.variable == "order" and best.periodicity.order == pytest.approx(1.0, abs=0.01)


def test_a_draft_says_that_the_second_encoder_was_left_out_for_its_holes(tmp_path, capsys):
    time = np.arange(SAMPLES) * 2e-3
    rows = [f"{t:.6g},{RATIO * a:.9g},{a:.9g}" for t, a in zip(time, moved(time, 1.0), strict=True)]
    rows[700:720] = [f"{row.rpartition(',')[0]}," for row in rows[700:720]]
    trace = tmp_path / "run.csv"
    trace.write_text("\n".join(["time [s],motor position [rad],output position [rad]", *rows]) + "\n")
    init(str(tmp_path / "machine"), [trace])
    told = " ".join(capsys.readouterr().out.split())
    assert "output position [rad]: 20 of 5000 cells hold no number (the first in line 702), so it is not used" in told
    assert "to use it, fill in these cells or remove their rows" in told
    assert "output position [rad] cannot be left out: fill in the missing values in" in told
    assert "add its column" not in told


@pytest.mark.slow
def test_play_that_is_off_its_flanks_is_as_wide_as_they_are_apart(discovered):
    """As where an unseen load chooses the flanks, and a width that fits is a compromise; ± tells by how much."""
    recording, _, end = discovered("play", 1.0)
    right = end.search
    assert with_play_between_flanks(right, [recording]) == (right, {})
    (path,) = (path for path in right.fit.hypothesis.by_path if path.endswith(".width"))
    wrong = right.with_numbers(fit(right.problem, right.fit.hypothesis.put({path: 3e-3}), 0))
    found, uncertain = with_play_between_flanks(wrong, [recording])
    assert found.fit.hypothesis.by_path[path] == pytest.approx(2e-3, rel=0.02)
    assert uncertain == {path: pytest.approx(1e-3, rel=0.04)}
    (warning,) = of_unseen_load(found.fit, uncertain)
    assert "the play of 2.00 mrad is the measured distance between the flanks" in warning
