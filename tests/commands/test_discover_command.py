"""What a person sees of discover and diagnose: verdicts in words, files that other tools open, and refusals."""

import json
import math
import re
import shlex
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from ema_bench_replay.bags.bag_writer import write_mcap
from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from ema_twin_sim.commands.demo import moments_of, switched_off
from ema_twin_sim.commands.discover import compare_command
from ema_twin_sim.commands.inputs import refuse_inputs
from ema_twin_sim.commands.shown_search import moved_slightly
from ema_twin_sim.comparison.compare import compare
from ema_twin_sim.discovery.diagnose import Ranked
from ema_twin_sim.model import load_model
from ema_twin_sim.quantities import estimate
from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.virtual_bench import virtual_bench
from ema_twin_sim.words import sentences as wording
from ema_twin_sim.words.findings import Findings
from ema_twin_sim.words.ranking import worth_showing
from tests.command_line import LONGEST, MODEL, done, refused

HIDDEN = ("backlash", "stribeck_friction")


@pytest.fixture(scope="module")
def found(tmp_path_factory, traces):
    """One run of the command on the project's recordings: its folder, what it printed, and its errors."""
    folder = tmp_path_factory.mktemp("discover")
    outputs = ("-o", folder / "new.yaml", "--json", folder / "found.json", "--evidence", folder / "found.mcap")
    page = ("--report", folder / "found.html")
    result = done("discover", *traces, *MODEL, "--to", 10, *outputs, *page)
    return folder, result.stdout, result.stderr


@pytest.fixture(scope="module")
def content(found):
    return json.loads((found[0] / "found.json").read_text())


@pytest.mark.slow
def test_it_names_the_hidden_effects_in_one_sentence(found, content):
    assert found[1].startswith("Your model lacks backlash and Stribeck friction.\n")
    assert content["verdict"] == "explained" and sorted(content["added"]) == sorted(HIDDEN)
    for words in ("runner-up", "Parameters, with standard errors", " ± ", "The search ended", "compare"):
        assert words in found[1]
    assert "nan" not in found[1].lower()


@pytest.mark.slow
def test_its_report_tells_the_same(found):
    text = (found[0] / "found.html").read_text()
    assert "<h1>polito_bench lacks backlash and Stribeck friction.</h1>" in text
    assert re.search(r"Probability of each: backlash 98\s% and Stribeck friction 98\s%", text)
    assert "found.html" in found[1]


@pytest.mark.slow
def test_a_log_holds_no_bars(found):
    progress = [line for line in found[2].splitlines() if not line.startswith("warning: ")]
    assert all(re.fullmatch(r"\d+ s: .* …", line) for line in progress)


@pytest.mark.slow
def test_its_json_has_what_the_design_lists(content):
    for step in content["steps"]:
        assert step["rmse_before"] > 0.0 and step["rmse_after"] > 0.0
    assert set(HIDDEN) <= {step["effect"] for step in content["steps"]}
    assert set(content["parameters"]) == set(HIDDEN)
    width = content["parameters"]["backlash"]["width"]
    assert width["unit"] == "rad" and width["value"] == pytest.approx(0.004, rel=0.02) and width["std"] > 0.0
    inertia = content["constants"]["machine"]["motor_inertia"]
    assert inertia["nominal"] == pytest.approx(7.7e-4) and inertia["unit"] == "kg m^2" and inertia["std"] > 0.0
    assert (content["model"], content["machine"]) == ("polito_bench", "politecnico_ema")
    for name in ("groups", "depends_on", "next_recording", "warnings", "recordings"):
        assert name in content


@pytest.mark.slow
def test_the_new_model_is_better_and_holds_the_refitted_constants(found, content, traces, stock):
    model = load_model(found[0] / "new.yaml")
    assert set(HIDDEN) <= set(model.effects)
    refitted = content["constants"]["machine"]["motor_inertia"]["value"]
    assert model.value("machine.motor_inertia") == pytest.approx(refitted)
    recordings = [load(trace) for trace in traces if "ramp" in trace.name or "triangle" in trace.name]
    before, after = (compare(recordings, each).overall for each in (stock, model))
    for name in ("current", "output_position", "unexplained_torque"):
        assert after[name]["rmse"] < 0.6 * before[name]["rmse"], name


