"""The signals in which a twin is compared with its bench: one table of what each of them means for every input."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from ema_bench_replay.units import signal_unit

from ..model import Model
from .sensor_noise import Sensors
from .simulate import BY_MOTOR, POINTWISE


@dataclass(frozen=True)
class ComparedSignal:
    """A signal whose noise floor is known.

    ``floor`` is the noise [SI] that remains if the twin is correct. ``sensor`` is the constant of a model that states
    it, which otherwise the recordings tell; empty if it follows from other signals. With the inputs ``given_with`` it
    drives the twin, so that its residual means nothing. One that ``drifts`` does so with the input ``current``, since
    nothing holds the twin's motion to the bench's.
    """

    floor: Callable[[Sensors], float]
    sensor: str = ""
    given_with: tuple[str, ...] = ()
    drifts: bool = False


COMPARED: dict[str, ComparedSignal] = {
    "current": ComparedSignal(lambda sensors: sensors.current, "sensors.current_noise", given_with=("current",)),
    "speed": ComparedSignal(
        lambda sensors: sensors.speed, "sensors.speed_noise", given_with=(POINTWISE, BY_MOTOR), drifts=True
    ),
    "motor_position": ComparedSignal(
        lambda sensors: sensors.position("motor"),
        "sensors.motor_encoder_counts",
        given_with=(POINTWISE, BY_MOTOR),
        drifts=True,
    ),
    "output_position": ComparedSignal(
        lambda sensors: sensors.position("output"),
        "sensors.output_encoder_counts",
        given_with=(POINTWISE,),
        drifts=True,
    ),
    "unexplained_torque": ComparedSignal(lambda sensors: sensors.balance()),
}
"""By name, in the order in which they are shown. The message ``Signals.msg`` has a field for each."""

ENCODER_DIFFERENCE = "encoder_difference"
OFFLINE: dict[str, ComparedSignal] = {ENCODER_DIFFERENCE: ComparedSignal(lambda sensors: sensors.encoder_difference())}
"""Those compared in whole recordings only (``encoder_difference.py``)."""

UNITS: dict[str, str] = {name: signal_unit(name) for name in COMPARED}
"""The units of those compared live, too; a residual is measured minus twin."""

ALL_UNITS: dict[str, str] = {**UNITS, ENCODER_DIFFERENCE: signal_unit("output_position")}
"""The units of all compared signals."""


def driving(source: str) -> frozenset[str]:
    """The compared signals that drive a twin with this input."""
    return frozenset(name for name, signal in COMPARED.items() if source in signal.given_with)


def drifting(source: str) -> frozenset[str]:
    """The compared signals that drift from the bench's with this input."""
    return frozenset(name for name, signal in COMPARED.items() if signal.drifts and source == "current")


def noise_floors(model: Model, *, has_speed: bool = True, period: float | None = None) -> dict[str, float]:
    """RMSE per compared signal that remains if the twin is correct, SI.

    Current and speed: their sensors' white noise. Positions: the counter's noise and quantisation twice, since they
    count from one noisy first sample; the twin's own quantisation; and a lasting lag of the speed loop caused by the
    first sample's current noise, from which the drive's integrator starts. The unexplained torque: the noise of current
    and speed (or, if ``has_speed`` is false, of the motor counter used instead) through the filters of
    ``plant.balance`` at a sample ``period`` [s] (by default the model's). The encoder difference: one sample of each
    counter.
    """
    sensors = Sensors(model, has_speed, period or model.value("sensors.sample_period"))
    return {name: signal.floor(sensors) for name, signal in {**COMPARED, **OFFLINE}.items()}
