"""What an explanation must be beside fitting well: constants near their file, sizes that are known, one cause."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from ema_twin_sim.criteria import (
    COST_PARAMETER,
    DEPENDS,
    LEAST_SIZE,
    LIKELY,
    SIGNIFICANT,
    STRAINED_BESIDE,
    STRAINED_TOGETHER,
)
from ema_twin_sim.discovery.criteria import plausible
from ema_twin_sim.discovery.criteria.plausible import insignificant, only_constants, strained
from tests.fits_by_hand import a_fit, a_hypothesis, a_problem
from tests.opened import an_open

ROWS = 100


def off_by(stock, *effects, **standard):
    """A fit whose constants are off their file by so many tolerances: inertia, viscous, coulomb, lag."""
    h = a_hypothesis(stock, *effects)
    paths = {"inertia": "scale.inertia", "viscous": "scale.viscous_friction", "coulomb": "scale.coulomb_friction"}
    values = {}
    for free in h.free:
        for name, times in standard.items():
            if free.path == paths.get(name, name) and free.prior is not None:
                values[free.path] = free.prior[0] + times * free.prior[1]
    assert len(values) == len(standard)
    return a_fit(h.put(values), np.ones(ROWS))


class TestStrained:
    def test_one_constant_that_is_surely_off_is(self, stock):
        assert strained(off_by(stock, viscous=0.99 * SIGNIFICANT)) == ()
        assert strained(off_by(stock, viscous=1.01 * SIGNIFICANT)) == ("speed",)
        assert strained(off_by(stock, viscous=-1.01 * SIGNIFICANT)) == ("speed",)
        assert strained(off_by(stock, inertia=1.01 * SIGNIFICANT)) == ("acceleration",)

    def test_several_that_may_be_off_are_together(self, stock):
        each = math.sqrt(0.5 * STRAINED_TOGETHER)
        assert strained(off_by(stock, viscous=0.99 * each, inertia=0.99 * each)) == ()
        assert set(strained(off_by(stock, viscous=1.01 * each, inertia=1.01 * each))) == {"speed", "acceleration"}
        other = math.sqrt(STRAINED_TOGETHER) - 0.5  # less than is likely stays
        assert strained(off_by(stock, viscous=other, inertia=1.01 * LIKELY)) == ("acceleration", "speed")
        assert strained(off_by(stock, viscous=other, inertia=0.99 * LIKELY)) == ()

    def test_over_one_quantity_they_are_told_once(self, stock):
        assert strained(off_by(stock, viscous=5.0, coulomb=5.0)) == ("speed",)

    def test_beside_an_effect_that_only_constants_tell_less_is_enough(self, stock):
        each = math.sqrt(0.5 * STRAINED_BESIDE)
        assert strained(off_by(stock, "quadratic_drag", viscous=1.01 * each, inertia=1.01 * each)) == ()
        for effect in ("added_inertia", "torque_constant_error"):
            assert strained(off_by(stock, effect, viscous=1.01 * each, inertia=1.01 * each)) != ()
            assert strained(off_by(stock, effect, viscous=0.99 * each, inertia=0.99 * each)) == ()

    def test_a_lag_is_no_constant_of_the_machine(self, stock):
        assert strained(off_by(stock, lag=9.0)) == ()

    def test_nor_is_how_a_gearbox_that_parts_shares_them(self, stock):
        """The output's share is off by far, and the motor's by as much the other way: the sum is the file's."""
        h = a_hypothesis(stock, "backlash")
        side = next(f for f in h.free if f.path == "scale.output_inertia")
        motor = sum(stock.value(f"machine.{part}_inertia") for part in ("motor", "gearbox"))
        output = stock.value("machine.output_inertia")
        shared = h.put({"scale.output_inertia": 0.5, "scale.inertia": 1.0 + 0.5 * output / motor})
        assert abs(0.5 - side.prior[0]) / side.prior[1] > 2.0 * SIGNIFICANT
        assert strained(a_fit(shared, np.ones(ROWS))) == ()
        heavier = h.put({"scale.output_inertia": 2.0, "scale.inertia": 2.0})
        assert strained(a_fit(heavier, np.ones(ROWS))) == ("acceleration",)


