"""The documentation builds without a warning, and its pages fetch nothing."""

import re
import subprocess
import sys

import pytest

from ema_twin_sim.commands.main import VERBS
from ema_twin_sim.effects import catalogue
from tests.tutorials import DOCS

README = (DOCS.parent / "README.md").read_text()


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """As `make docs` does it."""
    folder = tmp_path_factory.mktemp("documentation")
    command = [sys.executable, "-m", "sphinx", "--fail-on-warning", "--keep-going", "--quiet", DOCS, folder]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return folder


@pytest.mark.slow
def test_every_page_is_there_and_led_to(built):
    pages = {file.stem for file in DOCS.glob("*.md")}
    start = (built / "index.html").read_text()
    assert {file.stem for file in built.glob("*.html")} >= pages
    for page in pages - {"index"}:
        assert f'href="{page}.html"' in start, page


@pytest.mark.slow
def test_pages_fetch_nothing(built):
    fetched = re.compile(r'<(script|img|iframe)[^>]*src="(https?:)?//|<link[^>]*href="(https?:)?//|url\(.?https?:')
    for file in [*built.glob("*.html"), *(built / "_static").rglob("*.css")]:
        assert not fetched.search(file.read_text()), file.name


def test_the_readme_leads_to_every_tutorial():
    for file in DOCS.glob("tutorial_*.md"):
        assert f"(docs/{file.name})" in README, file.name


def test_the_readme_names_every_target_of_make_and_every_verb():
    targets = re.findall(r"^([a-z-]+):.*## ", (DOCS.parent / "Makefile").read_text(), re.MULTILINE)
    named = set(re.findall(r"\bmake ([a-z-]+)|`([a-z-]+)`", README))
    assert {*targets} - {word for pair in named for word in pair} == {"help"}
    rows = " ".join(re.findall(r"^\| (`.*?) \|", README.partition("| command | does |")[2], re.MULTILINE))
    verbs = set(VERBS)
    missing = {verb for verb in verbs if not re.search(rf"`{verb}[ `]", rows)}
    assert missing == set(), "add a row to README's table of commands"


def test_pages_count_the_effects_of_the_catalogue():
    counted = {
        str(file.relative_to(DOCS.parent)): count
        for file in [DOCS.parent / "README.md", *DOCS.glob("*.md")]
        for count in re.findall(r"catalogue holds (.*?) effects", file.read_text())
    }
    assert {*counted} == {"README.md", "docs/tutorial_own_effect.md"}
    wrong = {page: count for page, count in counted.items() if count != str(len(catalogue()))}
    assert wrong == {}, f"the catalogue holds {len(catalogue())} effects: correct the number on these pages"


def test_the_readme_lists_every_effect_of_the_catalogue():
    rows = README.partition("| kind | effects |")[2].partition("\n\n")[0]
    listed = re.findall(r"`(\w+)`", rows)
    assert sorted(listed) == sorted(catalogue()), "correct README's table of effects"
