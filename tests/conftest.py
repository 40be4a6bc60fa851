"""What all tests share: an isolated ROS graph, and the folders of recordings."""

import gc
import importlib
import os
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import settings

import tests.ros_domain  # noqa: F401 - takes a graph of its own

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the package does where it is imported first

from ema_twin_sim.listing import number_of
from ema_twin_sim.parallel import one_after_another

# the same examples at every run; HYPOTHESIS_PROFILE=explore looks for new ones. None has a deadline: on a busy machine
# any example may take long
settings.register_profile("steady", derandomize=True, deadline=None)
settings.register_profile("explore", deadline=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "steady"))

ROOT = Path(__file__).resolve().parent.parent
RECORDINGS = Path(__file__).resolve().parent / "recordings"
SHARED = ROOT.parent / "shared"


def pytest_collection_modifyitems(items):
    """Put the files with slow tests first: begun last, one process would wait for the other.

    Those in nodes/, most of which play recordings in real time, stand at equal distances between the others: two of
    them seldom share the machine. Within a file, and of the quick ones, the order stays.
    """
    slow = dict.fromkeys(item.path for item in items if item.get_closest_marker("slow"))
    place = dict.fromkeys((item.path for item in items), 1.0)
    for of_nodes in (True, False):
        files = [path for path in slow if (path.parent.name == "nodes") == of_nodes]
        place |= {path: k / len(files) for k, path in enumerate(files)}
    items.sort(key=lambda item: place[item.path])


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """What is collected stays to the end: looking through it for what is not needed takes a quarter of that time."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()
        gc.freeze()


ABSENT = "absent, and no part of the project: "
"""What a test is skipped with that needs recordings from elsewhere."""


def outside(name):
    """A folder of recordings beside the project; where it is absent, the test is skipped."""
    folder = SHARED / name
    if not folder.is_dir():
        pytest.skip(f"{ABSENT}{folder}")
    return folder


@pytest.fixture(scope="session", autouse=True)
def _one_core_for_each_process():
    """With a test process on every core, searches in two threads only take turns: a seventh of the time is lost."""
    if "PYTEST_XDIST_WORKER" in os.environ:
        one_after_another()


def pytest_report_teststatus(report):
    """Count the tests without their recordings apart from other skips, each of which has a line of its own."""
    if report.skipped and isinstance(report.longrepr, tuple) and ABSENT in report.longrepr[2]:
        return "without recordings", "s", "WITHOUT RECORDINGS"
    return None


def pytest_terminal_summary(terminalreporter):
    """Say once which recordings were absent, and how many tests want them."""
    reports = terminalreporter.stats.get("without recordings", ())
    folders = Counter(report.longrepr[2].partition(ABSENT)[2] for report in reports)
    for folder, count in sorted(folders.items()):
        terminalreporter.write_line(
            f"not run, since {folder} with its recordings is absent: {number_of(count, 'test')}"
        )


@pytest.fixture(scope="module", autouse=True)
def no_effects_of_other_tests():
    """What a file of tests reads into the catalogue leaves it with that file: others run in the same process."""
    held = importlib.import_module("ema_twin_sim.effects.catalogue")
    before = dict(held._own)
    yield
    held._own.clear()
    held._own.update(before)
    held.catalogue.cache_clear()


@pytest.fixture
def catalogue_of_the_package():
    """What a test adds to the catalogue of this process goes with it."""
    held = importlib.import_module("ema_twin_sim.effects.catalogue")
    yield
    held._own.clear()
    held.catalogue.cache_clear()


@pytest.fixture
def graph():
    """Nodes of a test, in one process; they end with it."""
    from tests.ros_graph import Graph

    graph = Graph()
    yield graph
    graph.close()


@pytest.fixture(scope="session")
def traces():
    """The project's own recordings: CSV traces of a bench with two hidden effects."""
    return sorted(RECORDINGS.glob("*.CSV"))


@pytest.fixture(scope="session")
def ramp(traces):
    """The one of them that is a ramp."""
    return next(path for path in traces if "ramp" in path.name)


@pytest.fixture(scope="session")
def imported(tmp_path_factory, traces):
    """A folder of them as MCAP."""
    from tests.command_line import done

    folder = tmp_path_factory.mktemp("recordings")
    done("import", *traces, "-o", folder)
    return folder


@pytest.fixture
def trace(tmp_path):
    """Write a trace file, of bytes or of rows, and return its path."""
    from tests.trace_text import HEADER, ROWS

    def write(content=None, *, header=HEADER, rows=ROWS, name="run.csv"):
        path = tmp_path / name
        if content is None:
            content = "\r\n".join([header, *rows, ""]).encode()
        path.write_bytes(content)
        return path

    return write


@pytest.fixture
def bag(tmp_path):
    """The folder of a small recording."""
    from ema_bench_replay.bags.bag_writer import write_bag
    from tests.bags import a_recording

    return write_bag(a_recording(), tmp_path)


@pytest.fixture
def mcap(bag):
    """The file in it."""
    return bag / "run.mcap"


@pytest.fixture(scope="session")
def bench_cases():
    """Labelled recordings of another virtual bench; they lie outside the project."""
    return outside("bench_cases")


@pytest.fixture(scope="session")
def real():
    """Measured recordings of other people's machines; they lie outside the project."""
    return outside("real")


@pytest.fixture(scope="session")
def stock():
    """The stock model; models are frozen, so all tests may share it."""
    from ema_twin_sim.model import load_model

    return load_model("polito_bench")


@pytest.fixture(scope="session")
def frictionless(stock):
    """The machine without friction, its sensors ideal: what it shows is what it does."""
    model = stock.without_effect("viscous_friction").without_effect("coulomb_friction")
    for side in ("motor", "output"):
        model = model.with_value(f"sensors.{side}_encoder_counts", 1e12)
    return model.with_value("sensors.speed_smoothing", 0.0)