@pytest.mark.slow
def test_evidence_in_the_json(found, content):
    assert (found[0] / "found.json").stat().st_size < 2e6
    steps = content["evidence"]["steps"]
    taken = [step for step in steps if step["taken"]]
    assert any("backlash" in step["title"] for step in taken) and not steps[-1]["taken"]
    for step in steps:
        shares = [view["share"] for view in step["views"] if view["left_over"] == step["views"][0]["left_over"]]
        assert shares == sorted(shares, reverse=True)
        for curve in (curve for view in step["views"] for curve in view["curves"]):
            assert len(curve["x"]) == len(curve["median"]) <= 200
            assert all(np.less_equal(curve["lower"], curve["median"]))
            assert all(np.less_equal(curve["median"], curve["upper"]))
        assert {entry["order"] for entry in step["orders"]["named"]} >= {1.0, 15.75, 24.0}
    backlash = next(step for step in taken if "backlash" in step["title"])["views"][0]
    assert backlash["left_over"] == "encoder_difference" and backlash["unit"] == "rad"
    height = {
        name: np.median(np.abs(np.concatenate([c["median"] for c in backlash["curves"] if c["name"] == name])))
        for name in ("before", "after")
    }
    assert height["before"] > 5e-4 and height["after"] < 2e-5
    stribeck = next(step for step in taken if "stribeck_friction" in step["title"])["views"][0]
    assert (stribeck["left_over"], stribeck["against"]) == ("torque", "speed")
    assert set(content["evidence"]["rmse"]["recordings"]) == {r["name"] for r in content["unseen"]["recordings"]}


@pytest.mark.slow
def test_the_evidence_mcap_holds_what_each_step_left_over(found, traces):
    with (found[0] / "found.mcap").open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        summary = reader.get_summary()
        topics = {channel.topic for channel in summary.channels.values()}
        assert {schema.name for schema in summary.schemas.values()} == {"sensor_msgs/msg/JointState"}
        assert all("offered_qos_profiles" in channel.metadata for channel in summary.channels.values())
        place = next(topic.rpartition("/")[0] for topic in topics if "stribeck_friction/BancoEMA_ramp" in topic)
        wanted = [f"{place}/torque", f"{place}/left_over"]
        messages = {topic: [] for topic in wanted}
        for _, channel, _, message in reader.iter_decoded_messages(topics=wanted):
            messages[channel.topic].append(message)
    for trace in traces:
        name = trace.stem.replace(".", "_")
        for series in ("torque", "left_over", "encoder_difference"):
            assert any(topic.endswith(f"backlash/{name}/{series}") for topic in topics)
    torque, left = (messages[topic] for topic in wanted)
    assert torque[0].name == ["measured", "model before", "model after"] and len(torque) == len(left) > 500
    assert left[0].name[:2] == ["left over before", "left over with stribeck_friction"]
    stamps = [m.header.stamp.sec + 1e-9 * m.header.stamp.nanosec for m in torque]
    assert np.all(np.diff(stamps) > 0.0)
    efforts = np.array([m.effort for m in torque])
    assert np.allclose(efforts[:, [0]] - efforts[:, 1:], [m.effort[:2] for m in left])


@pytest.mark.slow
def test_evidence_is_no_recording(found):
    line = refused("info", found[0] / "found.mcap", naming=("evidence", f"rerun {found[0] / 'found.mcap'}"))
    assert len(line) < 400


@pytest.mark.slow
def test_rerun_opens_the_evidence(found, tmp_path):
    script = (
        "import sys, rerun as rr\n"
        "rr.init('evidence'); rr.save(sys.argv[2]); rr.log_file_from_path(sys.argv[1]); rr.disconnect()\n"
    )
    arguments = [found[0] / "found.mcap", tmp_path / "found.rrd"]
    subprocess.run([sys.executable, "-c", script, *arguments], check=True, capture_output=True, timeout=LONGEST)
    assert b"left_over/effort" in (tmp_path / "found.rrd").read_bytes()


