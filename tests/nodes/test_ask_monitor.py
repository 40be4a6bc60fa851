"""The documentation's client of the monitor tells only errors that the machine has."""

import math
import runpy
from pathlib import Path
from types import SimpleNamespace

import pytest

from ema_twin_msgs.msg import Health, Signals

EXAMPLE = Path(__file__).resolve().parents[2] / "docs" / "examples" / "ask_monitor.py"


@pytest.mark.parametrize(
    ("errors", "told"),
    [
        ({"current": 0.004, "output_position": 1e-3}, "now: current 4.0 mA (noise 1.0), output position 1.000 mrad"),
        ({"current": 0.0, "unexplained_torque": 0.02}, "now: unexplained torque 20.0 mN m (noise 1.0)"),
        ({"current": 0.0}, "now: no signal to compare"),
    ],
)
def test_signals_that_the_machine_lacks_are_left_out(capsys, errors, told):
    lacking = dict.fromkeys(Signals.get_fields_and_field_types(), math.nan)
    health = Health(
        rmse_window=Signals(**{**lacking, **errors}), noise_floor=Signals(**{**lacking, **dict.fromkeys(errors, 1e-3)})
    )
    runpy.run_path(str(EXAMPLE))["Client"].tell_errors(SimpleNamespace(health=health), "now")
    assert capsys.readouterr().out.startswith(told)