def sure(h, monkeypatch, spread, jacobian=None, lost=0.0):
    """What is insignificant of a hypothesis whose numbers have these standard errors (by path) or this covariance.

    ``lost`` is what the rows lose without an effect, in units of the noise.
    """
    paths = [free.path for free in h.free]
    if isinstance(spread, dict):
        spread = np.diag([spread.get(path, 1e-9) ** 2 for path in paths])
    jacobian = np.ones((ROWS, len(paths))) if jacobian is None else jacobian
    monkeypatch.setattr(plausible, "covariance", lambda *_: spread)
    monkeypatch.setattr(plausible, "fit", lambda *_, **__: None)
    monkeypatch.setattr(plausible, "penalised_gain", lambda *_: lost)
    return insignificant(a_problem(ROWS), a_fit(h, np.ones(ROWS), jacobian=jacobian))


class TestInsignificant:
    LOAD = "effects.constant_load.torque"

    @pytest.mark.parametrize(("errors", "there"), [(0.99 * SIGNIFICANT, False), (1.01 * SIGNIFICANT, True)])
    def test_a_size_must_be_so_many_standard_errors_from_none(self, errors, there, stock, monkeypatch):
        for torque in (0.02, -0.02):
            h = a_hypothesis(stock, "constant_load", constant_load={"torque": torque})
            found = sure(h, monkeypatch, {self.LOAD: 0.02 / errors})
            assert found == (None if there else "constant_load")

    @pytest.mark.parametrize(("errors", "lost", "there"), [
        (0.99 * SIGNIFICANT, 1.01, True), (0.99 * SIGNIFICANT, 0.99, False),
        (1.01 * LIKELY, 1.01, True), (0.99 * LIKELY, 99.0, False),
    ])  # fmt: skip
    def test_fewer_suffice_where_nothing_else_explains_the_rows(self, errors, lost, there, stock, monkeypatch):
        """A standard error describes the misfit close to its minimum; without the effect it may be far larger."""
        for model, open_too in ((an_open(stock), there), (stock, False)):
            h = a_hypothesis(model, "presliding_friction", presliding_friction={"stiffness": 1.0})
            spread = {"effects.presliding_friction.stiffness": 1.0 / errors}
            found = sure(h, monkeypatch, spread, lost=lost * SIGNIFICANT * DEPENDS)
            assert found == (None if open_too else "presliding_friction")

    def test_none_is_where_an_effect_does_nothing(self, stock, monkeypatch):
        """A factor of one."""
        h = a_hypothesis(stock, "asymmetric_friction", asymmetric_friction={"fraction": 0.02})
        assert sure(h, monkeypatch, {"effects.asymmetric_friction.fraction": 0.002}) is None
        h = a_hypothesis(stock, "presliding_friction", presliding_friction={"stiffness": 1.0})
        assert sure(h, monkeypatch, {"effects.presliding_friction.stiffness": 0.2}) is None
        assert sure(h, monkeypatch, {"effects.presliding_friction.stiffness": 0.6}) == "presliding_friction"

    def test_the_least_sure_of_several_goes(self, stock, monkeypatch):
        h = a_hypothesis(stock, "constant_load", "quadratic_drag", "spring_load")
        drag, spring = "effects.quadratic_drag.coefficient", "effects.spring_load.stiffness"
        assert sure(h, monkeypatch, {self.LOAD: 0.003, drag: 0.0031, spring: 1e-4}) == "quadratic_drag"
        assert sure(h, monkeypatch, {self.LOAD: 0.0031, drag: 0.003, spring: 1e-4}) == "constant_load"
        assert sure(h, monkeypatch, {self.LOAD: 1e-4, drag: 1e-4, spring: 1e-4}) is None

    def test_of_two_the_later_goes_where_it_is_not_sure_by_itself(self, stock, monkeypatch):
        h = a_hypothesis(stock, "constant_load", "quadratic_drag")
        drag = "effects.quadratic_drag.coefficient"
        assert sure(h, monkeypatch, {self.LOAD: 0.02, drag: 0.01}) == "quadratic_drag"

    def test_what_only_constants_tell_is_not_asked(self, stock, monkeypatch):
        for effect, number in (("added_inertia", "inertia"), ("torque_constant_error", "scale")):
            h = a_hypothesis(stock, effect)
            assert sure(h, monkeypatch, {f"effects.{effect}.{number}": 99.0}) is None

    @pytest.mark.parametrize(("scale", "there"), [(0.5, False), (0.52, True), (1.46, True), (1.5, False)])
    def test_a_factor_as_far_off_as_it_may_be_goes(self, scale, there, stock, monkeypatch):
        """It wants to be more than any motor has; beside it an inertia or a friction stands for the rest."""
        for model, stays in ((stock, there), (an_open(stock), True)):
            h = a_hypothesis(model, "torque_constant_error", torque_constant_error={"scale": scale})
            assert sure(h, monkeypatch, {}) == (None if stays else "torque_constant_error")

    @pytest.mark.parametrize(
        ("scale", "error", "there"), [(1.45, 0.04, True), (1.45, 0.06, False), (0.55, 0.06, False), (1.35, 0.3, True)]
    )
    def test_so_does_one_that_is_as_far_off_within_its_error(self, scale, error, there, stock, monkeypatch):
        h = a_hypothesis(stock, "torque_constant_error", torque_constant_error={"scale": scale})
        found = sure(h, monkeypatch, {"effects.torque_constant_error.scale": error})
        assert found == (None if there else "torque_constant_error")

    def test_nor_what_every_machine_has_beside_a_basis(self, stock, monkeypatch):
        bare = stock.without_effect("viscous_friction")
        h = a_hypothesis(bare, "viscous_friction")
        vague = {"effects.viscous_friction.coefficient": 99.0}
        assert sure(h, monkeypatch, vague) == "viscous_friction"
        assert sure(h.with_generic_basis("speed", 2), monkeypatch, vague) is None
        twice = a_hypothesis(stock, "constant_load").with_generic_basis("speed", 2)
        assert sure(twice, monkeypatch, {self.LOAD: 99.0}) == "constant_load"


