"""The curves of a page are in the units of the errors that stand above them."""

from dataclasses import replace

import numpy as np
import pytest

from ema_twin_sim.comparison.beyond_noise import shown_signals
from ema_twin_sim.comparison.compare import compare
from ema_twin_sim.model import load_model
from ema_twin_sim.report.beside import beside
from tests.recorded import record


@pytest.mark.parametrize("by_torque", [False, True])
@pytest.mark.parametrize("source", ["setpoint", "current"])
@pytest.mark.parametrize("name", ["polito_bench", "emps"])
def test_a_curves_error_is_that_of_the_comparison(name, source, by_torque):
    model = load_model(name)
    (run,) = record(model, ("sine:0.05:0.5",), seconds=4.0)
    if by_torque:
        others = {signal: values for signal, values in run.signals.items() if signal != "current"}
        torque = model.value("machine.torque_constant") * run.signals["current"]
        run = replace(run, signals={**others, "motor_torque": torque})
    (curves,) = beside([run], model, source)
    compared = compare([run], model, source)
    names = shown_signals(compared.input, compared.overall)
    assert ("motor_torque" in names) == (by_torque and source == "setpoint")
    for signal in names:
        error = compared.overall[signal]
        residual = curves.curves[signal].residual
        assert np.sqrt(np.nanmean(residual**2)) == pytest.approx(error["rmse"], rel=1e-6)
        assert curves.curves[signal].unit == error["unit"]
        if signal in curves.stretches:
            assert curves.stretches[signal].residual == pytest.approx(residual, nan_ok=True)
