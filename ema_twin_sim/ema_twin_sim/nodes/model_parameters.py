"""Every number of a running twin's model, and every effect's switch, as ROS parameters of the node that runs it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter

from ema_bench_replay.nodes.parameters import Declaration, check_all, declare

from ..effects import catalogue
from ..simulation.twin import Twin

_SWITCH = ".enabled"


class ModelParameters:
    """Declares a twin's parameters on a node, and sets them on the twin: from its next sample on.

    Several set at once are all refused where one is impossible.
    """

    def __init__(self, node: Node, twin: Callable[[], Twin]) -> None:
        """`twin` returns the present twin: another one may take its place. Raises InputError on a wrong start value."""
        self._twin = twin
        self._declarations = _declarations(twin())
        before = {declaration.name: declaration.default for declaration in self._declarations}
        given = declare(node, self._declarations)
        self._set({name: value for name, value in given.items() if value != before[name]})
        node.add_on_set_parameters_callback(self._on_set)

    def _on_set(self, parameters: Iterable[Parameter]) -> SetParametersResult:
        result = check_all(self._declarations, parameters)
        if result.successful:
            own = {declaration.name for declaration in self._declarations}
            self._set({parameter.name: parameter.value for parameter in parameters if parameter.name in own})
        return result

    def _set(self, values: dict[str, Any]) -> None:
        twin = self._twin()
        for name, value in values.items():
            if name.endswith(_SWITCH):
                twin.set_enabled(name.removeprefix("effects.").removesuffix(_SWITCH), value)
            else:
                twin.set_parameter(name, float(value))


def _declarations(twin: Twin) -> list[Declaration]:
    numbers = [
        Declaration(p.path, p.value, p.description, p.unit, p.lower, p.upper, fixed=False) for p in twin.parameters()
    ]
    switches = [
        Declaration(
            f"effects.{name}{_SWITCH}",
            instance.enabled,
            f"switch on: {catalogue()[instance.effect].summary}",
            fixed=False,
        )
        for name, instance in twin.effects.items()
    ]
    return numbers + switches
