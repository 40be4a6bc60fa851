"""Exports as programs write them: lines above the header, a row of units below it, times of day, angles that begin
again after each turn, and other languages. The servo of strangers is in all of them."""

from datetime import datetime, timedelta

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.traces.header_words import header_words
from ema_bench_replay.traces.trace_table import read_table
from ema_bench_replay.traces.wrapped_angle import counted_on
from ema_bench_replay.units import units_of
from ema_twin_sim.commands.init import run as init

DEGREES, RPM = 180.0 / np.pi, 30.0 / np.pi
TIME = np.arange(1500) * 2e-3
SPEED = 60.0 * np.sin(2.0 * TIME)
ANGLE = 30.0 * (1.0 - np.cos(2.0 * TIME)) + 0.5
CURRENT = 0.5 * np.sign(SPEED) + 0.2 * np.cos(2.0 * TIME)
BEGUN = datetime(2024, 5, 17, 23, 59, 59)


def cells(*columns):
    return [
        [value if isinstance(value, str) else f"{value:.7f}" for value in row] for row in zip(*columns, strict=True)
    ]


def text(head, columns, mark=",", comma=False):
    rows = [mark.join(row) for row in cells(*columns)]
    return head + "\n".join(row.replace(".", ",") if comma else row for row in rows) + "\n"


EXPORTS = {
    "an oscilloscope's lines above": text(
        "Model,MSO44\nHorizontal Units,s\nRecord Length,1500\n\nTIME [s],angle [rad],speed [rad/s],current [A]\n",
        (TIME, ANGLE, SPEED, CURRENT),
    ),
    "a controller's trace with units below": text(
        "Trace;;;\nProjekt;Presse;;\n\nZeit;Achse.Istposition;Achse.Istgeschwindigkeit;Achse.Iststrom\nms;°;1/min;A\n",
        (TIME * 1e3, ANGLE * DEGREES, SPEED * RPM, CURRENT),
        ";",
        comma=True,
    ),
    "a drive's recorder, which does not name the time": text(
        'Date:;2020-07-08 21:54:05\nIndex:;0x30D3;0x30D2\nScale:;0;True;100.000;0.500\n"Trigger:;0;""Channel 1"""\n'
        ";Position actual value;Velocity actual value;Current actual value\nms;°;rpm;A\n",
        (TIME * 1e3, ANGLE * DEGREES, SPEED * RPM, CURRENT),
        ";",
    ),
    "LabVIEW's header, with a comment that no row has": text(
        "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\t\n\t\nChannels\t3\t\t\nSamples\t1500\t1500\t1500\n"
        "***End_of_Header***\t\t\t\t\nX_Value\tMotor angle (deg)\tMotor speed (rpm)\tMotor current (A)\tComment\n",
        (TIME, ANGLE * DEGREES, SPEED * RPM, CURRENT),
        "\t",
    ),
    "dates and times, over midnight": text(
        "timestamp,motor_angle_rad,motor_speed_rad_s,current_A\n",
        ([(BEGUN + timedelta(seconds=t)).isoformat(timespec="microseconds") for t in TIME], ANGLE, SPEED, CURRENT),
    ),
    "French": text(
        "Temps (s);Position moteur (tr);Vitesse moteur (tr/min);Courant (A)\n",
        (TIME, ANGLE / (2.0 * np.pi), SPEED * RPM, CURRENT),
        ";",
        comma=True,
    ),
    "Italian": text(
        "Tempo [ms];Posizione motore [gradi];Velocità motore [giri/min];Corrente [mA]\n",
        (TIME * 1e3, ANGLE * DEGREES, SPEED * RPM, CURRENT * 1e3),
        ";",
        comma=True,
    ),
    "an absolute encoder": text(
        "time [s],motor angle [deg],motor speed [rpm],motor current [A]\n",
        (TIME, np.mod(ANGLE * DEGREES, 360.0), SPEED * RPM, CURRENT),
    ),
    "a counter that says nothing of itself": text(
        "t_us,enc,vel_rpm,iq_mA\n",
        ([f"{t:.0f}" for t in TIME * 1e6], np.rint(ANGLE * 8192 / (2.0 * np.pi)), SPEED * RPM, CURRENT * 1e3),
    ),
    "blanks between the columns": text(
        "  time[s]   motor_pos[rad]  motor_vel[rad/s]   iq[A]\n", (TIME, ANGLE, SPEED, CURRENT), "    "
    ),
    "one blank, units in brackets of their own": text(
        "time [s] motor position [deg] motor speed [rpm] current [A]\n",
        (TIME, ANGLE * DEGREES, SPEED * RPM, CURRENT),
        " ",
    ),
    "numpy's header in a comment": text("# time motor_pos motor_vel iq\n", (TIME, ANGLE, SPEED, CURRENT), " "),
    "a table that counts its rows": text(
        ",time,motor_pos,motor_vel,motor_current\n", ([str(k) for k in range(len(TIME))], TIME, ANGLE, SPEED, CURRENT)
    ),
}


