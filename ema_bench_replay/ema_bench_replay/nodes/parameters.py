"""Declare a node's parameters with description, unit and range; a wrong value is refused in one line."""

from __future__ import annotations

import difflib
import math
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rclpy.exceptions import ParameterException
from rclpy.node import Node
from rclpy.parameter import Parameter

from ema_bench_replay.errors import InputError

_FOREIGN = ("use_sim_time", "start_type_description_service", "qos_overrides.")
"""Parameters that rclpy declares itself."""
_KINDS = {bool: "true or false", int: "a whole number", float: "a number", str: "text", tuple: "a list of texts"}


@dataclass(frozen=True)
class Declaration:
    """One parameter of a node; its type is that of `default`."""

    name: str
    default: Any  # bool, int, float, str, or a tuple of str
    description: str
    unit: str = ""
    lower: float = -math.inf
    upper: float = math.inf
    choices: Sequence[str] = ()
    allows: Callable[[Any], bool] | None = None  # replaces the test whether a value is one of the choices
    allowed: str = ""  # the choices in words, if `allows` accepts others, too
    fixed: bool = True  # read once at the start

    @property
    def range(self) -> str:
        """Allowed values in words; empty if unrestricted."""
        if self.choices:
            return f"one of {self.allowed or ', '.join(self.choices)}"
        if math.isinf(self.lower) and math.isinf(self.upper):
            return ""
        if math.isinf(self.upper):
            least = "more than 0" if 0.0 < self.lower <= sys.float_info.min else f"at least {self.lower:g}"
            return f"{least} {self.unit}".rstrip()
        return f"{self.lower:g} to {self.upper:g} {self.unit}".rstrip()

    def checked(self, value: Any) -> Any:
        """The value in the parameter's own type. Raises InputError with the range.

        Integers are accepted for floats, and numbers for a text that ``allows`` numbers (``ros2 param set … 22``).
        """
        kind = type(self.default)
        if kind is float and type(value) is int:
            value = float(value)
        if kind is str and self.allows is not None and type(value) in (int, float):
            value = f"{value:.15g}"
        if kind is tuple:
            value = tuple(value) if isinstance(value, (list, tuple)) else value
        if type(value) is not kind:
            name = _KINDS[kind]
            raise InputError(f"parameter {self.name}: {value!r} is not {name}; give {self.range or name}")
        outside = kind in (int, float) and not self.lower <= value <= self.upper
        allowed = self.allows or (lambda choice: not self.choices or choice in self.choices)
        if outside or not allowed(value):
            raise InputError(f"parameter {self.name}: {value} is refused; give {self.range}")
        return value

    def descriptor(self) -> ParameterDescriptor:
        """Descriptor shown by `ros2 param describe`."""
        number = isinstance(self.default, float) and (math.isfinite(self.lower) or math.isfinite(self.upper))
        most = sys.float_info.max  # a ROS range needs two finite ends
        return ParameterDescriptor(
            description=f"{self.description} [{self.unit}]" if self.unit else self.description,
            additional_constraints=self.range,
            read_only=self.fixed,
            # An integer for a float (`rate:=5`) is allowed; `checked` enforces the type.
            dynamic_typing=True,
            floating_point_range=[FloatingPointRange(from_value=max(self.lower, -most), to_value=min(self.upper, most))]
            if number
            else [],
        )


def declare(node: Node, declarations: Iterable[Declaration]) -> dict[str, Any]:
    """Declare parameters; returns their values, as given at the start. Raises InputError on a wrong one."""
    values = {}
    for declaration in declarations:
        default = declaration.default
        asked = node._parameter_overrides.get(declaration.name)  # rclpy has no public way to see them
        try:
            if asked is not None:  # rclpy's own refusal gives the range a second time, without the unit
                declaration.checked(asked.value)
            given = node.declare_parameter(
                declaration.name, list(default) if isinstance(default, tuple) else default, declaration.descriptor()
            ).value
            values[declaration.name] = declaration.checked(given)
        except InputError as error:
            raise InputError(f"{node.get_name()}: {error}") from None
        except ParameterException as error:
            raise InputError(
                f"{node.get_name()}: parameter {declaration.name}: {error}; give {declaration.range}"
            ) from None
    return values


def refuse_unknown(node: Node) -> None:
    """Raise InputError on a parameter given at the start that the node lacks: ROS would silently ignore it."""
    for name in node._parameter_overrides:  # rclpy has no public way to see them
        if not node.has_parameter(name) and not name.startswith(_FOREIGN):
            near = difflib.get_close_matches(name, node._parameters, n=1)
            hint = f"did you mean {near[0]!r}?" if near else f"it has {', '.join(sorted(node._parameters))}"
            raise InputError(f"{node.get_name()}: parameter {name}: there is none of this name; {hint}")


def check_all(declarations: Iterable[Declaration], parameters: Iterable[Parameter]) -> SetParametersResult:
    """Result of a request to set parameters of a running node: refused with the range if one is wrong."""
    by_name = {declaration.name: declaration for declaration in declarations}
    try:
        for parameter in parameters:
            if parameter.name in by_name:
                by_name[parameter.name].checked(parameter.value)
    except InputError as error:
        return SetParametersResult(successful=False, reason=str(error))
    return SetParametersResult(successful=True)
