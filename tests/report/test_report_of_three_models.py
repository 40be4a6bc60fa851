"""The report of three models: the one given, what was found, and that fitted; all told from one comparison."""

import json
from dataclasses import replace

import pytest
import rerun as rr

from ema_bench_replay.errors import InputError
from ema_twin_sim.comparison.compare import compare_all
from ema_twin_sim.model import save_model
from ema_twin_sim.quantities import quantity
from ema_twin_sim.report.content import ROLES, Content, shown
from ema_twin_sim.report.difference import check_same_effects, two_values
from ema_twin_sim.report.page import page
from ema_twin_sim.views.recording_views import write_views
from ema_twin_sim.words.findings import read_findings
from ema_twin_sim.words.fit_findings import read_fit_findings
from ema_twin_sim.words.sentences import fit_sentences
from tests.command_line import done, refused
from tests.report.test_report import FOUND, Read, charts_of, folder, models, recordings  # noqa: F401
from tests.rrd_content import RrdContent

TRUE = 0.004  # rad, the play of the bench
NAMES = ("polito_bench", "better", "fitted")
INERTIA = 7.8e-4  # kg m²; the bench's is 7.7e-4
WIDTH = {"value": TRUE, "std": 4e-6, "unit": "rad"}
FIT = {
    "parameters": {"backlash": {"effect": "backlash", "options": {}, "width": WIDTH}},
    "constants": {"machine": {"motor_inertia": {"value": INERTIA, "std": 1e-6, "unit": "kg m^2", "nominal": 7.7e-4}}},
    "rmse": {
        "current": {"before": 0.0055, "after": 0.0065, "noise_floor": 0.003, "unit": "A", "driven": False},
        "output_position": {"before": 1e-4, "after": 8e-6, "noise_floor": 7e-6, "unit": "rad", "driven": False},
    },
    "judged_on": "each recording with numbers fitted to the others",
}  # fmt: skip


@pytest.fixture(scope="module")
def three(stock):
    """The bench without its play; with nearly its width, as a search may find it; and with the true one."""
    found = stock.with_effect("backlash", {"width": 0.0037})
    fitted = stock.with_effect("backlash", {"width": TRUE}).with_value("machine.motor_inertia", INERTIA)
    return stock, replace(found, name="better"), replace(fitted, name="fitted")


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """What a search and a fit wrote."""
    place = tmp_path_factory.mktemp("three")
    width = {"value": 0.0037, "std": 2e-5, "unit": "rad"}
    found = {**FOUND, "groups": [], "parameters": {"backlash": {"effect": "backlash", "options": {}, "width": width}}}
    (place / "found.json").write_text(json.dumps({**found, "constants": {}}))
    (place / "fit.json").write_text(json.dumps(FIT))
    return place


@pytest.fixture(scope="module")
def content(three, recordings, told):  # noqa: F811
    given = shown(recordings[:2], three)
    findings, fit = read_findings(told / "found.json"), read_fit_findings(told / "fit.json")
    return Content(three, NAMES, given, None, findings, "1.2.3", fit=fit)


@pytest.fixture(scope="module")
def written(content):
    return page(content)


def test_one_table_has_all_errors_beside_one_noise_floor(written, three, recordings):  # noqa: F811
    text = Read(written).text
    head, table = text.split("RMSE, measured minus twin, all recordings")
    row = table.split("output position")[1].split("unexplained")[0]
    errors = [comparison.overall["output_position"] for comparison in compare_all(recordings[:2], three)]
    places = [row.index(quantity(value, "rad")) for value in (errors[0]["noise_floor"], *(e["rmse"] for e in errors))]
    assert places == sorted(places)
    assert all(f"{role} " in table for role in ROLES)
    assert "Names of the models: polito_bench (your model), better (with the effects found), fitted (fitted)." in text
    floors = {error["noise_floor"] for error in errors}
    assert len(floors) == 1 and head.startswith("polito_bench lacks backlash.")


def test_it_tells_what_fitting_did_and_that_it_gains_nothing_elsewhere(written):
    told = Read(written).text.split("What was wrong")[0]
    assert "with the effects found, the error of the output position falls from" in told
    assert "Fitting the found model's numbers to the simulated loop takes the error of" in told
    assert (
        "the error of the current is 6.50 mA; the found model, which was fitted to all recordings, has 5.50 mA" in told
    )


def test_numbers_stand_as_found_and_as_fitted(written):
    text = Read(written).text.split("Step by step")[1]
    assert "width 3.700 ± 0.020 mrad 4.000 ± 0.004 mrad +8.1 %" in text
    assert "machine: motor inertia 0.00077 kg m^2 0.00077 kg m^2 (7.800 ± 0.010)e-4 kg m^2 +1.3 %" in text


def test_constants_that_did_not_move_visibly_are_left_out(three, content):
    """Without standard errors every change counts, and one of a ten thousandth was told as +0.0 %."""
    before, after = (
        three[1].with_value("machine.motor_inertia", factor * three[1].value("machine.motor_inertia"))
        for factor in (1.0, 1.0001)
    )
    same = replace(content, models=(before, after), names=NAMES[:2], findings=None, fit=None)
    text = Read(page(replace(same, given=shown(content.given.recordings, (before, after))))).text
    assert "Constants that moved" not in text and "+0.0 %" not in text


