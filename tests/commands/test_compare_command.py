"""``compare`` as its user meets it: what it takes, what it prints, and where it says that a model fails."""

import json
import re
import shutil

from ema_bench_replay.bags.bag_writer import write_mcap
from ema_twin_sim.commands.inputs import load_runs
from ema_twin_sim.model import load_model, save_model
from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.virtual_bench import virtual_bench
from tests.command_line import MODEL, done, refused
from tests.rrd_content import RrdContent


def test_compare_takes_csv_mcap_folder_and_folder_of_folders_alike(tmp_path, imported, ramp):
    forms = (ramp, imported / ramp.stem, imported / ramp.stem / f"{ramp.stem}.mcap")
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
    assert re.search(r"there.*elsewhere(.*\n)+?.*\d mA │ +[\d.]+ mA│", text)
    assert "NaN" not in text and "nan" not in text


def test_errors_in_a_noise_as_large_as_the_signal_are_no_good_news(tmp_path, ramp):
    model = load_model("polito_bench").with_value("sensors.current_noise", 5.0)
    save_model(model.with_value("sensors.output_encoder_noise", 1e5), tmp_path / "noisy.yaml")
    text = done("compare", ramp, "--model", tmp_path / "noisy.yaml", "--input", "current").stdout
    assert "nothing left to find" not in text
    assert "which hides any error" in text


def test_cutting_in_time(tmp_path, ramp):
    cut = ("--from", "2", "--to", "4")
    done("compare", ramp, "--model", "polito_bench", *cut, "--json", tmp_path / "c.json")
    assert json.loads((tmp_path / "c.json").read_text())["recordings"][0]["samples"] == 1001
    refused("compare", ramp, "--model", "polito_bench", "--from", "90", naming=(ramp.stem,))


def test_a_recording_given_twice_counts_once(tmp_path, imported, traces, ramp):
    again = (imported, imported / ramp.stem, imported / ramp.stem / f"{ramp.stem}.mcap")
    result = done("compare", *again, *MODEL, "--to", "1", "--json", tmp_path / "c.json")
    assert len(json.loads((tmp_path / "c.json").read_text())["recordings"]) == len(traces)
    assert result.stderr.count("warning:") == 1 and "more than once" in result.stderr


def test_short_cuts(ramp):
    refused("compare", ramp, *MODEL, "--to", "0", naming=(ramp.name, "1 sample"))
    text = done("compare", ramp, *MODEL, "--to", "0.317").stdout
    assert "too short" in text and "160 samples" in text
    assert "Where the model fails" in done("compare", ramp, *MODEL, "--to", "0.319").stdout


def test_samples_too_few_to_tell_anything(tmp_path, ramp):
    header, *rows = ramp.read_text().splitlines()
    short = tmp_path / "short.CSV"
    short.write_text("\n".join([header, *rows[:2]]) + "\n")
    text = done("compare", short, *MODEL).stdout
    assert "too short to be sure" in text and "160 samples" in text and "nothing left" not in text


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
    refused("compare", folder, *MODEL, "--json", folder / "one.CSV", naming=("no JSON file",))


def test_where_shows_what_tells_and_the_best_of_each_signal(tmp_path, ramp):
    text = done("compare", ramp, *MODEL, "--json", tmp_path / "c.json").stdout
    where = json.loads((tmp_path / "c.json").read_text())["where"]
    rows = [line for line in text.splitlines() if " % " in line and "│" in line]
    shares = [int(line.split("%")[0].split()[-1]) for line in rows]
    telling = [found for found in where if found["share"] >= 0.1]
    assert len(shares) < len(where) and len(shares) >= len(telling) and max(shares) >= 10
    assert sum(share < 10 for share in shares) <= len({found["signal"] for found in where})


def test_orders_and_constants_have_no_place(tmp_path, stock):
    model = stock.with_effect("sun_runout", {"torque": 0.03}).with_effect("constant_load", {"torque": 0.05})
    write_mcap(virtual_bench(model, parse_command("ramp:0.05"), 8.0), tmp_path / "ramp.mcap")
    text = done("compare", tmp_path / "ramp.mcap", *MODEL).stdout
    rows = [line for line in text.splitlines() if "%" in line and "│" in line]
    rows = [[cell.strip() for cell in line.split("│")[1:-1]] for line in rows]
    for variable, place in (("order", "of it repeat"), ("constant", "everywhere")):
        assert all(row[-2:] == ["–", "–"] for row in rows if row[1] == variable)
        assert any(place in row[4] for row in rows if row[1] == variable), variable


def test_under_the_current_what_drifts_is_left_out(tmp_path, ramp):
    text = done("compare", ramp, *MODEL, "--input", "current", "--json", tmp_path / "c.json").stdout
    assert "drift and are left out" in text and "unexplained torque" in text
    assert "motor position" not in text.split("Where")[0] and "error of the speed" not in text
    assert "motor_position" in json.loads((tmp_path / "c.json").read_text())["overall"]


def test_damaged_but_readable_input_is_used_with_a_warning(tmp_path, ramp, imported):
    torn = tmp_path / "torn.CSV"
    text = ramp.read_bytes()
    torn.write_bytes(text[: len(text) // 2 + 7])
    cut = tmp_path / "cut.mcap"
    whole = (imported / ramp.stem / f"{ramp.stem}.mcap").read_bytes()
    cut.write_bytes(whole[: len(whole) * 2 // 3])
    for damaged in (torn, cut):
        result = done("compare", damaged, "--model", "polito_bench", "--json", tmp_path / "c.json")
        assert len([line for line in result.stderr.splitlines() if line.startswith("warning:")]) == 1
        content = json.loads((tmp_path / "c.json").read_text())
        assert len(content["warnings"]) == 1
        assert 3000 < content["recordings"][0]["samples"] < 8000
        line = refused("compare", damaged, "--model", "polito_bench", "--strict", naming=(damaged.name,))
        assert line == f"error: {content['warnings'][0]} (--strict refuses this; without it, it is only a warning)"
        assert "can be used" in line


def test_recordings_of_one_name_are_told_apart(tmp_path, ramp):
    """By their folders, and by numbers where these have one name too; also in the views, which go by names."""
    files = [tmp_path / folder / "run.CSV" for folder in ("d1", "d2", "a/d3", "b/d3")]
    for file in files:
        file.parent.mkdir(parents=True)
        shutil.copy(ramp, file)
    assert [run.name for run in load_runs([*files, ramp])] == ["run (d1)", "run (d2)", "run (3)", "run (4)", ramp.stem]
    done("compare", *files[:2], *MODEL, "--to", "1", "--rrd", tmp_path / "run.rrd")
    shown = RrdContent(tmp_path / "run.rrd")
    for folder in ("d1", "d2"):
        time, _ = shown.curve(rf"/compare/run\ \({folder}\)/current/curves/measured")
        assert len(time) == len(set(time)) == 501


def test_a_model_that_is_closer_in_another_signal_alone_is_said_to_be(tmp_path, ramp):
    """An encoder's eccentricity that is not there takes nothing from the torque."""
    right = load_model("polito_bench").with_effect("backlash", {"width": 0.004})
    save_model(right.with_effect("encoder_eccentricity", {"amplitude": 0.001}), tmp_path / "bent.yaml")
    save_model(right, tmp_path / "right.yaml")
    models = ("--model", tmp_path / "bent.yaml", "--model", tmp_path / "right.yaml")
    said = " ".join(done("compare", ramp, *models, "--input", "current").stdout.split())
    assert re.search(r"Model right: .* in the unexplained torque; ≥ [\d.]+ × closer in the encoder difference\.", said)
