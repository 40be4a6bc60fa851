"""Machines of other people from their CSV to the answer, as a stranger goes: the draft of ``init``, nothing edited.

(shared/real/machines; the tests skip where it is absent.)
"""

import pytest

from ema_twin_sim.discovery.discover import discover
from tests.by_draft import by_draft

NEVER = {"backlash", "shaft_compliance", "cogging", "torque_ripple", "mesh_ripple", "asymmetric_friction"}
"""What none of these machines has."""


def drafted(folder, tmp_path, shown=None, **known):
    """Recordings of a folder, and the model that ``init`` drafts of those shown and of what its user would know."""
    return by_draft(tmp_path, sorted(folder.glob("*.csv")), None if shown is None else [folder / shown], **known)


def level(model, effect, parameter):
    return sum(i.parameters[parameter] for i in model.active.values() if i.effect == effect)


@pytest.fixture
def machines(real):
    return real / "machines"


@pytest.mark.parametrize("with_coulomb", [True, False])
def test_a_geared_servo_that_was_held_at_rest_has_friction_and_nothing_else(with_coulomb, machines, tmp_path):
    """Half of the recording it stands, its torque ramped up to where it would break away: no friction slides there."""
    recordings, model = drafted(machines / "damiao_dm8009" / "train", tmp_path, "run_01.csv")
    found = discover(recordings, model if with_coulomb else model.without_effect("coulomb_friction"))
    assert found.added == (() if with_coulomb else ("coulomb_friction",))
    assert found.verdict == ("none" if with_coulomb else "explained")
    assert level(found.model, "coulomb_friction", "torque") == pytest.approx(0.52, rel=0.05)
    assert level(found.model, "viscous_friction", "coefficient") == pytest.approx(0.030, rel=0.1)
    assert found.model.value("machine.motor_inertia") == pytest.approx(0.024, rel=0.15)


@pytest.mark.slow
def test_a_dynamometers_load_is_told_at_the_output(machines, tmp_path):
    known = {"gear_ratio": 6.0, "torque_constant": 0.1095}
    recordings, model = drafted(machines / "michigan_dyno" / "train", tmp_path, "idle_load_a.csv", **known)
    for start in (model, model.without_effect("coulomb_friction").without_effect("viscous_friction")):
        found = discover(recordings, start)
        assert not NEVER & {*found.added}
        # N m at the output, whose load is 2.3 N m: its dry friction is as much alone as follows the load
        coulomb = 6.0 * level(found.model, "coulomb_friction", "torque")
        assert 0.1 < coulomb + 2.3 * level(found.model, "mesh_friction", "coefficient") < 0.3


@pytest.mark.slow
@pytest.mark.parametrize(
    ("known", "with_coulomb"),
    [({"torque_constant": 7.6}, False), ({"gear_ratio": 100.0, "torque_constant": 0.076}, True)],
)
def test_one_direction_is_friction_and_a_reversal_is_asked_for(known, with_coulomb, machines, tmp_path):
    recordings, model = drafted(machines / "kinova_gen3_joint7" / "train", tmp_path, **known)
    model = model if with_coulomb else model.without_effect("coulomb_friction")
    found = discover([recording.between(0.5) for recording in recordings], model)
    # the motor's own orders show if its turns are known: 7, 12, 14 and 28 are those of 12 slots and 7 pole pairs
    assert not (NEVER - {"cogging"} if "gear_ratio" in known else NEVER) & {*found.added}
    at_joint = level(found.model, "coulomb_friction", "torque") * known.get("gear_ratio", 1.0)
    assert at_joint == pytest.approx(1.5, rel=0.2)
    assert found.next_recording.startswith(("triangle", "sine"))  # both reverse


@pytest.mark.parametrize(
    ("known", "with_friction"),
    [
        ({"torque_constant": 10.6956}, True),
        ({"torque_constant": 10.6956}, False),
        pytest.param({"gear_ratio": 101.0, "torque_constant": 0.105897}, False, marks=pytest.mark.slow),
        pytest.param({"gear_ratio": 101.0, "torque_constant": 10.6956}, True, marks=pytest.mark.slow),
    ],
)
def test_a_robots_joint_has_gravity_and_friction_that_follows_load(known, with_friction, machines, tmp_path):
    """However its user tells the gear and the torque constant: at the joint, at the motor, or either at either."""
    recordings, model = drafted(machines / "ur10e_joint2" / "train", tmp_path, **known)
    if not with_friction:
        model = model.without_effect("coulomb_friction").without_effect("viscous_friction")
    found = discover(recordings, model)
    assert {*found.added} == {"gravity_load", "mesh_friction"} | (
        set() if with_friction else {"coulomb_friction", "viscous_friction"}
    )
    assert level(found.model, "mesh_friction", "coefficient") == pytest.approx(0.063, rel=0.1)
    ratio = found.model.value("machine.gear_ratio")
    assert ratio * level(found.model, "gravity_load", "torque") == pytest.approx(114.0, rel=0.03)


@pytest.mark.slow
def test_a_table_of_holding_currents_is_no_motion(real, tmp_path):
    """Its rows have stamps, milliseconds or seconds apart, and a speed that is zero throughout."""
    found = discover(*by_draft(tmp_path, [real / "laas_holding_current.csv"], torque_constant=0.025))
    assert {*found.added} == {"cogging"}
    orders = {i.options["order"] for i in found.model.effects.values() if i.effect == "cogging"}
    assert orders == {"72", "18", "12", "144", "24", "36"}
    assert found.unseen.rmse[-1] <= 0.025
