"""A planetary model let run under a constant current, with every energy booked."""

from pathlib import Path

from ema_twin_sim.model import Model, load_model
from ema_twin_sim.simulation.twin import Twin
from tests.fidelities import write_model


def planetary_model(folder: Path, **values: float) -> Model:
    """The bench's model with an averaged drive and the train; ``values`` are those of its transmission."""
    model = load_model(write_model(folder, "planetary", "polito_bench", transmission={"kind": "planetary"}))
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
