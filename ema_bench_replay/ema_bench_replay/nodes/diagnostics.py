"""A node's report about itself on `/diagnostics`, once a second."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from . import qos
from .spin import steady_timer

OK = DiagnosticStatus.OK
WARN = DiagnosticStatus.WARN
ERROR = DiagnosticStatus.ERROR
STALE = DiagnosticStatus.STALE

PERIOD = 1.0
"""s."""


@dataclass(frozen=True)
class Report:
    """A node's condition: level, one line, and figures by name; a figure with a unit is a text that includes it."""

    level: bytes
    message: str
    values: Mapping[str, object] = field(default_factory=dict)


class Diagnostics:
    """Publishes a node's report on `/diagnostics` every second."""

    def __init__(self, node: Node, about: str, hardware: str, report: Callable[[], Report]) -> None:
        """`about` names the topic of the report; `hardware` its subject: a recording, a model."""
        self._node = node
        self._about = about
        self._hardware = hardware
        self._report = report
        self._publisher = node.create_publisher(DiagnosticArray, "/diagnostics", qos.DIAGNOSTICS)
        steady_timer(node, PERIOD, self.publish)

    def publish(self) -> None:
        """Publish the report now."""
        report = self._report()
        status = DiagnosticStatus(
            level=report.level,
            name=f"{self._node.get_fully_qualified_name().lstrip('/')}: {self._about}",
            message=report.message,
            hardware_id=self._hardware,
            values=[KeyValue(key=key, value=_in_words(value)) for key, value in report.values.items()],
        )
        array = DiagnosticArray(status=[status])
        array.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(array)


def _in_words(value: object) -> str:
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return str(value)
