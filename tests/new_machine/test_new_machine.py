"""A machine that nobody here has seen: `init` drafts its map and its model, and discover names what it hides."""

import re
import shlex
import shutil

import numpy as np
import pytest
import yaml

from docs.examples import press
from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from ema_twin_sim.commands.init import run as init
from ema_twin_sim.measured.consistency import inconsistencies
from ema_twin_sim.model import load_model, save_model
from ema_twin_sim.model.matching import matched
from ema_twin_sim.new_machine.columns import guess_columns
from ema_twin_sim.new_machine.steps import smallest_step
from tests.command_line import done, refused, twin
from tests.conftest import RECORDINGS
from tests.trace_text import write_columns

RATIO = press.CONSTANTS["machine.gear_ratio"]


@pytest.fixture(scope="module")
def traces(tmp_path_factory):
    """Recordings of a press: ratio 12, 4 ms, degrees and rpm, and an unbalanced arm of 90 mN m on its output."""
    return press.write(tmp_path_factory.mktemp("press"))


@pytest.mark.slow
def test_its_map_and_model_are_drafted_and_what_it_hides_is_named(traces, tmp_path):
    ended = twin("init", traces[1], "-o", "press", "--torque-constant", "0.4", cwd=tmp_path)
    assert ended.returncode == 0, ended.stderr
    model, drawn = load_model(tmp_path / "press.yaml"), (tmp_path / "press_map.yaml").read_text()
    assert model.value("machine.gear_ratio") == pytest.approx(RATIO, rel=2e-3)
    assert model.value("sensors.motor_encoder_counts") == pytest.approx(8192.0, rel=1e-3)
    assert model.value("sensors.sample_period") == pytest.approx(4e-3)
    assert "CHECK" not in drawn.partition("\n")[2]
    recording = load(traces[1], import_map=tmp_path / "press_map.yaml")
    assert set(recording.signals) == {"current", "speed", "motor_position", "output_position", "temperature"}
    assert np.abs(recording.signals["output_position"]).max() == pytest.approx(0.6, rel=0.1)

    found = twin(
        "discover", *traces, "--map", "press_map.yaml", "--model", "press.yaml", "-o", "better.yaml", cwd=tmp_path
    )
    assert found.returncode == 0, found.stderr
    better = yaml.safe_load((tmp_path / "better.yaml").read_text())
    assert {entry["effect"] for entry in better["effects"].values()} == {
        "viscous_friction", "coulomb_friction", "gravity_load",
    }  # fmt: skip
    assert better["effects"]["gravity_load"]["parameters"]["torque"] == pytest.approx(0.09, rel=0.05)
    both = [better["machine"][name]["value"] for name in ("inertia", "output_inertia")]
    assert sum(both) == pytest.approx(7.0e-4, rel=0.05)


def test_what_init_says_to_run_next_runs_as_it_is(traces, tmp_path):
    said = done("init", *traces, "-o", "press", "--torque-constant", "0.4", cwd=tmp_path).stdout
    (command,) = re.findall(r"ema-twin (info .*(?:\n .*)?)\n *ema-twin discover", said)
    assert "output_position" in done(*shlex.split(command), cwd=tmp_path).stdout
    shutil.copy(tmp_path / "press.yaml", tmp_path / "found.yaml")
    for verb in ("compare", "report"):  # with the map, and beside what discover writes
        (command,) = re.findall(rf"ema-twin ({verb} .*)", said)
        assert "--map press_map.yaml --model press.yaml --model found.yaml" in command
    (command,) = re.findall(r"ema-twin (compare .*)", said)
    assert "RMSE" in done(*shlex.split(command), cwd=tmp_path).stdout


def test_the_commands_after_a_model_alone_take_the_map_too(traces, tmp_path):
    done("init", traces[1], "-o", "press", "--torque-constant", "0.4", cwd=tmp_path)
    given = ("init", traces[1], "-o", "model", "--map", "press_map.yaml", "--torque-constant", "0.4")
    said = done(*given, cwd=tmp_path).stdout
    listed = re.findall(r"  ema-twin (\w+) .* --map press_map.yaml --model model.yaml", said)
    assert listed == ["discover", "compare", "report"]


