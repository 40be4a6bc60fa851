"""The command line as its user meets it: every verb, its exit status and what it writes."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from ema_twin_sim.commands import main
from tests.command_line import MODEL, done, refused, twin

VERBS = sorted(
    file.stem.rstrip("_") for file in Path(main.__file__).parent.glob("*.py") if "\nEXAMPLES = " in file.read_text()
)


def test_no_verb_is_left_out():
    assert sorted(main.VERBS) == VERBS


def test_descriptions_are_folded_by_the_terminal_alone():
    """Lines of a docstring were kept, and folded once more on a terminal of 80 columns."""
    for verb in VERBS:
        (command,) = main.application([verb]).registered_commands
        paragraphs = command.help.split("\n\n")
        assert all(paragraph and "\n" not in paragraph for paragraph in paragraphs), verb


@pytest.mark.parametrize("verb", VERBS)
def test_every_verb_has_help_with_an_example(verb):
    assert f"ema-twin {verb}" in " ".join(done(verb, "--help").stdout.split())


def test_version_and_bare_call():
    assert done("--version").stdout.startswith("ema-twin 0.")
    bare = twin()
    assert bare.returncode in (0, 2) and "compare" in bare.stdout + bare.stderr


def test_the_loop_add_compare_remove(tmp_path, imported):
    done("add", "backlash", "--set", "width=0.004", "--model", "polito_bench", "-o", tmp_path / "one.yaml")
    two = ("--set", "torque=0.08", "--set", "speed=2")
    done("add", "stribeck_friction", *two, "--model", tmp_path / "one.yaml", "-o", tmp_path / "two.yaml")
    models = ("--model", "polito_bench", "--model", tmp_path / "two.yaml")
    text = done("compare", imported, *models, "--json", tmp_path / "c.json").stdout
    assert "times closer" in text and "two: " in text
    before, after = json.loads((tmp_path / "c.json").read_text())
    assert (before["model"], after["model"]) == ("polito_bench", "two")
    assert after["overall"]["output_position"]["rmse"] < 0.01 * before["overall"]["output_position"]["rmse"]
    done("remove", "backlash", "--model", tmp_path / "two.yaml", "-o", tmp_path / "three.yaml")
    assert "backlash" not in done("info", tmp_path / "three.yaml").stdout


def test_simulate_makes_recordings_that_compare_reads(tmp_path):
    for name in ("made.mcap", "made.CSV"):
        command = ("--command", "triangle:0.04:1", "--seconds", "3", "--seed", "7")
        done("simulate", "--model", "polito_bench", *command, "-o", tmp_path / name)
        done("compare", tmp_path / name, "--model", "polito_bench", "--json", tmp_path / f"{name}.json")
    by_mcap, by_csv = (
        json.loads((tmp_path / f"{name}.json").read_text())["overall"] for name in ("made.mcap", "made.CSV")
    )
    # the drive's CSV rounds to its own digits
    assert by_csv["current"]["rmse"] == pytest.approx(by_mcap["current"]["rmse"], rel=0.02)
    assert by_mcap["current"]["rmse"] < 1.1 * by_mcap["current"]["noise_floor"]


@pytest.mark.parametrize(
    ("command", "asked"),
    [("ramp:50", "6200 rad/s"), ("speed-sine:7:1", "868 rad/s"), ("sine:0.05:1", ""), ("step:1:0.5", "")],
)
def test_a_command_beyond_the_speed_limit_is_warned_of(tmp_path, command, asked):
    result = done("simulate", *MODEL, "--command", command, "--seconds", "1", "-o", tmp_path / "run.mcap")
    assert result.stderr.count("warning:") == bool(asked)
    if asked:
        assert f"needs {asked} at the motor" in result.stderr and "drive.speed_limit is 837.8 rad/s" in result.stderr


def test_export_gives_the_trace_back(tmp_path, imported, ramp):
    done("export", imported / ramp.stem, "-o", tmp_path / "back.CSV")
    assert (tmp_path / "back.CSV").read_bytes() == ramp.read_bytes()
    done("export", imported / ramp.stem, "-o", tmp_path / "table.parquet")
    from pyarrow import parquet

    assert parquet.read_table(tmp_path / "table.parquet").num_rows == 10_000


def test_info_gives_units_and_what_it_prints_as_json(tmp_path, ramp):
    model = tmp_path / "one.yaml"
    done("add", "cogging", "--set", "torque=0.02", *MODEL, "-o", model)
    assert "torque 0.02 N m, phase 0 rad" in done("info", model, "--json", tmp_path / "model.json").stdout
    assert json.loads((tmp_path / "model.json").read_text())["effects"]["cogging"]["units"]["torque"] == "N m"
    comments = [line for line in model.read_text().splitlines() if line.startswith("# ")]
    assert "# cogging: torque [N m], phase [rad]" in comments and sum("viscous" in line for line in comments) == 1
    done("info", ramp, "--json", tmp_path / "run.json")
    current = json.loads((tmp_path / "run.json").read_text())["statistics"]["current"]
    assert current["unit"] == "A" and current["least"] < current["mean"] < current["greatest"]


def test_effects_as_json(tmp_path):
    done("effects", "--json", tmp_path / "effects.json")
    listed = json.loads((tmp_path / "effects.json").read_text())
    assert {"backlash", "stribeck_friction"} <= {effect["id"] for effect in listed}
    done("effects", "backlash")


@pytest.mark.slow
def test_live_gives_what_compare_gives(tmp_path, ramp):
    cut = ("--from", "0", "--to", "4")
    done("live", ramp, "--model", "polito_bench", *cut, "--rate", "5", "--headless", "--json", tmp_path / "live.json")
    done("compare", ramp, "--model", "polito_bench", *cut, "--json", tmp_path / "compare.json")
    live, compare = (json.loads((tmp_path / f"{name}.json").read_text()) for name in ("live", "compare"))
    assert live["recordings"][0]["samples"] == compare["recordings"][0]["samples"]
    assert list(live["overall"]) == list(compare["overall"])
    for name, expected in compare["overall"].items():
        assert live["overall"][name]["rmse"] == pytest.approx(expected["rmse"], rel=1e-6)


def test_json_on_the_standard_output(ramp):
    text = done("compare", ramp, *MODEL, "--to", "1", "--json", "/dev/stdout").stdout
    assert json.loads(text[text.index("\n{") :])["model"] == "polito_bench"


def test_commands_that_need_no_physics_do_not_load_it():
    """It takes half a second to import, and tab completion and --help wait for it."""
    code = "import sys; from ema_twin_sim.commands.main import application; application(); "
    code += "sys.exit('numba' in sys.modules or 'numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_a_verb_is_read_without_the_others():
    code = "import sys; from ema_twin_sim.commands import main; sys.argv[1:] = ['info', '--help']\n"
    code += "try: main.main()\nexcept SystemExit: pass\n"
    code += "print(*[verb for verb in main.VERBS if f'ema_twin_sim.commands.{verb}' in sys.modules])"
    told = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout
    assert told.splitlines()[-1] == "info"


def test_diff_tells_what_two_models_differ_in(tmp_path):
    fine = done("diff", "polito_hf", "polito_hff", "--json", tmp_path / "d.json").stdout
    assert "transmission.kind" in fine and "planetary" in fine and "motor_inertia" not in fine
    found = json.loads((tmp_path / "d.json").read_text())
    assert {"what": "transmission.kind", "first": "rigid", "second": "planetary"} in found["differences"]
    done("add", "backlash", "--set", "width=0.004", *MODEL, "-o", tmp_path / "new.yaml")
    assert "width 0.004 rad" in done("diff", "polito_bench", tmp_path / "new.yaml").stdout
    assert "are identical" in done("diff", "polito_bench", "polito_bench").stdout
    refused("diff", "polito_bench", "polito_benhc", naming=("polito_benhc",))
