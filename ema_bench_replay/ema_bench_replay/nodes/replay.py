"""The node `replay`: publishes a recording's samples on `/bench/state` at their times."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

from rcl_interfaces.msg import SetParametersResult
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock
from std_srvs.srv import Trigger

from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from ema_bench_replay.recording import Recording, refuse_points
from ema_twin_msgs.msg import EmaState, Run
from ema_twin_msgs.srv import Seek

from . import diagnostics, qos
from .joint_states import JointStates
from .keep_all_publisher import KeepAllPublisher
from .messages import header
from .parameters import Declaration, check_all, declare, refuse_unknown
from .playback import Playback
from .played_run import PlayedRun
from .reached_rate import ReachedRate, rate_in_words
from .sample_codec import write_state
from .spin import run, steady_timer
from .whole_or_none import whole_or_none

PARAMETERS = (
    Declaration("recording", "", "recording to play: an MCAP, the folder that import wrote, or a CSV trace"),
    Declaration("map", "siemens", "import map that names a CSV's columns: a shipped name or a YAML file"),
    Declaration(
        "rate", 1.0, "speed of playing, 1 is real time; 0 plays as fast as it goes", "", 0.0, 1000.0, fixed=False
    ),
    Declaration("loop", False, "begin again after the last sample"),
    Declaration("start", 0.0, "place in the recording to start from, and to return to in a loop", "s", 0.0, 1e6),
    Declaration("paused", False, "wait for the resume or step service before the first sample"),
    Declaration("on_end", "exit", "what to do after the last sample", choices=("exit", "wait")),
    Declaration("subscribers", 2, "readers of bench/state to wait for before the first sample", "", 0, 100),
    Declaration("patience", 5.0, "longest time to wait for those readers", "s", 0.0, 3600.0),
)

_BURST = 32
"""Maximum samples sent at once, so that the executor's other callbacks (services, other nodes) get their turn."""
_SHORTEST_PERIOD = 0.001
"""s between two checks for due samples; several are due if the recording is faster."""
_EARLY = 100_000
"""ns by which a sample may be sent early, rather than a period late."""
_CLOCK_PERIOD = 0.02
"""s."""
_LOOK_AROUND = 0.02
"""s between two checks of the readers, while waiting for them."""
_LONGEST_END = 60 * 10**9
"""Longest wait [ns] at the end: Fast DDS resends 256 samples every 3 s to a reader that is behind."""


