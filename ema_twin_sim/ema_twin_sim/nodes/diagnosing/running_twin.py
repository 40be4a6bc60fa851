"""Read and change the running twin through its ROS parameters."""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from rclpy.node import Node
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from rclpy.task import Future

from ema_bench_replay.errors import InputError

from ...model import Model
from ...model.constants import PARTS
from ...model.model import ENABLED
from ...simulation.switchable import switchable

_PATIENCE = 5.0
"""Time in s that the twin has to answer."""
_LOOK = 0.1
"""Interval in s at which a call checks whether to give up."""

_PARTS = (*PARTS, "effects")

Settings = Mapping[str, bool | float | str]


class RunningTwin:
    """A twin's node in the namespace of `node`. Calls block: another thread must spin `node`."""

    def __init__(self, node: Node, name: str, closing: threading.Event) -> None:
        """`name` is the twin's node; once `closing` is set, calls give up."""
        self._name = name
        self._closing = closing
        self._client = AsyncParameterClient(node, name, callback_group=node.default_callback_group)

    def models(self, base: Model, applied: Settings) -> tuple[Model, Model]:
        """Two models: `base` with the twin's numbers and the effects that are switched on there, and the same without
        those of the settings `applied` that still have the value that was set.

        Raises InputError if there is no twin, or it has effects that this process does not know.
        """
        settings = self._settings()
        others = {path: value for path, value in settings.items() if path not in applied or applied[path] != value}
        return _with(base, settings), _with(base, others)

    def change(self, settings: Settings) -> dict[str, bool | float | str]:
        """Set parameters, all or none; return them.

        Raises InputError if there is no twin, it lacks one of them, or it refuses.
        """
        held = set(self._names())
        absent = sorted({path.rpartition(".")[0] for path in settings if path not in held})
        if absent:
            raise InputError(
                f"the running twin has no {', '.join(absent)}: write the model with ema-twin discover, and start the "
                "twin with that"
            )
        wanted = [Parameter(path, value=value) for path, value in settings.items()]
        answer = self._wait(self._client.set_parameters_atomically(wanted))
        if not answer.result.successful:
            raise InputError(f"the twin refuses: {answer.result.reason}")
        return dict(settings)

    def _settings(self) -> dict[str, bool | float | str]:
        names = [name for name in self._names() if name.partition(".")[0] in _PARTS]
        values = self._wait(self._client.get_parameters(names)).values
        return dict(zip(names, map(parameter_value_to_python, values), strict=True))

    def _names(self) -> list[str]:
        end = time.monotonic() + _PATIENCE
        while not self._client.wait_for_services(_LOOK):
            if self._closing.is_set() or time.monotonic() > end:
                raise InputError(
                    f"no node '{self._name}' answers in this namespace; start it: ros2 run ema_twin_sim twin (or set "
                    "the monitor's parameter twin to its name)"
                )
        return list(self._wait(self._client.list_parameters([], 0)).result.names)

    def _wait(self, future: Future) -> Any:
        ended = threading.Event()
        future.add_done_callback(lambda _: ended.set())
        end = time.monotonic() + _PATIENCE
        while not ended.wait(_LOOK):
            if self._closing.is_set() or time.monotonic() > end:
                future.cancel()
                raise InputError(f"the twin did not answer within {_PATIENCE:g} s; is it still running?")
        return future.result()


def _with(base: Model, settings: Settings) -> Model:
    """`base` with the settings of a twin that started with it; effects that are off and not in `base` are left out."""
    model = switchable(base)
    known = {}
    for path, value in settings.items():
        _, name, *_ = [*path.split("."), ""]
        if path in model.constants or (path.startswith("effects.") and name in model.effects):
            known[path] = value
        elif path.endswith(f".{ENABLED}") and value:
            raise InputError(
                f"the twin has an effect '{name}' that the monitor does not know; give the monitor the twin's model, "
                "and its effect_files"
            )
    model = model.with_settings(known)
    kept = {name: held for name, held in model.effects.items() if held.enabled or name in base.effects}
    return replace(model, effects=kept)