@pytest.mark.slow
def test_play_is_named_in_a_machine_of_which_no_constant_is_known(tmp_path):
    """The project's own recordings, as a logger without a setpoint and without Siemens' names would have them."""
    for path in sorted(RECORDINGS.glob("*.CSV")):
        run = load(path)
        names = {"current": "current_A", "motor_position": "motor_angle_rad", "speed": "motor_speed_rad_s",
                 "output_position": "output_angle_rad"}  # fmt: skip
        columns = {word: run.signals[name] for name, word in names.items()}
        write_columns(tmp_path / f"{path.stem}.csv", {"time_s": run.time, **columns})
    traces = sorted(tmp_path.glob("*.csv"))
    told = done("init", traces[1], "-o", "own", "--gear-ratio", "124", cwd=tmp_path)
    assert "own_map.yaml: no line to check" in told.stdout
    done("discover", *traces, "--map", "own_map.yaml", "--model", "own.yaml", "-o", "own_better.yaml", cwd=tmp_path)
    effects = yaml.safe_load((tmp_path / "own_better.yaml").read_text())["effects"]
    assert effects["backlash"]["parameters"]["width"] == pytest.approx(4e-3, rel=0.03)
    assert "encoder_delay" not in effects


def test_what_cannot_be_guessed_is_marked(tmp_path):
    (tmp_path / "bare.csv").write_text(
        "Time,Iq,Position,Velocity,foo\n" + "".join(f"{k},0.{k},{k},1,2\n" for k in range(9))
    )
    ended = twin("init", "bare.csv", "-o", "bare", cwd=tmp_path)
    assert ended.returncode == 0, ended.stderr
    drawn, model = ((tmp_path / name).read_text() for name in ("bare_map.yaml", "bare.yaml"))
    for column in ("Iq", "Position", "Velocity"):
        line = next(line for line in drawn.splitlines() if f"'{column}'" in line)
        assert "CHECK" in line
    assert "not used: foo" in drawn
    assert "CHECK" in next(line for line in model.splitlines() if "torque_constant" in line)
    assert "marked CHECK" in ended.stdout


def test_a_column_that_numbers_runs_is_told_with_the_key_of_the_map(tmp_path):
    rows = "".join(f"{k},{k // 50},{k % 7},{k}\n" for k in range(100))
    (tmp_path / "runs.csv").write_text("time [ms],sequence,current [A],motor position [rad]\n" + rows)
    said = " ".join(done("init", "runs.csv", "-o", "runs", cwd=tmp_path).stdout.split())
    assert "sequence: seems to number 2 runs; with `run: sequence` in the import map, ema-twin campaign judges" in said


@pytest.mark.parametrize(
    ("answers", "question", "remedy"),
    [
        ([], "Name of the time column", "give a trace, whose columns answer it: ema-twin init TRACE.csv"),
        (["t [s]", "I [A]", "", "phi [rad]", "", ""], "Turns of the motor", "give --gear-ratio"),
        (["t [s]", "I [A]", "", "phi [rad]", "", "", "1"], "Torque per ampere", "give --torque-constant"),
    ],
)
def test_where_the_input_ends_at_a_question_what_answers_it_is_told(tmp_path, answers, question, remedy):
    """It was said to be interrupted."""
    naming = f'the input ended before an answer to "{question}', remedy
    refused("init", "-o", "press", cwd=tmp_path, answers="".join(f"{line}\n" for line in answers), naming=naming)


def test_without_a_trace_questions_are_asked(tmp_path):
    answers = ["time [ms]", "", "force [N]", "s [mm]", "", "", "1"]
    ended = twin("init", "-o", "slide", cwd=tmp_path, answers="\n".join(answers) + "\n")
    assert ended.returncode == 0, ended.stderr
    assert load_model(tmp_path / "slide.yaml").motion == "linear"
    assert "unit: mm" in (tmp_path / "slide_map.yaml").read_text()


