"""A user's own effect whose table says nothing of where to begin: its numbers come back whatever its defaults are."""

import math

import pytest

from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.effects.effect import Effect, Parameter
from ema_twin_sim.fitting.fit import fit_model
from ema_twin_sim.identification.search_limits import Reached
from ema_twin_sim.identification.start_values import start_values
from ema_twin_sim.own_effects import load_effect
from ema_twin_sim.own_effects.wave import turns_a_wave
from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.virtual_bench import virtual_bench

FILE = """import math
from ema_twin_sim.effects.effect import DRY_LEVEL, TORQUE, Effect, Parameter

def act(at, p):
    return {act}

EFFECT = Effect(
    id="{id}", summary="s", equation="e", signature="s", source="s", act=act, depends_on="{depends_on}", place={place},
    parameters=(Parameter("torque", "N m", 0.05, 0.0, 10.0, "size"), {shapes},),
)
"""
CASES = {
    "angle": (
        "p[0] * max(0.0, math.cos(at.motor_angle - p[1])) ** 6", "order", "TORQUE",
        'Parameter("angle", "rad", -2.5, -6.3, 6.3, "of the lobe")',
        {"torque": 0.1, "angle": 0.55},
    ),
    "angle round the circle": (
        "p[0] * max(0.0, math.cos(at.motor_angle - p[1])) ** 6", "order", "TORQUE",
        'Parameter("angle", "rad", -2.5, -6.3, 6.3, "of the lobe", periodic=True)',
        {"torque": 0.1, "angle": 0.55},
    ),
    "speed": (
        "math.copysign(p[0] / (1.0 + ((abs(at.motor_speed) - p[1]) / 0.8) ** 2), at.motor_speed)", "speed", "TORQUE",
        'Parameter("speed", "rad/s", 80.0, 0.01, 1000.0, "at which it rubs most")',
        {"torque": 0.08, "speed": 4.0},
    ),
    "place and width": (
        "p[0] * math.exp(-(((at.output_angle - p[1]) / p[2]) ** 2))", "output_position", "DRY_LEVEL",
        'Parameter("place", "rad", -3.0, -6.3, 6.3, "of the tight spot"), '
        'Parameter("width", "rad", 2.0, 1e-4, 6.3, "of the tight spot")',
        {"torque": 0.15, "place": 0.03, "width": 0.01},
    ),
}  # fmt: skip
COMMANDS = ("ramp:0.05", "sine:0.05:0.25", "triangle:0.04:2")


pytestmark = pytest.mark.usefixtures("catalogue_of_the_package")


def recorded(tmp_path, stock, kind):
    """(effect, its true numbers, recordings of a machine that has it)."""
    act, depends_on, place, shapes, hidden = CASES[kind]
    id = f"own_{kind.split()[0]}"
    file = tmp_path / f"{id}.py"
    file.write_text(FILE.format(act=act, id=id, depends_on=depends_on, place=place, shapes=shapes))
    effect = load_effect(file)
    machine = stock.with_effect(id, hidden)
    runs = [virtual_bench(machine, parse_command(command), 20.0, seed=k) for k, command in enumerate(COMMANDS)]
    return effect, hidden, runs


@pytest.mark.slow
@pytest.mark.parametrize("kind", CASES)
def test_it_is_found_with_its_numbers_from_a_bad_default(kind, tmp_path, stock):
    effect, hidden, runs = recorded(tmp_path, stock, kind)
    found = discover(runs, stock)
    assert found.added == (effect.id,)
    for name, true in hidden.items():
        held = found.parameters[effect.id][name]
        assert held["value"] == pytest.approx(true, rel=0.02)
        assert abs(held["value"] - true) < 4.0 * held["std"]


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["angle", "speed"])
def test_it_is_fitted_from_a_bad_default(kind, tmp_path, stock):
    effect, hidden, runs = recorded(tmp_path, stock, kind)
    fitted = fit_model(runs, stock.with_effect(effect.id), method="equation").parameters[effect.id]
    for name, true in hidden.items():
        assert fitted[name]["value"] == pytest.approx(true, rel=0.02)


def own(act, *shapes):
    """An effect that is no effect of the package."""
    size = Parameter("torque", "N m", 0.05, 0.0, 10.0, "size")
    return Effect("mine", "s", "e", "s", "s", (size, *shapes), act=act)


REACHED = Reached(0.4, 10.0, 15.0, 1.0, 20.0, (-0.2, 0.8), (0.0, 0.0), 0.02)


def test_what_a_table_says_is_kept():
    given = Parameter("speed", "rad/s", 1.0, 0.1, 10.0, "s", starts=(1.0, 3.0))
    assert start_values(own(lambda at, p: p[0] * p[1], given), given, REACHED) == (1.0, 3.0)


@pytest.mark.parametrize(
    ("parameter", "truths"),
    [
        (Parameter("speed", "rad/s", 500.0, 0.0, 1e4, "s"), (0.01, 0.3, 9.0)),
        (Parameter("width", "rad", 5.0, 1e-6, 6.3, "s"), (0.002, 0.05, 0.9)),
        (Parameter("time", "s", 500.0, 1e-3, 1e4, "s"), (0.05, 1.0, 19.0)),
    ],
)
def test_what_is_never_negative_is_tried_by_factors_of_two(parameter, truths):
    values = start_values(own(lambda at, p: p[0] * p[1], parameter), parameter, REACHED)
    for true in truths:
        assert min(abs(math.log2(value / true)) for value in values) < 1.0


def test_a_place_is_tried_over_the_way_that_was_passed_and_an_angle_over_the_turn():
    place = Parameter("place", "rad", 3.0, -6.3, 6.3, "s")
    values = start_values(own(lambda at, p: p[0] * max(0.0, p[1]), place), place, REACHED)
    for true in (-0.19, 0.3, 0.79):
        assert min(abs(value - true) for value in values) < 0.03
    for true in (-3.0, 1.0, 3.0):
        assert min(abs(value - true) for value in values) < 0.3
    for shape in (place, Parameter("far", "rad", 3.0, 2.0, 6.3, "s")):
        assert all(
            shape.lower <= v <= shape.upper for v in start_values(own(lambda at, p: p[0], shape), shape, REACHED)
        )


def test_a_wave_is_told_from_what_is_none():
    angle = Parameter("angle", "rad", 0.0, -6.3, 6.3, "s", periodic=True)
    wave = own(lambda at, p: p[0] * 0.5 * (1.0 + math.sin(3.0 * at.output_angle + p[1])), angle)
    lobe = own(lambda at, p: p[0] * max(0.0, math.cos(at.motor_angle - p[1])), angle)
    assert turns_a_wave(wave, angle) and not turns_a_wave(lobe, angle)
    assert len(start_values(wave, angle, REACHED)) == 2
    assert len(start_values(lobe, angle, REACHED)) == 24


def test_many_shapes_are_not_too_many_starts():
    shapes = [Parameter(f"shape{k}", "rad/s", 1.0, 0.01, 100.0, "s") for k in range(3)]
    effect = own(lambda at, p: p[0], *shapes)
    assert math.prod(len(start_values(effect, shape, REACHED)) for shape in shapes) <= 500
