"""A node that refuses what it was given leaves the graph at once."""

from __future__ import annotations

from functools import wraps
from typing import Any, TypeVar

from rclpy.node import Node

SomeNode = TypeVar("SomeNode", bound=type[Node])


def whole_or_none(node_class: SomeNode) -> SomeNode:
    """Class decorator: a node whose constructor raises is destroyed before the error goes on.

    Otherwise its readers stay in the graph until Python frees them, which may take minutes. Nobody reads what they
    receive, so that every keep-all publisher of those topics waits for them.
    """
    construct = node_class.__init__

    @wraps(construct)
    def constructed(self: Node, *arguments: Any, **named: Any) -> None:
        try:
            construct(self, *arguments, **named)
        except BaseException:
            # what rclpy's own constructor makes last; a refused parent class has left already
            if hasattr(self, "_type_description_service"):
                Node.destroy_node(self)  # not the class's own, which may need what was not made
                del self._type_description_service
            raise

    node_class.__init__ = constructed  # type: ignore[method-assign]
    return node_class
