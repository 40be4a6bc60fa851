"""Sweeps: models that are simulated and searched, detection limits beside the bound of Cramér and Rao."""

import base64
import json
import re
from dataclasses import replace

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_twin_sim.campaign.results import DONE
from ema_twin_sim.campaign.sweep import VERB, Study, Varied, _unit, grid, sample, swept, with_settings
from ema_twin_sim.campaign.sweep_points import detection_limit, swept_points
from ema_twin_sim.model import load_model
from ema_twin_sim.quantities import quantity
from ema_twin_sim.report.sweep_page import write_sweep_page
from ema_twin_sim.words.sweep import columns, meaning, point_cells
from tests.command_line import done_here, refused, twin
from tests.stored_rows import complete

STUDY = Study("polito_bench", ("triangle:0.1:0.5", "triangle:0.03:1"), 4.0)


@pytest.fixture(scope="module")
def frictions():
    """Stribeck friction from nothing that could be told to plenty, each twice."""
    points = grid([Varied.of("stribeck_friction.torque=0.001:0.1:3:log")], STUDY, 2)
    return swept_points(complete(swept(point, STUDY) for point in points))


def test_a_number_takes_its_values():
    assert Varied.of("a.b=1:3:3").at(np.linspace(0, 1, 3)).tolist() == [1.0, 2.0, 3.0]
    assert Varied.of("a.b=1:100:3:log").at(np.linspace(0, 1, 3)) == pytest.approx([1.0, 10.0, 100.0])
    assert Varied.of("a.b=2") == Varied("a.b", 2.0, 2.0, 1)


@pytest.mark.parametrize("text", ["a.b", "a.b=1:2", "a=1:2:3", "a.b=3:1:2", "a.b=0:1:2:log", "a.b=1:2:3:lin", "a.b=x"])
def test_what_is_no_range_is_refused(text):
    with pytest.raises(InputError, match="--vary"):
        Varied.of(text)


def test_too_many_points_are_refused_before_any_is_made():
    varied = [Varied("backlash.width", 0.001, 0.002, 100_000), Varied("constant_load.torque", 0.1, 0.2, 100_000)]
    with pytest.raises(InputError, match=r"more than 1e[+]06 points"):
        grid(varied, Study("polito_bench", ("ramp:0.05",), 2.0), 1)


def test_points_of_two_studies_have_names_of_their_own():
    varied = [Varied("backlash.width", 0.001, 0.002, 2)]
    one, other = (grid(varied, Study("polito_bench", ("ramp:0.05",), seconds), 1) for seconds in (2.0, 3.0))
    assert {point.name for point in one}.isdisjoint(point.name for point in other)


def test_a_number_of_a_linear_machine_has_its_unit():
    carriage = load_model("emps").with_effect("stribeck_friction", {"torque": 1.0})
    assert _unit(carriage, "stribeck_friction.torque") == "N"
    assert _unit(load_model("polito_bench"), "machine.motor_inertia") == "kg m^2"


def test_numbers_of_the_model_are_changed_and_effects_that_it_lacks_are_added():
    model = load_model("polito_bench")
    settings = [("coulomb_friction.torque", 0.1), ("machine.motor_inertia", 1e-3), ("backlash.width", 2e-3)]
    true, lacked = with_settings(model, settings)
    assert true.effects["coulomb_friction"].parameters["torque"] == 0.1
    assert true.value("machine.motor_inertia") == 1e-3
    assert lacked == {"backlash": {"width": 2e-3}} and true.effects["backlash"].parameters["width"] == 2e-3
    with pytest.raises(InputError, match=r"did you mean 'backlash\.width'"):
        with_settings(model, [("backlsh.width", 1.0)])


def test_points_are_all_combinations_or_a_sample_of_them():
    varied = [Varied.of("backlash.width=0.001:0.002:3"), Varied.of("coulomb_friction.torque=0.05:0.1:2")]
    points = grid(varied, STUDY, 2)
    assert len(points) == 12 and len({point.key for point in points}) == 12
    drawn = sample(varied, STUDY, 50, 1, 1)
    widths = np.array([point.settings[0][1] for point in drawn])
    assert widths.min() < 0.00105 and widths.max() > 0.00195  # a Latin hypercube leaves no part out
    assert [point.key for point in drawn] == [point.key for point in sample(varied, STUDY, 50, 1, 1)]


