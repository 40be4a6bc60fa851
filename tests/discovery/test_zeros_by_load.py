"""An arm or a return spring in recordings whose counters all begin at zero, wherever the output stood."""

import math

import numpy as np
import pytest

from ema_twin_sim.comparison.compare import compare
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.discovery.zeros_by_load import zeros_by_load
from ema_twin_sim.discovery.zeros_by_model import with_the_models_zeros, zeros_by_model
from tests.open_motor import open_motor, recorded_motion
from tests.problems import fit_of

RATIO, PERIOD, SECONDS = 50.0, 2e-3, 16.0
INERTIA, VISCOUS, DRY = 6e-5, 1.2e-4, 0.015
NOISE = 2e-3  # A, at 1 N m/A, of ``recorded_motion``
STARTS = {"a": -1.1, "b": 0.4, "c": 1.3}  # rad, of the output
TORQUE, ANGLE = 0.05, 0.3
STIFFNESS, RELAXED = 0.06, -2.0


def arm(angle):
    return TORQUE * np.sin(angle + ANGLE)


def spring(angle):
    return STIFFNESS * (angle - RELAXED)


def none(angle):
    return 0.0 * angle


def swung(name, start, load, anew=True, way=0.8, ratio=RATIO):
    """A joint that moves from ``start`` [rad] to and fro; its counter reads 0 there, or where its angle is 0."""
    random = np.random.default_rng(ord(name))
    time = np.arange(round(SECONDS / PERIOD)) * PERIOD
    fast = 2.0 * math.pi * (0.12 + 0.03 * random.random())
    travel = ratio * way * (np.sin(fast * time) + 0.2 * np.sin(3.1 * fast * time))
    speed = ratio * way * fast * (np.cos(fast * time) + 0.62 * np.cos(3.1 * fast * time))
    acceleration = -ratio * way * fast**2 * (np.sin(fast * time) + 0.2 * 3.1**2 * np.sin(3.1 * fast * time))
    torque = INERTIA * acceleration + VISCOUS * speed + DRY * np.sign(speed) + load(start + travel / ratio)
    return recorded_motion(name, time, torque, speed, travel, random, 0.0 if anew else ratio * start)


def runs(load, anew=True, starts=STARTS):
    return [swung(name, start, load, anew) for name, start in starts.items()]


@pytest.fixture(scope="module")
def joint():
    return open_motor(1.0, NOISE, PERIOD, speed_noise=1e-3).with_value("machine.gear_ratio", RATIO)


@pytest.fixture(scope="module")
def known(joint):
    """The joint with its constants known."""
    joint = joint.without_effect("viscous_friction").with_effect("viscous_friction", {"coefficient": VISCOUS})
    return joint.with_value("machine.motor_inertia", INERTIA).with_value("effects.coulomb_friction.torque", DRY)


def changing(load):
    """Recordings from one start with the load and another weight in each."""
    return [swung(name, 0.0, lambda angle, k=k: 0.02 * k + load(angle)) for k, name in enumerate(STARTS)]


APART = {name: RATIO * (start - STARTS["a"]) for name, start in STARTS.items() if name != "a"}


@pytest.mark.parametrize("load", [arm, spring])
def test_the_ways_between_the_zeros_are_found(load, joint):
    assert zeros_by_load(fit_of(runs(load), joint)) == pytest.approx(APART, rel=0.01)


@pytest.mark.parametrize("load", [arm, spring, none])
def test_nothing_is_moved_where_the_zeros_agree(load, joint):
    assert not zeros_by_load(fit_of(runs(load, anew=False), joint))
    assert not zeros_by_load(fit_of(runs(load, starts=dict.fromkeys(STARTS, 0.7)), joint))
    assert not zeros_by_load(fit_of(runs(load)[:1], joint))


def test_a_weight_that_changes_between_recordings_moves_no_zero(joint):
    """What is the same everywhere in a recording, and another in the next, is no load at an angle."""
    assert not zeros_by_load(fit_of(changing(none), joint))


def test_a_weight_that_changes_beside_an_arm_moves_no_zero(joint):
    """The counters were homed: the arm is at one zero, and what comes and goes is another load."""
    assert not zeros_by_load(fit_of(changing(arm), joint))


def test_where_the_load_does_more_than_add_its_torque_nothing_is_moved(known):
    assert not zeros_by_load(fit_of(runs(arm), known.with_effect("mesh_friction")))


def test_a_spring_that_another_machine_is_wound_the_other_way_by_is_none(joint):
    """A stiffness below zero would push the output away."""
    assert not zeros_by_load(fit_of(runs(lambda angle: -spring(angle)), joint))


