"""The papers for whoever carries on: what they name exists, the picture shows today's imports, one version."""

import re
from pathlib import Path

import pytest

import ema_bench_replay
import ema_twin_sim
from docs.figures import rooms
from docs.figures.__main__ import ROOMS
from ema_twin_sim.version import VERSION

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
ARCHITECTURE = DOCS / "architecture.md"
DECISIONS = sorted((DOCS / "decisions").glob("[0-9]*.md"))
PAPERS = [ARCHITECTURE, ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md", DOCS / "decisions" / "index.md", *DECISIONS]


@pytest.mark.parametrize("paper", PAPERS, ids=lambda paper: paper.name)
def test_what_a_paper_leads_to_exists(paper):
    text = paper.read_text()
    for target in re.findall(r"\]\(([^)#\s]+)(?:#[\w-]+)?\)", text):
        assert target.startswith("https://") or (paper.parent / target).exists(), target
    for path in re.findall(r"`((?:tests|config|docs|\.ci)/[\w./-]+\.\w+)`", text):
        assert (ROOT / path).exists(), path


@pytest.mark.parametrize("paper", PAPERS, ids=lambda paper: paper.name)
def test_every_target_of_make_that_a_paper_names_is_there(paper):
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    assert set(re.findall(r"`make ([a-z-]+)", paper.read_text())) <= targets


def test_every_room_has_its_line():
    folders = {path.parent.name for path in Path(ema_twin_sim.__file__).parent.glob("*/__init__.py")}
    text = ARCHITECTURE.read_text()
    assert folders == set(re.findall(r"ema_twin_sim/ema_twin_sim/(\w+)/__init__\.py", text))
    assert folders <= {*rooms.COLOURS}


@pytest.mark.slow
def test_the_picture_shows_todays_imports():
    drawn = re.search(r"<dc:description>(.*?)</dc:description>", ROOMS.read_text(), re.DOTALL)[1]
    assert drawn.split("; ") == rooms.in_words(), "make figures draws it anew"


def test_the_functions_on_the_way_of_a_recording_are_where_the_page_says():
    way = ARCHITECTURE.read_text().split("in ten lines")[1].split("\n## ")[0]
    named = re.findall(r"\[`(\w+)`\]\(([\w./]+\.py)\)", way)
    assert len(named) >= 9 and len(re.findall(r"^\d+\.", way, re.MULTILINE)) == 10
    for name, path in named:
        assert re.search(rf"^(def|class) {name}\b", (DOCS / path).read_text(), re.MULTILINE), name


def test_a_decision_is_short_and_tells_its_cost():
    assert len(DECISIONS) >= 10
    for paper in DECISIONS:
        text = paper.read_text()
        assert len(text.splitlines()) <= 20 and all(f"**{part}**" in text for part in ("Why.", "So.", "What it costs."))


def test_one_version():
    """The packages' files say what ``version.py`` does; the change log's newest release is it or comes after it."""
    for package in ("config", "ema_twin_msgs", "ema_bench_replay", "ema_twin_sim"):
        assert f"<version>{VERSION}</version>" in (ROOT / package / "package.xml").read_text()
    for module in (ema_bench_replay, ema_twin_sim):
        setup = (Path(module.__file__).parents[1] / "setup.py").read_text()
        assert f'version="{VERSION}"' in setup
    assert f"## {VERSION}" in (ROOT / "CHANGELOG.md").read_text()
