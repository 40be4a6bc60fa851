"""What the command line refuses, in one line that names it, and what it never replaces."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.command_line import ENDING, MODEL, done, refused


def test_unknown_verbs_and_options_are_refused_in_one_line():
    refused("compre", naming=("compre",))
    refused("compare", "--modle", "x", naming=("--modle",))


def test_refused_models_effects_and_values(tmp_path, ramp):
    refused("compare", ramp, "--model", "polito_bensh", naming=("polito_bench",))
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
    refused("init", tmp_path / "run.csv", "-o", ".", naming=("-o .: is a folder", "-o press"))


def test_refused_recordings(tmp_path, ramp):
    compare = ("--model", "polito_bench")
    refused("compare", tmp_path / "none.CSV", *compare, naming=("none.CSV",))
    (tmp_path / "empty.CSV").touch()
    refused("compare", tmp_path / "empty.CSV", *compare, naming=("empty.CSV",))
    (tmp_path / "other.mcap").write_bytes(b"not an mcap at all")
    refused("compare", tmp_path / "other.mcap", *compare, naming=("other.mcap",))
    (tmp_path / "folder").mkdir()
    refused("compare", tmp_path / "folder", *compare, naming=("folder",))
    header, *rows = ramp.read_text().splitlines()[:100]
    bare = tmp_path / "bare.CSV"
    bare.write_text("\n".join([header.replace("r62", "r9062"), *rows]))
    refused("compare", bare, *compare, "--input", "setpoint", naming=("speed_setpoint", "bare"))


@pytest.mark.slow
def test_outputs_that_exist_or_cannot_be_written(tmp_path, ramp, imported):
    refused("import", ramp, "-o", imported, naming=("already", "--force"))
    done("import", ramp, "-o", imported, "--force")
    (tmp_path / "file").touch()
    refused("import", ramp, "-o", tmp_path / "file", naming=("file",))
    compare = ("compare", ramp, "--model", "polito_bench", "--json")
    refused(*compare, tmp_path / "file" / "c.json", naming=("c.json",))
    refused(
        *compare,
        "/proc/c.json",
        naming=("/proc/c.json: cannot be written (no file can be made in /proc); choose another",),
    )
    (tmp_path / "model.yaml").touch()
    add = ("add", "backlash", "--model", "polito_bench", "-o", tmp_path / "model.yaml")
    refused(*add, naming=("exists",))
    done(*add, "--force")
    refused("export", ramp, "-o", tmp_path / "model.yaml", naming=("model.yaml",))


def test_a_folder_that_cannot_be_made(tmp_path, ramp):
    (tmp_path / "file").write_text("kept")
    refused("import", ramp, "-o", tmp_path / "file" / "folder", naming=("file",))
    assert (tmp_path / "file").read_text() == "kept"


@pytest.mark.parametrize("verb", ["compare", "live"])
@pytest.mark.parametrize(
    "cut", [("--from", "nan"), ("--from", "inf"), ("--from", "1e300"), ("--to", "-inf"), ("--from", "3", "--to", "2")]
)
def test_cuts_that_are_none(ramp, verb, cut):
    refused(verb, ramp, *MODEL, *cut, naming=cut[::2])


@pytest.mark.parametrize(
    "option", [("--seconds", "nan"), ("--seconds", "inf"), ("--phase", "inf"), ("--offset", "nan")]
)
def test_numbers_that_are_none(tmp_path, option):
    refused("simulate", *MODEL, "-c", "ramp:0.05", "-o", tmp_path / "x.mcap", *option, naming=option[:1])
    refused("simulate", *MODEL, "-c", "ramp:1e300", "-o", tmp_path / "x.mcap", naming=("ramp:1e300",))
    assert not list(tmp_path.iterdir())


def test_a_rate_that_is_none(ramp):
    refused("live", ramp, *MODEL, "--rate", "nan", naming=("--rate",))
    refused("demo", "--rate", "nan", naming=("--rate",))


@pytest.mark.slow
def test_live_replaces_nothing_but_its_own(tmp_path, ramp, imported):
    """All are refused before a node starts: the mark is an input that the recording lacks."""
    folder = tmp_path / "folder"
    folder.mkdir()
    files = [folder / name for name in ("folder.mcap", "metadata.yaml", "other.mcap")]
    for file in files:
        file.write_text("precious")
    live = ("live", ramp, *MODEL, "--headless", "--force")
    refused(*live, "--rrd", folder, naming=("folder: is a folder; name a file",))
    refused(*live, "--record", folder, naming=("other.mcap", "another folder"))
    files.pop().unlink()
    refused(*live[:-1], "--record", folder, naming=("--force",))
    files[0].rename(folder / "some.mcap")
    refused(*live, "--record", folder, naming=("metadata.yaml", "some.mcap"))
    refused(*live, "--record", folder / "some.mcap", naming=("some.mcap",))
    assert {file.read_text() for file in folder.iterdir()} == {"precious"}
    bag = imported / ramp.stem
    before = (bag / f"{bag.name}.mcap").read_bytes()
    for run in (bag, bag / f"{bag.name}.mcap"):
        refused("live", run, *live[2:], "--record", bag, naming=("is an input",))
        refused("live", run, *live[2:], "--rrd", bag / f"{bag.name}.mcap", naming=("is an input",))
    assert (bag / f"{bag.name}.mcap").read_bytes() == before


@pytest.mark.slow
def test_live_records_over_its_own_bag(tmp_path, ramp):
    folder = tmp_path / "bag"
    folder.mkdir()
    live = ("live", ramp, *MODEL, "--headless", "--rate", "10", "--to", "1", "--record", folder)
    done(*live)
    refused(*live, naming=("--force",))
    done(*live, "--force")
    assert sorted(path.name for path in folder.iterdir()) == ["bag.mcap", "metadata.yaml"]
    assert (folder / "bag.mcap").stat().st_size > 10_000


@pytest.mark.slow
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


@pytest.mark.slow
def test_json_replaces_no_input(tmp_path, ramp):
    run = shutil.copy(ramp, tmp_path / "run.CSV")
    model = tmp_path / "model.yaml"
    done("add", "backlash", *MODEL, "-o", model)
    link = tmp_path / "link.json"
    link.symlink_to(run)
    for output in (run, model, link):
        for verb in ("compare", "live"):
            refused(verb, run, "--model", model, "--json", output, naming=("no JSON file", str(output)))
    notes = tmp_path / "notes.txt"
    notes.write_text("of last week\n")
    refused("compare", run, "--model", model, "--json", notes, naming=("no JSON file",))
    assert run.read_bytes() == ramp.read_bytes() and "backlash" in model.read_text()
    assert notes.read_text() == "of last week\n"


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
    result = subprocess.run([sys.executable, "-c", start], capture_output=True, text=True, timeout=ENDING, check=False)
    assert result.returncode == 1
    assert result.stderr.startswith("internal error: RuntimeError: broken on purpose")
    assert "Traceback" not in result.stderr
