"""Linear machines: their models, and the drum that stands in for them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_twin_sim.comparison.compare import compare
from ema_twin_sim.discovery.diagnose import diagnose
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.effects import catalogue
from ema_twin_sim.fitting.fit import fit_model
from ema_twin_sim.measured.scales import drum_radius
from ema_twin_sim.model import load_model, save_model
from ema_twin_sim.model.matching import matched
from ema_twin_sim.model.own_units import OwnUnits, model_in, native, recording_in
from ema_twin_sim.words.sentences import order_sentences
from tests.command_line import refused
from tests.recorded import record, sampled

MASS, VISCOUS, COULOMB, LOAD = 80.0, 150.0, 18.0, -4.0
PITCH = 0.024  # m


def carriage(asymmetry=0.0, seed=0, detent=0.0):
    """A carriage on rails, driven to and fro: way [m] and force [N] with noise, from its equation of motion.

    Magnets hold it with a force that repeats every ``PITCH``, ``detent`` [N] at most.
    """
    random = np.random.default_rng(seed)
    period = 1e-3
    time = np.arange(12_000) * period
    way = 0.08 * np.sin(2.0 * np.pi * 0.4 * time) + 0.03 * np.sin(2.0 * np.pi * 1.1 * time + seed)
    speed = np.gradient(way, period)
    sense = np.tanh(speed / 1e-5)
    friction = (VISCOUS * speed + COULOMB * sense) * (1.0 + asymmetry * sense)
    force = MASS * np.gradient(speed, period) + friction + LOAD + random.normal(0.0, 0.2, len(time))
    force += detent * np.sin(2.0 * np.pi * way / PITCH + 0.5)
    signals = {"motor_position": way - way[0] + random.normal(0.0, 1e-8, len(time)), "motor_torque": force}
    return sampled(f"run{seed}", time, signals, metadata={"motion": "linear"})


@pytest.fixture(scope="module")
def emps():
    return load_model("emps")


def test_the_drum_and_back_is_the_same_model(emps):
    for id in catalogue():
        emps = emps if id in emps.effects else emps.with_effect(id)
    drum = model_in(emps, OwnUnits(radius=0.01))
    assert (drum.motion, drum.units.radius) == ("rotary", 0.01)
    assert drum.value("machine.motor_inertia") == pytest.approx(50.0 * 0.01**2)
    assert drum.effects["viscous_friction"].parameters["coefficient"] == pytest.approx(100.0 * 0.01**2)
    back = native(drum)
    assert (back.motion, back.units) == ("linear", None)
    for path, held in emps.constants.items():
        assert back.value(path) == pytest.approx(held.value, rel=1e-12)
    for name, instance in emps.effects.items():
        assert dict(back.effects[name].parameters) == pytest.approx(dict(instance.parameters), rel=1e-12)


def test_an_order_counts_along_the_way_and_is_written_as_it_was(emps):
    wavy = emps.with_effect("cogging", {"torque": 3.0, "phase": 0.5}, {"order": "41.67"})
    drum = model_in(wavy, OwnUnits(radius=0.01))
    assert float(drum.effects["cogging"].options["order"]) == pytest.approx(41.67 * 2.0 * np.pi * 0.01, rel=1e-9)
    assert native(drum).effects["cogging"].options == {"order": "41.67"}


@pytest.mark.slow
@pytest.mark.parametrize("stretched", [1.0, 30.0])
def test_magnets_along_the_way_are_named_with_their_pitch(stretched, emps):
    """On a machine of any size: the drum that stands for it has another radius, and the way the same pitch."""
    bare = emps.without_effect("constant_load").with_effect("constant_load", {"torque": LOAD})
    runs = [carriage(seed=k, detent=8.0) for k in range(2)]
    far = [replace(r, signals={**r.signals, "motor_position": stretched * r.signals["motor_position"]}) for r in runs]
    found = discover(far, bare.with_value("machine.motor_inertia", MASS / stretched))
    assert found.added == ("cogging",)
    told = found.parameters["cogging"]
    assert 1.0 / float(told["options"]["order"]) == pytest.approx(stretched * PITCH, rel=3e-3)
    assert told["torque"]["value"] == pytest.approx(8.0, rel=0.03)
    (said,) = order_sentences(found.model, found.parameters)
    assert said.startswith("cogging: repeats every ") and said.endswith("m of the way.")
    before, after = (compare(far, model).overall["unexplained_torque"]["rmse"] for model in (bare, found.model))
    assert after < 0.2 * before


def test_power_is_the_same_round_the_drum(emps):
    recording = matched(carriage(), emps)
    radius = drum_radius([recording])
    turned = recording_in(recording, OwnUnits(radius=radius))
    power = [r.signals["motor_torque"] * np.gradient(r.signals["motor_position"], r.time) for r in (recording, turned)]
    assert np.allclose(*power, rtol=1e-9)


def test_a_mass_and_its_friction_are_fitted_in_their_own_units(emps):
    fitted = fit_model([carriage(seed=k) for k in range(2)], emps, method="equation")
    found = {
        "kg": (fitted.constants["machine"]["inertia"], MASS),
        "N s/m": (fitted.parameters["viscous_friction"]["coefficient"], VISCOUS),
        "N": (fitted.parameters["coulomb_friction"]["torque"], COULOMB),
    }
    for unit, (held, true) in found.items():
        assert held["unit"] == unit
        assert held["value"] == pytest.approx(true, rel=0.01), unit
    assert fitted.parameters["constant_load"]["torque"]["value"] == pytest.approx(LOAD, rel=0.02)
    assert fitted.model.motion == "linear" and fitted.model.value("machine.motor_inertia") == pytest.approx(
        MASS, rel=0.01
    )
    assert all(error.filtered < 0.02 for error in fitted.torque_errors.values())


def test_what_a_carriage_lacks_is_found_from_its_mass_alone():
    bare = load_model("emps_mass")
    found = discover([carriage(asymmetry=0.15, seed=k) for k in range(2)], bare)
    assert set(found.added) == {"viscous_friction", "coulomb_friction", "constant_load", "asymmetric_friction"}
    assert found.verdict == "explained"
    assert found.parameters["asymmetric_friction"]["fraction"]["value"] == pytest.approx(0.15, abs=0.01)
    assert found.constants["machine"]["inertia"]["value"] == pytest.approx(MASS, rel=0.01)
    assert found.unseen.unit == "N"


def test_what_a_carriage_lacks_is_diagnosed_in_its_own_units():
    """The recordings have no current, and are weighed as they were searched."""
    diagnosis = diagnose([carriage(asymmetry=0.15, seed=k) for k in range(2)], load_model("emps_mass"))
    units = {e.effect: {n: held["unit"] for n, held in e.parameters.items()} for e in diagnosis.ranking if e.found}
    assert units["viscous_friction"]["coefficient"] == "N s/m" and units["coulomb_friction"]["torque"] == "N"


def test_a_model_is_written_with_its_own_words_and_units(emps, tmp_path):
    path = save_model(emps, tmp_path / "own.yaml")
    text = path.read_text()
    assert "motion: linear" in text and "inertia: {value: 50.0, unit: kg, tolerance: open" in text
    assert "motor_inertia" not in text and "gear_ratio" not in text
    again = load_model(path)
    assert again.constants == emps.constants and again.effects == emps.effects


def test_recording_and_model_of_other_motions_are_refused(stock):
    with pytest.raises(InputError, match="is of a linear machine, model polito_bench of a rotary one"):
        compare([carriage()], stock)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("unit: kg", "unit: kg m^2", "unit 'kg m^2' but 'kg' is needed"),
        ("motion: linear", "motion: sideways", "'sideways' is not possible"),
        ("inertia: {", "motor_inertia: {value: 1.0, unit: kg}\n  inertia: {", "give one or the other"),
        ("tolerance: open", "tolerance: unknown", "'unknown' is no number"),
    ],
)
def test_a_wrong_machine_is_refused(emps, tmp_path, old, new, said):
    path = Path(save_model(emps, tmp_path / "own.yaml"))
    path.write_text(path.read_text().replace(old, new, 1))
    with pytest.raises(InputError) as error:
        load_model(path)
    assert said in str(error.value)


def test_what_the_virtual_bench_records_of_a_carriage_is_a_carriages(emps):
    """Its own model leaves nothing of it, and a heavier one is fitted back."""
    runs = record(emps, ("sine:0.05:0.4", "triangle:0.05:1"), 6.0)
    assert all(run.metadata["motion"] == "linear" for run in runs)
    own = compare(runs, emps).overall
    assert own["speed"]["unit"] == "m/s" and own["motor_position"]["rmse"] < 1e-3
    heavier = emps.with_value("machine.motor_inertia", 70.0)
    fitted = fit_model(runs, heavier, method="equation")
    assert fitted.constants["machine"]["inertia"]["value"] == pytest.approx(50.0, rel=0.02)


def test_it_is_not_followed_live(tmp_path):
    """A twin of a carriage would take a drum's standstill for its own: live, it is refused."""
    (tmp_path / "run.csv").write_text("t [s],x [m],f [N]\n" + "".join(f"0.00{k},{k},1\n" for k in range(9)))
    (tmp_path / "m.yaml").write_text(
        "version: 1\nmotion: linear\ntime: {column: 't .*', unit: s}\nsignals:\n"
        "  motor_position: {columns: ['x .*']}\n  motor_torque: {columns: ['f .*']}\n"
    )
    naming = "model emps", "linear machine", "compare"
    refused("live", "run.csv", "--map", "m.yaml", "--model", "emps", cwd=tmp_path, naming=naming)