def bounded(h, path, **bounds):
    """The hypothesis with other bounds of one of its numbers."""
    return replace(h, free=tuple(replace(f, **bounds) if f.path == path else f for f in h.free))


class TestShapes:
    """Effects of which a size and a shape take each other's place."""

    SIZE, SPEED = "effects.stribeck_friction.torque", "effects.stribeck_friction.speed"

    def told(self, h, size, shape, error, correlation, slopes=(1.0, 0.0), of_shape=1.0):
        """(hypothesis, covariance, slopes) of a size that is known to an ``error``, and a shape to ``of_shape``."""
        paths = [free.path for free in h.free]
        i, j = paths.index(size), paths.index(shape)
        spread = 1e-18 * np.eye(len(paths))
        spread[i, i], spread[j, j] = error**2, of_shape**2
        spread[i, j] = spread[j, i] = correlation * error
        jacobian = np.zeros((ROWS, len(paths)))
        jacobian[:, i], jacobian[:, j] = slopes
        return h, spread, jacobian

    def stribeck(self, stock, torque_error, correlation, slopes=(1.0, 0.0), **of):
        h = a_hypothesis(stock, "stribeck_friction", stribeck_friction={"torque": 0.06, "speed": 2.0})
        return self.told(h, self.SIZE, self.SPEED, torque_error, correlation, slopes, **of)

    @pytest.mark.parametrize(("error", "there"), [(0.06 / 2.05, True), (0.06 / 1.95, False)])
    def test_with_its_shape_free_it_must_still_be_told_from_nothing(self, error, there, stock, monkeypatch):
        """With the shape held it is known twenty times as well; what both do together is sure."""
        h, *known = self.stribeck(stock, error, math.sqrt(1.0 - 1.0 / 400.0), (1.0, -0.03))
        assert sure(h, monkeypatch, *known) == (None if there else "stribeck_friction")

    @pytest.mark.parametrize(("held", "there"), [(0.06 / 4.05, True), (0.06 / 3.95, False)])
    def test_with_its_shape_held_it_must_be_significant(self, held, there, stock, monkeypatch):
        correlation = 0.8
        h, *known = self.stribeck(stock, held / math.sqrt(1.0 - correlation**2), correlation)
        assert sure(h, monkeypatch, *known) == (None if there else "stribeck_friction")

    @pytest.mark.parametrize(("error", "there"), [(0.06 / 2.05, True), (0.06 / 1.95, False)])
    def test_what_it_does_must_be_told_from_nothing(self, error, there, stock, monkeypatch):
        """The same shape does as much as the size: the errors of both add up."""
        of_speed = math.sqrt(error**2 - 0.006**2) / 0.06
        h, *known = self.stribeck(stock, 0.06 / 10.0, 0.0, (1.0, 0.06), of_shape=of_speed)
        assert sure(h, monkeypatch, *known) == (None if there else "stribeck_friction")

    def test_where_constants_are_open_it_must_be_surely(self, stock, monkeypatch):
        for model, there in ((stock, True), (an_open(stock), False)):
            of_speed = math.sqrt((0.06 / 3.0) ** 2 - 0.006**2) / 0.06
            h, *known = self.stribeck(model, 0.06 / 10.0, 0.0, (1.0, 0.06), of_shape=of_speed)
            assert sure(h, monkeypatch, *known) == (None if there else "stribeck_friction")

    @pytest.mark.parametrize("share", [0.5, 0.9])
    def test_a_share_is_bounded_to_both_sides(self, share, stock, monkeypatch):
        """A lubricant that thins by 0.5 ± 0.6 at a speed that takes its place: what it does is sure."""
        h = a_hypothesis(stock, "shear_thinning", shear_thinning={"fraction": share, "speed": 3.0})
        paths = (f"effects.shear_thinning.{name}" for name in ("fraction", "speed"))
        h, *known = self.told(h, *paths, 1.2 * share, 0.999, (1.0, -1.2 * share))
        assert sure(h, monkeypatch, *known) is None

    @pytest.mark.parametrize(("errors", "there"), [(1.05, True), (0.95, False)])
    def test_of_a_wave_over_a_part_of_a_turn_one_error_is_enough(self, errors, there, stock, monkeypatch):
        """Amplitude and angle take each other's place: with the angle held it is surely there."""
        h = a_hypothesis(stock, "gravity_load", gravity_load={"torque": 0.06, "angle": 0.2})
        h, spread, _ = self.told(h, *(f"effects.gravity_load.{n}" for n in ("torque", "angle")), 0.06 / errors, 0.999)
        assert sure(h, monkeypatch, spread) == (None if there else "gravity_load")

    @pytest.mark.parametrize(("model", "speed", "stands"), [
        ("open", 0.06, False), ("open", 2.0, True), ("known", 0.06, True),
    ])  # fmt: skip
    def test_where_constants_are_open_no_shape_may_stand_on_its_bound(self, model, speed, stands, stock, monkeypatch):
        """There it is a part of the constants that these do not fit."""
        machine = an_open(stock) if model == "open" else stock
        h = a_hypothesis(machine, "stribeck_friction", stribeck_friction={"torque": 0.06, "speed": speed})
        assert sure(bounded(h, self.SPEED, lower=0.06), monkeypatch, {}) == (None if stands else "stribeck_friction")

    def test_but_a_size_may_and_an_angle_has_none(self, stock, monkeypatch):
        gravity, bristle = {"torque": 0.06, "angle": 0.2}, {"stiffness": 1.0, "damping": 0.01}
        h = a_hypothesis(an_open(stock), "gravity_load", gravity_load=gravity)
        assert sure(bounded(h, "effects.gravity_load.angle", lower=0.2, upper=0.2), monkeypatch, {}) is None
        h = a_hypothesis(an_open(stock), "presliding_friction", presliding_friction=bristle)
        assert sure(bounded(h, "effects.presliding_friction.stiffness", upper=1.0), monkeypatch, {}) is None

    @pytest.mark.parametrize(("coefficient", "stands"), [(0.5, True), (0.7, False)])
    def test_a_share_that_no_machine_has_is_not_named_if_constants_are_open(
        self, coefficient, stands, stock, monkeypatch
    ):
        """Teeth do not lose more than half of what they carry to friction."""
        for machine, held in ((an_open(stock), stands), (stock, True)):
            h = a_hypothesis(machine, "mesh_friction", mesh_friction={"coefficient": coefficient})
            assert sure(h, monkeypatch, {}) == (None if held else "mesh_friction")

    def test_what_depends_on_circumstances_is_no_such_share(self, stock, monkeypatch):
        """A propeller's drag is many times all other friction."""
        h = a_hypothesis(an_open(stock), "quadratic_drag", quadratic_drag={"coefficient": 1e3})
        assert sure(h, monkeypatch, {}) is None


