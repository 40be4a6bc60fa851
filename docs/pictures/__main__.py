"""``python -m docs.pictures``: the pictures of rerun's views, of the project's own recordings and a search beside them.

Takes a minute or two, and lavapipe (``mesa-vulkan-drivers``) to draw with.
"""

import sys
import tempfile
from pathlib import Path

from PIL import Image

from ema_bench_replay.load import load
from ema_twin_sim import discover, load_model
from ema_twin_sim.comparison.noise import noise_floors
from ema_twin_sim.discovery.diagnose import weigh
from ema_twin_sim.report.content import shown
from ema_twin_sim.report.findings import findings_of
from ema_twin_sim.simulation.simulate import simulate
from ema_twin_sim.views.recording_views import write_views
from ema_twin_sim.views.rerun_view import RerunView
from tests.viewer import LAVAPIPE, REASON, Viewer

HERE = Path(__file__).resolve().parent
RECORDINGS = HERE.parents[1] / "tests" / "recordings"
_COLOURS = 128  # which are plenty, and a third of the size
SECOND = 10.0  # s of the recording that the cursor stands at
NAMES = ("polito_bench", "better")
TABS = {
    "compare": ("compare", "BancoEMA_sine_0.02_1Hz"),
    "where_it_fails": ("where it fails", "output position"),
    "where_it_fails_current": ("where it fails", "current"),
    "why": ("why",),
    "after": ("after",),
    "gear_train": ("gear train",),
}


def main() -> None:
    """Search, write the views, and take a picture of each."""
    if LAVAPIPE is None:
        sys.exit(f"pictures: {REASON}")
    recordings = [load(path) for path in sorted(RECORDINGS.glob("*.CSV"))]
    stock = load_model("polito_bench")
    found = discover(recordings, stock)
    both = (stock, found.model)
    with tempfile.TemporaryDirectory() as folder:
        views, live = Path(folder) / "found.rrd", Path(folder) / "live.rrd"
        write_views(views, shown(recordings, both), both, NAMES, findings_of(found, weigh(found)))
        _take(views, TABS)
        run = next(recording for recording in recordings if recording.name == TABS["compare"][1])
        twin = simulate(stock, run).signals
        view = RerunView(live, run.name, noise_floors(stock), model=stock)
        left = {name: run.signals[name] - twin[name] for name in ("current", "speed", "output_position")}
        view.add(run.time, run.signals, twin, left | {"unexplained_torque": twin["unexplained_torque"]})
        view.tell(0.0, "the stock model beside the bench")
        view.close()
        _take(live, {"live": ("compare",)})


def _take(views: Path, tabs: dict[str, tuple[str, ...]]) -> None:
    viewer = Viewer(views)
    try:
        for name, tab in tabs.items():
            viewer.show(*tab)
            viewer.at(SECOND)
            path = HERE / f"{name}.png"
            viewer.picture(path)
            Image.open(path).convert("RGB").quantize(_COLOURS).save(path, optimize=True)
            print(f"  {path.relative_to(HERE.parents[1])}  {path.stat().st_size // 1000} kB", flush=True)
    finally:
        viewer.close()


if __name__ == "__main__":
    main()
