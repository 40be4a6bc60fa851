"""The bench of the Politecnico di Torino, in whose size own units tell every machine.

In SI: rms torque and speed over ramps, sines, triangles and steps (six recordings of bench_cases, median of 28 cases),
inertia and torque constant of its model.
"""

TORQUE = 0.34  # N m
INERTIA = 1.77175e-3  # kg m^2
TORQUE_CONSTANT = 1.91  # N m/A
MOTOR_SPEED = 6.9  # rad/s
DRUM_SPEED = 10.0  # rad/s, of the drum that a carriage runs round
OUTPUT_FRICTION = 0.2  # N m: what holds an output in its play, where no torque tells it