class TestOnlyConstants:
    """Fits without one of the effects are given by hand."""

    def fits_without(self, monkeypatch, **fits):
        """Let a fit without an effect be the one of that name."""
        asked = []

        def fit(problem, h, iterations, known):
            name = next(name for name in known.hypothesis.added if name not in h.added)
            asked.append(name)
            return fits[name]

        monkeypatch.setattr(plausible, "fit", fit)
        return asked

    def bare(self, stock, size, *effects):
        return a_fit(a_hypothesis(stock, *effects), np.full(ROWS, math.hypot(1.0, size)))

    def test_a_cause_for_each_constant_is_none(self, stock, monkeypatch):
        two = "viscous_friction", "added_inertia"
        f = a_fit(a_hypothesis(stock, *two), np.ones(ROWS))
        names = tuple(f.hypothesis.added)
        for sizes, told in (
            ((0.98, 0.98), names), ((1.02, 0.98), ()), ((0.98, 1.02), ()), ((1.02, 1.02), ()), ((0.0, 0.0), names),
        ):  # fmt: skip
            without = {n: self.bare(stock, s * LEAST_SIZE) for n, s in zip(names, sizes, strict=True)}
            self.fits_without(monkeypatch, **without)
            assert only_constants(a_problem(ROWS), f) == told, sizes

    def test_of_three_those_that_nothing_else_calls_for(self, stock, monkeypatch):
        bare = stock.without_effect("coulomb_friction")
        f = a_fit(a_hypothesis(bare, "viscous_friction", "added_inertia", "coulomb_friction"), np.ones(ROWS))
        names = tuple(f.hypothesis.added)
        self.fits_without(monkeypatch, **{n: self.bare(stock, k * 0.15) for k, n in enumerate(names)})
        assert only_constants(a_problem(ROWS), f) == names[:2]

    def test_one_cause_for_one_constant_is_one(self, stock, monkeypatch):
        asked = self.fits_without(monkeypatch)
        f = a_fit(a_hypothesis(stock, "added_inertia", "gravity_load", "quadratic_drag"), np.ones(ROWS))
        assert only_constants(a_problem(ROWS), f) == ()
        assert asked == []

    @pytest.mark.parametrize(("left", "told"), [(1.01, True), (0.99, False)])
    def test_a_torque_constant_must_put_right_more_than_one_constant(self, left, told, stock, monkeypatch):
        """Without it inertia is off by 3 tolerances, friction by 2 and by 1: all but the worst cost five."""
        h = a_hypothesis(stock)
        z = {"scale.inertia": 3.0, "scale.viscous_friction": 2.0, "scale.coulomb_friction": -1.0}
        unscaled = h.put({f.path: f.prior[0] + z[f.path] * f.prior[1] for f in h.free if f.path in z})
        f = a_fit(a_hypothesis(stock, "torque_constant_error"), np.ones(ROWS), prior=left * (5.0 + COST_PARAMETER))
        self.fits_without(monkeypatch, torque_constant_error=a_fit(unscaled, np.ones(ROWS)))
        assert only_constants(a_problem(ROWS), f) == (("torque_constant_error",) if told else ())

    def test_a_model_without_constants_to_be_off_has_none_that_are(self):
        h = SimpleNamespace(free=(), values=np.zeros(0))
        assert plausible._beside_the_worst(SimpleNamespace(hypothesis=h)) == 0.0
