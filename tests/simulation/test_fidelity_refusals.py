"""What no fidelity can run is refused in one line: wheels that do not mesh, long steps, low voltage, divergence."""

from dataclasses import replace

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_twin_sim.model import load_model
from ema_twin_sim.plant.layout import BENCH
from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.twin import Twin
from ema_twin_sim.simulation.virtual_bench import virtual_bench
from tests.command_line import done, refused, twin
from tests.fidelities import KINDS, LONGEST, entry, models_in, write_model

pytestmark = pytest.mark.timeout(LONGEST)


@pytest.fixture(scope="module")
def models(tmp_path_factory):
    return models_in(tmp_path_factory.mktemp("models"))


RUNAWAY = """
from ema_twin_sim.effects.effect import Effect, Parameter

def act(at, p):
    return -p[0] * at.motor_speed

EFFECT = Effect(
    id="runaway", summary="drives itself", equation="-gain w", signature="none", source="none",
    parameters=(Parameter("gain", "N m s/rad", 5.0, 0.0, 10.0, "of its speed"),), act=act,
)
"""


@pytest.mark.parametrize(
    ("teeth", "words"),
    [
        ({"ring_teeth": 62}, ("centre distance", "would fit")),
        ({"sun_teeth": 22, "ring_teeth": 64, "output_ring_teeth": 63}, ("does not divide", "change the number")),
        ({"second_planet_teeth": 21, "output_ring_teeth": 63}, ("ratio is infinite",)),
        ({"sun_teeth": 21.5}, ("sun_teeth", "whole number")),
    ],
)
def test_wheels_that_do_not_mesh_are_refused(tmp_path, ramp, teeth, words):
    file = write_model(tmp_path, "teeth", transmission={name: entry(number, '"1"') for name, number in teeth.items()})
    refused("compare", ramp, "--model", file, naming=("model teeth: transmission", *words))


def test_teeth_that_lose_contact_are_refused(tmp_path, ramp):
    file = write_model(tmp_path, "tips", transmission={"tip_radius": entry(0.0395, "m")})
    refused("info", file, naming=("model tips: transmission", "contact ratio", "tip_radius"))


@pytest.mark.slow
def test_inertias_below_zero_are_refused(tmp_path, ramp):
    for section, name in (("machine", "motor_inertia"), ("machine", "output_inertia"), ("transmission", "sun_inertia")):
        file = write_model(tmp_path, "inertia", **{section: {name: entry(-1e-6, "kg m^2")}})
        refused("compare", ramp, "--model", file, naming=("inertia.yaml", f"{section}.{name}", "out of range; give"))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "words"),
    [("polito_hff", "teeth are too stiff for its wheels"), ("polito_hf", "leave their hysteresis band")],
)
def test_a_step_too_long_is_refused_with_the_longest(ramp, name, words):
    line = refused("compare", ramp, "--model", name, "--to", 1, "--step", 1e-4, naming=(name, words, "s at most"))
    longest = float(line.rpartition("take ")[2].split()[0])
    done("compare", ramp, "--model", name, "--to", 0.1, "--step", longest, timeout=LONGEST)


def test_a_contact_too_stiff_for_the_step_is_refused(stock):
    stiff = stock.with_effect("backlash").with_value("transmission.contact_stiffness", 1e6)
    with pytest.raises(
        InputError, match=r"its contact is too stiff for its inertias at a step of 0\.0001 s.* s at most"
    ):
        Twin(stiff, step=1e-4)


@pytest.mark.slow
def test_a_dc_link_too_low_for_the_speed_is_refused(ramp, tmp_path):
    low = write_model(tmp_path, "low", "polito_hf", drive={"dc_link_voltage": entry(10.0, "V")})
    words = ("DC link of 10 V of model low allows", "rad/s; give drive.dc_link_voltage")
    for verb in (("compare",), ("live", "--headless")):
        line = refused(*verb, ramp, "--model", low, naming=(ramp.stem, *words))
    simulate = ("simulate", "--model", low, "--command", "ramp:0.05", "--seconds", 1)
    refused(*simulate, "-o", tmp_path / "run.mcap", naming=("command 'ramp:0.05'", *words))
    assert not (tmp_path / "run.mcap").exists()
    enough = float(line.partition("dc_link_voltage ")[2].split()[0])
    high = write_model(tmp_path, "high", "polito_hf", drive={"dc_link_voltage": entry(enough, "V")})
    done("compare", ramp, "--model", high, "--to", 0.1, timeout=LONGEST)


def test_a_jump_of_the_position_asks_for_no_speed():
    steps = virtual_bench(load_model("polito_hf"), parse_command("step:0.01:0.2"), 0.5, seed=None)
    assert np.isfinite(steps.signals["current"]).all()


@pytest.mark.slow
def test_a_switching_drive_needs_its_winding(tmp_path, ramp):
    for name, unit in (("phase_inductance", "H"), ("back_emf_constant", "V s/rad")):
        file = write_model(tmp_path, "winding", "polito_hf", machine={name: entry(0.0, unit)})
        refused("compare", ramp, "--model", file, naming=("model winding", f"machine.{name} is 0"))


# each plant is compiled on its first use
@pytest.mark.parametrize("kind", ["lumped", *(pytest.param(kind, marks=pytest.mark.slow) for kind in KINDS)])
def test_a_simulation_that_diverges_stops_and_names_moment_and_state(kind, models):
    model = load_model(models.get(kind, "polito_bench"))
    driving = replace(model.effects["viscous_friction"], parameters={"coefficient": -5.0})  # no model file may have it
    diverging = Twin(replace(model, effects={**model.effects, "viscous_friction": driving}), "standalone")
    diverging.start({"output_command": 0.0})
    stamps = np.arange(10_001, dtype=np.int64) * 2_000_000
    bench = np.full((len(stamps), len(BENCH)), np.nan)
    bench[:, 0] = 0.05e-9 * stamps
    with pytest.raises(InputError, match=r"diverges: the (motor's speed|current) is beyond 1e\+07 .* 0\.0\d+ s after"):
        diverging.follow(stamps, bench)
    assert diverging._state[0]["time"] < 1.5  # it did not go on for 20 s


@pytest.mark.slow
def test_a_diverging_model_is_told_in_one_line(ramp, tmp_path):
    file, runaway = tmp_path / "away.yaml", tmp_path / "runaway.py"
    runaway.write_text(RUNAWAY)
    done("add", runaway, "--model", "polito_bench", "-o", file)
    words = ("model away", "diverges: the motor's speed", "s after the start", "check")
    refused("compare", ramp, "--model", file, "--with", runaway, naming=(ramp.stem, *words))
    live = twin("live", ramp, "--model", file, "--with", runaway, "--headless")
    assert live.returncode == 2 and "Traceback" not in live.stderr
    assert all(word in live.stderr.splitlines()[-1] for word in ("error: ", *words))
