"""What real benches do to a diagnosis besides having an effect: each a switch, all off on a kind bench."""

from __future__ import annotations

from dataclasses import dataclass

COUNTERS_AND_CURRENT = ("current", "motor_position", "output_position")
"""The signals of a partial trace."""


@dataclass(frozen=True)
class Unkind:
    """Switches of unkindness."""

    controller_noise: float = 0.0  # rad/s of white noise on the drive's own speed, each control cycle
    gear_resonance: float = 0.0  # Hz at which a softish, lightly damped gearbox rings (0: it is stiff)
    load_resonance: float = 0.0  # Hz at which half of the load rings on a coupling beyond the encoder (0: none)
    wander: float = 0.0  # share by which friction wanders over minutes
    warming: float = 0.0  # share by which viscous friction falls over the first minutes of a day
    interpolation: float = 0.0  # rad of the slow shaft, error within the output encoder's lines
    spikes: float = 0.0  # share of samples with a spike in the current or in a counter
    uneven: float = 0.0  # share of the sample period by which stamps are uneven
    dropped: float = 0.0  # share of rows that are missing, in bursts
    counter_jump: bool = False  # the motor counter jumps mid-run
    power_cycled: bool = False  # the counters start elsewhere in each recording, unlike the shafts
    signals: tuple[str, ...] = ()  # those that the trace holds (none given: all)
