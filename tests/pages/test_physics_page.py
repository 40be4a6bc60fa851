"""docs/physics.md: what it names exists, every equation is there, its figures too, and its numbers are current."""

import re
from pathlib import Path

import pytest

from docs.figures import efficiency, page, spectrum
from docs.figures.__main__ import FIGURES
from docs.figures.number import Number
from docs.figures.quick import quick_numbers
from docs.figures.speed import models
from ema_twin_sim.effects import catalogue
from ema_twin_sim.model.planetary_constants import PLANETARY_CONSTANTS

TEXT = page.PAGE.read_text()
PLACES = dict(re.findall(r"^\[([\w-]+)\]: (\S+)$", TEXT, re.MULTILINE))
NAMED = re.findall(r"\[`([\w./]+)`\]\[([\w-]+)\]((?:[ ,\n]+`\w+`)*)", TEXT)
SLOW = {  # of runs that take minutes: make figures measures them
    "forward_running", "backward_running", "locking_running", "healthy_low", "healthy_15", "healthy_15_75",
    "healthy_31_5", "healthy_45", "sun_runout_twice", "planet_runout_twice",
    *(f"{name}_at" for name in spectrum.CONDITIONS), "planet_tooth_15", "ring_tooth_15",
}  # fmt: skip
NEARLY_NONE = {"short_ripple_healthy", "healthy_15"}
TIMED = {f"{what}_{name}" for name in models() for what in ("ns", "times")}


def defined(name, source):
    return re.search(rf"^\s*(def|class) {name}\b|^{name}\b.*=", source, re.MULTILINE)


def test_every_file_function_and_test_that_it_names_exists():
    assert len(NAMED) > 80
    assert set(PLACES) == {place for _, place, _ in NAMED}, "a link without a place, or a place without a link"
    for file, place, names in NAMED:
        path = (page.DOCS / PLACES[place]).resolve()
        assert path.exists(), PLACES[place]
        named = path.parent if file.endswith("/") else path  # a package is linked by the file that opens it
        assert named.as_posix().endswith(file.rstrip("/")), f"[`{file}`] leads to {path}"
        for name in re.findall(r"`(\w+)`", names):
            assert defined(name, path.read_text()), f"{file} has no {name}"


def test_every_other_test_that_it_names_exists():
    sources = "\n".join(path.read_text() for path in (page.DOCS.parent / "tests").rglob("test_*.py"))
    for name in set(re.findall(r"`(test_\w+)`", TEXT)):
        assert defined(name, sources), name


def test_parameters_and_effects_that_it_names_exist():
    known = {constant.name for constant in PLANETARY_CONSTANTS}
    condition = TEXT.split("\n## Gear condition")[1].split("\n## ")[0]
    named = set(re.findall(r"`([a-z]\w*_(?:tooth_damage|damaged_tooth|runout|runout_phase|mesh_play))`", condition))
    assert len(named) == 17 and named <= known
    assert {"sun_runout", "thermal_friction", "phase_short", "rotor_eccentricity"} <= set(catalogue())


@pytest.mark.parametrize("number", range(1, 64))
def test_every_equation_of_chapter_3_has_a_row(number):
    rows = [line for line in TEXT.splitlines() if re.match(rf"^\| (?:3\.\d+, )*3\.{number}(?:, 3\.\d+)* \|", line)]
    assert len(rows) == 1
    assert len(re.split(r"(?<!\\)\|", rows[0])) == 7
    assert ".py`" in rows[0] and "`test_" in rows[0]


def test_its_figures_are_there_and_small():
    shown = re.findall(r"!\[[^\]]+\]\((\S+)\)", TEXT)
    assert sorted(shown) == sorted(f"physics/{name}.svg" for name in FIGURES)
    for path in (page.DOCS / shown_path for shown_path in shown):
        assert path.stat().st_size < 150_000
    assert sorted(path.stem for path in page.FOLDER.iterdir()) == sorted(FIGURES)


def test_its_sections_are_linked_rightly():
    heads = {re.sub(r"[^\w -]", "", head.lower()).replace(" ", "-") for head in re.findall(r"^#+ (.*)$", TEXT, re.M)}
    assert set(re.findall(r"\]\(#([\w-]+)\)", TEXT)) <= heads


@pytest.mark.slow
@pytest.mark.timeout(600)  # the first run of a checkout compiles the finer fidelities
def test_its_numbers_are_current():
    fresh = quick_numbers()
    quoted = page.quoted(TEXT)
    assert {name for name, _ in quoted} <= set(fresh) | SLOW | TIMED
    for name, text in quoted:
        if name in fresh:
            assert fresh[name].is_shown_by(text), f"{name}: the page says {text}, measured is {fresh[name].text}"


def test_no_number_is_shown_in_two_ways():
    shown = {}
    for name, text in page.quoted(TEXT):
        assert shown.setdefault(name, text) == text, name
        assert float(text.replace("−", "-")) != 0.0 or name in NEARLY_NONE, f"{name}: never measured"


def test_a_number_says_itself_and_its_neighbours_do_not():
    assert Number(0.7104, 3).text == "0.710" and Number(-42.0).text == "−42"
    assert Number(0.7104, 3).is_shown_by("0.710") and Number(-0.5, 1).is_shown_by("−0.5")
    assert not Number(0.7104, 3).is_shown_by("0.712") and not Number(0.7104, 3).is_shown_by("0.71")
    assert page.renewed("0.5<!--a--> of 3<!--b-->", {"a": Number(-1.25, 2)}) == "−1.25<!--a--> of 3<!--b-->"


def test_the_running_train_has_the_balances_efficiency():
    """The slow numbers of the page against the quick ones."""
    quoted = {name: float(text.replace("−", "-")) for name, text in page.quoted(TEXT)}
    assert quoted["forward_running"] == pytest.approx(quoted["forward_positions"], abs=0.02)
    assert quoted["backward_running"] == pytest.approx(quoted["backward_positions"], abs=0.02)
    assert quoted["locking_running"] == pytest.approx(quoted["locking_first"], abs=0.02)
    assert efficiency.USUAL == 0.1


def test_the_readme_leads_to_it():
    assert "docs/physics.md" in (Path(page.DOCS).parent / "README.md").read_text()