def record(folder, model, seconds=8.0):
    """Recordings of a bench that is the model."""
    for seed, command in enumerate(("triangle:0.03:1.3", "sine:0.04:0.4")):
        name = command.partition(":")[0]
        write_mcap(virtual_bench(model, parse_command(command), seconds, seed=seed), folder / f"{name}.mcap")
    return sorted(folder.glob("*.mcap"))


@pytest.mark.slow
def test_a_diagnosis_of_two_effects(tmp_path, stock):
    hidden = {"cogging": {"torque": 0.03, "phase": 0.4}, "stribeck_friction": {"torque": 0.06, "speed": 1.5}}
    model = stock
    for id, parameters in hidden.items():
        model = model.with_effect(id, parameters)
    runs = record(tmp_path, model)
    outputs = ("--json", tmp_path / "d.json", "--evidence", tmp_path / "d.mcap")
    text = done("diagnose", *runs, *MODEL, *outputs).stdout
    content = json.loads((tmp_path / "d.json").read_text())
    assert content["model"] == "polito_bench" and content["recordings"] == [run.stem for run in runs]
    assert content["verdict"] in hidden and text.startswith("Your model lacks ")
    assert all(words in text.splitlines()[0] for words in ("cogging", "Stribeck friction"))
    ranking = content["ranking"]
    assert {entry["effect"] for entry in ranking if entry["found"]} == set(hidden)
    probabilities = [entry["probability"] for entry in ranking]
    assert probabilities == sorted(probabilities, reverse=True)
    assert content["none"] < 0.05 and content["unknown"] < 0.05
    for entry in ranking:
        if entry["found"]:
            assert entry["probability"] > 0.9 and entry["error_removed"] > 0.1
            for name, value in hidden[entry["effect"]].items():
                assert entry["parameters"][name]["value"] == pytest.approx(value, rel=0.2)
                assert entry["parameters"][name]["std"] > 0.0
    for name in ("groups", "depends_on", "next_recording", "warnings", "evidence"):
        assert name in content
    assert "in addition to all others found" in " ".join(text.split())
    assert "several may be missing at once" in " ".join(text.split())
    assert "█" in text and (tmp_path / "d.mcap").stat().st_size > 10_000


def test_nothing_hidden_is_nothing_found_and_the_refitted_model_is_written(tmp_path, stock):
    runs = record(tmp_path, stock)
    done("diagnose", *runs, *MODEL, "--json", tmp_path / "d.json")
    content = json.loads((tmp_path / "d.json").read_text())
    assert content["verdict"] == "none" and content["none"] > 0.9
    outputs = ("-o", tmp_path / "new.yaml", "--json", tmp_path / "n.json")
    text = done("discover", *runs, *MODEL, *outputs).stdout
    assert text.startswith("These recordings show nothing missing.")
    assert "efitted" in text and "within standard errors: " in text
    assert json.loads((tmp_path / "n.json").read_text())["added"] == []
    assert set(load_model(tmp_path / "new.yaml").effects) == set(stock.effects)


@pytest.mark.slow
def test_what_is_unknown_is_told_with_its_size_and_place(tmp_path, bench_cases):
    runs = sorted((bench_cases / "dev13" / "train").glob("*.CSV"))
    outputs = ("-o", tmp_path / "same.yaml", "--json", tmp_path / "u.json", "--report", tmp_path / "u.html")
    text = done("discover", *runs, *MODEL, *outputs).stdout
    told = re.search(
        r"depends on the output's position: from (-\d\d\.\d) mN m at 2\.\d+ rad "
        r"to (\d\d\.\d) mN m at 2\.8\d rad, moving forward\.\n",
        text,
    )
    assert told and float(told[1]) == pytest.approx(-23.0, abs=3.0) and float(told[2]) == pytest.approx(15.0, abs=3.0)
    content = json.loads((tmp_path / "u.json").read_text())
    assert content["depends_on"] == ["output_position"] and content["left_over"] in text
    assert content["left_over"] in (tmp_path / "u.html").read_text().replace("\N{NO-BREAK SPACE}", " ")
    assert f"{tmp_path / 'same.yaml'} equals polito_bench" in text
    suggested = next(line for line in text.splitlines() if line.startswith("  ema-twin compare"))
    assert suggested.count("--model") == 1 and "same.yaml" not in suggested


