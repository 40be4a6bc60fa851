"""What tests of ``init`` share: recordings of columns given to it, and what it says and writes of them."""

from dataclasses import dataclass
from pathlib import Path

import pytest

from ema_bench_replay.load import load
from ema_twin_sim.commands.init import run as init
from ema_twin_sim.model import load_model
from tests.trace_text import write_columns


@dataclass(frozen=True)
class Draft:
    """What ``init`` prints, and warns of, in one line each; the texts of the map and the model that it writes."""

    said: str
    warned: str
    map: str
    model: str

    @property
    def told(self):
        """What it says and warns of."""
        return f"{self.said} {self.warned}"

    def line(self, name):
        """Of map or model, the line that gives this."""
        return next(line for line in (self.map + self.model).splitlines() if line.lstrip().startswith(f"{name}:"))


@pytest.fixture
def drafted(tmp_path, capsys):
    """Give recordings to ``init``, each as columns (n,) by name or as its file; it writes m_map.yaml and m.yaml."""

    def draft(*runs, **options):
        files = [
            run if isinstance(run, Path) else write_columns(tmp_path / f"run{k}.csv", run) for k, run in enumerate(runs)
        ]
        init(str(tmp_path / "m"), files, **{"force": True, **options})
        shown = capsys.readouterr()
        texts = ((tmp_path / name).read_text() for name in ("m_map.yaml", "m.yaml"))
        return Draft(" ".join(shown.out.split()), " ".join(shown.err.split()), *texts)

    return draft


@pytest.fixture
def read(tmp_path):
    """The first recording that was drafted, as its map reads it."""
    return lambda: load(tmp_path / "run0.csv", import_map=tmp_path / "m_map.yaml")


@pytest.fixture
def drawn(tmp_path):
    """The model that was drafted last."""
    return lambda: load_model(tmp_path / "m.yaml")
