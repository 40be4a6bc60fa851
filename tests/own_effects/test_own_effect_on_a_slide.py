"""A user's own effect on a linear machine: its numbers are metres, and it is named though it acts over a short way."""

from dataclasses import replace

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_twin_sim.comparison.compare import stretch_of
from ema_twin_sim.discovery.diagnose import weigh
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.discovery.evidence import evidence_json
from ema_twin_sim.effects import catalogue
from ema_twin_sim.fitting.fit import fit_model
from ema_twin_sim.model import load_model
from ema_twin_sim.model.own_units import OwnUnits, model_in, table_in
from ema_twin_sim.own_effects import load_effect
from ema_twin_sim.report.beside import beside
from tests.recorded import changed, sampled

MASS, VISCOUS, COULOMB, STRIBECK, SLOW = 38.0, 90.0, 45.0, 55.0, 0.004
MAGNET = {"force": 70.0, "centre": 0.13, "width": 0.012}
BEGINS = 0.02  # m, what the counter shows where each recording begins
FILE = '''"""A magnet beside a slide that pulls it to a place."""
import math
from ema_twin_sim.effects.effect import OUTPUT_TORQUE, Effect, Parameter

def act(at, p):
    u = (at.output_angle - p[1]) / p[2]
    return p[0] * u * math.exp(0.5 - 0.5 * u * u)

EFFECT = Effect(
    id="magnet", summary="s", equation="e", signature="s", source="s", depends_on="output_position",
    parameters=(
        Parameter("force", "N m", 30.0, 0.0, math.inf, "largest pull"),
        Parameter("centre", "rad", 0.1, -math.inf, math.inf, "where it is"),
        Parameter("width", "rad", 0.02, 0.0005, 0.05, "distance of the largest pull"),
    ),
    act=act, place=OUTPUT_TORQUE,
)
'''
MODEL = """version: 1
machine:
  name: slide
  motion: linear
  inertia: {value: 1, unit: kg, tolerance: open, source: start value}
drive:
  speed_gain: {value: 2600, unit: N s/m, tolerance: 0.2, source: data sheet}
  integral_time: {value: 0.03, unit: s, tolerance: 0.2, source: data sheet}
transmission: {kind: rigid}
sensors:
  motor_encoder_counts: {value: 1000000, unit: 1/m, tolerance: 0.0, source: data sheet}
  current_noise: {value: 1.0, unit: A, source: data sheet}
  sample_period: {value: 0.002, unit: s, tolerance: 0.0}
effects:
  viscous_friction: {effect: viscous_friction, options: {side: motor}, parameters: {coefficient: 10.0}, open: true}
  coulomb_friction:
    {effect: coulomb_friction, options: {side: motor}, parameters: {torque: 1.0, static_ratio: 1.0}, open: true}
"""

pytestmark = pytest.mark.usefixtures("catalogue_of_the_package")


def slid(swing, cycles, seed):
    """A slide moved to and fro past the magnet: way [m] and force [N] in steps of 0.1 N, by its equation of motion."""
    period = 2e-3
    time = np.arange(10_000) * period
    way = BEGINS + 0.5 * swing * (1.0 - np.cos(2.0 * np.pi * cycles * time))
    speed = np.gradient(way, period)
    sense = np.tanh(speed / 1e-5)
    u = (way - MAGNET["centre"]) / MAGNET["width"]
    force = MASS * np.gradient(speed, period) + VISCOUS * speed + MAGNET["force"] * u * np.exp(0.5 - 0.5 * u * u)
    force += sense * (COULOMB + STRIBECK * np.exp(-np.abs(speed) / SLOW))
    force += np.random.default_rng(seed).normal(0.0, 1.0, len(time))
    signals = {"motor_position": np.round(way - BEGINS, 6), "motor_torque": np.round(force, 1)}
    return replace(sampled(f"run{seed}", time, signals, metadata={"motion": "linear"}), motor_angle_origin=BEGINS)


