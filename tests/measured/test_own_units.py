"""A machine told in its own units: mechanics is covariant, so a similar machine gets the same answer, scaled."""

from dataclasses import replace

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.effects import catalogue
from ema_twin_sim.fitting.fit import fit_model
from ema_twin_sim.measured.scales import own_units, rms_torque, to_own_units
from ema_twin_sim.model import load_model, reference_bench, save_model
from ema_twin_sim.model.constants import CONSTANTS
from ema_twin_sim.model.own_units import (
    OwnUnits,
    in_si,
    is_scalable,
    model_in,
    native,
    native_as_given,
    recording_in,
    shown,
)
from ema_twin_sim.simulation.simulate import simulate
from tests.recorded import record

UNITS = OwnUnits(time=0.25, torque=0.05, current=0.5)


def native_of(model):
    """The similar machine's model in SI: a model told in other units, which it does not remember."""
    return replace(model_in(model, UNITS), units=None)


@pytest.fixture(scope="module")
def runs(stock):
    hidden = stock.with_effect("gravity_load", {"torque": 0.06, "angle": 0.4})
    return record(hidden, ("triangle:0.06:2", "sine:0.05:0.4"), 8.0)


@pytest.mark.parametrize(
    ("unit", "factor"),
    [
        ("N m s^3/rad^3", 0.05 * 0.25**3),
        ("N m/A^2", 0.05 / 0.5**2),
        ("N m s^2/rad^2", 0.05 * 0.25**2),
        ("kg m^2", 0.05 * 0.25**2),
        ("ohm", 0.05 / 0.25 / 0.5**2),
        ("rad/s^3", 0.25**-3),
        ("N m/K", 0.05),
        ("1", 1.0),
    ],
)
def test_any_unit_of_a_parameter_is_scaled_by_its_parts(unit, factor):
    """Of an effect that somebody adds to the catalogue, too: no table has to know its unit."""
    assert UNITS.factor(unit) == pytest.approx(factor, rel=1e-12)


def test_there_and_back_is_the_same_model(stock):
    for id, effect in catalogue().items():
        if id not in stock.effects and not effect.electrical:
            stock = stock.with_effect(id)
    back = native(model_in(stock, UNITS))
    assert back.units is None
    for path, held in stock.constants.items():
        assert back.value(path) == pytest.approx(held.value, rel=1e-12), path
    for name, instance in stock.effects.items():
        assert dict(back.effects[name].parameters) == pytest.approx(dict(instance.parameters), rel=1e-12), name


def test_units_belong_together():
    """Power is torque times speed, volts times amperes; an inertia's torque is inertia times acceleration."""
    factor = UNITS.factor
    assert factor("N m") * factor("rad/s") == pytest.approx(factor("V") * factor("A"))
    assert factor("kg m^2") * factor("rad/s^2") == pytest.approx(factor("N m"))
    assert factor("N m/A") * factor("A") == pytest.approx(factor("N m"))
    assert factor("V s/rad") * factor("rad/s") == pytest.approx(factor("V"))
    assert factor("ohm") * factor("A") == pytest.approx(factor("V"))
    assert factor("H") * factor("A") == pytest.approx(factor("V") * factor("s"))
    for unit, power in (("N m/rad", 0), ("N m s/rad", 1), ("N m s^2/rad^2", 2)):
        assert factor(unit) * factor("rad/s") ** power == pytest.approx(factor("N m"))
    assert factor("1/rev") == factor("count") == factor("rad") == 1.0


def test_every_unit_of_a_constant_or_parameter_is_known():
    """A unit that is not in the table would stay as it is, and one number of a model would be of another machine."""
    plain = {"1", "rad", "count", "1/rev"}
    lengths = {"m", "kg/m^3", "K"}  # of planetary trains, which are told in SI
    used = {c.unit for c in CONSTANTS.values()} | {p.unit for e in catalogue().values() for p in e.parameters}
    odd = OwnUnits(2.0, 3.0, 5.0)
    assert {unit for unit in used if odd.factor(unit) == 1.0} <= plain | lengths


def test_every_unit_of_a_parameter_can_be_converted():
    """A root would be read as a whole power and a prefix as nothing: wrong on machines of another size."""
    units = {f"{id}.{p.name}": p.unit for id, effect in catalogue().items() for p in effect.parameters}
    assert {where: unit for where, unit in units.items() if not is_scalable(unit)} == {}, (
        "give whole powers of SI units"
    )
    for unit in ("N m s^(1/3)", "N m^0.5", "N m s^-1", "mN m", "m", "N m^2", "s/"):
        assert not is_scalable(unit), unit