@pytest.mark.parametrize("verb", ["discover", "diagnose"])
def test_what_is_refused(tmp_path, traces, verb):
    outputs = ("-o", tmp_path / "new.yaml") if verb == "discover" else ()
    refused(verb, tmp_path / "none.mcap", *MODEL, *outputs, naming=("none.mcap",))
    refused(verb, traces[0], *MODEL, *outputs, "--without", "backlsh", naming=("--without", "did you mean 'backlash'"))
    refused(verb, traces[0], "--model", "polito_bensh", *outputs, naming=("polito_bench",))
    refused(verb, traces[0], *MODEL, *outputs, "--with", tmp_path / "no.py", naming=("no.py",))
    refused(verb, traces[0], *MODEL, *outputs, "--evidence", tmp_path / "e.txt", naming=("e.txt", ".mcap"))
    (tmp_path / "e.mcap").write_text("kept")
    refused(verb, traces[0], *MODEL, *outputs, "--evidence", tmp_path / "e.mcap", naming=("exists", "--force"))
    assert (tmp_path / "e.mcap").read_text() == "kept" and not (tmp_path / "new.yaml").exists()


def test_a_model_that_exists_is_kept(tmp_path, traces):
    (tmp_path / "new.yaml").write_text("kept")
    refused("discover", traces[0], *MODEL, "-o", tmp_path / "new.yaml", naming=("exists", "--force"))
    refused("discover", traces[0], *MODEL, "-o", tmp_path / "new.txt", naming=(".yaml",))
    assert (tmp_path / "new.yaml").read_text() == "kept"


def test_one_file_for_two_outputs_is_refused(tmp_path):
    with pytest.raises(InputError, match="another output too"):
        refuse_inputs([], tmp_path / "a.json", None, tmp_path / "b" / ".." / "a.json")


@pytest.mark.parametrize(
    ("number", "text"),
    [
        ((0.003996967, 9.06e-8, "rad"), "3.99697 ± 0.00009 mrad"),
        ((-0.02745, 0.000123, "N m"), "-27.45 ± 0.12 mN m"),
        ((0.0, 0.001, "N m"), "0.0 ± 1.0 mN m"),
        ((7.243e-4, 2.89e-6, "kg m^2"), "(7.243 ± 0.029)e-4 kg m^2"),
        ((0.8427, 0.0999, "1"), "0.84 ± 0.10"),
        ((12.3, 40.0, "1"), "12 ± 40"),
        ((7.7e-4, None, "kg m^2"), "0.00077 kg m^2"),
        ((0.02, math.nan, "N m"), "20.0 mN m"),
    ],
)
def test_estimates_have_the_digits_that_mean_something(number, text):
    assert estimate(*number) == text


def test_verdicts_in_words():
    def sentence(verdict, *added, **found):
        return wording.verdict_of(Findings(verdict, added, **found))

    three = sentence("explained", "backlash", "stribeck_friction", "cogging")
    assert three.endswith("backlash, Stribeck friction and cogging.")
    assert "depends on the output's position." in sentence("unknown", depends_on=("output_position",))
    assert sentence("unknown", depends_on=("time",), left_over="from 1 to 2").endswith("depends on time: from 1 to 2.")
    assert sentence("unknown", "cogging").startswith("Your model lacks cogging. A further error remains")
    assert "gravity load or constant load" in wording.groups_sentence([["gravity_load", "constant_load"]])
    assert wording.effect_words("time#3") == "any dependence on time"