@pytest.mark.parametrize(
    ("columns", "expected"),
    [
        (["time_s", "motorPosition_deg", "q_ref"], {"motor_position": "deg", "output_command": None}),
        (["t_s", "motor_speed_rad_s", "shaft_torque_N_m"], {"speed": "rad/s", "motor_torque": "N m"}),
        (["t_s", "motor_speed_rad_per_s"], {"speed": "rad/s"}),
        (["Zeit [ms]", "Strom [A]", "Drehzahl [1/min]", "Lage [rad]"],
         {"current": "A", "speed": "rpm", "motor_position": "rad"}),
        (["X [ms]", "iq set [A]", "iq [A]", "load torque [Nm]", "motor torque [Nm]"],
         {"current_setpoint": "A", "current": "A", "load_torque": "N m", "motor_torque": "N m"}),
        (["elapsed time [s]", "i_q [A]", "current limit [A]", "torque setpoint", "torque [Nm]", "speed error"],
         {"current": "A", "motor_torque": "N m"}),
        (["Zeit [ms]", "Weg Schlitten [mm]", "Geschwindigkeit [mm/s]", "Antriebskraft [N]", "Winkel"],
         {"motor_position": "mm", "speed": "mm/s", "motor_torque": "N"}),
        (["t", "position reference [mm]", "position [mm]", "force [kN]"],
         {"output_command": "mm", "motor_position": "mm", "motor_torque": "kN"}),
    ],
)  # fmt: skip
def test_columns_are_known_by_their_names(columns, expected):
    guesses = guess_columns(columns)
    assert guesses.time is not None
    assert {guess.signal: guess.unit for guess in guesses.signals} == expected


def test_an_answer_with_another_unit_is_refused_and_nothing_is_written(tmp_path):
    answers = ["time [s]", "motor_position [deg]", "", "current [A]", "", ""]
    naming = "'motor_position [deg]'", "unit", "A, mA"
    refused("init", "-o", "slip", cwd=tmp_path, answers="\n".join(answers) + "\n", naming=naming)
    assert not list(tmp_path.iterdir())


def test_an_output_that_turns_the_other_way_is_said(tmp_path):
    rows = "".join(f"{k},{0.1 * k},{12.0 * k % 700},{-1.0 * k % 700 - 0.0}\n" for k in range(50))
    (tmp_path / "a: b.csv").write_text("time [s],current [A],motor position [deg],output position [deg]\n" + rows)
    told = done("init", "a: b.csv", "-o", "counter", cwd=tmp_path)
    assert "marked CHECK" in told.stdout
    assert "the output turns against the motor" in (tmp_path / "counter_map.yaml").read_text()


def test_counts_are_no_radians(tmp_path):
    rows = "".join(f"{k},{(k * 37) % 4096},{0.1 * k}\n" for k in range(50))
    (tmp_path / "counts.csv").write_text("time [ms],encoder_counts,iq [A]\n" + rows)
    done("init", "counts.csv", "-o", "counts", cwd=tmp_path)
    line = next(line for line in (tmp_path / "counts_map.yaml").read_text().splitlines() if "encoder_counts" in line)
    assert "counts_per_revolution" in line and "CHECK" in line


def test_an_encoder_without_steps_is_as_fine_as_its_noise(tmp_path):
    rng = np.random.default_rng(3)
    time = np.arange(500) * 1e-3
    position = 30.0 * np.sin(6.0 * time) + 0.01 * rng.standard_normal(500)
    columns = {"time [s]": time, "motor position [deg]": position, "current [A]": np.cos(6.0 * time)}
    write_columns(tmp_path / "a.csv", columns)
    done("init", "a.csv", "-o", "a", cwd=tmp_path)
    counts = load_model(tmp_path / "a.yaml").value("sensors.motor_encoder_counts")
    assert 360.0 / counts / np.sqrt(12.0) == pytest.approx(0.01, rel=0.2)


def test_a_steady_speed_is_no_counters_step():
    """Each sample goes by about as much as the one before; a counter's would stand still now, or go twice as far."""
    rng = np.random.default_rng(3)
    way = np.cumsum(1.5e-3 * (1.0 + 0.02 * rng.standard_normal(3000)))
    assert smallest_step(np.round(way, 5)) is None
    assert smallest_step(2e-3 * np.floor(way / 2e-3)) == pytest.approx(2e-3)


def test_a_counter_of_a_fast_shaft_shows_single_steps_where_it_reverses():
    time = np.arange(15_000) * 1e-3
    way = 60.0 * np.cumsum(np.clip(2.0 * np.sin(1.26 * time), -1.0, 1.0)) * 1e-3
    assert smallest_step(1.5e-3 * np.rint(way / 1.5e-3)) == pytest.approx(1.5e-3)
    noisy = way + 1e-4 * np.random.default_rng(1).standard_normal(len(way))
    assert smallest_step(np.round(noisy, 9)) is None


