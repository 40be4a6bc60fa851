"""The pages of a fleet: one of all units, one of each, that say what the results say and load nothing."""

import re
from dataclasses import replace
from urllib.parse import unquote

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_twin_sim.campaign.feature_courses import feature_courses
from ema_twin_sim.campaign.healthy import Healthy
from ema_twin_sim.campaign.histories import outlooks
from ema_twin_sim.campaign.results import REFUSED
from ema_twin_sim.campaign.unit_health import sickest_first, unit_health
from ema_twin_sim.campaign.units import units_of
from ema_twin_sim.report.fleet import write_fleet
from ema_twin_sim.views.unit_history import write_unit_history
from ema_twin_sim.words.unit_health import course_words
from tests.health_results import health_results
from tests.rrd_content import RrdContent
from tests.stored_rows import WEEK, complete, weekly


def results(unit, wear, drawn):
    """Play that is told each week to 10 µrad, and grows by ``wear`` [rad] a week from the tenth on."""
    widths = 2.3e-3 + 1e-5 * drawn.normal(size=24) + wear * np.maximum(0.0, np.arange(24) - 10.0)
    return weekly(widths, 1e-5, unit)


@pytest.fixture(scope="module")
def units():
    drawn = np.random.default_rng(2)
    torn = {"unit": "C", "name": "torn", "task": "fit", "status": REFUSED, "message": "no rows"}
    return units_of([*results("A/worn <b>", 4e-5, drawn), *results("B", 0.0, drawn), *complete([torn])])


@pytest.fixture
def pages(units, tmp_path):
    ahead = {unit.name: outlooks(unit, {"backlash.width": 4e-3}) for unit in units}
    overview = write_fleet(tmp_path / "fleet", units, ahead, dict.fromkeys(ahead))
    links = re.findall(r'href="(units/[^"]+)"', overview.read_text())
    return overview, {unquote(unquote(link)): overview.parent / unquote(link) for link in links}


def test_every_unit_has_a_page_that_the_overview_leads_to(pages):
    overview, of_units = pages
    assert len(of_units) == 3
    assert all(page.is_file() for page in of_units.values())
    assert "3 units" in overview.read_text() and "error left / noise" in overview.read_text()
    assert "once the missing effects are added" in overview.read_text()
    assert "<b>" not in overview.read_text()  # names are text


def test_what_has_changed_is_told_with_where_it_leads(pages):
    overview, of_units = pages
    assert len(re.findall(r"backlash width \+\d+", overview.read_text())) == 1
    worn = next(page.read_text() for name, page in of_units.items() if "worn" in name)
    assert re.search(r"it has changed since week 1[0-4]", worn)
    assert re.search(r"reaches its limit in \d+ to \d+ days", worn)
    assert re.search(r"Find out why backlash width has changed \([+−][\d.]+\s%\)\.", worn)
    assert worn.count("<circle") == 24
    well = next(page.read_text() for name, page in of_units.items() if "/B" in name)
    assert "No parameter has changed." in well and "No number shows a trend." in well and "Nothing to do." in well
    assert "Find out why" not in well
    torn = next(page.read_text() for name, page in of_units.items() if "/C" in name)
    assert "no rows" in torn and "1 refused" in torn


def test_a_unit_that_has_passed_its_limit_is_told_so(tmp_path):
    """Worn out, and steady since: no trend leads anywhere any more."""
    drawn = np.random.default_rng(6)
    rows = results("A", 0.0, drawn)
    for row in rows[6:]:
        row["parameters"][0]["value"] += 2.7e-3
    (unit,) = units_of(rows)
    looks = outlooks(unit, {"backlash.width": 4e-3}, Healthy(5))
    assert looks[0].life.latest == 0.0
    write_fleet(tmp_path / "fleet", [unit], {"A": [replace(looks[0], trend=None)]}, {"A": None})
    page = (tmp_path / "fleet" / "units" / "A.html").read_text()
    assert "backlash width has passed its limit." in page and "Repair it" in page and "in passed" not in page


def test_the_pages_load_nothing(pages):
    overview, of_units = pages
    for page in (overview, *of_units.values()):
        text = page.read_text()
        assert "default-src 'none'" in text
        assert not re.search(r'(src|href)="(https?:|//)', text)


