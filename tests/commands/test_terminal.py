"""What the commands print fits the terminal that it is printed on, and a number is never broken."""

import fcntl
import io
import os
import pty
import re
import struct
import subprocess
import tempfile
import termios
import threading
from pathlib import Path

import pytest
from rich.console import Console
from rich.text import Text

from ema_twin_sim.commands import tables
from ema_twin_sim.commands.output import fold, takes_colours
from tests.command_line import ENVIRONMENT, LONGEST, MODEL, TWIN, done, server

BROKEN = re.compile(r"(\d|±|\bN|\bkg)$")  # at a line's end: what must have its unit, or the rest of it, beside it


def on_terminal(*arguments, columns=80, timeout=LONGEST):
    """What a command prints on a terminal, its lines without colours."""
    ours, theirs = pty.openpty()
    parts = []
    reader = threading.Thread(target=lambda: parts.extend(_read(ours)))
    reader.start()
    with tempfile.NamedTemporaryFile("r") as errors:
        streams = (os.devnull, os.ttyname(theirs), errors.name)
        given = {"COLUMNS": str(columns), "TERM": "xterm"}
        status = server().give([*map(str, arguments)], Path.cwd(), timeout, streams, **given)
        os.close(theirs)
        reader.join()
        os.close(ours)
        assert status == 0, errors.read()
    text = re.sub(rb"\x1b\[[0-9;?]*[a-zA-Z]", b"", b"".join(parts)).decode()
    return text.replace("\r\n", "\n").split("\n")


def _read(file):
    while True:
        try:
            part = os.read(file, 1 << 16)
        except OSError:  # how a terminal says that its other side is closed
            return
        if not part:
            return
        yield part


def check(lines, columns=80):
    """No line is longer than the terminal, but commands to be copied; nothing is cut off or broken."""
    text = "\n".join(lines)
    assert "…" not in text
    for line in lines:
        if not line.startswith("  ema-twin "):
            assert len(line) <= columns, line
    for line in lines:  # a unit alone in its cell has lost its number
        cells = re.split(r"\s{2,}", line.strip())
        assert not re.match(r"^([nµm]?(A|rad|rad/s)|[mnµ]?N m|m|%)$", cells[0]), line


def test_what_is_piped_is_as_wide_as_the_terminal_that_it_is_read_on():
    """``ema-twin effects | less``: only the error output still is the terminal."""
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 70, 0, 0))
    piped = subprocess.run([TWIN, "effects"], stdout=subprocess.PIPE, stderr=theirs, env=ENVIRONMENT, check=True)
    os.close(theirs)
    os.close(ours)
    cells = [line for line in piped.stdout.decode().splitlines() if line.startswith("  ")]
    assert len(cells) > 50 and max(map(len, cells)) <= 70  # sentences stay whole in a pipe, to be searched


@pytest.fixture(scope="module")
def better(tmp_path_factory):
    file = tmp_path_factory.mktemp("model") / "a_better_one_with_backlash.yaml"
    done("add", "backlash", *MODEL, "-o", file)
    return file


@pytest.mark.slow
@pytest.mark.parametrize("columns", [60, 80, 100])
def test_compare(traces, better, columns):
    runs = (*traces, "--to", 8)
    one = on_terminal("compare", *runs, *MODEL, columns=columns)
    two = on_terminal("compare", *runs, *MODEL, "--model", better, columns=columns)
    for lines in (one, two):
        check(lines, columns)
        text = "\n".join(lines)
        for trace in traces:
            assert trace.stem in text
        assert "all recordings" in text and "Where the model fails" in text
        assert re.search(r"unexplained( torque)? +\d[\d.]+ mN m +\d[\d.]+ mN m", text) or columns != 80
    assert "a_better_one_with_backlash:" in " ".join(two) and "times closer" in " ".join(" ".join(two).split()).lower()


