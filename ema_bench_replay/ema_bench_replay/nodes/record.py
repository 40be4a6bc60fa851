"""The node `record`: topics into a bag, as they come."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from fnmatch import fnmatchcase
from functools import partial
from importlib import import_module

from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription

from ema_bench_replay.bags.bag_metadata import qos_profile
from ema_bench_replay.bags.stream_writer import StreamWriter
from ema_bench_replay.errors import InputError

from . import diagnostics
from .parameters import Declaration, declare, refuse_unknown
from .published_numbers import PublishedNumbers
from .spin import run, steady_timer

PARAMETERS = (
    Declaration("output", "", "folder to make, with the MCAP and its metadata.yaml"),
    Declaration("topics", ("*",), "topics to record; * and ? stand for any text and any character"),
)

_LOOK_AROUND = 0.1
"""s between two looks for topics that have come up."""
_COLLECT = 0.01
"""s between two emptyings of what DDS has kept for us."""
_AT_ONCE = 2000
"""Messages of a topic taken in one go: the others, and a signal to end, shall not wait longer."""
_LAST_WORDS = 10.0
"""s at the end for what has arrived and was not taken yet."""
_FLUSH = 0.15
"""s after which a message is on disk, however slowly they come."""


class RecordNode(Node):
    """Records every message of the topics, serialised as it is.

    A topic is subscribed to as it is published: reliable where every publisher is, so that nothing is lost, with the
    messages sent before where every publisher keeps them. What is lost is counted.

    The recorded topics are not served by the executor but emptied on a timer: only so do messages come with their times
    and numbers (`EventsExecutor` of these rclpy versions fails where a callback wants them), and DDS's own report of
    losses must not be asked for: taking it while more are lost locks up rmw_fastrtps.

    Attributes:
        written: messages written, by topic.
        lost: messages lost, by topic.
    """

    def __init__(self, *, parameters: Sequence[Parameter] = (), context: Context | None = None) -> None:
        """Raises InputError where a parameter is wrong, or the output cannot be written."""
        super().__init__("record", parameter_overrides=list(parameters), context=context)
        given = declare(self, PARAMETERS)
        refuse_unknown(self)
        if not given["output"]:
            raise InputError("record: parameter output: it is not given; give output:=FOLDER")
        self._patterns = given["topics"]
        self._writer = StreamWriter(given["output"])
        self._recorded: dict[str, Subscription] = {}
        self._numbers: dict[str, PublishedNumbers] = {}
        self._unreadable: dict[str, str] = {}
        self._problem = ""
        self._closed = False
        self.written: dict[str, int] = {}
        self.lost: dict[str, int] = {}
        self._diagnostics = diagnostics.Diagnostics(self, "bag", str(given["output"]), self._report)
        self._look_around()
        steady_timer(self, _LOOK_AROUND, self._look_around)
        steady_timer(self, _COLLECT, self._collect)
        steady_timer(self, _FLUSH, self._flush)

    @property
    def ready_words(self) -> str:
        """What the node says when it runs."""
        return f"writes {', '.join(self._patterns)} to {self._writer.path}"

    @property
    def subscriptions(self) -> Iterator[Subscription]:
        """Those that an executor serves: none of the recorded topics."""
        recorded = {id(subscription) for subscription in self._recorded.values()}
        return (subscription for subscription in super().subscriptions if id(subscription) not in recorded)

    def _look_around(self) -> None:
        for topic, types in self.get_topic_names_and_types():
            wanted = any(fnmatchcase(topic, pattern) for pattern in self._patterns)
            if wanted and topic not in self.written and topic not in self._unreadable and self.count_publishers(topic):
                self._subscribe(topic, types[0])

    def _subscribe(self, topic: str, type_name: str) -> None:
        package, _, name = type_name.split("/")
        offered = [endpoint.qos_profile for endpoint in self.get_publishers_info_by_topic(topic)]
        try:
            message_type = getattr(import_module(f"{package}.msg"), name)
            self._writer.add_topic(topic, type_name, "\n".join(map(_as_yaml, offered)))
        except (ImportError, AttributeError, InputError) as error:
            self._unreadable[topic] = type_name
            self.get_logger().warning(f"{topic} is not recorded: {type_name} is not installed here ({error})")
            return
        self.written[topic] = self.lost[topic] = 0
        self._numbers[topic] = PublishedNumbers(partial(self.count_publishers, topic))
        # rclpy wants a callback, but no executor serves the subscription
        self._recorded[topic] = self.create_subscription(
            message_type, topic, lambda _message: None, _matching(offered), raw=True
        )

    def _collect(self) -> bool:
        """Take what has come; whether there was anything."""
        any_came = False
        for topic, subscription in self._recorded.items():
            for _ in range(_AT_ONCE):
                taken = subscription.handle.take_message(subscription.msg_type, True)
                if taken is None:
                    break
                any_came = True
                self._on_message(topic, *taken)
        return any_came

    def _on_message(self, topic: str, message: bytes, info: Mapping[str, int | None]) -> None:
        self.lost[topic] += self._numbers[topic].lost_before(info["publication_sequence_number"])
        if self._problem:
            self.lost[topic] += 1
            return
        try:
            arrived = info["received_timestamp"] or time.time_ns()
            self._writer.write(topic, message, arrived, info["source_timestamp"])
        except InputError as error:
            self._fail(error)
        else:
            self.written[topic] += 1

    def _flush(self) -> None:
        if not self._problem:
            try:
                self._writer.flush()
            except InputError as error:
                self._fail(error)

    def _fail(self, error: InputError) -> None:
        """The disk is full, or gone: what is written stays, and the node goes on to say so."""
        self._problem = str(error)
        self.get_logger().error(self._problem)

    def _report(self) -> diagnostics.Report:
        lost = sum(self.lost.values())
        if self._problem:
            level, message = diagnostics.ERROR, self._problem
        elif lost:
            level, message = diagnostics.ERROR, f"{lost} messages did not come, or were not written"
        elif self._unreadable:
            level, message = diagnostics.WARN, f"not recorded, type not installed: {', '.join(self._unreadable)}"
        else:
            level, message = diagnostics.OK, f"records {len(self.written)} topics"
        figures = {topic: f"{count} messages written" for topic, count in self.written.items()}
        return diagnostics.Report(level, message, {**figures, "messages lost": lost})

    def close(self) -> None:
        """Finish the file, and say what is in it."""
        if self._closed:
            return
        self._closed = True
        until = time.monotonic() + _LAST_WORDS
        try:
            while self._collect() and time.monotonic() < until:
                pass
        finally:
            self._finish()

    def destroy_node(self) -> None:
        """Close, then end the node."""
        self.close()
        super().destroy_node()

    def _finish(self) -> None:
        try:
            self._writer.finish()
        except InputError as error:
            self._fail(error)
        text = f"{sum(self.written.values())} messages of {len(self.written)} topics in {self._writer.path}"
        lost = [f"{count} of {topic}" for topic, count in self.lost.items() if count]
        if self._problem:
            after = sum(self.lost.values())
            self.get_logger().error(f"{self._problem}; {after} messages that came afterwards are not recorded")
        elif lost:
            self.get_logger().warning(f"{text}; lost: {', '.join(lost)}{self._doubt()}")
        else:
            self.get_logger().info(f"{text}, none lost{self._doubt()}")

    def _doubt(self) -> str:
        """Of which topics losses are not known, in words."""
        unknown = [topic for topic, numbers in self._numbers.items() if not numbers.known]
        return f" (losses of {', '.join(unknown)} are not counted: its messages bear no numbers)" if unknown else ""


def _matching(offered: Sequence[QoSProfile]) -> QoSProfile:
    """The strongest profile that all publishers can serve."""
    reliable = all(profile.reliability == ReliabilityPolicy.RELIABLE for profile in offered)
    kept = all(profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for profile in offered)
    return QoSProfile(
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if kept else DurabilityPolicy.VOLATILE,
        history=HistoryPolicy.KEEP_ALL,
    )


def _as_yaml(profile: QoSProfile) -> str:
    return qos_profile(
        reliability=profile.reliability.name.lower(),
        durability=profile.durability.name.lower(),
        history=profile.history.name.lower(),  # "unknown": DDS does not tell it, and rosbag2 writes the same
        depth=profile.depth,
    )


def main() -> int:
    """Run the node in this process; returns the exit status."""
    return run(RecordNode, PARAMETERS)


if __name__ == "__main__":
    raise SystemExit(main())