def test_a_size_is_named_from_its_detection_limit_on(frictions):
    least, _, most = frictions
    assert least.lacked == ("stribeck_friction",) and (least.named, most.named) == (0, 2)
    limit = detection_limit(frictions)
    assert limit.path == "stribeck_friction.torque" and limit.named in (0.01, 0.1)
    assert 1e-4 < limit.bound <= limit.named  # nothing is named that could not be told


def test_no_estimate_is_better_than_its_bound(frictions):
    """The search tells errors of the bound's size or above, and it errs by what it tells."""
    torque = frictions[-1].numbers[0]
    assert torque.path == "stribeck_friction.torque" and torque.value == pytest.approx(0.1)
    assert 0.3 * torque.bound < torque.told < 20.0 * torque.bound
    assert torque.scatter < 4.0 * torque.told


def test_an_angle_that_is_found_a_turn_away_is_right():
    true, found = -3.1, 3.1
    row = {"task": VERB, "status": DONE, "verdict": "explained", "settings": [], "lacked": [], "missing": [],
           "bounds": [{"owner": "cogging", "name": "phase", "unit": "rad", "value": true, "std": 0.1}],
           "parameters": [{"owner": "cogging", "name": "phase", "value": found, "std": 0.1}]}  # fmt: skip
    ((phase,),) = (point.numbers for point in swept_points([row]))
    assert phase.scatter == pytest.approx(2.0 * np.pi - 6.2)


def test_a_limit_is_of_the_number_that_was_varied_and_none_where_nothing_bounds_it(frictions):
    path = "stribeck_friction.torque"
    other = replace(frictions[0].numbers[0], path="machine.motor_inertia", bound=1e-5)
    swapped = [replace(point, numbers=(other, *point.numbers)) for point in frictions]
    assert detection_limit(swapped).bound == detection_limit(frictions).bound
    held = [replace(point, numbers=tuple(n for n in point.numbers if n.path != path)) for point in frictions]
    assert detection_limit(held) is None


def test_longer_recordings_tell_more():
    """Four times the time halves the bound of what nothing else is known of."""
    stds = []
    for seconds in (4.0, 16.0):
        study = Study("polito_bench", STUDY.commands, seconds, search=False)
        (point,) = grid([Varied.of("stribeck_friction.torque=0.1")], study, 1)
        row = swept(point, study)
        assert row["status"] == DONE and "verdict" not in row
        stds.append(next(b["std"] for b in row["bounds"] if (b["owner"], b["name"]) == ("stribeck_friction", "torque")))
    assert stds[1] / stds[0] == pytest.approx(0.5, abs=0.15)


def test_the_single_inertia_of_a_linear_machine_is_bounded_too():
    """Its path is not that of its constant; and the true value is that of the simulated machine."""
    study = Study("emps", ("triangle:0.1:1",), 3.0, search=False)
    row = swept(*grid([Varied.of("machine.motor_inertia=60")], study, 1), study)
    assert row["status"] == DONE, row["message"]
    inertia, *_ = row["bounds"]
    assert (inertia["owner"], inertia["name"], inertia["value"], inertia["unit"]) == ("machine", "inertia", 60.0, "kg")
    assert 0.0 < inertia["std"] < 6.0


def charts_of(page):
    """The charts of a page, the arrays of their traces as lists."""
    charts = json.loads(re.search(r'<script type="application/json" id="charts">(.*?)</script>', page)[1])
    for trace in (trace for chart in charts for trace in chart["traces"]):
        for name in trace.keys() & {*"xyz"}:
            trace[name] = np.frombuffer(base64.b64decode(trace[name]["bdata"]), "<f4").tolist()
    return charts


def test_a_page_shows_curve_and_points(frictions, tmp_path):
    ratios = frozenset({"stribeck_friction.torque"})
    page = write_sweep_page(tmp_path / "s.html", frictions, detection_limit(frictions), ratios=ratios).read_text()
    assert [chart["layout"]["xaxis"]["type"] for chart in charts_of(page)] == ["log", "log"]
    assert [len(chart["traces"][0]["x"]) for chart in charts_of(page)] == [3, 3]
    assert "default-src 'none'" in page
    assert "no method can detect it reliably" in page and "0/2" in page and "2/2" in page