@pytest.mark.parametrize("kind", EXPORTS)
def test_what_a_program_exports_is_read_without_editing(tmp_path, drafted, read, kind):
    (tmp_path / "run0.csv").write_text(EXPORTS[kind], "utf-8")
    drafted(tmp_path / "run0.csv", gear_ratio=10.0, torque_constant=0.1)
    recording = read()
    assert recording.time == pytest.approx(TIME, abs=2e-6)
    resolution = 2.0 * np.pi / 8192
    assert recording.signals["motor_position"] == pytest.approx(ANGLE - ANGLE[0], abs=resolution)
    assert recording.signals["speed"] == pytest.approx(SPEED, abs=1e-4)
    assert recording.signals["current"] == pytest.approx(CURRENT, abs=1e-4)


@pytest.mark.parametrize("mark", [",", ";", "\t", "  "])
@pytest.mark.parametrize(
    "above",
    [
        "",
        "# of the press, before it was greased\n\n",
        "Export of the greased press\n",
        "Amplitude: 480.00, 480.00\nBias: 960\n====\nTimePosVelocityCurrent\n",
        "gains; 2.5; 0.1\nTimePosVelocityCurrent\n",
    ],
)
def test_numbers_without_a_header_are_refused(tmp_path, mark, above):
    file = tmp_path / "run.csv"
    file.write_text(text(above, (TIME, ANGLE, SPEED, CURRENT), mark))
    line = 1 + above.count("\n")
    with pytest.raises(
        InputError, match=rf"line {line}: 4 cells, and no line above them names as many columns; .* as in 'time \[s\]"
    ) as refusal:
        init(str(tmp_path / "servo"), [file])
    assert "\n" not in str(refusal.value)
    assert not (tmp_path / "servo_map.yaml").exists()


def test_a_header_is_known_by_its_width_below_settings_and_above_a_ruler(tmp_path):
    file = tmp_path / "run.csv"
    file.write_text("gains,2.5,0.1\ntime,pos,vel,iq\n0,1,2,3\n1,2,3,4\n")
    assert read_table(file).header == ["time", "pos", "vel", "iq"]
    file.write_text("gains,2.5\ntime,pos,vel,iq\n====\n0,1,2,3\n1,2,3,4\n")
    assert read_table(file).header == ["time", "pos", "vel", "iq"] and read_table(file).line(0) == 4


def test_lists_in_cells_are_refused_with_what_to_write(tmp_path):
    file = tmp_path / "run.csv"
    rows = [f'on,{20 * row}.5,"[0.1, -0.{row}]","[1.5, {row}.25]"' for row in range(30)]
    file.write_text("\n".join(["state,timestamp,positions,torques", *rows, ""]))
    with pytest.raises(InputError, match=r"run\.csv: torques, positions: no cell holds one number .* column for each"):
        init(str(tmp_path / "servo"), [file])


def test_blanks_part_german_numbers_too(tmp_path):
    file = tmp_path / "run.txt"
    file.write_text("Zeit  Lage   Strom\n  0,00   1,5  -0,25\n  0,01  -2,5   1e-3  \n")
    table = read_table(file)
    assert table.header == ["Zeit", "Lage", "Strom"]
    assert table.columns[1] == pytest.approx([1.5, -2.5])
    assert table.place(1) == f"{file}: line 3"
    file.write_text("time pos state iq\ns rad - A\n0.0 1.5 RUN 2.5\n0.1 1.5 OFF 2.5\n")
    table = read_table(file, needed=lambda header: (0, 1, 3))
    assert table.header == ["time [s]", "pos [rad]", "state [-]", "iq [A]"]
    assert table.columns[3] == pytest.approx([2.5, 2.5])
    file.write_text("time pos iq\n0.0 1.5 2.5\n0.1 1.5 2.5\n0.2 1.5\n0.3 1.5 2.5\n")
    with pytest.raises(InputError, match="line 4: has 2 cells where the header has 3"):
        read_table(file)