def test_a_twin_of_the_similar_machine_makes_the_similar_motion(stock, runs):
    model = stock.with_effect("backlash", {"width": 0.002}).with_effect("stribeck_friction", {"torque": 0.05})
    own = simulate(model_in(model, UNITS), recording_in(runs[0], UNITS))
    there = recording_in(simulate(model, runs[0]), UNITS)
    for name in ("current", "speed", "motor_position"):
        size = np.ptp(there.signals[name])
        assert np.abs(own.signals[name] - there.signals[name]).max() < 1e-5 * size, name


def test_in_own_units_a_machine_has_the_reference_size(stock, runs):
    for recordings, model in ((runs, stock), ([recording_in(run, UNITS) for run in runs], native_of(stock))):
        told, own = to_own_units(recordings, model)
        inertia = sum(own.value(f"machine.{part}_inertia") for part in ("motor", "gearbox", "output"))
        assert inertia == pytest.approx(reference_bench.INERTIA)
        assert rms_torque(told, own) == pytest.approx(reference_bench.TORQUE)


def test_scales_do_not_depend_on_order_names_or_cuts(stock, runs):
    units = own_units(runs, stock)
    assert own_units(runs[::-1], stock) == units
    cut = [piece for run in runs for piece in (run.between(0.0, 4.0), run.between(4.002, 8.0))]
    assert own_units(cut, stock).time == pytest.approx(units.time, rel=1e-3)


def test_a_similar_machine_gets_the_same_answer_scaled(stock, runs):
    here = discover(runs, stock)
    there = discover([recording_in(run, UNITS) for run in runs], native_of(stock))
    assert here.verdict == there.verdict == "explained"
    assert here.added == there.added == ("gravity_load",)
    for name, told in here.parameters.items():
        for parameter, held in told.items():
            if parameter in ("effect", "options"):
                continue
            factor = 1.0 if parameter == "angle" else UNITS.factor(held["unit"])
            other = there.parameters[name][parameter]
            assert other["value"] * factor == pytest.approx(held["value"], rel=1e-6), (name, parameter)
            assert other["std"] * factor == pytest.approx(held["std"], rel=1e-4), (name, parameter)


def test_a_fit_of_a_similar_machine_is_the_same_scaled(stock, runs):
    model = stock.with_effect("gravity_load")
    here = fit_model(runs, model, method="equation")
    there = fit_model([recording_in(run, UNITS) for run in runs], native_of(model), method="equation")
    held, other = (f.parameters["gravity_load"]["torque"] for f in (here, there))
    assert other["value"] * UNITS.factor("N m") == pytest.approx(held["value"], rel=1e-6)
    assert other["std"] * UNITS.factor("N m") == pytest.approx(held["std"], rel=1e-4)


def test_what_did_not_move_is_told_to_the_digit(stock):
    own = model_in(stock, UNITS)
    moved = own.with_value("machine.motor_inertia", 2.0 * own.value("machine.motor_inertia"))
    told = native_as_given(moved, stock)
    assert told.value("machine.motor_inertia") == pytest.approx(2.0 * stock.value("machine.motor_inertia"))
    changed = [path for path, held in told.constants.items() if held != stock.constants[path]]
    assert changed == ["machine.motor_inertia"] and dict(told.effects) == dict(stock.effects)


def test_numbers_are_shown_in_si(stock):
    own = model_in(stock, UNITS)
    assert shown(own, own.value("machine.motor_inertia"), "kg m^2") == pytest.approx(
        (stock.value("machine.motor_inertia"), "kg m^2")
    )
    assert in_si(own).units is None
    assert in_si(own).value("drive.integral_time") == pytest.approx(stock.value("drive.integral_time"))


@pytest.mark.parametrize("slower", [6.0, 0.1])
def test_a_delay_is_found_and_written_at_any_scale(stock, slower, tmp_path):
    """36 ms of a large slow machine, 0.6 ms of a quick one: no bound is one bench's."""
    units = OwnUnits(time=1.0 / slower)
    runs = record(stock.with_effect("encoder_delay", {"delay": 0.006}), ("triangle:0.06:2", "sine:0.05:0.4"), 8.0)
    other = replace(model_in(stock, units), units=None)
    found = discover([recording_in(run, units) for run in runs], other)
    assert (found.verdict, found.added) == ("explained", ("encoder_delay",))
    assert found.parameters["encoder_delay"]["delay"]["value"] == pytest.approx(0.006 * slower, rel=0.01)
    assert load_model(save_model(found.model, tmp_path / "found.yaml")).active.keys() == found.model.active.keys()


def test_a_torque_of_no_machines_size_is_refused_with_what_to_check(stock):
    """Samples would be less than a nanosecond apart in its own units: it ended as an internal error."""
    time = np.arange(400) * 1_000_000
    signals = {"motor_position": np.sin(5e-9 * time), "current": np.full(400, 1e-24)}
    with pytest.raises(InputError, match=r"^tiny: .* of no machine's size; check the units and factors of current"):
        to_own_units([Recording("tiny", time, signals)], stock)
