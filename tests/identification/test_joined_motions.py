"""Recordings that are predicted in one compiled call, and effects' rows that a search keeps from round to round."""

import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from ema_twin_sim.identification.equation import EquationErrorProblem, torque_scale
from ema_twin_sim.identification.hypothesis import DRY_SCALE
from ema_twin_sim.identification.joined_motions import JoinedMotions
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from ema_twin_sim.measured.smoothing import gaussian, smooth_at
from ema_twin_sim.model import EffectInstance
from ema_twin_sim.plant.measured_motion import REQUIRED, REQUIRED_TORQUE, inverse_dynamics
from ema_twin_sim.plant.motion import MOTOR_ANGLE, SPEED
from ema_twin_sim.plant.output_side import LOW_SPEED
from ema_twin_sim.simulation.assembly import assemble
from tests.few_rows import few_rows

NOISE = 0.01  # N m
DISSIPATIVE = {"kind": "dissipative"}


@pytest.fixture(scope="module")
def recordings():
    """Three recordings that turn to and fro, of different lengths, kernels and zeros of their counters."""
    found = []
    for k, rows in enumerate((40, 25, 60)):
        o = few_rows(np.zeros(rows), NOISE)
        time = np.arange(len(o.motion)) * 0.01
        motion = o.motion.copy()
        motion[:, MOTOR_ANGLE] = (8.0 + k) * np.sin(2.0 * time)
        motion[:, SPEED] = 2.0 * (8.0 + k) * np.cos(2.0 * time)
        kernel = gaussian(0.01 * (1 + k), 0.01)
        inside = (o.rows >= len(kernel) // 2) & (o.rows < len(motion) - len(kernel) // 2)
        measured = ("rows", "torque", "torque_rate", "acceleration", "acceleration_rest", "torque_noise")
        kept = {name: getattr(o, name)[inside] for name in measured}
        found.append(replace(o, motion=motion, kernel=kernel, motor_origin=0.3 * k, **kept))
    return found


@pytest.fixture(scope="module")
def problem(recordings):
    return EquationErrorProblem(recordings)


@pytest.fixture(scope="module")
def waved(stock):
    return null_hypothesis(stock).with_effect("sun_runout", DISSIPATIVE, {"torque": 0.01, "phase": 0.4})


def test_all_recordings_together_need_what_each_needs_alone(problem, recordings, waved):
    predicted = problem.predict(waved)
    assembly = assemble(waved.model())
    for k, o in enumerate(recordings):
        required = np.empty((len(o.motion), len(REQUIRED)))
        of = (assembly.plant, assembly.effects, o.motion, o.motor_origin, o.output_origin)
        inverse_dynamics(*of, np.zeros(0), False, LOW_SPEED, required)
        assert np.array_equal(predicted.required_by_recording[k], required)
        torque = np.empty(len(o.rows))
        smooth_at(required[:, REQUIRED_TORQUE].copy(), o.kernel, o.rows, torque)
        alone = EquationErrorProblem([o])
        assert np.array_equal(predicted.rows[problem.torque_parts[k]], alone.predict(waved).rows)
        inertia = assembly.plant["motor_inertia"][0] + assembly.plant["output_inertia"][0]
        whole = (torque + inertia * o.acceleration) / torque_scale(assembly.plant[0]) / o.torque_noise
        assert predicted.rows[problem.torque_parts[k]] == pytest.approx(whole, rel=1e-12)


def test_two_threads_predict_a_compliant_shaft_as_one_does(problem, waved, monkeypatch):
    monkeypatch.setattr("ema_twin_sim.parallel._MANY", 0)  # two threads, however few samples there are
    threads = set()
    require = JoinedMotions.require
    monkeypatch.setattr(
        JoinedMotions, "require", lambda *of: threads.add(threading.get_ident()) or time.sleep(0.1) or require(*of)
    )
    compliant = waved.with_effect("shaft_compliance", {}, {"stiffness": 20.0, "damping": 0.01})
    with ThreadPoolExecutor(1) as caller:  # in a test process beside others, its own thread does all alone
        together = caller.submit(problem.predict, compliant, side_by_side=True).result()
    alone = problem.predict(compliant)
    assert len(threads) == 3  # two, and this one
    assert together.plant["two_inertia"][0] != 0.0
    assert np.array_equal(together.required, alone.required) and np.array_equal(together.rows, alone.rows)


def test_rows_of_friction_levels_are_alike_beside_any_higher_level(problem, stock):
    """A wave of friction adds the same beside much and little dry friction, until it cuts the level off at zero."""
    bare = null_hypothesis(stock)
    level = problem.predict(bare).lowest_dry_level
    wave = [EffectInstance("sun_runout", DISSIPATIVE, {"torque": 0.1 * level, "phase": 0.4})]
    predicted = {scale: problem.predict(bare.put({DRY_SCALE: scale})) for scale in (0.5, 1.0, 2.0)}
    assert len({p.lowest_dry_level for p in predicted.values()}) == 3
    kept = problem.alike_beside_any(predicted[1.0], wave)
    for beside in predicted.values():
        assert problem.alike_beside_any(beside, wave) is kept
        assert kept[:, 0] == pytest.approx(problem.alone(beside, wave[0])[: problem.size], abs=1e-9)
    larger = [replace(wave[0], parameters={"torque": 10.0 * level, "phase": 0.4})]
    for beside in predicted.values():
        assert problem.alike_beside_any(beside, larger) is None
