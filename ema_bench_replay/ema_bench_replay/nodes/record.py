"""The node `record`: writes topics to a bag as they arrive."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from fnmatch import fnmatchcase
from functools import partial
from importlib import import_module
from pathlib import Path

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
from .whole_or_none import whole_or_none

PARAMETERS = (
    Declaration("output", "", "folder to make, with the MCAP and its metadata.yaml"),
    Declaration("topics", ("*",), "topics to record; * and ? stand for any text and any character"),
    Declaration("max_bagfile_size", 0, "size at which the next file begins; 0: no limit", unit="byte", lower=0),
    Declaration("max_bagfile_duration", 0.0, "longest span of one file; 0: no limit", unit="s", lower=0.0),
)

_LOOK_AROUND = 0.1
"""s between checks for new topics."""
_COLLECT = 0.01
"""s between two reads of the messages kept by DDS."""
_AT_ONCE = 2000
"""Maximum messages of a topic taken at once, so that other topics and a signal to end do not wait longer."""
_LAST_WORDS = 10.0
"""s at the end for messages that have arrived and were not taken yet."""
_FLUSH = 0.1
"""s after which a message is on disk, even at low rates."""
_WATCH = 1.0
"""s between two checks whether the files still exist."""


@whole_or_none
class RecordNode(Node):
    """Records every message of the topics in serialised form.

    A subscription matches its publishers: reliable if every publisher is, so that nothing is lost, and with earlier
    messages if every publisher keeps them. Losses are counted.

    The recorded topics are not served by the executor but read on a timer. Only then do messages come with their times
    and numbers (`EventsExecutor` of these rclpy versions fails if a callback wants them). DDS's own report of losses
    must not be used: reading it while more are lost blocks rmw_fastrtps.

    If the disk is full, or the file or its folder is gone, this is reported, messages wait in memory, and the recording
    continues when possible; losses are counted. Files are split if requested, as with `ros2 bag record`.

    Attributes:
        missed: messages that did not arrive, by topic.
        faults: why the finished recording is incomplete, in words; empty if it is complete, or lacks only best-effort
            messages that did not arrive.
    """

    def __init__(self, *, parameters: Sequence[Parameter] = (), context: Context | None = None) -> None:
        """Raises InputError if a parameter is wrong, or the output cannot be written."""
        super().__init__("record", parameter_overrides=list(parameters), context=context)
        given = declare(self, PARAMETERS)
        refuse_unknown(self)
        if not given["output"]:
            raise InputError("record: parameter output: it is not given; give output:=FOLDER")
        self._patterns = given["topics"]
        self._writer = StreamWriter(
            given["output"], max_size=given["max_bagfile_size"], max_duration=given["max_bagfile_duration"]
        )
        self._recorded: dict[str, Subscription] = {}
        self._numbers: dict[str, PublishedNumbers] = {}
        self._best_effort: set[str] = set()
        self._unreadable: dict[str, str] = {}
        self._problem = ""
        self._removed: set[Path] = set()
        self._closed = False
        self.missed: dict[str, int] = {}
        self.faults = ""
        self._diagnostics = diagnostics.Diagnostics(self, "bag", str(given["output"]), self._report)
        self._look_around()
        steady_timer(self, _LOOK_AROUND, self._look_around)
        steady_timer(self, _COLLECT, self._collect)
        steady_timer(self, _FLUSH, self._flush)
        steady_timer(self, _WATCH, self._watch)

    @property
    def ready_words(self) -> str:
        """The line that the node logs when it runs."""
        return f"writes {', '.join(self._patterns)} to {self._writer.path}"

    @property
    def subscriptions(self) -> Iterator[Subscription]:
        """Subscriptions served by the executor: none of the recorded topics."""
        recorded = {id(subscription) for subscription in self._recorded.values()}
        return (subscription for subscription in super().subscriptions if id(subscription) not in recorded)

    def _look_around(self) -> None:
        for topic, types in self.get_topic_names_and_types():
            wanted = any(fnmatchcase(topic, pattern) for pattern in self._patterns)
            if wanted and topic not in self.missed and topic not in self._unreadable and self.count_publishers(topic):
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
        self.missed[topic] = 0
        self._numbers[topic] = PublishedNumbers(partial(self.count_publishers, topic))
        profile = _matching(offered)
        if profile.reliability == ReliabilityPolicy.BEST_EFFORT:
            self._best_effort.add(topic)
        # rclpy requires a callback, but no executor serves the subscription
        self._recorded[topic] = self.create_subscription(message_type, topic, lambda _message: None, profile, raw=True)

    def _collect(self) -> bool:
        """Take the messages that have arrived; returns whether there were any."""
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
        self.missed[topic] += self._numbers[topic].lost_before(info["publication_sequence_number"])
        self._writer.write(topic, message, info["received_timestamp"] or time.time_ns(), info["source_timestamp"])

    def _flush(self) -> None:
        self._writer.flush()
        before, self._problem = self._problem, self._writer.problem
        if self._problem and not before:
            self.get_logger().error(f"{self._problem}; messages wait in memory")
        elif before and not self._problem:
            self.get_logger().warning(f"writes again, to {self._writer.path}")

    def _watch(self) -> None:
        for file in self._writer.removed:
            if file.path not in self._removed:
                self._removed.add(file.path)
                self.get_logger().error(f"{file.path} was removed or moved, with {file.messages} messages")

    def _report(self) -> diagnostics.Report:
        written, lost, waiting = self._writer.written, sum(self.lost.values()), self._writer.waiting
        if self._problem:
            wait = f"{waiting} messages wait, {lost} are lost"
            level, message = diagnostics.ERROR, f"{self._problem}; {wait}"
        elif lost:
            level = diagnostics.ERROR if self._is_at_fault(self.lost) else diagnostics.WARN
            message = f"{lost} messages are lost: {self._reasons()}"
        elif self._unreadable:
            level, message = diagnostics.WARN, f"not recorded, type not installed: {', '.join(self._unreadable)}"
        else:
            level, message = diagnostics.OK, f"records {len(written)} topics"
        figures: dict[str, object] = {topic: f"{count} messages written" for topic, count in written.items()}
        figures |= {"messages lost": lost, "messages waiting": waiting, "files": len(self._writer.files)}
        return diagnostics.Report(level, message, figures)

    @property
    def lost(self) -> dict[str, int]:
        """Messages that did not arrive, or arrived and are in no file, by topic."""
        unwritten = self._writer.lost
        return {topic: missed + unwritten[topic] for topic, missed in self.missed.items()}

    @property
    def exit_status(self) -> int:
        """Exit status of the process: 1 if the recording is incomplete."""
        return int(bool(self.faults))

    def _reasons(self) -> str:
        """Why messages are lost, in words."""
        gone = {file.path: file.messages for file in self._writer.removed}
        unwritten = sum(self._writer.lost.values()) - sum(gone.values())
        reasons = [f"{count} were in {path}, which was removed or moved" for path, count in gone.items()]
        if missed := ", ".join(f"{count} of {topic}" for topic, count in self.missed.items() if count):
            reasons.append(f"{missed} did not come")
        if unwritten:
            reasons.append(f"{unwritten} could not be written")
        return ", ".join(reasons)

    def _is_at_fault(self, lost: Mapping[str, int]) -> bool:
        """Whether any loss (by topic) is a fault: best-effort publishers may lose messages."""
        surely = (topic for topic, count in lost.items() if count and topic not in self._best_effort)
        return any(surely) or sum(self._writer.lost.values()) > 0

    def close(self) -> None:
        """Finish the file, and log its contents."""
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
        faults = []
        try:
            self._writer.finish()
        except InputError as error:
            faults.append(str(error))
        faults += [f"{path} has no index (ema-twin recover {path})" for path in self._writer.unfinished]
        files = self._writer.files
        where = f"{files[0] if files else self._writer.folder}{f' and {len(files) - 1} more' if len(files) > 1 else ''}"
        text = f"{sum(self._writer.written.values())} messages of {len(self.missed)} topics in {where}"
        lost = {topic: count for topic, count in self.lost.items() if count}
        counts = ", ".join(f"{count} of {topic}" for topic, count in lost.items())
        in_words = f"lost: {counts}{self._doubt()}: {self._reasons()}"
        if self._is_at_fault(lost):
            faults.insert(0, in_words)
        self.faults = "; ".join(faults)
        if faults:
            self.get_logger().error(f"{text}; {self.faults}")
        elif lost:  # only of topics with best-effort publishers
            self.get_logger().warning(f"{text}; {in_words}")
        else:
            self.get_logger().info(f"{text}, none lost{self._doubt()}")

    def _doubt(self) -> str:
        """Topics whose losses are unknown, in words."""
        unknown = [topic for topic, numbers in self._numbers.items() if not numbers.known]
        return f" (losses of {', '.join(unknown)} are not counted: its messages bear no numbers)" if unknown else ""


def _matching(offered: Sequence[QoSProfile]) -> QoSProfile:
    """The strictest profile that all publishers can serve."""
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
        history=profile.history.name.lower(),  # "unknown": DDS does not report it, and rosbag2 writes the same
        depth=profile.depth,
    )


def main() -> int:
    """Run the node in this process; returns the exit status."""
    return run(RecordNode, PARAMETERS)


if __name__ == "__main__":
    raise SystemExit(main())
