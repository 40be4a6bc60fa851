"""A slide whose positions are lengths, moved by a motor that turns: what --travel-per-turn makes of its numbers."""

import math

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.model import load_model
from tests.command_line import refused, twin
from tests.trace_text import write_columns

MASS, VISCOUS, COULOMB = 40.0, 300.0, 60.0  # kg, N s/m, N
LEAD, CONSTANT = 0.005, 0.05  # m per turn, N m/A
PER_RADIAN = LEAD / (2.0 * math.pi)  # m
TIME = np.arange(6000) * 1e-3
WAY = 0.03 * np.sin(2.0 * np.pi * 0.5 * TIME) + 0.01 * np.sin(2.0 * np.pi * 1.7 * TIME)
SPEED = np.gradient(WAY, TIME)
FORCE = MASS * np.gradient(SPEED, TIME) + VISCOUS * SPEED + COULOMB * np.tanh(SPEED / 1e-4)
CURRENT = FORCE * PER_RADIAN / CONSTANT + np.random.default_rng(4).normal(0.0, 0.02, len(TIME))
SLIDE = {"time [s]": TIME, "current [A]": CURRENT, "position [mm]": np.round(1e3 * WAY, 4)}
TURNING = {
    "motor angle [deg]": np.round(np.degrees(WAY / PER_RADIAN), 2),
    "motor speed [rpm]": SPEED / PER_RADIAN * 60.0 / (2.0 * np.pi),
    "motor torque [N m]": CURRENT * CONSTANT,
}
GIVEN = {"torque_constant": CONSTANT, "travel_per_turn": LEAD}


def test_the_mass_behind_a_screw_is_found_from_the_motors_torque_constant(drafted, read, drawn):
    draft = drafted(SLIDE, **GIVEN)
    assert "Known: torque constant 62.8 N/A (given: 0.05 N m/A of the motor, 5 mm per turn)" in draft.said
    assert "source: 'given: 0.05 N m/A of the motor, 5 mm per turn'" in draft.line("torque_constant")
    assert "CHECK" not in draft.line("torque_constant") and not draft.warned
    found = discover([read()], drawn())
    mass = found.constants["machine"]["inertia"]
    assert abs(mass["value"] - MASS) < 3.0 * mass["std"] and mass["unit"] == "kg"
    assert not any("torque constant" in told for told in found.warnings)


def test_without_the_way_per_turn_a_torque_constant_is_asked_about(drafted):
    draft = drafted(SLIDE, torque_constant=CONSTANT)
    assert "Assumed: torque constant 50.0 mN/A (read as a force per ampere; if it is in N m/A" in draft.said
    assert "Known: torque constant" not in draft.said
    assert "CHECK: read as a force per ampere" in draft.line("torque_constant")
    assert "give its way per turn too, as in --travel-per-turn '5 mm'" in draft.said
    assert "the motor would do next to no work: it would induce 10.0 mV" in draft.warned


def test_a_search_warns_of_a_force_per_ampere_that_no_motor_has(drafted, read, drawn):
    drafted(SLIDE, torque_constant=CONSTANT)
    warnings = discover([read()], drawn()).warnings
    assert any("torque constant of your model, 50.0 mN/A, is only assumed" in told for told in warnings)


def test_a_force_per_ampere_that_motors_have_is_no_reason_for_a_warning(drafted):
    draft = drafted(SLIDE, torque_constant=CONSTANT / PER_RADIAN)
    assert "CHECK: read as a force per ampere" in draft.line("torque_constant") and not draft.warned


def test_a_gear_ratio_of_lengths_is_refused(drafted):
    with pytest.raises(InputError, match=r"--gear-ratio: positions in a unit of length.* --travel-per-turn '5 mm'"):
        drafted(SLIDE, torque_constant=CONSTANT, gear_ratio=22405.0)
    with pytest.raises(InputError, match=r"5 mm, has the gear in it; .* give --travel-per-turn '1.25 mm'"):
        drafted(SLIDE, gear_ratio=4.0, **GIVEN)


def test_a_gear_ratio_of_one_is_none(drafted):
    assert "unit: N/A" in drafted(SLIDE, gear_ratio=1.0, **GIVEN).line("torque_constant")