@pytest.fixture
def slide(tmp_path):
    """(model, recordings) of the slide; its magnet's file is read."""
    (tmp_path / "magnet.py").write_text(FILE)
    (tmp_path / "slide.yaml").write_text(MODEL)
    load_effect(tmp_path / "magnet.py")
    return load_model(tmp_path / "slide.yaml"), [slid(0.2, 0.15, 1), slid(0.16, 0.4, 2), slid(0.15, 0.05, 3)]


def test_one_of_two_missing_effects_is_named_though_it_acts_over_a_short_way(slide):
    model, recordings = slide
    found = discover(recordings, model)
    assert set(found.added) == {"magnet", "stribeck_friction"}
    ranked = {entry.effect: entry for entry in weigh(found).ranking}
    assert min(ranked[id].probability for id in found.added) > 0.9
    told = ranked["magnet"].parameters
    assert {name: each["unit"] for name, each in told.items()} == {"force": "N", "centre": "m", "width": "m"}
    assert {name: each["value"] for name, each in told.items()} == pytest.approx(MAGNET, rel=0.03)
    shown = {step["title"]: step["views"][0]["against"] for step in evidence_json(found)["steps"]}
    assert shown["magnet"] == "output_position" and shown["stribeck_friction"] == "speed"


def test_a_bound_that_keeps_it_out_is_told(slide, tmp_path):
    model, recordings = slide
    (tmp_path / "magnet.py").write_text(FILE.replace("0.02, 0.0005, 0.05", "0.1, 0.04, 0.5"))
    load_effect(tmp_path / "magnet.py")
    found = discover(recordings, model)
    assert "magnet" not in found.added
    assert any("width ended on the lower bound of your file, 0.04 m" in warning for warning in found.warnings)


def test_a_report_draws_its_force_in_newtons(slide):
    model, recordings = slide
    force, way = (recordings[0].signals[name] for name in ("motor_torque", "motor_position"))
    told = changed(recordings[0], speed_setpoint=np.gradient(way, recordings[0].time))
    (drawn,) = beside([told], model)
    assert drawn.curves["motor_torque"].unit == "N"
    assert drawn.curves["motor_torque"].measured == pytest.approx(force, rel=1e-6, abs=1e-9)


def test_its_bounds_are_metres_wherever_they_are_asked_for(slide):
    model, recordings = slide
    begun = model.with_effect("magnet", {**MAGNET, "width": 0.049})
    with pytest.raises(InputError, match=r"width: 0\.2 m is out of range; give 0\.0005 to 0\.05 m"):
        model.with_effect("magnet", {**MAGNET, "width": 0.2})
    fitted = fit_model(recordings[:1], begun, free=["effects.magnet.width"]).model
    assert fitted.effects["magnet"].parameters["width"] == pytest.approx(MAGNET["width"], rel=0.2)


def test_in_a_models_own_units_its_table_is_converted_as_the_models_numbers_are(slide):
    model, _ = slide
    drum = model_in(model.with_effect("magnet", MAGNET), OwnUnits(radius=0.01))
    table = {p.name: p for p in table_in(catalogue()["magnet"], drum.units).parameters}
    width = drum.effects["magnet"].parameters["width"]
    assert (width, table["width"].lower, table["width"].upper) == pytest.approx((1.2, 0.05, 5.0))
    assert table["force"].default == pytest.approx(30.0 * 0.01) and table["centre"].is_place
    of_the_package = catalogue()["stribeck_friction"]
    assert table_in(of_the_package, drum.units) is of_the_package
    assert table_in(catalogue()["magnet"], None) is catalogue()["magnet"]


def test_a_place_is_told_from_the_counters_zero():
    run = slid(0.2, 0.15, 1)
    stretch = stretch_of(run, run, run.signals["motor_torque"], 1.0)
    assert stretch.output_position == pytest.approx(run.signals["motor_position"] + BEGINS)