def test_the_verdict_tells_on_which_side_another_friction_is():
    """A model with viscous friction was said to lack viscous friction."""

    def sentence(**sides):
        added = {name: {"effect": "viscous_friction", "options": {"side": side}} for name, side in sides.items()}
        return wording.verdict_of(Findings("explained", ("viscous_friction",), parameters=added))

    lacks = "Your model lacks viscous friction"
    assert sentence(viscous_friction_2="output") == f"{lacks} on the output's side."
    assert sentence(viscous_friction_2="motor") == f"{lacks} on the motor's side."
    assert (
        sentence(viscous_friction="motor", viscous_friction_2="output")
        == f"{lacks} on the motor's and the output's side."
    )
    assert sentence(viscous_friction="motor") == f"{lacks}."


def test_the_command_to_see_how_far_off_it_is(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    folder = Path("my runs")
    folder.mkdir()
    files = [folder / f"{k}.CSV" for k in range(4)]
    for file in files:
        file.touch()
    models = ["polito_bench", Path("a new.yaml")]
    of_all = "ema-twin compare 'my runs'/*.CSV --model polito_bench --model 'a new.yaml'"
    assert compare_command(files, models) == of_all
    assert compare_command([folder], ["polito_bench"]) == "ema-twin compare 'my runs' --model polito_bench"
    assert compare_command([folder], ["emps"], import_map="emps").endswith("--model emps --map emps")
    (folder / "other.CSV").touch()
    mixed = [*files, folder / "5.mcap"]
    for given in (files, mixed, [Path(f"{k}.CSV") for k in range(4)]):
        command = compare_command(given, models, [Path("my effect.py")])
        assert shlex.split(command)[2:-6] == list(map(str, given)) and command.endswith(" --with 'my effect.py'")


@pytest.mark.parametrize(
    ("gain", "text"),
    [
        (-1.0, "too small a gain for its parameters"), (0.085, "less than 1 % of the step's gain"),
        (84.4, "84 % of the step's gain"), (99.7, "as much gain as the step's"),
        (130.0, "as much gain as the step's"),
    ],
)  # fmt: skip
def test_the_runner_up_in_words(gain, text):
    tried = ({"names": ["backlash"], "gain": 100.0}, {"names": ["encoder_delay"], "gain": gain})
    assert wording.why_step(SimpleNamespace(action="add", instance="backlash", tried=tried)) == f"encoder delay, {text}"


def test_constants_that_moved_within_their_errors_are_told():
    def held(value, std):
        return {"value": value, "nominal": 1.0, "std": std, "unit": "kg m^2"}

    constants = {
        "machine": {"motor_inertia": held(1.004, 0.01), "output_inertia": held(1.2, 0.01)},
        "transmission": {"contact_damping": held(1.0, 3e4)},
        "viscous_friction": {"coefficient": held(0.998, 0.01)},
        "coulomb_friction": {"torque": held(1e-3, 2.0)},
    }
    slightly, unknown = moved_slightly(SimpleNamespace(constants=constants))
    assert slightly == ["motor inertia +0.4 %", "viscous friction -0.2 %"]
    assert unknown == ["Coulomb friction = 0.0 ± 2.0 kg m^2"]


def test_of_what_is_unlikely_three_are_shown():
    def ranked(probability, found=False):
        return Ranked("backlash", {}, probability, None, {}, found)

    likely = [ranked(0.6, found=True), ranked(0.4), ranked(0.0, found=True)]
    ranking = (*likely[:2], *(ranked(1e-4 * k) for k in range(5)), likely[2])
    shown, left_out = worth_showing(ranking)
    assert shown[:3] == likely and len(shown) == 6 and left_out == 2
    assert worth_showing(likely) == (likely, 0)


def test_the_demo_switches_on_what_was_found(stock):
    found = stock.with_effect("backlash").with_effect("cogging", {"torque": 0.02}, {"order": "12"})
    beside = switched_off(stock, found.with_value("machine.motor_inertia", 8e-4))
    assert [name for name, held in beside.effects.items() if not held.enabled] == ["backlash", "cogging"]
    assert beside.effects["cogging"].options["order"] == "12"
    assert beside.value("machine.motor_inertia") == stock.value("machine.motor_inertia")
    assert moments_of(["backlash", "cogging"], 20.0) == {"backlash": 7.0, "cogging": 14.0}
    assert max(moments_of([str(k) for k in range(6)], 20.0).values()) < 20.0
