"""The views as rerun's viewer shows them: every tab drawn, nothing complained of, the same picture each time."""

from itertools import pairwise

import numpy as np
import pytest
from PIL import Image

from ema_twin_sim.report.content import shown
from ema_twin_sim.simulation.compared_signals import noise_floors
from ema_twin_sim.simulation.simulate import simulate
from ema_twin_sim.views.recording_views import write_views
from ema_twin_sim.views.rerun_view import RerunView
from tests.report.test_report import findings, folder, models, recordings  # noqa: F401
from tests.viewer import LAVAPIPE, REASON, SIZE, Viewer

pytestmark = [pytest.mark.skipif(LAVAPIPE is None, reason=REASON), pytest.mark.timeout(300), pytest.mark.slow]

TABS = (
    ("compare", "run0"),
    ("where it fails", "output position"),
    ("where it fails", "current"),
    ("why",),
    ("after",),
    ("gear train",),
)
LEAST_INK = 0.01  # of the pixels differ from the ground by more than a little
LEAST_COLOURS = 60
GROUND = 40  # of 255
MOST_CHANGED = 0.002  # of the pixels, from one picture to the next of the same thing


def drawn(path, tabs, folder):  # noqa: F811
    """A picture (height, width, 3) of each tab."""
    viewer = Viewer(path)
    try:
        pictures = []
        for names in tabs:
            viewer.show(*names)
            viewer.at(2.0)
            viewer.picture(folder / "picture.png")
            pictures.append(np.asarray(Image.open(folder / "picture.png").convert("RGB"), np.int16))
        assert viewer.troubles() == []
        return pictures
    finally:
        viewer.close()


def assert_shows_something(picture):
    below_the_tabs = picture[100:-40]
    assert picture.shape == (SIZE[1], SIZE[0], 3)
    assert np.mean(below_the_tabs.max(axis=2) > GROUND) > LEAST_INK
    assert len(np.unique(below_the_tabs.reshape(-1, 3) // 8, axis=0)) > LEAST_COLOURS


def changed(one, other):
    return float(np.mean(np.abs(one - other).max(axis=2) > GROUND))


def test_every_tab_is_drawn_alike_each_time(tmp_path, models, recordings, findings):  # noqa: F811
    path = tmp_path / "found.rrd"
    write_views(path, shown(recordings, models), models, ("polito_bench", "better"), findings)
    first, second = (drawn(path, TABS, tmp_path) for _ in range(2))
    for names, one, other in zip(TABS, first, second, strict=True):
        assert_shows_something(one)
        assert changed(one, other) < MOST_CHANGED, names
    for one, other in pairwise(first):
        assert changed(one, other) > MOST_CHANGED  # tabs differ, else the measure would see nothing


def test_the_live_view_is_drawn(tmp_path, stock, recordings):  # noqa: F811
    run = recordings[0]
    twin = simulate(stock, run).signals
    view = RerunView(tmp_path / "live.rrd", run.name, noise_floors(stock), model=stock)
    view.add(run.time, run.signals, twin, {name: run.signals[name] - twin[name] for name in ("current", "speed")})
    view.tell(1.0, "backlash switched on")
    view.close()
    for picture in drawn(tmp_path / "live.rrd", (("compare",), ("current",), ("gear train",)), tmp_path):
        assert_shows_something(picture)
