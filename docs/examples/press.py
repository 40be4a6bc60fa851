"""Recordings of a machine that the project does not know, to try `init` with: `python docs/examples/press.py`.

It writes `press_0.csv` to `press_3.csv` into the present folder, as a logger would: a small press with a gear of ratio
12, sampled every 4 ms, in degrees and rpm. What the machine hides is written below.
"""

from pathlib import Path

import numpy as np

from ema_twin_sim import load_model
from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.virtual_bench import virtual_bench

CONSTANTS = {
    "machine.gear_ratio": 12.0,
    "machine.motor_inertia": 2.0e-4,  # kg m^2
    "machine.output_inertia": 5.0e-4,  # kg m^2, as the motor feels it
    "machine.torque_constant": 0.4,  # N m/A
    "sensors.motor_encoder_counts": 8192.0,
    "sensors.output_encoder_counts": 262144.0,
    "sensors.sample_period": 4.0e-3,  # s
    "sensors.speed_smoothing": 0.0,  # s
    "drive.position_gain": 240.0,  # 1/s
}
HIDDEN = {"torque": 0.09, "angle": 0.4}
"""Of the effect gravity_load: an arm on the output that nobody balanced; N m at the motor, rad."""
COMMANDS = ("ramp:0.5", "sine:0.6:0.5", "triangle:0.8:1.5", "sine:0.2:1.5")
SECONDS = 12.0
HEADER = "t [ms],shaft angle (deg),motor speed [rpm],motor current [A],link angle [deg],lab temperature [°C]"
DEGREES, RPM = 180.0 / np.pi, 30.0 / np.pi


def write(folder: Path) -> list[Path]:
    """The CSVs of the press in this folder, one a command."""
    press = load_model("polito_bench")
    for path, value in CONSTANTS.items():
        press = press.with_value(path, value)
    press = press.with_effect("gravity_load", HIDDEN)
    files = []
    for k, command in enumerate(COMMANDS):
        run = virtual_bench(press, parse_command(command), SECONDS, seed=k, origins=(0.0, 0.3))
        columns = [
            run.time * 1e3,
            run.signals["motor_position"] * DEGREES,
            run.signals["speed"] * RPM,
            run.signals["current"],
            (run.signals["output_position"] + run.output_angle_origin) * DEGREES,
            np.full(len(run), 21.5),
        ]
        files.append(folder / f"press_{k}.csv")
        np.savetxt(files[-1], np.column_stack(columns), "%.8g", ",", header=HEADER, comments="", encoding="utf-8")
    return files


if __name__ == "__main__":
    for file in write(Path()):
        print(file)