def test_what_init_refuses(tmp_path):
    (tmp_path / "odd.csv").write_text("foo,bar\n1,2\n3,4\n")
    refused("init", "odd.csv", "-o", "odd", cwd=tmp_path, naming=("odd.csv: header", "foo, bar", "rename them"))
    (tmp_path / "there.yaml").write_text("")
    for name in ("there", "there.yaml"):  # a file's name is the machine's all the same
        refused("init", "odd.csv", "-o", name, cwd=tmp_path, naming=("there.yaml: exists already", "--force"))
    refused("init", "none.csv", "-o", "none", cwd=tmp_path, naming=("none.csv", "check the path"))


def test_a_torque_in_place_of_a_current_has_its_noise(tmp_path):
    rng = np.random.default_rng(5)
    time = np.arange(800) * 1e-3
    table = np.column_stack([time, np.cumsum(np.sin(time)), 20.0 * np.cos(time) + 0.3 * rng.standard_normal(800)])
    np.savetxt(tmp_path / "a.csv", table, "%.9g", ";", header="time [s];position [mm];force [N]", comments="")
    done("init", "a.csv", "-o", "a", cwd=tmp_path)
    assert load_model(tmp_path / "a.yaml").value("sensors.current_noise") == pytest.approx(0.3, rel=0.1)


def turning(tmp_path, ratio, *, both=False, speed="speed [rpm]", position="position [deg]"):
    """A trace of a motor whose position counts the turns of an output behind a gearbox."""
    time = np.arange(1000) * 2e-3
    angle = 40.0 * np.sin(3.0 * time)  # rad of the motor
    columns = {
        "time [s]": time,
        "current [A]": np.cos(3.0 * time),
        position: angle / ratio * press.DEGREES,
        **({"output position [deg]": angle / ratio * press.DEGREES} if both else {}),
        **({speed: np.gradient(angle, time) * press.RPM} if speed else {}),
    }
    write_columns(tmp_path / "a.csv", columns)


def line_of(file, word):
    return next(line for line in file.read_text().splitlines() if word in line)


@pytest.mark.parametrize("both", [False, True])
def test_the_shaft_of_a_position_is_told_by_the_speed(tmp_path, both):
    turning(tmp_path, 50.0, both=both)
    done("init", "a.csv", "-o", "a", cwd=tmp_path)
    line = line_of(tmp_path / "a_map.yaml", "motor_position")
    assert "shaft: output" in line and "CHECK" in line and "0.02 times" in line
    model = load_model(tmp_path / "a.yaml")
    assert model.value("machine.gear_ratio") == pytest.approx(50.0, rel=1e-3)
    assert "CHECK" in line_of(tmp_path / "a.yaml", "gear_ratio")
    moved = matched(load(tmp_path / "a.csv", import_map=tmp_path / "a_map.yaml"), model)
    assert np.ptp(moved.signals["motor_position"]) == pytest.approx(80.0, rel=1e-3)
    assert not list(inconsistencies(moved, model))


def test_the_shaft_of_a_position_is_told_by_the_output_and_the_ratio(tmp_path):
    turning(tmp_path, 50.0, both=True, speed=None)
    done("init", "a.csv", "-o", "a", "--gear-ratio", "50", cwd=tmp_path)
    assert "shaft: output" in line_of(tmp_path / "a_map.yaml", "motor_position")


@pytest.mark.parametrize(("ratio", "arguments"), [(1.0, ()), (press.RPM, ()), (20.0, ("--gear-ratio", "50"))])
def test_a_position_of_the_motor_stays_the_motors(tmp_path, ratio, arguments):
    """It goes the way of the speed, or a factor that wrong units make, or one that is no gear ratio."""
    turning(tmp_path, ratio)
    done("init", "a.csv", "-o", "a", *arguments, cwd=tmp_path)
    line = line_of(tmp_path / "a_map.yaml", "motor_position")
    assert ", shaft: output}" not in line
    assert ("CHECK" in line) == (ratio != 1.0)


