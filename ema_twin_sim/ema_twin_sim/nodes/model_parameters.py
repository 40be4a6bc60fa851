"""All numbers of a running twin's model, and its effects' switches and options, as ROS parameters of its node."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial

from rcl_interfaces.msg import SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter

from ema_bench_replay.errors import InputError
from ema_bench_replay.nodes.parameters import Declaration, check_all, declare

from ..effects import catalogue
from ..model.model import ENABLED
from ..simulation.twin import Twin


class ModelParameters:
    """Declares a twin's parameters on a node, and sets them on the twin from its next sample on.

    Several parameters set at once are all refused if one of them is impossible.
    """

    def __init__(self, node: Node, twin: Callable[[], Twin]) -> None:
        """`twin` returns the present twin, which may be replaced. Raises InputError if a start value is wrong."""
        self._twin = twin
        self._declarations = _declarations(twin())
        before = {declaration.name: declaration.default for declaration in self._declarations}
        given = declare(node, self._declarations)
        twin().change({name: value for name, value in given.items() if value != before[name]})
        node.add_on_set_parameters_callback(self._on_set)

    def _on_set(self, parameters: Iterable[Parameter]) -> SetParametersResult:
        result = check_all(self._declarations, parameters)
        if result.successful:
            own = {declaration.name: declaration for declaration in self._declarations}
            try:
                self._twin().change({p.name: own[p.name].checked(p.value) for p in parameters if p.name in own})
            except InputError as error:  # each is possible, but not all together
                return SetParametersResult(successful=False, reason=str(error))
        return result


def _declarations(twin: Twin) -> list[Declaration]:
    numbers = [
        Declaration(p.path, p.value, p.description, p.unit, p.lower, p.upper, fixed=False) for p in twin.parameters()
    ]
    effects = {name: (instance, catalogue()[instance.effect]) for name, instance in twin.effects.items()}
    switches = [
        Declaration(f"effects.{name}.{ENABLED}", instance.enabled, f"switch on: {effect.summary}", fixed=False)
        for name, (instance, effect) in effects.items()
    ]
    options = [
        Declaration(
            f"effects.{name}.{option}",
            instance.options[option],
            f"option {option} of {name}",
            choices=choices,
            allows=partial(effect.allows, option),
            allowed=effect.choices_in_words(option),
            fixed=False,
        )
        for name, (instance, effect) in effects.items()
        for option, choices in effect.options.items()
    ]
    return numbers + switches + options