@pytest.mark.parametrize("names", [("motor angle [deg]",), ("motor speed [rpm]", "motor torque [N m]"), tuple(TURNING)])
def test_what_is_told_of_the_motors_turns_is_read_as_of_the_slide(names, drafted, read):
    draft = drafted({**SLIDE, **{name: TURNING[name] for name in names}}, **GIVEN)
    assert f"{names[0]} → " in draft.said and "as of the slide, 5 mm per turn (`factor` in the map)" in draft.said
    recording = read()
    assert recording.motion == "linear" and "# CHECK" not in draft.map and not draft.warned
    expected = {"motor_position": WAY, "speed": SPEED, "motor_torque": CURRENT * CONSTANT / PER_RADIAN}
    for signal, values in expected.items():
        if recording.has(signal):
            assert np.allclose(recording.signals[signal], values - values[0] * (signal == "motor_position"), atol=1e-5)


def test_a_factor_of_one_digit_is_written_as_yaml_reads_a_number(drafted, read):
    drafted({**SLIDE, "motor speed [rpm]": TURNING["motor speed [rpm]"] * LEAD / 0.0054}, travel_per_turn=0.0054)
    assert np.allclose(read().signals["speed"], SPEED, atol=1e-5)


def test_an_angle_that_wraps_is_counted_on_along_the_way(drafted, read):
    columns = {"time [s]": TIME, "current [A]": CURRENT, "motor angle [deg]": TURNING["motor angle [deg]"] % 360.0}
    drafted({**columns, "slide position [mm]": 1e3 * WAY}, **GIVEN)
    assert np.allclose(read().signals["motor_position"], WAY - WAY[0], atol=1e-6)


def test_a_way_per_turn_that_both_positions_contradict_is_said(drafted):
    columns = {**SLIDE, "motor angle [deg]": TURNING["motor angle [deg]"]}
    draft = drafted(columns, torque_constant=CONSTANT, travel_per_turn=0.02)
    assert "both positions give 5 mm per turn of the motor, --travel-per-turn says 20 mm" in draft.said
    assert "CHECK" not in drafted(columns, **GIVEN).line("gear_ratio")


def test_how_to_use_the_motors_turns_beside_lengths_is_told(drafted):
    draft = drafted({**SLIDE, "speed [rev/s]": SPEED / LEAD})
    assert "if it is of the motor that moves the slide, give the way per turn, as in --travel-per-turn" in draft.said


def test_a_counter_of_the_motor_is_not_read_as_a_length(drafted):
    draft = drafted({**SLIDE, "motor position [counts]": np.round(WAY / LEAD * 4096.0)}, **GIVEN)
    assert "if it counts the motor's turns, write them into the file as 'motor position [rev]'" in draft.said
    assert "position [mm] → motor_position in mm" in draft.said and not draft.warned


def test_a_way_per_turn_without_lengths_is_refused(drafted):
    columns = {"time [s]": TIME, "current [A]": CURRENT, "motor angle [deg]": TURNING["motor angle [deg]"]}
    with pytest.raises(InputError, match=r"--travel-per-turn: no position or speed of run0 is in a unit of length"):
        drafted(columns, **GIVEN)


def test_a_way_per_turn_so_short_that_no_motor_is_so_fast_is_refused(drafted):
    with pytest.raises(InputError, match="if the slide goes farther per turn of the motor, correct --travel-per-turn"):
        drafted(SLIDE, torque_constant=CONSTANT, travel_per_turn=1e-6)


@pytest.mark.parametrize("text", ["5 mm", "5mm", "0.005", "0.5 cm", "5e-3 m"])
def test_a_length_is_read_with_its_unit_or_in_metres(text, tmp_path):
    write_columns(tmp_path / "a.csv", {name: values[:500] for name, values in SLIDE.items()})
    ended = twin("init", "a.csv", "-o", "a", "--torque-constant", "0.05", "--travel-per-turn", text, cwd=tmp_path)
    assert ended.returncode == 0, ended.stderr
    assert load_model(tmp_path / "a.yaml").value("machine.torque_constant") == pytest.approx(CONSTANT / PER_RADIAN)


@pytest.mark.parametrize(
    ("text", "why"),
    [("5", "5 has no unit"), ("5 kg", "is no length"), ("-5 mm", "out of range"), ("mm", "is no length")],
)
def test_what_is_no_length_is_refused(text, why, tmp_path):
    refused("init", "a.csv", "-o", "a", "--travel-per-turn", text, cwd=tmp_path, naming=(why, "as in '5 mm'"))


def test_without_a_trace_the_way_per_turn_of_a_slide_is_asked_for(tmp_path):
    answers = ["time [ms]", "I [A]", "", "s [mm]", "", "", "5 mm", "0.05"]
    ended = twin("init", "-o", "slide", cwd=tmp_path, answers="\n".join(answers) + "\n")
    assert ended.returncode == 0, ended.stderr
    model = load_model(tmp_path / "slide.yaml")
    assert model.value("machine.torque_constant") == pytest.approx(CONSTANT / PER_RADIAN)