@whole_or_none
class ReplayNode(Node):
    """Plays a recording.

    Every start, loop and seek begins a run, announced on `bench/run`, with sequence from 0, positions from zero and the
    recording's stamps from there; a pause does not. Run numbers increase by one; the first of a process is its start
    time in seconds since the epoch, so that it differs from an earlier process's.

    Attributes:
        finished: the last sample was sent and received by every reader; the node is to end (`on_end` is `exit`).
    """

    def __init__(
        self,
        recording: Recording | None = None,
        *,
        parameters: Sequence[Parameter] = (),
        context: Context | None = None,
    ) -> None:
        """Play `recording`, or the one named by the parameter. Raises InputError if a parameter is wrong."""
        super().__init__("replay", parameter_overrides=list(parameters), context=context)
        given = declare(self, PARAMETERS)
        refuse_unknown(self)
        if recording is None:
            if not given["recording"]:
                raise InputError("replay: parameter recording: it is not given; give recording:=FILE")
            recording = load(given["recording"], import_map=given["map"])
        refuse_points(recording)
        for warning in recording.warnings:
            self.get_logger().warning(warning)
        self.finished = False
        self._recording = recording
        self._exit_at_end = given["on_end"] == "exit"
        try:
            self._playback = Playback(
                recording.stamps,
                rate=given["rate"],
                loop=given["loop"],
                start=given["start"],
                paused=given["paused"],
            )
        except InputError as error:
            raise InputError(f"{recording.name}: start: {error}") from None
        self._next_run = int(time.time()) % 2**32
        self._played: PlayedRun | None = None
        self._announced = 0
        self._behind = False
        self._started = False
        self._waits_until = time.monotonic_ns() + int(given["patience"] * 1e9)
        self._wanted_readers = given["subscribers"]
        self._worst_delay = 0
        self._reached = ReachedRate(recording.sample_period)

        self._publisher = KeepAllPublisher(self, EmaState, "bench/state", qos.STATE)
        self._run_publisher = self.create_publisher(Run, "bench/run", qos.LATEST)
        self._clock_publisher = self.create_publisher(Clock, "/clock", qos.CLOCK)
        self._joints = JointStates(self, "bench/joint_states")
        self._diagnostics = diagnostics.Diagnostics(self, "recording", recording.name, self._report)
        self.create_service(Trigger, "~/pause", self._on_pause)
        self.create_service(Trigger, "~/resume", self._on_resume)
        self.create_service(Trigger, "~/step", self._on_step)
        self.create_service(Seek, "~/seek", self._on_seek)
        self.add_on_set_parameters_callback(self._on_parameters)
        steady_timer(self, _CLOCK_PERIOD, self._publish_clock)
        self._timer = steady_timer(self, _LOOK_AROUND, self._wait_for_readers)

    @property
    def ready_words(self) -> str:
        """The line that the node logs when it runs."""
        recording = self._recording
        return f"plays {recording.name}: {len(recording)} samples, {recording.duration:.1f} s"

    @property
    def ended(self) -> bool:
        """Whether the last sample was sent."""
        return self._playback.ended

    @property
    def run(self) -> int:
        """Number of the present run; 0 before the first."""
        return self._played.number if self._played else 0

    @property
    def sent(self) -> int:
        """Samples sent, of all runs."""
        return self._publisher.sent

    def _wait_for_readers(self) -> None:
        readers = self._publisher.readers
        if readers < self._wanted_readers:
            if time.monotonic_ns() < self._waits_until:
                return
            self.get_logger().warning(f"starts with {readers} of {self._wanted_readers} readers of bench/state")
        self._started = True
        self._playback.start(time.monotonic_ns())
        self._serve()

    def _serve(self) -> None:
        """Check for due samples once per sample period, counted from the start of the playback."""
        if self._playback.ended:
            return
        rate = self._playback.rate
        self._look(max(_SHORTEST_PERIOD, self._recording.sample_period / rate) if rate else 0.0, self._play)

    def _look(self, period: float, callback: Callable[[], None]) -> None:
        self._timer.cancel()
        self.destroy_timer(self._timer)
        self._timer = steady_timer(self, period, callback)

    def _play(self) -> None:
        """Send the due samples."""
        playback = self._playback
        for _ in range(_BURST):
            wait = playback.wait(time.monotonic_ns())
            if wait is None:
                self._timer.cancel()
                return
            if wait > _EARLY:
                return
            self._worst_delay = max(self._worst_delay, -wait)
            played = self._present_run()
            stamp, sequence, fields = played.sample(playback.next)
            self._behind = not self._publisher.try_send(write_state(stamp, played.number, sequence, fields))
            if self._behind:
                return
            self._joints.publish(stamp, fields)
            playback.played()
            if playback.ended:
                self._end(played)
                return

    def _present_run(self) -> PlayedRun:
        """The run of the playback's present pass; announced when it begins."""
        if self._played is None or self._announced != self._playback.passes:
            self._announced = self._playback.passes
            self._played = PlayedRun(self._recording, self._playback.first, self._next_run)
            self._next_run = (self._next_run + 1) % 2**32
            self._announce(self._played)
        return self._played

    def _announce(self, played: PlayedRun) -> None:
        part = played.part
        self._run_publisher.publish(
            Run(
                header=header(part.start),
                run=played.number,
                recording=part.name,
                samples=len(part),
                duration=part.duration,
                signals=list(part.signals),
            )
        )

    def _end(self, played: PlayedRun) -> None:
        count, name = len(played.part), played.part.name
        self.get_logger().info(f"sent {count} samples of {name} in run {played.number}, {self.sent} in all runs")
        self._timer.cancel()
        if self._exit_at_end:
            self._waits_until = time.monotonic_ns() + _LONGEST_END
            self._look(_LOOK_AROUND, self._leave)

    def _leave(self) -> None:
        """End once every reader has received everything: unsent data are lost with this process."""
        if self._publisher.all_received:
            self.finished = True
        elif time.monotonic_ns() > self._waits_until:
            self.get_logger().warning("a reader of bench/state has not received all samples")
            self.finished = True

    def _on_pause(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._playback.pause()
        return self._answer(response, "paused")

    def _on_resume(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._playback.resume(time.monotonic_ns())
        return self._answer(response, "playing")

    def _on_step(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        try:
            self._playback.step()
        except InputError as error:
            return Trigger.Response(success=False, message=str(error))
        return self._answer(response, "one sample")

    def _on_seek(self, request: Seek.Request, response: Seek.Response) -> Seek.Response:
        try:
            self._playback.seek(request.position, time.monotonic_ns())
        except InputError as error:
            return Seek.Response(success=False, message=str(error))
        return self._answer(response, "a new run begins")

    def _answer(self, response: Trigger.Response | Seek.Response, what: str) -> Trigger.Response | Seek.Response:
        if self._started:
            self._serve()
        response.success = True
        response.message = f"{what} at {self._playback.position(time.monotonic_ns()) * 1e-9:.3f} s"
        return response

    def _on_parameters(self, parameters: list[Parameter]) -> SetParametersResult:
        result = check_all(PARAMETERS, parameters)
        for parameter in parameters:
            if result.successful and parameter.name == "rate":
                self._playback.set_rate(float(parameter.value), time.monotonic_ns())
                if self._started:
                    self._serve()
        return result

    def _publish_clock(self) -> None:
        if self._started:
            now = self._recording.start + self._playback.position(time.monotonic_ns())
            self._clock_publisher.publish(Clock(clock=header(now).stamp))

    def _report(self) -> diagnostics.Report:
        playback = self._playback
        reached = None
        if self._started and not (playback.ended or playback.paused):
            reached = self._reached.look(self.sent, time.monotonic_ns())
        else:
            self._reached.pause()
        if not self._started:
            condition = f"waits for {self._wanted_readers} readers, {self._publisher.readers} are there"
        elif playback.ended:
            condition = "ended, every sample is sent"
        else:
            condition = "paused" if playback.paused else f"playing at {rate_in_words(playback.rate, reached)}"
        if self._behind:
            condition = "a reader is behind; waits for it, nothing is lost"
        return diagnostics.Report(
            diagnostics.WARN if self._behind else diagnostics.OK,
            condition,
            {
                "run": self.run,
                "position": f"{playback.position(time.monotonic_ns()) * 1e-9:.2f} of {self._recording.duration:.2f} s",
                "rate": rate_in_words(playback.rate, None),
                "rate reached": None if reached is None else f"{reached:.3g} × real time",
                "samples sent": f"{self.sent} of {len(self._recording)}",
                "readers": self._publisher.readers,
                "sent again, a reader was behind": self._publisher.repeated,
                "longest delay": f"{self._worst_delay * 1e-6:.1f} ms",
            },
        )

    def destroy_node(self) -> None:
        """Log how many samples were sent, if the end was not reached."""
        if not self.ended:
            self.get_logger().info(f"stopped after {self.sent} samples of {self._recording.name}")
        super().destroy_node()


def main() -> int:
    """Run the node in this process; returns the exit status."""
    return run(ReplayNode, PARAMETERS)


if __name__ == "__main__":
    raise SystemExit(main())