def test_points_drawn_anywhere_are_shown_where_they_are(frictions, tmp_path):
    second = [("viscous_friction.coefficient", value, "N m s/rad") for value in (0.03, 0.01, 0.02)]
    anywhere = [replace(point, settings=(*point.settings, one)) for point, one in zip(frictions, second, strict=True)]
    first, *_ = charts_of(write_sweep_page(tmp_path / "s.html", anywhere, None).read_text())
    (trace,) = first["traces"]
    assert trace["mode"] == "markers" and trace["y"] == pytest.approx([0.03, 0.01, 0.02])
    assert len(trace["text"]) == 3 and first["layout"]["yaxis"]["title"]["text"].endswith("[N m s/rad]")


def test_bounds_alone_fill_one_column_in_the_order_of_the_numbers(frictions):
    bare = [replace(point, searched=0, named=0) for point in frictions]
    assert columns(bare) == ("lowest error",) and "search" not in meaning(bare)
    point = bare[-1]
    size, held = point.settings[0], ("machine.motor_inertia", 1e-3, "kg m^2")
    (known,) = [n for n in point.numbers if n.path == size[0]]
    two = replace(point, settings=(held, size), numbers=(known,))
    assert point_cells(two, columns([two]))[-1] == f"-, {quantity(known.bound, known.unit)}"
    assert columns(frictions) == ("found", "lowest error", "reported error", "actual error")


@pytest.mark.slow
def test_points_that_are_all_refused_are_counted_and_end_as_refused_input_does(tmp_path):
    asked = ["sweep", "--model", "polito_bench", "-c", "triangle:0.1:0.5", "--seconds", "0.1", "--bounds-only",
             "--workers", "1", "-o", tmp_path / "r", "--vary", "coulomb_friction.torque=0.05:0.1:2"]  # fmt: skip
    ended = twin(*asked)
    assert ended.returncode == 2, ended.stderr
    assert "0 of 2 points were done; 2 were refused or failed" in ended.stdout
    again = twin(*asked)
    assert again.returncode == 2 and "0 of 2 points were done; 2 were refused or failed" in again.stdout
    page = tmp_path / "map.html"
    page.write_text("held")
    refused(*asked, "--page", page, naming=["exists already"])


@pytest.mark.parametrize(("page", "words"), [("pages.html", "is a folder"), ("map.txt", "name it .html")])
def test_a_page_that_cannot_be_is_refused_before_anything_is_simulated(page, words, tmp_path):
    (tmp_path / "pages.html").mkdir()
    asked = ["sweep", "--model", "polito_bench", "-c", "triangle:0.1:0.5", "-o", tmp_path / "r"]
    refused(*asked, "--vary", "coulomb_friction.torque=0.05:0.1:2", "--page", tmp_path / page, naming=[words])
    assert not (tmp_path / "r").exists()


@pytest.mark.slow
def test_the_verb_goes_on_where_it_was_and_maps_two_numbers(tmp_path, capsys):
    asked = ["sweep", "--model", "polito_bench", "-c", "triangle:0.1:0.5", "--seconds", "3", "--bounds-only",
             "--workers", "1", "-o", tmp_path / "r"]  # fmt: skip
    two = ["--vary", "coulomb_friction.torque=0.05:0.1:2", "--vary", "viscous_friction.coefficient=0.02:0.03:2"]
    done_here(*asked, *two, "--page", tmp_path / "map.html")
    page = (tmp_path / "map.html").read_text()
    maps = [chart["traces"][0] for chart in charts_of(page)]
    assert [(each["type"], len(each["z"])) for each in maps] == [("heatmap", 4)] * 2
    capsys.readouterr()
    done_here(*asked, *two, "--json", tmp_path / "again.json")
    told = capsys.readouterr().out
    assert "4 of 4 already have results" in told and "other sweeps" not in told
    points = json.loads((tmp_path / "again.json").read_text())
    assert len(points) == 4 and all(point["results"] == 1 and point["named"] is None for point in points)
    assert all(point["numbers"][0]["bound"] > 0.0 for point in points)
    done_here(*asked, "--vary", "coulomb_friction.torque=0.07")
    told = " ".join(capsys.readouterr().out.split())
    assert "holds 4 results of other sweeps" in told and "reported error" not in told
