"""``python -m docs.pictures``: run the demo, and take a picture of each tab of the views that it writes.

Takes a minute or two, and lavapipe (``mesa-vulkan-drivers``) to draw with.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

from tests.viewer import LAVAPIPE, REASON, Viewer

HERE = Path(__file__).resolve().parent
TWIN = Path(sys.prefix) / "bin" / "ema-twin"
COLOURS = 256  # which are plenty, and a third of the size
FOUND = {
    "compare": ("compare", "BancoEMA_sine_0.02_1Hz"),
    "where_it_fails": ("where it fails", "output position"),
    "where_it_fails_current": ("where it fails", "current"),
    "why": ("why",),
    "after": ("after",),
    "gear_train": ("gear train",),
}


def main() -> None:
    """Run the demo and take the pictures."""
    if LAVAPIPE is None:
        sys.exit(f"pictures: {REASON}")
    with tempfile.TemporaryDirectory() as folder:
        demo = Path(folder) / "demo"
        subprocess.run([TWIN, "demo", "-o", demo], check=True, stdout=subprocess.DEVNULL)
        _take(demo / "found.rrd", {HERE / f"{name}.png": tab for name, tab in FOUND.items()}, 10.0)
        _take(demo / "live.rrd", {HERE.parent / "live.png": ("compare",)}, 19.9)


def _take(views: Path, pictures: dict[Path, tuple[str, ...]], second: float) -> None:
    """Pictures of tabs, the cursor at a second of the recording."""
    viewer = Viewer(views)
    try:
        for path, tab in pictures.items():
            viewer.show(*tab)
            viewer.at(second)
            viewer.picture(path)
            Image.open(path).convert("RGB").quantize(COLOURS, Image.Quantize.FASTOCTREE).save(path, optimize=True)
            print(f"  {path.relative_to(HERE.parents[1])}  {path.stat().st_size // 1000} kB", flush=True)
    finally:
        viewer.close()


if __name__ == "__main__":
    main()
