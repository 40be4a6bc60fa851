"""Which models can run live."""

from __future__ import annotations

from ema_bench_replay.errors import InputError

from ..model import Model, load_model


def live_model(model: str | Model) -> Model:
    """A model, by its file or name, for twin and monitor. Raises InputError if it is of a linear machine.

    The limit of standstill and the units of the topics are those of a rotary machine. Offline, a linear machine is
    treated as a drum that its carriage runs round (``model.equivalent``).
    """
    found = model if isinstance(model, Model) else load_model(model)
    if found.motion != "rotary":
        raise InputError(
            f"model {found.name}: is of a linear machine, which live does not support; compare, fit and discover do"
        )
    return found
