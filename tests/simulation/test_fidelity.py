"""Every fidelity runs in every verb, and live says so where the machine is too slow for it."""

import json
import logging

import numpy as np
import pytest
from numba import njit
from numba.core.event import install_listener

from ema_bench_replay.load import load
from ema_twin_sim import compare
from ema_twin_sim.commands import shown_live
from ema_twin_sim.model import load_model
from ema_twin_sim.nodes.live import run_live
from ema_twin_sim.nodes.live_session import LiveResult
from ema_twin_sim.plant.kernel import _Compiling
from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.figures import figures
from ema_twin_sim.simulation.lumped_model import lumped_model
from ema_twin_sim.simulation.virtual_bench import virtual_bench
from tests.command_line import done, done_here
from tests.fidelities import KINDS, LONGEST, models_in

pytestmark = pytest.mark.timeout(LONGEST)

HELD = [
    argument
    for path in (
        *(f"machine.{part}_inertia" for part in ("motor", "gearbox", "output")),
        *(f"effects.{name}" for name in ("coulomb_friction", "coulomb_friction_2", "viscous_friction_2")),
    )
    for argument in ("--fix", path)
]
"""All numbers but one, of which each costs a fine simulation as many runs again."""


@pytest.fixture(scope="module")
def models(tmp_path_factory):
    return models_in(tmp_path_factory.mktemp("models"))


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_verbs_of_one_fidelity(kind, models, traces, tmp_path):
    model = ("--model", models[kind])
    triangle = next(path for path in traces if "triangle" in path.name)
    done_here("info", models[kind])
    done_here("simulate", *model, "--command", "sine:0.02:1", "--seconds", 1, "-o", tmp_path / "run.mcap")
    done_here("simulate", *model, "--command", "speed-sine:0.05:1", "--seconds", 1, "-o", tmp_path / "speed.mcap")
    for run in (tmp_path / "run.mcap", tmp_path / "speed.mcap"):
        for name, signal in load(run).signals.items():
            assert np.isfinite(signal).all(), name
    done_here("export", tmp_path / "run.mcap", "-o", tmp_path / "run.CSV")
    done_here("compare", tmp_path / "run.mcap", *model, "--json", tmp_path / "own.json")
    current = json.loads((tmp_path / "own.json").read_text())["overall"]["current"]
    assert current["rmse"] < 10.0 * current["noise_floor"]  # itself again, but for how it starts
    for method in ("equation", "simulation"):
        new = tmp_path / f"{method}.yaml"
        done_here("fit", triangle, *model, "--to", 1.3, "--method", method, *HELD, "-o", new)
        assert load_model(new).kinds == load_model(models[kind]).kinds
    for effect in ("backlash", "shaft_compliance", "torque_constant_error", "added_inertia"):
        new = tmp_path / f"{effect}.yaml"
        done_here("add", effect, *model, "-o", new)
        done_here("compare", triangle, "--to", 0.5, "--model", new, "--json", tmp_path / "c.json")
        assert np.isfinite(json.loads((tmp_path / "c.json").read_text())["overall"]["current"]["rmse"])
    done_here("remove", "backlash", "--model", tmp_path / "backlash.yaml", "-o", tmp_path / "back.yaml")
    assert load_model(tmp_path / "back.yaml").kinds == load_model(models[kind]).kinds


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_live_as_fast_as_it_goes_gives_what_compare_gives(kind, models, traces):
    recording = load(next(path for path in traces if "triangle" in path.name)).between(0.0, 0.4)
    model = load_model(models[kind]).with_effect("cogging", {"torque": 0.02, "phase": 0.0}, {})
    offline = compare([recording], model).overall
    live = run_live(recording, model, rate=0.0)
    assert live.complete
    for name, error in live.signals.items():
        assert error["rmse"] == pytest.approx(offline[name]["rmse"], rel=1e-6), name
    assert live.pace > 0.0 and live.elapsed > 0.0