def test_all_twins_are_in_the_same_figures(written, content):
    charts = charts_of(written)
    curves = [chart for chart in charts if chart["link"] == "time"]
    for chart in curves:
        for choice in chart["choices"]:
            assert [trace["name"] for trace in choice["traces"][1:]] == [*ROLES, *ROLES]
            assert [trace["line"]["color"] for trace in choice["traces"][1:4]] == ["@before", "@after", "@fitted"]
    widths = [trace["line"]["width"] for trace in curves[0]["choices"][0]["traces"]]
    assert widths[3] < widths[2]  # the fitted line does not hide the other
    assert len(charts) >= 11


def test_what_differs_is_judged_by_the_standard_errors(three, told):
    findings, fit = read_findings(told / "found.json"), read_fit_findings(told / "fit.json")
    values = {each.name: each for each in two_values(three[1], three[2], findings, fit)}
    assert set(values) == {"width", "motor_inertia"} and all(each.differ for each in values.values())
    near = three[1].with_value("effects.backlash.width", 0.00371)
    assert [each.differ for each in two_values(three[1], near, findings)] == [False]
    assert [each.differ for each in two_values(three[1], near)] == [True]  # where no standard error is known
    assert not two_values(three[1], three[1], findings, fit)


def test_only_the_same_model_fitted_is_taken(three):
    check_same_effects(three[1], three[2], NAMES[1:])
    with pytest.raises(InputError, match=r"fitted: the third model .* \(backlash\) differ from those of better; give"):
        check_same_effects(three[1], three[0], NAMES[1:])


def test_fitting_is_told_alike_where_all_is_noise():
    noise = {"current": {"rmse": 0.003, "noise_floor": 0.003, "unit": "A", "relative": 0.0, "driven": False}}
    assert fit_sentences(noise, noise, ["current"]).endswith("leaves it at the sensors' noise.")
    found, fitted = ({"current": {**noise["current"], "rmse": rmse}} for rmse in (0.006, 0.005))
    assert fit_sentences(found, fitted, ["current"]).endswith(
        "loop takes the error of the current from 6.00 mA to 5.00 mA."
    )
    assert fit_sentences(found, found, ["current"]).endswith("loop leaves the error of the current at 6.00 mA.")
    found, fitted = ({**errors, "speed": {**found["current"], "unit": "rad/s"}} for errors in (found, fitted))
    assert fit_sentences(found, fitted, ["speed", "current"]).endswith(
        "takes the error of the current from 6.00 mA to 5.00 mA and leaves that of the speed at 6.00 mrad/s."
    )


def test_views_show_all_three(tmp_path, content):
    path = tmp_path / "three.rrd"
    tabs = write_views(path, content.given, content.models, ROLES, content.findings)
    assert {"compare", "after"} <= set(tabs)
    views = RrdContent(path)
    at = f"/compare/{content.given.recordings[0].name}/output_position/curves"
    for role in ROLES:
        twin = views.curve(f"{at}/twin\\ {role}".replace(" ", "\\ ").replace("\\\\", "\\"))[1]
        assert len(twin) == len(content.given.recordings[0])
    words = views.words("/after/errors")
    assert "your model (orange), with the effects found (blue) and fitted (pink)" in words
    assert "output position" in words
    bars = {f"/after/errors/{rr.escape_entity_path_part(f'output position, {role}')}" for role in ROLES}
    assert bars <= {*views.entities}


@pytest.mark.slow
def test_the_command_takes_three_models(tmp_path, three, told, ramp):
    files = []
    for name, model in zip(NAMES[1:], three[1:], strict=True):
        files += ["--model", save_model(model, tmp_path / f"{name}.yaml")]
    common = (ramp, "--model", "polito_bench", *files, "--to", 4, "--discovery", told / "found.json")
    done("report", *common, "--fit", told / "fit.json", "-o", tmp_path / "r.html")
    assert "with the effects found" in (tmp_path / "r.html").read_text()
    same = save_model(replace(three[1], name="same"), tmp_path / "same.yaml")
    two = (ramp, "--model", "polito_bench", *files[:2], "--model", same, *common[-4:])
    result = done("report", *two, "-o", tmp_path / "two.html")
    assert "same is not shown: no parameter differs from better's by more than its standard error" in result.stderr
    text = (tmp_path / "two.html").read_text()
    assert "same is not shown" in text and "with the effects found" not in text
    refused("report", *common, "--model", same, "-o", tmp_path / "s.html", naming=("two models", "or three", "4 times"))
    pair = (*common[:5], *common[7:])
    refused("report", *pair, "--fit", told / "fit.json", "-o", tmp_path / "s.html", naming=("third",))
    refused("report", *common, "--fit", told / "found.json", "-o", tmp_path / "s.html", naming=("fit --json",))
    backward = (ramp, *files, "--model", "polito_bench", *common[-4:])
    refused("report", *backward, "-o", tmp_path / "s.html", naming=("polito_bench: the third model",))
