"""Machines of other people from their CSV to the answer, as a stranger goes: the draft of ``init``, nothing edited.

(shared/real/machines; the tests skip where it is absent.)
"""

import pytest

from ema_bench_replay.load import load
from ema_twin_sim.commands.init import run as init
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.model import load_model

NEVER = {"backlash", "shaft_compliance", "cogging", "torque_ripple", "mesh_ripple", "asymmetric_friction"}
"""What none of these machines has."""


def drafted(trace, tmp_path, **known):
    """Import map and model that ``init`` drafts from one trace and what its user would know."""
    init(str(tmp_path / "machine"), [trace], **known)
    return tmp_path / "machine_map.yaml", load_model(tmp_path / "machine.yaml")


def discovered(folder, import_map, model, start=None):
    recordings = [load(path, import_map=import_map) for path in sorted(folder.glob("*.csv"))]
    return discover([r if start is None else r.between(start) for r in recordings], model)


def level(model, effect, parameter):
    return sum(i.parameters[parameter] for i in model.active.values() if i.effect == effect)


@pytest.fixture
def machines(real):
    return real / "machines"


@pytest.mark.parametrize("with_coulomb", [True, False])
def test_a_geared_servo_that_was_held_at_rest_has_friction_and_nothing_else(with_coulomb, machines, tmp_path):
    """Half of the recording it stands, its torque ramped up to where it would break away: no friction slides there."""
    folder = machines / "damiao_dm8009" / "train"
    import_map, model = drafted(folder / "run_01.csv", tmp_path)
    found = discovered(folder, import_map, model if with_coulomb else model.without_effect("coulomb_friction"))
    assert found.added == (() if with_coulomb else ("coulomb_friction",))
    assert found.verdict == ("none" if with_coulomb else "explained")
    assert level(found.model, "coulomb_friction", "torque") == pytest.approx(0.52, rel=0.05)
    assert level(found.model, "viscous_friction", "coefficient") == pytest.approx(0.030, rel=0.1)
    assert found.model.value("machine.motor_inertia") == pytest.approx(0.024, rel=0.15)


def test_a_dynamometers_load_is_told_at_the_output(machines, tmp_path):
    folder = machines / "michigan_dyno" / "train"
    import_map, model = drafted(folder / "idle_load_a.csv", tmp_path, gear_ratio=6.0, torque_constant=0.1095)
    for start in (model, model.without_effect("coulomb_friction").without_effect("viscous_friction")):
        found = discovered(folder, import_map, start)
        assert not NEVER & {*found.added}
        assert 0.1 < 6.0 * level(found.model, "coulomb_friction", "torque") < 0.25


def test_one_direction_is_friction_and_a_reversal_is_asked_for(machines, tmp_path):
    folder = machines / "kinova_gen3_joint7" / "train"
    import_map, model = drafted(folder / "speed_0p30.csv", tmp_path, gear_ratio=100.0, torque_constant=0.076)
    found = discovered(folder, import_map, model, start=1.0)
    assert not NEVER & {*found.added}
    assert 100.0 * level(found.model, "coulomb_friction", "torque") == pytest.approx(1.5, rel=0.2)
    assert "triangle" in found.next_recording
