"""Every effect of the catalogue, by being in it."""

import math
from pathlib import Path

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_twin_sim import effects
from ema_twin_sim.effects import Effect, Parameter, catalogue, find_effect
from ema_twin_sim.effects.effect import POSITIVE
from ema_twin_sim.model import load_model, save_model
from ema_twin_sim.plant.kernel import kernel
from ema_twin_sim.plant.operating_point import PARAMETER_SLOTS
from ema_twin_sim.simulation.assembly import assemble
from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.compared_signals import UNITS, noise_floors
from ema_twin_sim.simulation.simulate import simulate
from ema_twin_sim.simulation.twin import Twin
from ema_twin_sim.simulation.virtual_bench import virtual_bench

ids = pytest.mark.parametrize("id", sorted(catalogue()))


def choices():
    """Each effect with each of its options."""
    for id, effect in sorted(catalogue().items()):
        yield id, {}
        for name, values in effect.options.items():
            for value in values[1:]:
                yield id, {name: value}


@pytest.fixture(scope="module")
def recording(stock):
    return virtual_bench(stock, parse_command("sine:0.02:1"), 2.0, seed=None)


def difference(model, other, recording):
    """The largest difference of two models' signals, in units of the sensors' noise."""
    one, two = (simulate(each, recording, "setpoint").signals for each in (model, other))
    assert all(np.isfinite(one[name]).all() for name in UNITS if name != "unexplained_torque")
    return max(
        np.abs(one[name] - two[name]).max() / floor for name, floor in noise_floors(model).items()
        if name in UNITS and name != "unexplained_torque"
    )  # fmt: skip


@ids
def test_an_effect_tells_what_it_is(id):
    effect = catalogue()[id]
    assert effect.id == id
    assert effect.summary and effect.equation and effect.signature and effect.source
    assert effect.shown_by != Effect.shown_by, "which motion shows it?"
    for parameter in effect.parameters:
        assert parameter.unit and parameter.description
        assert parameter.lower <= parameter.default <= parameter.upper
        # what has the size of a machine is bounded by its sign alone, what has none on both sides
        bounded = parameter.unit in ("1", "rad") and not parameter.choice  # a place may be turns away
        assert math.isfinite(parameter.upper) == bounded
        assert parameter.lower in (0.0, POSITIVE, -math.inf) or bounded
        assert not parameter.choice or parameter.choice in effect.options[effect.law]


@ids
def test_an_effect_is_one_short_file(id):
    assert len((Path(effects.__file__).parent / f"{id}.py").read_text().splitlines()) < 100


@pytest.mark.parametrize(("id", "options"), list(choices()))
def test_an_effect_acts_and_switched_off_it_does_not(stock, recording, id, options):
    with_it = stock.with_effect(id, options=options)
    name = next(reversed(with_it.effects))
    assert difference(with_it, stock, recording) > 0.1
    assert difference(with_it.with_enabled(name, False), stock, recording) == 0.0


@ids
def test_an_effect_survives_its_model_file(tmp_path, stock, id):
    model = stock.with_effect(id)
    read = load_model(save_model(model, tmp_path / "model.yaml"))
    assert dict(read.effects) == dict(model.effects)
    assert dict(read.constants) == dict(model.constants)
    assert read.kinds == model.kinds


@ids
def test_switching_an_effect_compiles_no_kernel(stock, id):
    advance = kernel(False, False)
    compiled = len(advance.signatures)
    twin = Twin(stock, "setpoint")
    twin.start({"speed": 0.0, "current": 0.0, "speed_setpoint": 1.0})
    twin.change({f"effects.{id}.enabled": True})
    twin.advance(2_000_000, {"speed_setpoint": 1.0})
    twin.change({f"effects.{id}.enabled": False})
    twin.advance(2_000_000, {"speed_setpoint": 1.0})
    assert len(advance.signatures) == compiled == 1


@ids
def test_parameters_out_of_range_are_refused_with_the_range(stock, id):
    effect = catalogue()[id]
    for parameter in effect.parameters:
        options = {effect.law: parameter.choice} if parameter.choice else {}
        beyond = [-1.0] if parameter.lower >= 0.0 else []
        beyond += [parameter.upper * 2.0 + 1.0]  # of what is not bounded, infinity
        for value in (*beyond, math.nan, "much"):
            with pytest.raises(InputError, match=r"give|no number") as refused:
                stock.with_effect(id, {parameter.name: value}, options)
            assert parameter.name in str(refused.value)
            assert parameter.unit == "1" or parameter.unit in str(refused.value)


def test_dry_levels_are_made_up_before_what_depends_on_them(stock):
    model = stock.with_effect("sun_runout", options={"kind": "conservative"}).with_effect("stribeck_friction")
    _, places, parameters = assemble(model).effects
    assert places.tolist() == sorted(places.tolist(), reverse=True)
    assert parameters.shape == (2, PARAMETER_SLOTS)


def test_a_run_out_never_makes_the_dry_level_negative(stock):
    """Deep run-out takes all dry friction away and no more: friction never drives."""
    model = stock.with_effect("sun_runout", {"torque": 5.0, "phase": -math.pi / 2})
    bench = virtual_bench(model, parse_command("ramp:0.01"), 0.5, seed=None)
    assert bench.signals["current"].min() > -0.05


@pytest.mark.parametrize(
    ("id", "said"),
    [("nosuch", "; if it is your own"), ("backlsh", r"did you mean 'backlash'\? If it is your own")],
)
def test_an_unknown_effect_offers_the_nearest_and_says_what_to_do(id, said):
    with pytest.raises(InputError, match=said):
        find_effect(id, "test")


def test_an_effect_that_does_not_act_is_refused():
    table = (Parameter("torque", "N m", 0.1, 0.0, 1.0, "level"),)
    with pytest.raises(ValueError, match="give act or settle"):
        Effect("odd", "s", "e", "s", "s", table)
    with pytest.raises(ValueError, match="at most four"):
        Effect("odd", "s", "e", "s", "s", table * 5, act=lambda at, p: 0.0)


def test_an_effect_may_stand_several_times_but_a_gap_only_once(stock):
    model = stock.with_effect("viscous_friction").with_effect("sun_runout").with_effect("sun_runout")
    assert {"viscous_friction_3", "sun_runout", "sun_runout_2"} <= set(model.effects)
    with pytest.raises(InputError, match="there already"):
        stock.with_effect("backlash").with_effect("backlash")
    assert set(model.without_effect("viscous_friction").effects) == {
        "coulomb_friction", "coulomb_friction_2", "sun_runout", "sun_runout_2"
    }  # fmt: skip
    assert "viscous_friction_2" not in model.without_effect("viscous_friction_2").effects
    assert "viscous_friction" in model.without_effect("viscous_friction_2").effects