def test_the_shaft_is_asked_for_behind_a_gearbox(tmp_path):
    answers = ["time [s]", "current [A]", "", "q [deg]", "", "", "50", "output", "0"]
    done("init", "-o", "arm", cwd=tmp_path, answers="\n".join(answers) + "\n")
    assert "shaft: output" in line_of(tmp_path / "arm_map.yaml", "motor_position")
    refused(
        "init", "-o", "leg", cwd=tmp_path, answers="\n".join([*answers[:7], "wheel", "0"]) + "\n",
        naming=("'wheel' is not a shaft",),
    )  # fmt: skip


def joint(tmp_path, peak, position="position [rad]", torque="current [A]"):
    """A trace that tells position and speed of one shaft, up to ``peak`` [rad/s], without saying whose they are."""
    time = np.arange(1500) * 8e-3
    angle, speed = peak / 2.0 * np.sin(2.0 * time), peak * np.cos(2.0 * time)
    current = 3.0 * np.cos(angle) + np.sign(speed)
    write_columns(tmp_path / "j.csv", {"time [s]": time, position: angle, "speed [rad/s]": speed, torque: current})


@pytest.mark.parametrize(
    ("peak", "position", "at_output"),
    [(0.6, "position [rad]", True), (60.0, "position [rad]", False), (0.6, "motor position [rad]", False)],
)
def test_a_motor_does_not_stay_within_a_turn_behind_its_gear(tmp_path, peak, position, at_output):
    """Within a turn it is the output that is told, unless the column names the motor."""
    joint(tmp_path, peak, position)
    init(str(tmp_path / "j"), [tmp_path / "j.csv"], gear_ratio=100.0, torque_constant=0.1)
    lines = [line_of(tmp_path / "j_map.yaml", f" {signal}:") for signal in ("motor_position", "speed")]
    assert ["shaft: output}" in line for line in lines] == [at_output, at_output]
    assert ("CHECK" in lines[0]) == at_output
    noise = load_model(tmp_path / "j.yaml").value("sensors.speed_noise")
    moved = matched(load(tmp_path / "j.csv", import_map=tmp_path / "j_map.yaml"), load_model(tmp_path / "j.yaml"))
    assert np.abs(moved.signals["speed"]).max() == pytest.approx(peak * (100.0 if at_output else 1.0), rel=1e-3)
    assert noise < 1e-2 * np.abs(moved.signals["speed"]).max()


@pytest.mark.parametrize(
    ("position", "at_output"),
    [("measured steering angle [rad]", True), ("pedal position [rad]", True), ("steering motor angle [rad]", False)],
)
def test_the_angle_of_what_a_motor_moves_is_not_the_motors(tmp_path, position, at_output):
    """By 3 turns it may be either shaft's; the inertia and the counts of a turn would be off by the gear ratio."""
    joint(tmp_path, 20.0, position)
    init(str(tmp_path / "j"), [tmp_path / "j.csv"], gear_ratio=100.0, torque_constant=0.1)
    lines = [line_of(tmp_path / "j_map.yaml", f" {signal}:") for signal in ("motor_position", "speed")]
    assert ["shaft: output}" in line for line in lines] == [at_output, at_output]


def test_whose_angle_it_is_behind_a_gear_is_told_where_no_name_tells(tmp_path, capsys):
    joint(tmp_path, 20.0)
    init(str(tmp_path / "j"), [tmp_path / "j.csv"], gear_ratio=100.0, torque_constant=0.1)
    told = " ".join(capsys.readouterr().out.split())
    assert "position [rad]: read as the motor's, which turns 100 times as fast as the output" in told
    assert "as in 'output position [rad]'" in told
    asked = "it goes 3.18 turns in all, which as the motor's would turn the output by 11.5 deg: is it the motor's?"
    assert all(asked in line_of(tmp_path / "j_map.yaml", f" {signal}:") for signal in ("motor_position", "speed"))
    joint(tmp_path, 20.0, "motor position [rad]")
    init(str(tmp_path / "k"), [tmp_path / "j.csv"], gear_ratio=100.0, torque_constant=0.1)
    assert "read as the motor's" not in capsys.readouterr().out


