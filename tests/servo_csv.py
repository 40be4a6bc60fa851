"""CSVs of a simulated servo in the tutorials' words, for tests of what somebody meets who has nothing else."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from tests.accuracy.strangers.cases import Stranger
from tests.accuracy.strangers.servo import Servo

RATIO, TORQUE_CONSTANT = 80.0, 0.05  # N m/A
SIGNALS = "current", "speed", "speed_setpoint", "motor_position", "output_position"


def write_servo(
    folder: Path,
    hidden: Mapping[str, Mapping[str, float]] | None = None,
    signals: tuple[str, ...] = SIGNALS,
    top_speed: float = 300.0,
) -> list[Path]:
    """Three recordings of a servo of ratio 80, 8 s at 1 kHz each: far and back, two sines, slowly to and fro."""
    servo = Servo(
        inertia=2e-5,
        viscous=1e-4,
        dry=0.02,
        torque_constant=TORQUE_CONSTANT,
        top_speed=top_speed,
        top_current=8.0,
        ratio=RATIO,
        share_behind=0.3,
        hidden={name: dict(parameters) for name, parameters in (hidden or {}).items()},
    )
    files = Stranger("run", (5,), servo, 1e-3, 8.0, signals, "english", plain=True).write(folder)
    (folder / "answer.json").unlink()
    return files