class TestOfAModelThatHoldsTheLoad:
    @pytest.fixture
    def heavy(self, known):
        return known.with_effect("gravity_load", {"torque": TORQUE, "angle": ANGLE})

    @pytest.fixture
    def sprung(self, known):
        return known.with_effect("spring_load", {"stiffness": STIFFNESS, "angle": RELAXED}, {"relaxed": "angle"})

    @pytest.mark.parametrize(("load", "name"), [(arm, "heavy"), (spring, "sprung")])
    def test_each_zero_is_moved_to_the_models(self, load, name, request):
        model = request.getfixturevalue(name)
        by = zeros_by_model(runs(load), model)
        assert by == pytest.approx({name: RATIO * start for name, start in STARTS.items()}, rel=0.02)
        moved, (told,) = with_the_models_zeros(runs(load), model)
        assert "they are moved by" in told and zeros_by_model(moved, model) == {}
        before, after = (compare(each, model).overall["unexplained_torque"]["rmse"] for each in (runs(load), moved))
        assert after < 0.1 * before

    def test_a_weight_that_comes_and_goes_moves_no_zero(self, heavy):
        assert zeros_by_model(changing(arm), heavy) == {}

    def test_where_a_load_does_more_than_add_its_torque_nothing_is_moved(self, heavy):
        assert zeros_by_model(runs(arm), heavy.with_effect("mesh_friction")) == {}
        compliant = heavy.with_value("machine.output_inertia", INERTIA).with_effect("shaft_compliance")
        assert zeros_by_model(runs(arm), compliant) == {}

    def test_what_all_are_off_by_is_asked_about(self, heavy):
        """It may be the model's angle, or a weight more: nothing is moved."""
        given = runs(arm, starts=dict.fromkeys(STARTS, 0.4))
        same, (told,) = with_the_models_zeros(given, heavy)
        assert same == given
        assert "fit gravity_load of laas_motor at another angle: by" in told
        assert "add that to the positions; otherwise run fit" in told

    def test_nothing_is_said_where_it_is_as_the_model_has_it(self, heavy):
        for given in (runs(arm, anew=False), runs(arm, starts=dict.fromkeys(STARTS, 0.0))):
            assert with_the_models_zeros(given, heavy) == (given, ())


@pytest.mark.slow
@pytest.mark.parametrize(("load", "named", "size"), [(arm, "gravity_load", TORQUE), (spring, "spring_load", STIFFNESS)])
def test_the_load_is_found_in_all_recordings(load, named, size, joint):
    """Gravity was named as a spring and something over time, a spring as gravity."""
    found = discover(runs(load), joint)
    assert found.verdict == "explained" and found.added == (named,)
    assert next(iter(found.model.effects[named].parameters.values())) == pytest.approx(size, rel=0.02)
    assert any("the zero of the position differs" in warning for warning in found.warnings)


@pytest.mark.slow
def test_a_return_spring_is_relaxed_at_its_own_angle(joint):
    """Where recordings begin at several angles: it was named as gravity and a constant load."""
    found = discover(runs(spring, anew=False), joint)
    assert found.verdict == "explained" and found.added == ("spring_load",)
    instance = found.model.effects["spring_load"]
    assert instance.options == {"relaxed": "angle"}
    assert instance.parameters == pytest.approx({"stiffness": STIFFNESS, "angle": RELAXED}, rel=0.02)
    together = discover(runs(spring, anew=False, starts=dict.fromkeys(STARTS, 0.2)), joint)
    assert set(together.added) == {"spring_load", "constant_load"}
    assert together.model.effects["spring_load"].options == {"relaxed": "start"}


class TestAnArmOnAMotorThatCogs:
    """It turns several times: the arm tells each zero roughly, its magnets closely."""

    WAVE = 0.008

    @pytest.fixture
    def crank(self, known):
        direct = known.with_value("machine.gear_ratio", 1.0)
        direct = direct.with_effect("gravity_load", {"torque": TORQUE, "angle": ANGLE})
        return direct.with_effect("cogging", {"torque": self.WAVE, "phase": -1.0}, {"order": "12"})

    def turning(self):
        def load(angle):
            return arm(angle) + self.WAVE * np.sin(12.0 * angle - 1.0)

        return [swung(name, start, load, way=12.0, ratio=1.0) for name, start in STARTS.items()]

    def test_both_tell_the_zeros_of_the_model(self, crank):
        # a twelfth of a turn is 0.52 rad
        assert zeros_by_model(self.turning(), crank) == pytest.approx(STARTS, abs=0.008)

    @pytest.mark.slow
    def test_both_are_found(self, joint):
        found = discover(self.turning(), joint.with_value("machine.gear_ratio", 1.0))
        assert found.verdict == "explained" and set(found.added) == {"gravity_load", "cogging"}
        assert found.model.effects["cogging"].parameters["torque"] == pytest.approx(self.WAVE, rel=0.05)
