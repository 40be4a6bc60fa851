"""A twin on its own clock: it follows a command, not a bench. No ROS."""

from __future__ import annotations

import numpy as np

from ..model import Model
from ..simulation.command import Command
from ..simulation.dc_link_check import refuse_command_beyond_link
from ..simulation.twin import Twin
from .pace import Pace
from .warm_up import warm_up_twin

_LOOKED_AT = 60.0
"""Length in s of the part of a command that is checked for the speed that the DC link limits."""


class Standalone:
    """A twin driven by a command of the slow shaft.

    Attributes:
        twin: the twin; its parameters may be changed between two samples.
        pace: how fast the twin computes.
    """

    def __init__(self, model: Model, command: Command) -> None:
        refuse_command_beyond_link(model, command, np.arange(0.0, _LOOKED_AT, 0.01))
        source = "standalone_speed" if command.speed else "standalone"
        warm_up_twin(model, source)
        self.twin = Twin(model, source)
        self.pace = Pace()
        self._command = command
        self._time: int | None = None

    def answer(self, time: int) -> dict[str, float]:
        """The twin's signals (SI) at `time`, ns since the start; the first call starts it."""
        sample = self._sample(time)
        if self._time is None:
            answer = self.twin.start(sample, 0.0, 0.0)
        else:
            elapsed = time - self._time
            answer = self.pace.timed(elapsed, lambda: self.twin.advance(elapsed, sample))
        self._time = time
        return answer

    def _sample(self, time: int) -> dict[str, float]:
        value = self._command(np.array([time * 1e-9])).item()
        if self._command.speed:
            return {"speed_setpoint": value * self.twin.model.value("machine.gear_ratio")}
        return {"output_command": value}
