"""What `units` prints: what was found over all units first, then tables of a bounded size."""

import pytest

from ema_twin_sim.campaign.results import DONE, REFUSED
from ema_twin_sim.campaign.store import Store
from tests.command_line import done, refused
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
