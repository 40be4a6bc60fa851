"""Sizes that drives seldom have: what looks like a wrong unit is asked about once, by who drafts and by who judges."""

import numpy as np
import pytest

from ema_bench_replay.recording import Recording
from ema_twin_sim.comparison.compare import compare
from ema_twin_sim.discovery.diagnose import weigh
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.measured.usual_sizes import unusual_currents, unusual_sizes
from ema_twin_sim.model import load_model
from ema_twin_sim.new_machine.drafts import checked_model
from ema_twin_sim.new_machine.given import Given
from ema_twin_sim.new_machine.shaft import Shaft

TIME = np.arange(4000) * 1e-3
SPEED = 60.0 * np.sin(2.0 * TIME) + 20.0 * np.sin(7.0 * TIME)


def recording(name, times):
    """A servo whose current is told in ``times`` its unit."""
    random = np.random.default_rng(3)
    current = 4.0 * np.sign(SPEED) + 0.01 * np.gradient(SPEED, 1e-3) + random.normal(0.0, 0.02, len(TIME))
    signals = {
        "motor_position": np.cumsum(SPEED) * 1e-3,
        "speed": SPEED + random.normal(0.0, 0.05, len(TIME)),
        "current": times * current,
    }
    return Recording(name, np.arange(len(TIME)) * 1_000_000, signals)


def drafted(tmp_path, runs):
    place = tmp_path / "servo.yaml"
    place.write_text(checked_model(runs, Given("servo", 1.0, 0.05), Shaft()).text)
    return place


@pytest.mark.parametrize(("times", "words"), [(1000.0, "in mA, and read as A"), (1e-3, "in A, and read as mA")])
def test_a_current_of_unusual_size_is_asked_about_where_nothing_is_known(tmp_path, times, words):
    runs = [recording("a", times), recording("b", 1.5 * times)]
    place = drafted(tmp_path, runs)
    [asked] = unusual_currents(runs, load_model(place))
    assert asked.startswith("b: current reaches") and words in asked and "current_limit: {value: " in asked
    assert (
        "Then correct the unit in the column's name, and run init again" in asked
    )  # which the map alone does not mend
    assert next(unusual_sizes(runs[1])) in asked
    line = asked[asked.index("`current_limit") :].strip("`")
    place.write_text(f"{place.read_text()}drive:\n  {line}\n")
    assert load_model(place).value("drive.current_limit") > 2.0 * np.abs(runs[1].signals["current"]).max()
    assert unusual_currents(runs, load_model(place)) == ()


def test_usual_currents_and_known_machines_are_not_asked_about(tmp_path):
    runs = [recording("a", 1.0)]
    assert unusual_currents(runs, load_model(drafted(tmp_path, runs))) == ()
    assert unusual_currents([recording("a", 1000.0)], load_model("polito_bench")) == ()


@pytest.mark.parametrize(("constant", "asked"), [(0.003, False), (0.05, True), (None, True)])
def test_a_given_torque_constant_tells_a_small_motor_from_a_wrong_unit(tmp_path, constant, asked):
    """A watch's motor of 3 mN m/A that takes 5 mA induces a quarter of a volt: 50 ohm, as windings have."""
    runs = [recording("a", 1e-3)]
    place = tmp_path / "servo.yaml"
    place.write_text(checked_model(runs, Given("servo", 1.0, constant), Shaft()).text)
    assert bool(unusual_currents(runs, load_model(place))) == asked


def test_discover_repeats_the_question(tmp_path):
    runs = [recording("a", 1000.0), recording("b", 1000.0)]
    found = discover(runs, load_model(drafted(tmp_path, runs)))
    [asked] = [warning for warning in found.misread if "mA" in warning and "read as A?" in warning]
    assert found.warnings[0] == asked and "\n" not in asked
    assert weigh(found).as_json()["misread"] == [*found.misread]


def test_compare_asks_before_it_shows_an_error(tmp_path):
    runs = [recording("a", 1000.0), recording("b", 1500.0)]
    [asked] = compare(runs, load_model(drafted(tmp_path, runs))).misread
    assert asked.startswith("b: current reaches") and "in mA, and read as A?" in asked