def piped(columns, *arguments):
    with tempfile.NamedTemporaryFile("r") as out, tempfile.NamedTemporaryFile("r") as errors:
        streams = (os.devnull, out.name, errors.name)
        status = server().give([*map(str, arguments)], Path.cwd(), LONGEST, streams, COLUMNS=columns)
        assert status == 0, errors.read()
        return out.read().split("\n")


@pytest.mark.slow
def test_without_a_terminal_columns_say_how_wide(traces):
    compare = ("compare", traces[0], *MODEL, "--to", 5)
    check(piped("80", *compare))
    assert max(map(len, piped("160", "effects"))) > 120
    for unusable in ("", "0", "none"):  # then a width that most windows have, and sentences whole
        lines = piped(unusable, *compare)
        assert max(len(line) for line in lines if not line.endswith(".")) <= 120
        assert any(len(line) > 120 for line in lines if line.endswith("."))


@pytest.mark.slow
def test_effects_and_info(traces):
    for arguments in (("effects",), ("effects", "backlash"), ("info", "polito_bench"), ("info", traces[0])):
        check(on_terminal(*arguments))
    lines = on_terminal("info", "polito_bench")
    assert any("transmission.contact_stiffness " in line for line in lines)
    assert any("N m s/rad" in line for line in lines)


@pytest.mark.slow
def test_discover_and_fit(traces, tmp_path):
    runs = [*traces[1:3], "--to", 6]
    lines = on_terminal("discover", *runs, *MODEL, "-o", tmp_path / "new.yaml")
    check(lines)
    assert any(line.startswith("Runner-up to backlash: ") for line in lines)
    assert sum("mA" in line for line in lines) >= 3 and any(" ± " in line and "mrad" in line for line in lines)
    fit = ("--method", "equation", "-o", tmp_path / "fitted.yaml")
    check(on_terminal("fit", *runs, "--model", tmp_path / "new.yaml", *fit))


@pytest.mark.slow
def test_diagnose(traces):
    lines = on_terminal("diagnose", *traces[1:3], "--to", 6, *MODEL)
    check(lines)
    assert any(re.search(r"backlash\W+\d+ %", line) and "width" in line and "mrad" in line for line in lines)


def printed(table, width):
    console = Console(width=width, file=io.StringIO())
    with console.capture() as capture:
        console.print(table)
    return capture.get().split("\n")


def test_a_table_folds_words_and_never_numbers():
    table = tables.ReportTable("A title of some words")
    table.words("name", "what is said of it")
    table.numbers("value", "its change")
    table.add_row("a_rather_long_identifier", "many words that say little", "0.0812 ± 0.0003 mN m", "12.5 %")
    for width in (140, 90, 70, 60, 50, 40, 30):
        lines = printed(table, width)
        assert max(map(len, lines)) <= width
        for whole in ("a_rather_long_identifier", "0.0812 ± 0.0003 mN m", "12.5 %"):
            assert any(whole in line for line in lines), width


def test_numbers_and_units_stay_together():
    text = Text("on average -39.2 mA at 0.3 ± 0.2 mN m, which is 84 % of 25.6 mN m s/rad and (7.2 ± 0.1)e-4 kg m^2")
    for width in range(22, 60):
        for line in fold(text, width).plain.split("\n"):
            assert len(line) <= width and not BROKEN.search(line.replace("m^2", "")), line
    assert fold(Text("one\ntwo three"), 5).plain == "one\ntwo\nthree"
    assert fold(Text("transmission.contact_damping"), 24).plain == "transmission.contact_\ndamping"


@pytest.mark.parametrize(
    ("environment", "colours"),
    [
        ({"TERM": "xterm-256color"}, True),
        ({"TERM": "dumb"}, False),
        ({}, False),
        ({"TERM": "xterm", "NO_COLOR": "1"}, False),
    ],
)
def test_a_terminal_without_colours_gets_no_codes_of_them(environment, colours):
    assert takes_colours(environment) == colours
