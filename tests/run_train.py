"""A planetary model let run under a constant current, with every energy booked."""

from pathlib import Path

from ema_twin_sim.model import Model, load_model
from ema_twin_sim.simulation.twin import Twin

_TEXT = """
version: 1
base: {base}
transmission: {{kind: planetary}}
"""


def planetary_model(folder: Path, **values: float) -> Model:
    """The bench's model with an averaged drive and the train; ``values`` are those of its transmission."""
    path = folder / "planetary.yaml"
    path.write_text(_TEXT.format(base=Path(__file__).parents[1] / "config" / "models" / "polito_bench.yaml"))
    model = load_model(path)
    for name, value in values.items():
        model = model.with_value(f"transmission.{name}", value)
    return model


def teeth_alone(model: Model) -> Model:
    """The model with no friction but that of its teeth."""
    for name in list(model.effects):
        model = model.with_enabled(name, False)
    return model


def run(
    model: Model, current: float, speed: float, seconds: float, *, step: float | None = None, every: float = 1e-3
) -> tuple[Twin, list[dict[str, float]]]:
    """A twin after ``seconds`` under ``current`` [A] from ``speed`` [rad/s], and its samples ``every`` s."""
    twin = Twin(model, "current", step=step, accounting=True)
    sample = {"current": current, "speed": speed}
    rows = [twin.start(sample)]
    rows += [twin.advance(round(every * 1e9), sample) for _ in range(round(seconds / every))]
    return twin, rows