@pytest.mark.parametrize(("ratio", "told", "at_joint"), [(100.0, 20.0, True), (100.0, 0.2, False), (1.0, 20.0, False)])
def test_a_torque_constant_that_no_drive_could_feed_is_the_joints(tmp_path, ratio, told, at_joint):
    """20 N m/A are 20 V s/rad: 1200 V at the motor's 60 rad/s."""
    joint(tmp_path, 0.6)
    init(str(tmp_path / "j"), [tmp_path / "j.csv"], gear_ratio=ratio, torque_constant=told)
    own = told / (ratio if at_joint else 1.0)
    assert load_model(tmp_path / "j.yaml").value("machine.torque_constant") == pytest.approx(own)
    assert ("CHECK" in line_of(tmp_path / "j.yaml", "torque_constant")) == at_joint
    save_model(load_model(tmp_path / "j.yaml"), tmp_path / "later.yaml")
    assert ("CHECK" in line_of(tmp_path / "later.yaml", "torque_constant")) == at_joint


@pytest.mark.parametrize(("ratio", "told"), [(100.0, 4e5), (9.0, 420.0), (1.0, 4200.0)])
def test_a_torque_constant_that_no_motor_has_is_refused(tmp_path, ratio, told):
    """A motor behind a gear turns 1000 times a minute at least; in thousandths, data sheets are right."""
    joint(tmp_path, 0.6)
    with pytest.raises(InputError, match=rf"if it is in mN m/A, give {told / 1000.0:g}") as refusal:
        init(str(tmp_path / "j"), [tmp_path / "j.csv"], gear_ratio=ratio, torque_constant=told)
    assert "\n" not in str(refusal.value)
    assert not (tmp_path / "j.yaml").exists()


def test_a_torque_constant_that_hardly_a_motor_has_is_asked_about(tmp_path, capsys):
    """420 N m/A at a joint behind a gear of 50 are 8.4 at the motor: 880 V at 1000 turns a minute."""
    joint(tmp_path, 0.6)
    init(str(tmp_path / "j"), [tmp_path / "j.csv"], gear_ratio=50.0, torque_constant=420.0)
    [asked] = [line for line in capsys.readouterr().err.splitlines() if "--torque-constant" in line]
    assert "880 V" in asked and "in mN m/A, give 0.42" in asked
    init(str(tmp_path / "k"), [tmp_path / "j.csv"], gear_ratio=50.0, torque_constant=0.42)
    assert "--torque-constant" not in capsys.readouterr().err


@pytest.mark.parametrize(("torque", "at_output"), [("torque [N m]", True), ("motor torque [N m]", False)])
def test_each_column_that_follows_a_joint_is_to_be_looked_at(tmp_path, torque, at_output):
    joint(tmp_path, 0.6, torque=torque)
    printed = done("init", "j.csv", "-o", "j", "--gear-ratio", 100, cwd=tmp_path).stdout
    for signal, flipped in (("motor_position", True), ("speed", True), ("motor_torque", at_output)):
        line = line_of(tmp_path / "j_map.yaml", f" {signal}:")
        assert ("shaft: output}  # CHECK: " in line) == flipped, line
    columns = ("torque [N m], " if at_output else "") + "speed [rad/s], position [rad]"
    said = next(line for line in printed.splitlines() if line.startswith("Assumed: "))
    why = "it goes 0.0955 turns in all, which as the motor's would turn the output by 0.344 deg"
    assert said.startswith(f"Assumed: {columns}: read as values of the output shaft: {why} (")
    assert "'motor position [rad]', and run init again" in said
    assert f"{why}: assumed to be the output's" in line_of(tmp_path / "j_map.yaml", " motor_position:")


def test_what_a_drives_voltage_decided_is_said_with_the_number_and_the_remedy(tmp_path):
    joint(tmp_path, 0.6)
    arguments = ("--gear-ratio", 100, "--torque-constant", 20)
    done("init", "j.csv", "-o", "j", *arguments, cwd=tmp_path)
    printed = done("init", "j.csv", "-o", "k", "--map", "j_map.yaml", *arguments, cwd=tmp_path).stdout
    said = next(line for line in printed.splitlines() if line.startswith("Assumed: torque constant read as that of"))
    assert "20 N m/A would induce 1200 V" in said and "600 V" in said and "remove `shaft: output`" in said


def test_a_siemens_trace_needs_no_map(tmp_path):
    trace = next(RECORDINGS.glob("*.CSV"))
    told = refused("init", trace, "-o", tmp_path / "machine.yaml")
    assert told.endswith(
        f"{trace}: is a Siemens drive's trace, which needs no map; leave init out: ema-twin info {trace}"
    )
