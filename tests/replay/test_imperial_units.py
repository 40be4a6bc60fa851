"""Inches, feet, pounds, ounces, kips, kgf: in headers, rows of units and import maps, with their exact factors."""

import numpy as np
import pytest

from ema_bench_replay.load import load
from ema_bench_replay.traces.header_words import header_words
from ema_bench_replay.units import ALL_UNITS
from tests.trace_text import read_text, write_map


@pytest.mark.parametrize(
    ("unit", "value"),
    [
        ("in", 0.0254),
        ("ft", 0.3048),
        ("in/s", 0.0254),
        ("in/min", 0.0254 / 60.0),
        ("ft/s", 0.3048),
        ("ft/min", 0.3048 / 60.0),
        ("lbf", 4.4482216152605),
        ("ozf", 0.27801385095378125),
        ("kip", 4448.2216152605),
        ("kgf", 9.80665),
        ("gf", 0.00980665),
        ("lbf in", 0.1129848290276167),
        ("lbf ft", 1.3558179483314004),
        ("ozf in", 0.00706155181422604375),
    ],
)
def test_factors_are_exact(unit, value):
    assert ALL_UNITS[unit] == pytest.approx(value, rel=1e-15)


NAMES = {
    "in": ("displacement (in)", "x inches"),
    "ft": ("stroke [ft]",),
    "in/s": ("velocity (in/s)", "v_in_per_s"),
    "in/min": ("feed rate (ipm)",),
    "ft/s": ("speed ft/s",),
    "lbf": ("actuator force 1 (lb)", "force in lbf", "force_in_lb"),
    "kip": ("friction force (kip)",),
    "kgf": ("thrust [kgf]",),
    "gf": ("load_gf",),
    "lbf in": ("Torque [lb-in]", "Torque (in-lb)", "Torque in lb", "torque_in_lb"),
    "lbf ft": ("torque ft-lbs", "torque_lb_ft"),
    "ozf in": ("torque (oz-in)",),
    # the word before a unit is no inch
    "s": ("time_in_s",),
    "deg": ("angle in deg",),
    "rpm": ("Speed (in) [rpm]",),
    "N m": ("M in Nm",),
}


@pytest.mark.parametrize(("name", "unit"), [(name, unit) for unit, names in NAMES.items() for name in names])
def test_they_are_read_in_names(name, unit):
    assert header_words(name).unit == unit


@pytest.mark.parametrize("name", ["current in", "torque (in)", "pos_in", "speed in", "wrist ft", "voltage_in", "in"])
def test_words_that_are_no_units(name):
    assert header_words(name).unit is None


@pytest.mark.parametrize(
    ("name", "linear"), [("x (in)", True), ("F [lb]", True), ("v [ft/s]", True), ("M [lb-ft]", False), ("t [s]", None)]
)
def test_they_tell_the_kind_of_motion(name, linear):
    assert header_words(name).linear is linear


def test_a_row_of_them_is_one_of_units(tmp_path):
    table = read_text(tmp_path, "Time,Stroke,Load\nsec,in,lb\n0.0,1.5,20\n0.1,1.6,21\n")
    assert table.header == ["Time [sec]", "Stroke [in]", "Load [lb]"]


def test_an_import_map_takes_them(tmp_path):
    signals = {"speed": "{columns: [v], unit: in/s}", "motor_torque": "{columns: [F], unit: lbf}"}
    own = write_map(tmp_path, signals, "motion: linear\ntime: {column: t, unit: s}")
    (tmp_path / "run.csv").write_text("t,v,F\n0,1,2\n0.001,2,4\n")
    signals = load(tmp_path / "run.csv", import_map=own).signals
    assert np.allclose(signals["speed"], [0.0254, 0.0508], rtol=1e-12)
    assert np.allclose(signals["motor_torque"], [8.896443230521, 17.792886461042], rtol=1e-12)
