"""The bench of the Politecnico di Torino: own units scale every machine to its size.

In SI: rms torque and speed over ramps, sines, triangles and steps (six recordings of bench_cases, median of 28 cases),
inertia and torque constant of its model.
"""

TORQUE = 0.34  # N m
INERTIA = 1.77175e-3  # kg m^2
TORQUE_CONSTANT = 1.91  # N m/A
MOTOR_SPEED = 6.9  # rad/s
DRUM_SPEED = 10.0  # rad/s, of the drum that represents a linear machine
OUTPUT_FRICTION = 0.2  # N m: assumed friction that holds an output within backlash, if no torque is recorded
LONGEST_PERIOD = 0.01  # s: samples closer than this resolve its contact
SHORTEST_PERIOD = 1e-6  # s: stamps in whole nanoseconds keep samples apart that are no closer
