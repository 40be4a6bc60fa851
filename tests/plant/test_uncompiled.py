"""What the compiler makes of the plant's text is what the text says: the same run with and without it."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
CHILD = """
import json, sys
if {plain}:
    import tests.uncompiled
import numpy as np
from ema_twin_sim.model.model_file import load_model
from ema_twin_sim.simulation.twin import Twin
model = load_model("polito_bench")
for effect, parameters in {effects}.items():
    model = model.with_effect(effect, parameters)
twin = Twin(model, "setpoint")
start = dict(speed=2.0, speed_setpoint=2.0, current=0.5, motor_position=0.0, output_position=0.0)
rows = [twin.start(start)]
for k in range(1, 6):
    rows.append(twin.advance(2_000_000, dict(start, speed_setpoint=2.0 - 1.5 * k)))
print(json.dumps([[row[name] for name in sorted(row)] for row in rows]))
"""
EFFECTS = [
    {"stribeck_friction": {"torque": 0.05, "speed": 2.0}, "gravity_load": {"torque": 0.05, "angle": 0.3}},
    {"backlash": {"width": 0.001}, "encoder_delay": {"delay": 0.003}, "quadratic_drag": {"coefficient": 1e-4}},
    {"presliding_friction": {"stiffness": 3.0, "damping": 0.01}, "asymmetric_friction": {"fraction": 0.2}},
]


@pytest.mark.slow
@pytest.mark.parametrize("effects", EFFECTS)
def test_compiled_as_written(effects):
    """Through a reversal, with play, a delay, bristles and loads: to the last digits, as products may be fused."""
    found = []
    for plain in (False, True):
        words = [sys.executable, "-c", CHILD.format(plain=plain, effects=effects)]
        told = subprocess.run(words, cwd=ROOT, check=True, capture_output=True, text=True).stdout
        found.append(np.array(json.loads(told), float))
    compiled, written = found
    assert len(compiled) == 6 and np.isfinite(compiled).any()
    assert written == pytest.approx(compiled, rel=1e-9, abs=1e-12, nan_ok=True)