def test_a_comment_above_equal_columns_is_no_header(tmp_path):
    """Two lines of as many words: the one next to the rows names them, unless it is of units."""
    file = tmp_path / "run.csv"
    file.write_text("Label,Iq,Speed\nTIME,CH1,CH2\n0,1,2\n1,2,3\n")
    assert read_table(file).header == ["TIME", "CH1", "CH2"]
    file.write_text("time,Iq,Speed\ns,A,rpm\n0,1,2\n1,2,3\n")
    table = read_table(file)
    assert table.header == ["time [s]", "Iq [A]", "Speed [rpm]"]
    assert table.place(1) == f"{file}: line 4"


def test_a_column_whose_first_cell_is_empty_is_one(tmp_path):
    file = tmp_path / "run.csv"
    file.write_text("time;Iq;Kommentar\n0,0;1,5;\n0,1;2,5;ok\n")
    table = read_table(file, needed=lambda header: (0, 1))
    assert table.header == ["time", "Iq", "Kommentar"]
    assert table.columns[1] == pytest.approx([1.5, 2.5])


@pytest.mark.parametrize("first", [0.0, -180.0])
def test_an_angle_is_counted_on_whichever_way_it_turns(first):
    way = np.concatenate([np.linspace(0.0, 1500.0, 400), np.linspace(1500.0, -800.0, 600)])
    shown = np.mod(way - first, 360.0) + first
    on, turns = counted_on(shown, 360.0)
    assert turns == np.abs(np.diff(np.floor((way - first) / 360.0))).sum()
    assert on - on[0] == pytest.approx(way - way[0])


def test_an_angle_within_a_turn_stays_as_it_is():
    swing = 170.0 * np.sin(np.linspace(0.0, 20.0, 500))
    assert counted_on(swing, 360.0) == (pytest.approx(swing), 0)


def test_a_torque_in_per_cent_is_told_to_be_none(drafted):
    warned = drafted({"Time [s]": TIME, "Position [rad]": ANGLE, "Torque [%]": CURRENT}, gear_ratio=10.0).warned
    assert "Torque [%]: '%' is not a unit of the motor torque; the values are read as N m" in warned


@pytest.mark.parametrize(("unit", "read", "size"), [
    ("N mm", "N mm", 1e-3), ("Nmm", "N mm", 1e-3), ("N·mm", "N mm", 1e-3), ("kgf cm", "kgf cm", 9.80665e-2),
    ("kg·cm", "kgf cm", 9.80665e-2), ("gcm", "gf cm", 9.80665e-5), ("µNm", "uN m", 1e-6),
])  # fmt: skip
def test_torque_in_the_units_of_small_and_hobby_motors(unit, read, size):
    words = header_words(f"output torque [{unit}]")
    assert (words.unit, words.quantity) == (read, "torque")
    assert header_words(f"output_torque_{read.replace(' ', '_')}").unit == read
    assert units_of("load_torque")[read] == pytest.approx(size)


def test_a_unit_that_is_unknown_is_not_none_in_the_map(drafted):
    drawing = drafted({"Time [s]": TIME, "Position [rad]": ANGLE, "Torque [dyn cm]": CURRENT}, gear_ratio=10.0).map
    assert "'dyn cm' is not a known unit" in drawing and "no unit in the header" not in drawing


def test_topics_with_rows_of_their_own_are_joined_and_said(drafted):
    """As PlotJuggler writes: no row holds the motion and the current."""
    rows = [(t, "", 2.0 * np.sin(3.0 * t), 6.0 * np.cos(3.0 * t)) for t in TIME]
    rows += [(t, np.cos(3.0 * t), "", "") for t in TIME + 0.0011]
    names = ("__time", "/drive/current", "/joint_states/position", "/joint_states/velocity")
    draft = drafted(dict(zip(names, zip(*sorted(rows, key=lambda row: row[0]), strict=True), strict=True)))
    assert "/drive/current → current" in draft.said and "/joint_states/position → motor_position" in draft.said
    assert "each row holds the columns of one topic only, so they are joined" in draft.warned