@pytest.mark.parametrize("name", ["polito_hf", "polito_hff"])
def test_the_lumped_model_stands_for_the_fine_one(name):
    fine = load_model(name).with_effect("constant_load", {"torque": 0.3})
    lumped = lumped_model(fine)
    assert lumped.kinds["drive"] == "averaged" and lumped.kinds["transmission"] in ("rigid", "two_inertia")
    runs = [virtual_bench(model, parse_command("ramp:0.05"), 3.0, seed=None) for model in (fine, lumped)]
    means = [run.signals["current"][run.time > 1.5].mean() for run in runs]
    assert means[1] == pytest.approx(means[0], rel=0.03)
    assert lumped_model(lumped) is lumped
    played = lumped_model(
        load_model("polito_hff").with_effect("backlash", {"width": 0.002}).with_effect("shaft_compliance")
    )
    assert played.effects["backlash"].parameters["width"] == pytest.approx(0.002)
    assert "shaft_compliance" not in played.effects
    assert played.value("transmission.contact_stiffness") < 10.0  # in series with the teeth


def test_info_tells_what_a_gearbox_engineer_asks():
    found = {figure.name: figure for figure in figures(load_model("polito_hff"))}
    assert found["teeth"].value == "sun 21, planets 21 and 20, fixed ring 63, output ring 62"
    assert found["ratio"].value == pytest.approx(124.0)
    assert found["contact ratio, sun and planet"].value == pytest.approx(1.16, abs=0.005)
    fast, slow = (found[f"torsional stiffness at the {side} shaft"].value for side in ("fast", "slow"))
    assert slow == pytest.approx(fast * 124.0**2)
    assert 0.7 < found["efficiency, motor driving"].value < 0.8
    assert 0.6 < found["efficiency, output driving"].value < 0.7
    assert found["self-locking"].value == "no"
    surely, somewhere = (found[f"self-locking {how} from a friction coefficient of"].value
                         for how in ("by mean forces", "in some position"))  # fmt: skip
    assert surely == pytest.approx(0.285, abs=0.01) and somewhere == pytest.approx(0.173, abs=0.01)
    assert found["highest speed at the torque limit"].value < found["highest speed against its friction"].value
    assert found["highest speed against its friction"].value < found["highest speed, not loaded"].value
    assert found["step it is run at"].value < found["longest safe step"].value
    assert figures(load_model("polito_bench")) == []
    locked = {f.name: f for f in figures(load_model("polito_hff").with_value("transmission.friction_coefficient", 0.4))}
    assert locked["self-locking"].value == "yes" and locked["efficiency, output driving"].value == "none"


@pytest.mark.slow
def test_info_prints_them_and_writes_them(tmp_path):
    text = " ".join(done("info", "polito_hff", "--json", tmp_path / "i.json").stdout.split())
    for words in (
        "Derived quantities",
        "fixed ring 63",
        "MN/m",
        "mesh_friction constant",
        "longest safe step",
        "self-locking",
    ):
        assert words in text
    names = [figure["name"] for figure in json.loads((tmp_path / "i.json").read_text())["figures"]]
    assert "ratio" in names and "highest speed, not loaded" in names
    assert "Derived quantities" not in done("info", "polito_bench").stdout


def test_live_says_when_the_machine_is_too_slow():
    kept = {"name": "run", "model": "m", "input": "setpoint", "samples": 1, "signals": {}, "complete": True}
    kept |= {"interrupted": False, "counts": {}, "duration": 20.0}
    assert shown_live.late_words(LiveResult(**kept, pace=3.0, elapsed=20.1), 1.0) == ""
    assert shown_live.late_words(LiveResult(**kept, pace=3.0, elapsed=70.0), 0.0) == ""
    slow = shown_live.late_words(LiveResult(**kept, pace=0.5, elapsed=41.0), 1.0)
    assert "cannot keep real time" in slow and "20.0 s took 41.0 s" in slow and "drive.kind averaged" in slow
    late = shown_live.late_words(LiveResult(**kept, pace=3.0, elapsed=7.0), 5.0)
    assert "could not keep the requested rate: 4.0 s of replay took 7.0 s" in late


def test_compiling_is_told_once(caplog):
    caplog.set_level(logging.INFO, "ema_twin_sim")
    with install_listener("numba:compile", _Compiling("switching drive")):
        njit("int64(int64)")(lambda k: k + 1)
        njit("int64(int64)")(lambda k: k + 2)
    assert [record.getMessage() for record in caplog.records] == [
        "compiling the equations of the switching drive: once, 10 to 20 s"
    ]