def test_a_history_in_rerun_holds_values_errors_levels_and_limits(units, tmp_path):
    worn = next(unit for unit in units if "worn" in unit.name)
    looks = outlooks(worn, {"backlash.width": 4e-3})
    assert write_unit_history(tmp_path / "h.rrd", looks, None) == ["numbers"]
    found = RrdContent(tmp_path / "h.rrd")
    time, values = found.curve("/numbers/backlash.width/value")
    assert len(time) == 24 and time[1] == pytest.approx(WEEK)
    assert values == pytest.approx(looks[0].history.values * 1e3, rel=1e-6)  # mrad
    _, limit = found.curve("/numbers/backlash.width/limit")
    assert set(limit) == {4.0}
    with pytest.raises(InputError, match="exists"):
        write_unit_history(tmp_path / "h.rrd", looks, None)


def test_an_overview_that_exists_is_not_replaced(pages, units):
    overview, _ = pages
    with pytest.raises(InputError, match="exists already"):
        write_fleet(overview.parent, units, {unit.name: [] for unit in units}, {unit.name: None for unit in units})


def test_the_features_that_deviate_are_followed_over_the_tests(tmp_path):
    """Friction that rises from the 13th of 20 days on, 3 % a day, where days differ by 1 %; the other unit is well."""
    worn = [1.0] * 12 + [1.0 + 0.03 * day for day in range(1, 9)]
    units = units_of([*health_results("worn", worn, seed=4), *health_results("well", [1.0] * 20, seed=5)])
    health = {unit.name: unit_health(unit, Healthy(8)) for unit in units}
    written = []
    ordered = sickest_first(units, health)
    write_fleet(tmp_path / "fleet", ordered, {unit.name: [] for unit in units}, health, done=written.append)
    assert written == ["worn", "well"]
    assert re.findall(r">(\w+)</a>", (tmp_path / "fleet" / "index.html").read_text()) == ["worn", "well"]
    page = (tmp_path / "fleet" / "units" / "worn.html").read_text()
    assert re.search(r"Friction: in the last test \d+ standard deviations above the healthy, rising by \d+", page)
    assert page.count("<circle") == 20 and "friction, in standard deviations of the healthy tests" in page
    assert "No number shows a trend" not in page and "No error" not in page and "Missing in its model" not in page
    assert "compared with its healthy ones, and with no model" in page
    assert "No test deviates, so no trend" in (tmp_path / "fleet" / "units" / "well.html").read_text()


def test_a_step_of_a_feature_that_stays_is_no_trend():
    (unit,) = units_of(health_results("A", [1.0] * 10 + [1.3] * 10, seed=7))
    (look,) = feature_courses(unit, unit_health(unit, Healthy(8)))
    assert look.history.name == "friction" and look.change is not None and look.trend is None


@pytest.mark.parametrize("after", [1, 2, 3, 4, 6])
def test_a_step_is_no_trend_however_few_tests_follow_it(after):
    for seed in range(5):
        (unit,) = units_of(health_results("A", [1.0] * (12 - after) + [1.2] * after, seed=seed))
        (look,) = feature_courses(unit, unit_health(unit, Healthy(6)))
        assert look.trend is None
        assert "standard deviations above the healthy, without a trend since 2023" in course_words(look)


def test_friction_that_rises_from_test_to_test_is_a_trend_before_it_has_many_tests():
    (unit,) = units_of(health_results("A", [1.0] * 8 + [1.1, 1.2, 1.3, 1.4], seed=2))
    (look,) = feature_courses(unit, unit_health(unit, Healthy(7)))
    assert look.trend is not None and "rising by" in course_words(look)


def test_without_dates_a_feature_has_no_trend():
    its = health_results("A", [1.0] * 10 + [1.3] * 10, seed=7)
    rows = [{**row, "time": None, "name": f"condition {k}"} for k, row in enumerate(its)]
    (unit,) = units_of(rows)
    (look,) = feature_courses(unit, unit_health(unit, Healthy(8)))
    assert look.change is None and look.trend is None and "trend" not in course_words(look)
