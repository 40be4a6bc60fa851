"""Every command of the tutorials runs, and prints what its page shows."""

import re
import shutil

import pytest

from tests.tutorials import DOCS, TOLERANCE, check, page, prepare, run, shows, steps

PAGES = {
    "missing_effect": 0.25,
    "own_recordings": TOLERANCE,
    "stranger": TOLERANCE,
    "own_effect": TOLERANCE,
    "campaign": TOLERANCE,
    "emps": 0.005,
}
"""Those whose commands run one after another, and by what share their numbers may be others on another machine: where
teeth meet, what is left of a simulated current hangs on every last digit. The live one has a test of its own.
"""
IN_PROSE = {
    "missing_effect": ("98.2 %", "31 %", "6.10 µrad", "1.93 mrad"),
    "emps": (
        *("95.0 ± 0.3 kg", "204 ± 6 N s/m", "20.4 ± 0.4 N", "3.20 ± 0.12 N"),
        *("37.5 N", "8.24 N", "3.57 N", "1.12 N", "866 mN"),
        *("77.57 %", "75.09 %", "3.89 %", "4.95 %", "3.00 %", "4.30 %", "3.09 µm"),
    ),
}
"""Figures that a page gives in its tables and sentences."""


def test_no_tutorial_is_left_out():
    assert {file.stem.removeprefix("tutorial_") for file in DOCS.glob("tutorial_*.md")} == {*PAGES, "live"}


@pytest.mark.slow
@pytest.mark.timeout(1500)
@pytest.mark.parametrize("name", PAGES)
def test_every_command_prints_what_the_page_shows(name, request, tmp_path):
    folder = prepare(tmp_path)
    if name == "emps":
        for file in request.getfixturevalue("real").glob("emps_*.csv"):
            shutil.copy(file, folder)
    text, printed = page(name), ""
    for step in steps(text):
        told = run(step, folder)
        check(step, told, PAGES[name])
        printed += told
    for figure in IN_PROSE.get(name, ()):
        assert shows(printed, figure, PAGES[name]) and figure in text.replace("−", "-"), figure


def test_what_is_shown_is_looked_for():
    """The check itself can fail: on another number, on another order."""
    step = steps("```shell\ntrue\n```\nwords\n```text\n│a │ 1.0 mA│\nb … c\n```\n")[0]
    for printed in ("┃a ┃ 1.0 mA┃\nnothing\nb and c", "a 1.01 mA\nb and c"):
        check(step, printed)
    for printed in ("a 1.1 mA\nb and c", "a 11.0 mA\nb and c", "a 1.0 A\nb and c", "b and c\na 1.0 mA", "a 1.0 mA"):
        with pytest.raises(AssertionError, match="not printed"):
            check(step, printed)
    assert shows("0.006 mrad", "0.0… mrad") and not shows("0.1 mrad", "0.0… mrad")


def test_the_effect_on_its_page_is_the_one_in_its_file():
    act = re.search(r"```python\n(.*?)```", page("own_effect"), re.DOTALL)[1]
    first, last = act.strip().splitlines()
    file = (DOCS / "examples" / "position_friction.py").read_text()
    assert first in file.splitlines() and last in file.splitlines()
