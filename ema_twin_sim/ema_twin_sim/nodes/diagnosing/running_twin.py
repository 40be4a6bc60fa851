"""The twin that runs beside the bench, read and changed through its ROS parameters."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from typing import Any

from rclpy.node import Node
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from rclpy.task import Future

from ema_bench_replay.errors import InputError

from ...effects import catalogue
from ...model import Model
from ...model.constants import PARTS
from ...model.model import ENABLED

_PATIENCE = 5.0
"""s that the twin has to answer in."""

_PARTS = (*PARTS, "effects")

Settings = Mapping[str, bool | float | str]


class RunningTwin:
    """The node `twin` of this namespace. Its calls wait: another thread must serve `node`."""

    def __init__(self, node: Node) -> None:
        self._client = AsyncParameterClient(node, "twin", callback_group=node.default_callback_group)

    def models(self, base: Model, applied: Settings) -> tuple[Model, Model]:
        """`base` as it stands on the twin: its numbers, and the effects that are switched on there; and the same
        without the settings `applied`, where they stand as they were set.

        Raises InputError where there is no twin, or it has effects that this process does not know.
        """
        settings = self._settings()
        others = {path: value for path, value in settings.items() if path not in applied or applied[path] != value}
        return _with(base, settings), _with(base, others)

    def change(self, settings: Settings) -> list[str]:
        """Set parameters, all that the twin has or none; returns the effects that it has no parameters for.

        Raises InputError where there is no twin, or it refuses.
        """
        self._require()
        held = set(self._names())
        known = {path: value for path, value in settings.items() if path in held}
        wanted = [Parameter(path, value=value) for path, value in known.items()]
        answer = self._wait(self._client.set_parameters_atomically(wanted))
        if not answer.result.successful:
            raise InputError(f"the twin refuses: {answer.result.reason}")
        return sorted({path.split(".")[1] for path in settings if path not in held})

    def _settings(self) -> dict[str, bool | float | str]:
        self._require()
        names = [name for name in self._names() if name.partition(".")[0] in _PARTS]
        values = self._wait(self._client.get_parameters(names)).values
        return dict(zip(names, map(parameter_value_to_python, values), strict=True))

    def _names(self) -> list[str]:
        return list(self._wait(self._client.list_parameters([], 0)).result.names)

    def _require(self) -> None:
        if not self._client.wait_for_services(_PATIENCE):
            raise InputError("no node 'twin' answers in this namespace; start it: ros2 run ema_twin_sim twin")

    @staticmethod
    def _wait(future: Future) -> Any:
        ended = threading.Event()
        future.add_done_callback(lambda _: ended.set())
        if not ended.wait(_PATIENCE):
            raise InputError(f"the twin did not answer within {_PATIENCE:g} s; is it still running?")
        return future.result()


def _with(base: Model, settings: Settings) -> Model:
    switched = {path.split(".")[1] for path, value in settings.items() if path.endswith(f".{ENABLED}") and value}
    model = base
    for name in switched - set(base.effects):
        if name not in catalogue():
            raise InputError(
                f"the twin has an effect '{name}' that the monitor does not know; give the monitor its file too "
                "(effect_files)"
            )
        model = model.with_effect(name)
    for path, value in settings.items():
        _, name, *_ = [*path.split("."), ""]
        if path in model.constants or (path.startswith("effects.") and name in model.effects):
            model = model.with_setting(path, value)
    return model
