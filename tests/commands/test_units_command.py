"""What `units` prints: what was found over all units first, then tables of a bounded size."""

import re

import pytest

from ema_bench_replay.errors import InputError
from ema_twin_sim.campaign.healthy import Healthy
from ema_twin_sim.campaign.results import DONE, REFUSED
from ema_twin_sim.campaign.store import Store
from ema_twin_sim.campaign.unit_health import unit_health
from ema_twin_sim.campaign.units import units_of
from ema_twin_sim.words.unit_health import health_words
from tests.command_line import done, done_here, refused
from tests.health_results import health_results
from tests.stored_rows import complete

LACKS = ["backlash"], ["backlash", "stribeck_friction"], [], None


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Thirty units with thirty results each; of each four, two lack effects, one lacks none, one was not judged."""
    folder = tmp_path_factory.mktemp("campaign") / "r"
    store = Store.made(folder)
    for unit in range(30):
        missing = LACKS[unit % 4]
        judged = {"verdict": "found" if missing else "nothing", "missing": missing, "status": DONE, "task": "discover"}
        of = {"status": REFUSED, "message": "no rows", "task": "discover"} if missing is None else judged
        name = f"EMA-{unit:03}"
        store.write(complete({"unit": name, "name": f"run {k}", "key": f"{unit} {k}", **of} for k in range(30)))
    return folder


def printed(*arguments):
    return done("units", *arguments).stdout


def test_what_was_found_is_told_first(results):
    first = printed(results).splitlines()[:2]
    assert " ".join(first).startswith(
        "30 units: 16 with effects missing in their model (backlash 16, Stribeck friction 8). 690 results; 210 inputs "
    )


def test_tables_are_bounded_unless_all_is_asked_for(results):
    told, whole = printed(results), printed(results, "--all")
    assert "the first 20 of 30 units (--all shows all)" in told and told.count("EMA-0") == 20
    assert whole.count("EMA-0") == 30 and "--all" not in whole
    of_one = printed(results, "--unit", "EMA-000")
    assert of_one.startswith("EMA-000: 30 results, 0 refused, 0 failed. Missing in its model: backlash 30/30.")
    assert "the last 20 of 30 results" in of_one and "run 29" in of_one and "run 9 " not in of_one
    assert printed(results, "--unit", "EMA-000", "--all").count("│run") == 30


def test_a_mistyped_unit_or_pattern_is_told_with_what_may_be_meant(results):
    refused("units", results, "--unit", "EMA_012", naming=["did you mean 'EMA-012'?"])
    refused("units", results, "--healthy", "rnu", naming=["no result has a name with that, as 'run 0' is one"])


@pytest.fixture(scope="module")
def fleet(tmp_path_factory):
    """Thirty units with twenty tests each; the last two have more friction, from the 13th and from the 16th on."""
    folder = tmp_path_factory.mktemp("health") / "r"
    store = Store.made(folder)
    for unit in range(30):
        worn = {28: 12, 29: 15}.get(unit, 20)
        store.write(health_results(f"U{unit:02}", [1.0] * worn + [1.5] * (20 - worn), seed=unit))
    return folder


def test_units_that_deviate_come_first_with_since_when(fleet):
    told = printed(fleet, "--healthy", "8")
    assert "the first 20 of 30 units (--all shows all), those whose last test deviates first" in " ".join(told.split())
    rows = [line for line in told.splitlines() if line.startswith("│U")]
    assert [row[1:4] for row in rows[:2]] == ["U28", "U29"]
    assert "tests deviate, all since" in rows[0] and "error left" not in told


def test_all_units_that_deviate_are_shown(tmp_path):
    store = Store.made(tmp_path / "r")
    for unit in range(26):
        worn = 12 if unit < 23 else 20
        store.write(health_results(f"U{unit:02}", [1.0] * worn + [1.5] * (20 - worn), seed=unit))
    told = printed(tmp_path / "r", "--healthy", "8")
    shown = int(re.search(r"the first (\d+) of 26 units|26 units", told)[1] or 26)
    assert shown >= 23 and {f"U{unit:02}" for unit in range(23)} <= {*re.findall(r"│(U\d+)", told)}


def test_the_families_of_all_tests_add_up(fleet):
    first = " ".join(printed(fleet, "--healthy", "8").split())
    off = re.search(r"\((\d+) of 360 tests: ([^)]*)\)", first)
    assert int(off[1]) == sum(int(part.split()[0 if "other" in part else -1]) for part in off[2].split(", "))


def test_a_choice_of_healthy_results_that_leaves_nothing_to_compare_is_refused(fleet):
    refused("units", fleet, "--healthy", "25", naming=["no unit has more than 20 results; give 4 to 19"])
    refused("units", fleet, "--unit", "U04", "--healthy", "2023", naming=["U04 has 20 results"])
    refused("units", fleet, "--healthy", "csv", naming=["all results have a name with that"])
    refused("units", fleet, "--unit", "U04", "--healthy", "2022-", naming=["no result of U04 has a name with that"])


def test_single_units_with_too_few_results_are_warned_of(fleet, tmp_path):
    store = Store.made(tmp_path / "r")
    for unit, count in (("A", 20), ("B", 6), ("C", 6)):
        store.write(health_results(unit, [1.0] * count))
    told = done("units", tmp_path / "r", "--healthy", "8")
    assert "warning: B and C: all its 6 results are healthy by --healthy 8, so none is left to compare" in told.stderr
    assert "not judged: all its tests" in told.stdout and "(0 others)" not in told.stdout


def test_of_inputs_that_were_all_refused_it_is_told_that_none_was_judged(tmp_path):
    of = {"status": REFUSED, "message": "no rows", "task": "health"}
    Store.made(tmp_path / "r").write(complete({"unit": "A", "name": str(k), "key": str(k), **of} for k in range(3)))
    assert printed(tmp_path / "r").startswith("1 unit: none of its 3 inputs could be judged")


def test_when_a_unit_deviates_is_told_for_each_course(tmp_path):
    courses = {"all": [1.0] * 4 + [1.5] * 8, "gone": [1.0] * 4 + [1.5] * 2 + [1.0] * 6, "again": [1.0] * 12}
    courses["again"][5] = courses["again"][-1] = 1.5
    courses["none"] = [1.0] * 12
    health = {}
    for name, friction in courses.items():
        (unit,) = units_of(health_results(name, [1.0] * 8 + friction, seed=3))
        health[name] = health_words(unit_health(unit, Healthy(8)))
    assert "tests deviate, all since 20" in health["all"] and ", again since 20" in health["again"]
    assert re.search(r"tests deviate, the last [\d-]+, none since: ", health["gone"])
    assert health["none"] == "like its healthy tests (12 others)"


def test_outputs_that_are_there_are_refused_before_anything_is_computed(results, tmp_path, monkeypatch):
    def computed(*_):
        raise AssertionError("read before the outputs were looked at")

    monkeypatch.setattr(Store, "rows", computed)
    (tmp_path / "index.html").touch()
    (tmp_path / "history.rrd").touch()
    for options in (("--page", tmp_path), ("--unit", "EMA-000", "--rrd", tmp_path / "history.rrd")):
        with pytest.raises(InputError, match="exists already; give another name, or --force"):
            done_here("units", results, *options)
