"""The command line as its user meets it: every verb, its exit status, and one clear line for what is refused."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

TWIN = Path(sys.prefix) / "bin" / "ema-twin"
VERBS = (
    "init",
    "import",
    "compare",
    "diagnose",
    "discover",
    "fit",
    "plan",
    "live",
    "simulate",
    "add",
    "remove",
    "effects",
    "info",
    "export",
    "demo",
)


def twin(*arguments, cwd=None, timeout=60, answers=None):
    return subprocess.run(
        [TWIN, *map(str, arguments)],
        capture_output=True,
        text=True,
        cwd=cwd,
        timeout=timeout,
        check=False,
        input=answers,
    )


def done(*arguments, **options):
    result = twin(*arguments, **options)
    assert result.returncode == 0, result.stderr
    return result


def refused(*arguments, naming=(), **options):
    """The one line that a refusal is."""
    result = twin(*arguments, **options)
    assert result.returncode == 2, (result.returncode, result.stdout, result.stderr)
    lines = [line for line in result.stderr.splitlines() if not line.startswith("warning:")]
    assert len(lines) == 1 and lines[0].startswith("error: "), result.stderr
    for word in naming:
        assert word in lines[0], lines[0]
    return lines[0]


@pytest.fixture(scope="module")
def trace(traces):
    return next(path for path in traces if "ramp" in path.name)


@pytest.fixture(scope="module")
def imported(tmp_path_factory, traces):
    folder = tmp_path_factory.mktemp("recordings")
    done("import", *traces, "-o", folder)
    return folder


@pytest.mark.parametrize("verb", VERBS)
def test_every_verb_has_help_with_an_example(verb):
    assert f"ema-twin {verb}" in " ".join(done(verb, "--help").stdout.split())


def test_version_and_bare_call():
    assert done("--version").stdout.startswith("ema-twin 0.")
    bare = twin()
    assert bare.returncode in (0, 2) and "compare" in bare.stdout + bare.stderr


def test_unknown_verbs_and_options_are_refused_in_one_line():
    refused("compre", naming=("compre",))
    refused("compare", "--modle", "x", naming=("--modle",))


def test_import_writes_a_recording_a_trace(imported, traces):
    for path in traces:
        assert (imported / path.stem / f"{path.stem}.mcap").is_file()
        assert (imported / path.stem / "metadata.yaml").is_file()


def test_compare_takes_csv_mcap_folder_and_folder_of_folders_alike(tmp_path, imported, trace):
    forms = (trace, imported / trace.stem, imported / trace.stem / f"{trace.stem}.mcap")
    results = []
    for form in forms:
        done("compare", form, "--model", "polito_bench", "--json", tmp_path / "c.json")
        results.append(json.loads((tmp_path / "c.json").read_text()))
    assert results[0] == results[1] == results[2]
    done("compare", imported, "--model", "polito_bench", "--json", tmp_path / "all.json")
    assert len(json.loads((tmp_path / "all.json").read_text())["recordings"]) == 4


def test_compare_prints_units_noise_floor_and_where_it_fails(traces):
    text = done("compare", *traces, "--model", "polito_bench").stdout
    for word in ("noise floor", "mA", "rad", "N m", "Where the model fails", "direction", "output position"):
        assert word in text
    assert "NaN" not in text and "nan" not in text


def test_the_loop_add_compare_remove(tmp_path, imported):
    done("add", "backlash", "--set", "width=0.004", "--model", "polito_bench", "-o", tmp_path / "one.yaml")
    two = ("--set", "torque=0.08", "--set", "speed=2")
    done("add", "stribeck_friction", *two, "--model", tmp_path / "one.yaml", "-o", tmp_path / "two.yaml")
    models = ("--model", "polito_bench", "--model", tmp_path / "two.yaml")
    text = done("compare", imported, *models, "--json", tmp_path / "c.json").stdout
    assert "excess over noise removed" in text
    before, after = json.loads((tmp_path / "c.json").read_text())
    assert (before["model"], after["model"]) == ("polito_bench", "two")
    assert after["overall"]["output_position"]["rmse"] < 0.01 * before["overall"]["output_position"]["rmse"]
    done("remove", "backlash", "--model", tmp_path / "two.yaml", "-o", tmp_path / "three.yaml")
    assert "backlash" not in done("info", tmp_path / "three.yaml").stdout


def test_cutting_in_time(tmp_path, trace):
    cut = ("--from", "2", "--to", "4")
    done("compare", trace, "--model", "polito_bench", *cut, "--json", tmp_path / "c.json")
    assert json.loads((tmp_path / "c.json").read_text())["recordings"][0]["samples"] == 1001
    refused("compare", trace, "--model", "polito_bench", "--from", "90", naming=(trace.stem,))


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
        assert f"asks {asked} of the motor" in result.stderr and "drive.speed_limit is 837.8 rad/s" in result.stderr


def test_export_gives_the_trace_back(tmp_path, imported, trace):
    done("export", imported / trace.stem, "-o", tmp_path / "back.CSV")
    assert (tmp_path / "back.CSV").read_bytes() == trace.read_bytes()
    done("export", imported / trace.stem, "-o", tmp_path / "table.parquet")
    from pyarrow import parquet

    assert parquet.read_table(tmp_path / "table.parquet").num_rows == 10_000


def test_info_gives_units_and_what_it_prints_as_json(tmp_path, trace):
    model = tmp_path / "one.yaml"
    done("add", "cogging", "--set", "torque=0.02", *MODEL, "-o", model)
    assert "torque 0.02 N m, phase 0 rad" in done("info", model, "--json", tmp_path / "model.json").stdout
    assert json.loads((tmp_path / "model.json").read_text())["effects"]["cogging"]["units"]["torque"] == "N m"
    comments = [line for line in model.read_text().splitlines() if line.startswith("# ")]
    assert "# cogging: torque [N m], phase [rad]" in comments and sum("viscous" in line for line in comments) == 1
    done("info", trace, "--json", tmp_path / "run.json")
    current = json.loads((tmp_path / "run.json").read_text())["statistics"]["current"]
    assert current["unit"] == "A" and current["least"] < current["mean"] < current["greatest"]


def test_effects_as_json(tmp_path):
    done("effects", "--json", tmp_path / "effects.json")
    listed = json.loads((tmp_path / "effects.json").read_text())
    assert {"backlash", "stribeck_friction"} <= {effect["id"] for effect in listed}
    done("effects", "backlash")


def test_live_gives_what_compare_gives(tmp_path, trace):
    cut = ("--from", "0", "--to", "4")
    done("live", trace, "--model", "polito_bench", *cut, "--rate", "5", "--headless", "--json", tmp_path / "live.json")
    done("compare", trace, "--model", "polito_bench", *cut, "--json", tmp_path / "compare.json")
    live, compare = (json.loads((tmp_path / f"{name}.json").read_text()) for name in ("live", "compare"))
    assert live["recordings"][0]["samples"] == compare["recordings"][0]["samples"]
    assert list(live["overall"]) == list(compare["overall"])
    for name, expected in compare["overall"].items():
        assert live["overall"][name]["rmse"] == pytest.approx(expected["rmse"], rel=1e-6)


def test_refused_models_effects_and_values(tmp_path, trace):
    refused("compare", trace, "--model", "polito_bensh", naming=("polito_bench",))
    add = ("--model", "polito_bench", "-o", tmp_path / "x.yaml")
    refused("add", "backlsh", *add, naming=("did you mean 'backlash'",))
    refused("add", "backlash", "--set", "widht=1", *add, naming=("did you mean 'width'",))
    refused("add", "backlash", "--set", "width=9", *add, naming=("out of range", "rad"))
    refused("add", "backlash", "--set", "width", *add, naming=("NAME=VALUE",))
    refused("remove", "backlash", *add, naming=("no effect 'backlash'",))
    refused("effects", "nothing", naming=("unknown effect",))
    assert not (tmp_path / "x.yaml").exists()


def test_refused_commands(tmp_path):
    made = ("-o", tmp_path / "x.mcap")
    refused("simulate", "--model", "polito_bench", "--command", "wobble:1", *made, naming=("wobble", "ramp"))
    refused("simulate", "--model", "polito_bench", "--command", "ramp:1", "-o", tmp_path / "x.txt", naming=(".mcap",))
    long = ("--command", "ramp:1", "--seconds", "1e9")
    refused("simulate", "--model", "polito_bench", *long, *made, naming=("--seconds",))


def test_refused_recordings(tmp_path, trace):
    compare = ("--model", "polito_bench")
    refused("compare", tmp_path / "none.CSV", *compare, naming=("none.CSV",))
    (tmp_path / "empty.CSV").touch()
    refused("compare", tmp_path / "empty.CSV", *compare, naming=("empty.CSV",))
    (tmp_path / "other.mcap").write_bytes(b"not an mcap at all")
    refused("compare", tmp_path / "other.mcap", *compare, naming=("other.mcap",))
    (tmp_path / "folder").mkdir()
    refused("compare", tmp_path / "folder", *compare, naming=("folder",))
    header, *rows = trace.read_text().splitlines()[:100]
    bare = tmp_path / "bare.CSV"
    bare.write_text("\n".join([header.replace("r62", "r9062"), *rows]))
    refused("compare", bare, *compare, "--input", "setpoint", naming=("speed_setpoint", "bare"))


def test_outputs_that_exist_or_cannot_be_written(tmp_path, trace, imported):
    refused("import", trace, "-o", imported, naming=("already", "--force"))
    done("import", trace, "-o", imported, "--force")
    (tmp_path / "file").touch()
    refused("import", trace, "-o", tmp_path / "file", naming=("file",))
    refused("compare", trace, "--model", "polito_bench", "--json", tmp_path / "file" / "c.json", naming=("c.json",))
    (tmp_path / "model.yaml").touch()
    add = ("add", "backlash", "--model", "polito_bench", "-o", tmp_path / "model.yaml")
    refused(*add, naming=("exists",))
    done(*add, "--force")
    refused("export", trace, "-o", tmp_path / "model.yaml", naming=("model.yaml",))


def test_a_folder_that_cannot_be_made(tmp_path, trace):
    (tmp_path / "file").write_text("kept")
    refused("import", trace, "-o", tmp_path / "file" / "folder", naming=("file",))
    assert (tmp_path / "file").read_text() == "kept"


MODEL = ("--model", "polito_bench")


@pytest.mark.parametrize("verb", ["compare", "live"])
@pytest.mark.parametrize(
    "cut", [("--from", "nan"), ("--from", "inf"), ("--from", "1e300"), ("--to", "-inf"), ("--from", "3", "--to", "2")]
)
def test_cuts_that_are_none(trace, verb, cut):
    refused(verb, trace, *MODEL, *cut, naming=cut[::2])


@pytest.mark.parametrize(
    "option", [("--seconds", "nan"), ("--seconds", "inf"), ("--phase", "inf"), ("--offset", "nan")]
)
def test_numbers_that_are_none(tmp_path, option):
    refused("simulate", *MODEL, "-c", "ramp:0.05", "-o", tmp_path / "x.mcap", *option, naming=option[:1])
    refused("simulate", *MODEL, "-c", "ramp:1e300", "-o", tmp_path / "x.mcap", naming=("ramp:1e300",))
    assert not list(tmp_path.iterdir())


def test_a_rate_that_is_none(trace):
    refused("live", trace, *MODEL, "--rate", "nan", naming=("--rate",))
    refused("demo", "--rate", "nan", naming=("--rate",))


def test_live_replaces_nothing_but_its_own(tmp_path, trace, imported):
    """All are refused before a node starts: the mark is an input that the recording lacks."""
    folder = tmp_path / "folder"
    folder.mkdir()
    files = [folder / name for name in ("folder.mcap", "metadata.yaml", "other.mcap")]
    for file in files:
        file.write_text("precious")
    live = ("live", trace, *MODEL, "--headless", "--force")
    refused(*live, "--rrd", folder, naming=("folder", "--rrd"))
    refused(*live, "--record", folder, naming=("other.mcap", "another folder"))
    files.pop().unlink()
    refused(*live[:-1], "--record", folder, naming=("--force",))
    files[0].rename(folder / "some.mcap")
    refused(*live, "--record", folder, naming=("metadata.yaml", "some.mcap"))
    refused(*live, "--record", folder / "some.mcap", naming=("no folder",))
    assert {file.read_text() for file in folder.iterdir()} == {"precious"}
    bag = imported / trace.stem
    before = (bag / f"{bag.name}.mcap").read_bytes()
    for run in (bag, bag / f"{bag.name}.mcap"):
        refused("live", run, *live[2:], "--record", bag, naming=("is an input",))
        refused("live", run, *live[2:], "--rrd", bag / f"{bag.name}.mcap", naming=("is an input",))
    assert (bag / f"{bag.name}.mcap").read_bytes() == before


def test_live_records_over_its_own_bag(tmp_path, trace):
    folder = tmp_path / "bag"
    folder.mkdir()
    live = ("live", trace, *MODEL, "--headless", "--rate", "10", "--to", "1", "--record", folder)
    done(*live)
    refused(*live, naming=("--force",))
    done(*live, "--force")
    assert sorted(path.name for path in folder.iterdir()) == ["bag.mcap", "metadata.yaml"]
    assert (folder / "bag.mcap").stat().st_size > 10_000


def test_demo_leaves_folders_that_it_did_not_make(tmp_path):
    (tmp_path / "live").mkdir()
    (tmp_path / "better.yaml").write_text("mine")
    refused("demo", "-o", tmp_path, naming=(str(tmp_path), "-o"))
    assert (tmp_path / "live").is_dir() and (tmp_path / "better.yaml").read_text() == "mine"


def test_demo_clears_its_own_folder(tmp_path):
    from ema_twin_sim.commands.demo import _prepare

    _prepare(tmp_path / "demo")
    (tmp_path / "demo" / "live").mkdir()
    (tmp_path / "demo" / "notes").touch()
    _prepare(tmp_path / "demo")
    assert {path.name for path in (tmp_path / "demo").iterdir()} == {".ema-twin-demo", "notes"}


def test_json_replaces_no_input(tmp_path, trace):
    run = shutil.copy(trace, tmp_path / "run.CSV")
    model = tmp_path / "model.yaml"
    done("add", "backlash", *MODEL, "-o", model)
    link = tmp_path / "link.json"
    link.symlink_to(run)
    for output in (run, model, link):
        for verb in ("compare", "live"):
            refused(verb, run, "--model", model, "--json", output, naming=("is an input",))
    assert run.read_bytes() == trace.read_bytes() and "backlash" in model.read_text()


def test_json_on_the_standard_output(trace):
    text = done("compare", trace, *MODEL, "--to", "1", "--json", "/dev/stdout").stdout
    assert json.loads(text[text.index("\n{") :])["model"] == "polito_bench"


def test_a_recording_given_twice_counts_once(tmp_path, imported, traces, trace):
    again = (imported, imported / trace.stem, imported / trace.stem / f"{trace.stem}.mcap")
    result = done("compare", *again, *MODEL, "--to", "1", "--json", tmp_path / "c.json")
    assert len(json.loads((tmp_path / "c.json").read_text())["recordings"]) == len(traces)
    assert result.stderr.count("warning:") == 1 and "more than once" in result.stderr


def test_short_cuts(trace):
    refused("compare", trace, *MODEL, "--to", "0", naming=(trace.name, "1 sample"))
    text = done("compare", trace, *MODEL, "--to", "0.317").stdout
    assert "too short" in text and "160 samples" in text
    assert "Where the model fails" in done("compare", trace, *MODEL, "--to", "0.319").stdout


def test_samples_too_few_to_tell_anything(tmp_path, trace):
    header, *rows = trace.read_text().splitlines()
    short = tmp_path / "short.CSV"
    short.write_text("\n".join([header, *rows[:2]]) + "\n")
    text = done("compare", short, *MODEL).stdout
    assert "too short to tell" in text and "160 samples" in text and "nothing left" not in text


def test_a_folder_of_traces_is_its_recordings(tmp_path, traces):
    folder = tmp_path / "runs"
    folder.mkdir()
    refused("compare", folder, *MODEL, naming=("no .mcap and no CSV trace",))
    shutil.copy(traces[0], folder / "one.CSV")
    shutil.copy(traces[1], folder / "two.csv")
    (folder / "notes.txt").write_text("of the day")
    done("compare", folder, *MODEL, "--to", "1", "--json", tmp_path / "c.json")
    compared = json.loads((tmp_path / "c.json").read_text())["recordings"]
    assert [recording["name"] for recording in compared] == ["one", "two"]
    refused("compare", folder, *MODEL, "--json", folder / "one.CSV", naming=("is an input",))


def test_where_shows_what_tells_and_the_best_of_each_signal(tmp_path, trace):
    text = done("compare", trace, *MODEL, "--json", tmp_path / "c.json").stdout
    where = json.loads((tmp_path / "c.json").read_text())["where"]
    shares = [
        int(line.split("%")[0].split()[-1]) for line in text.splitlines() if " % " in line and "power" not in line
    ]
    telling = [found for found in where if found["share"] >= 0.1]
    assert len(shares) < len(where) and len(shares) >= len(telling) and max(shares) >= 10
    assert sum(share < 10 for share in shares) <= len({found["signal"] for found in where})


def test_under_the_current_what_drifts_is_left_out(tmp_path, trace):
    text = done("compare", trace, *MODEL, "--input", "current", "--json", tmp_path / "c.json").stdout
    assert "drift and are left out" in text and "unexplained torque" in text
    assert "motor position" not in text.split("Where")[0] and "error of the speed" not in text
    assert "motor_position" in json.loads((tmp_path / "c.json").read_text())["overall"]


def test_the_page_draws_a_bench_without_speed_and_motor_counter():
    import numpy as np

    from ema_bench_replay.recording import Recording
    from ema_twin_sim.views.page import _curves

    stamps = np.arange(50) * 2_000_000
    bench = Recording("bench", stamps, {"current": np.ones(50)})
    twin = Recording("twin", stamps, {n: np.zeros(50) for n in ("current", "speed", "unexplained_torque")})
    assert len(_curves(bench, [twin], ["twin"]).data) == 4


def test_damaged_but_readable_input_is_used_with_a_warning(tmp_path, trace, imported):
    torn = tmp_path / "torn.CSV"
    text = trace.read_bytes()
    torn.write_bytes(text[: len(text) // 2 + 7])
    cut = tmp_path / "cut.mcap"
    whole = (imported / trace.stem / f"{trace.stem}.mcap").read_bytes()
    cut.write_bytes(whole[: len(whole) * 2 // 3])
    for damaged in (torn, cut):
        result = done("compare", damaged, "--model", "polito_bench", "--json", tmp_path / "c.json")
        assert len([line for line in result.stderr.splitlines() if line.startswith("warning:")]) == 1
        content = json.loads((tmp_path / "c.json").read_text())
        assert len(content["warnings"]) == 1
        assert 3000 < content["recordings"][0]["samples"] < 8000
        refused("compare", damaged, "--model", "polito_bench", "--strict", naming=(damaged.name,))


def test_an_internal_error_is_one_line_with_status_1(tmp_path):
    """A catalogue with a broken effect in it: not the user's fault, and no traceback either."""
    import ema_twin_sim

    package = Path(ema_twin_sim.__file__).parent
    copy = tmp_path / "ema_twin_sim"
    shutil.copytree(package, copy, ignore=shutil.ignore_patterns("__pycache__"))
    (copy / "effects" / "broken.py").write_text("raise RuntimeError('broken on purpose')\n")
    start = (
        f"import sys; sys.path.insert(0, {str(tmp_path)!r}); sys.argv = ['ema-twin', 'effects'];"
        "from ema_twin_sim.commands.main import main; main()"
    )
    result = subprocess.run([sys.executable, "-c", start], capture_output=True, text=True, timeout=60, check=False)
    assert result.returncode == 1
    assert result.stderr.startswith("internal error: RuntimeError: broken on purpose")
    assert "Traceback" not in result.stderr


def test_commands_that_need_no_physics_do_not_load_it():
    """It takes half a second to import, and tab completion and --help wait for it."""
    code = "import sys; import ema_twin_sim.commands.main; sys.exit('numba' in sys.modules or 'numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
