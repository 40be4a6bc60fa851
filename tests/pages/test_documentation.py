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
    assert {verb for verb in verbs if not re.search(rf"`{verb}[ `]", rows)} == set()


def test_pages_count_the_effects_of_the_catalogue():
    pages = [README, *(file.read_text() for file in DOCS.glob("*.md"))]
    counts = [count for text in pages for count in re.findall(r"catalogue holds (.*?) effects", text)]
    assert len(counts) == 2 and {*counts} == {str(len(catalogue()))}
