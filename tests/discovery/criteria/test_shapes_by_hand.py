"""By its own shape or as the likeness of another: the rules, on fits that are given by hand."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from ema_twin_sim.criteria import (
    APART,
    DEPENDS,
    INTERPOLATED,
    LEAST_SIZE,
    MISFIT_DOUBTED,
    MISFIT_LEFT,
    MOSTLY,
    NEARLY_ALL,
    SMALL,
)
from ema_twin_sim.discovery.criteria import likeness, own_shape
from ema_twin_sim.discovery.criteria.likeness import likenesses
from ema_twin_sim.discovery.criteria.own_shape import (
    by_own_shape,
    explains_the_torque,
    imitates,
    is_play,
    only_teeth,
    parts_the_encoders,
    shape_over,
)
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from tests.fits_by_hand import a_fit, a_hypothesis, a_problem

ROWS = 100
SCALE = 3.0
"""Misfit that counts as one."""


def a_torque_fit(h, gained, nothing=1000.0, prior=0.0, **options):
    """A fit of the torque alone that gains so much over one of ``nothing``, in units of what is left."""
    misfits = nothing - SCALE * gained, 0.0
    return a_fit(h, np.ones(ROWS), misfits=misfits, inflations=(SCALE, 7.0 * SCALE), prior=prior, **options)


class TestOwnShape:
    """Effect alone, any shape alone, and both: what each gains over nothing, beyond what its numbers gain by chance."""

    def stands(
        self, monkeypatch, stock, effect, alone, any_shape, both, bases=None, columns=6, model=None, prior=0.0,
        chance=0.0, left=500.0, wander=None,
    ):  # fmt: skip
        h = a_hypothesis(model or stock, effect)
        (name,) = h.added
        over = own_shape.catalogue()[effect].depends_on
        numbers = len(h.free) - len(h.without(name).free)
        nothing = ROWS + SCALE * (alone + 2.0 * numbers + left)
        bare = a_torque_fit(h.without(name), 0.0, nothing, prior)
        hidden = 1 if over == "order" else 0
        f = a_torque_fit(h, alone + 2.0 * numbers, nothing)
        with_basis = {
            False: a_torque_fit(
                bare.hypothesis.with_generic_basis("b", columns), any_shape + 2.0 * (columns + hidden), nothing
            ),
            True: a_torque_fit(
                h.with_generic_basis("b", columns), both + 2.0 * (columns + hidden) + 2.0 * numbers, nothing
            ),
        }
        bases = {f"{over}#0": np.ones((ROWS, columns))} if bases is None else bases
        problem = a_problem(ROWS)
        problem.generic_bases = bases
        problem.weighting = SimpleNamespace(wander=wander)
        given = {}
        problem.with_generic_bases = lambda shapes: given.update(shapes) or problem
        monkeypatch.setattr(own_shape, "fit", lambda problem, h, *_, known=None: bare)
        monkeypatch.setattr(own_shape, "load_bases", lambda *_: {"load": np.ones((ROWS, columns))})
        monkeypatch.setattr(own_shape, "order_bases", lambda *_: {"order#torque1": np.ones((ROWS, columns))})
        monkeypatch.setattr(own_shape, "screen_generic_bases", lambda *_: [(9.0, name) for name in given])
        monkeypatch.setattr(own_shape, "fit_with_basis", lambda problem, known, name: with_basis[known is f])
        by_noise = SCALE * (2.0 * columns + chance)
        monkeypatch.setattr(own_shape, "gain_on_correlated_noise", lambda *_: by_noise)
        self.given, self.imitates = given, imitates(problem, f, name)
        return by_own_shape(problem, f) == (name,)

    @pytest.mark.parametrize("effect", ["stribeck_friction", "cogging", "mesh_friction", "gravity_load", "spring_load"])
    def test_it_imitates_another_shape_that_explains_much_more(self, effect, stock, monkeypatch):
        """In units of what is left, and what the numbers gain by chance left aside."""
        numbers = 2.0 * (1 + (effect in ("stribeck_friction", "cogging", "gravity_load")))
        for alone, imitates_it in ((MOSTLY * 1000.0 - numbers + 3.0, False), (MOSTLY * 1000.0 - numbers - 3.0, True)):
            self.stands(monkeypatch, stock, effect, alone, 1000.0, 1000.0)
            assert self.imitates == imitates_it

    def test_what_every_machine_has_imitates_nothing(self, stock, monkeypatch):
        self.stands(monkeypatch, stock.without_effect("viscous_friction"), "viscous_friction", 10.0, 1000.0, 1000.0)
        assert not self.imitates
        self.stands(monkeypatch, stock, "gravity_load", 10.0, 1000.0, 1000.0, bases={})
        assert not self.imitates  # and what has no quantity to depend on

    @pytest.mark.parametrize("effect", ["stribeck_friction", "cogging", "mesh_friction", "gravity_load"])
    def test_it_must_explain_nearly_all_that_any_shape_does(self, effect, stock, monkeypatch):
        alone = NEARLY_ALL * 1000.0
        assert self.stands(monkeypatch, stock, effect, alone, 999.0, 999.0)
        assert not self.stands(monkeypatch, stock, effect, alone, 1001.0, 1001.0)

    def test_what_any_shape_gains_by_chance_does_not_count(self, stock, monkeypatch):
        for chance, stands in ((60.0, True), (40.0, False)):
            assert self.stands(monkeypatch, stock, "stribeck_friction", 900.0, 1000.0, 1000.0, chance=chance) == stands

    def test_or_that_shape_must_explain_hardly_any_of_what_it_leaves(self, stock, monkeypatch):
        """The effect explains 1000 and leaves ten times as much; beside it the shape explains so much of that."""
        for share, stands in ((0.98, True), (1.02, False)):
            both = 1000.0 + share * (1.0 - NEARLY_ALL) * 10000.0
            held = self.stands(monkeypatch, stock, "stribeck_friction", 1000.0, 5000.0, both, left=10000.0)
            assert held == stands

    def test_what_it_leaves_must_not_depend_on_its_own_quantity_alone(self, stock, monkeypatch):
        """It explains nearly all that any shape does, which explains so much of what is left; not so for an order."""
        for effect in ("gravity_load", "cogging"):
            for share, stands in ((0.98, True), (1.02, effect == "cogging")):
                both = 10000.0 + share * MOSTLY * 200.0
                assert self.stands(monkeypatch, stock, effect, 10000.0, 10100.0, both, left=200.0) == stands

    def test_nor_depend_on_it_where_only_noise_is_left_and_friction_does_not_wander(self, stock, monkeypatch):
        little = 0.9 * (MISFIT_LEFT - 1.0) * ROWS / SCALE
        for more, wander, stands in (
            (0.9 * DEPENDS, None, True), (1.1 * DEPENDS, None, False), (0.7 * little, "it does", True),
        ):  # fmt: skip
            held = self.stands(monkeypatch, stock, "gravity_load", 1e4, 1e4, 1e4 + more, left=little, wander=wander)
            assert held == stands

    def test_or_most_of_what_it_does_beside_that_shape(self, stock, monkeypatch):
        """The shape explains 2000, both together so much more."""
        for more, stands in ((MOSTLY * 300.0 + 1.0, True), (MOSTLY * 300.0 - 1.0, False)):
            assert self.stands(monkeypatch, stock, "stribeck_friction", 300.0, 2000.0, 2000.0 + more) == stands

    def test_what_every_machine_has_is_there_if_it_explains_most(self, stock, monkeypatch):
        bare = stock.without_effect("viscous_friction")
        for alone, stands in ((1.001 * MOSTLY * 1000.0, True), (0.999 * MOSTLY * 1000.0, False)):
            assert self.stands(monkeypatch, bare, "viscous_friction", alone, 1000.0, 1000.0) == stands
        assert not self.stands(monkeypatch, stock, "viscous_friction", 0.9 * 1000.0, 1000.0, 1000.0)

    def test_what_takes_no_more_than_a_dependence_would_is_none(self, stock, monkeypatch):
        """By the misfit alone, whatever numbers it has."""
        at = DEPENDS - 2.0  # one number more
        assert not self.stands(monkeypatch, stock, "constant_load", at - 0.1, 0.0, 0.0)
        assert self.stands(monkeypatch, stock, "constant_load", at + 0.1, 0.0, 0.0)

    def test_constants_that_come_nearer_to_their_file_are_gained_too(self, stock, monkeypatch):
        """By the effect, and by any shape alike."""
        assert not self.stands(monkeypatch, stock, "stribeck_friction", 100.0, 140.0, 140.0)
        assert self.stands(monkeypatch, stock, "stribeck_friction", 100.0, 140.0, 140.0, prior=5000.0)

    def test_what_shows_over_a_quantity_without_a_basis_stands(self, stock, monkeypatch):
        none = {"speed#0": np.ones((ROWS, 2))}
        assert self.stands(monkeypatch, stock, "gravity_load", 1.0, 1e6, 1e6, bases=none)
        assert not self.stands(monkeypatch, stock, "stribeck_friction", 100.0, 1e6, 1e6, bases=none)

    def test_over_the_time_all_recordings_have_one_basis(self, stock, monkeypatch):
        bases = {f"time#{k}": np.full((ROWS, 2), float(k)) for k in range(3)} | {"speed": np.ones((ROWS, 2))}
        self.stands(monkeypatch, stock, "thermal_friction", 100.0, 1.0, 1.0, bases=bases)
        assert [*self.given] == ["time#all"]
        assert self.given["time#all"].shape == (ROWS, 6)
        self.stands(monkeypatch, stock, "quadratic_drag", 100.0, 1.0, 1.0, bases=bases)
        assert [*self.given] == ["speed"]
        for effect, name in (("mesh_friction", "load"), ("cogging", "order#torque1")):
            self.stands(monkeypatch, stock, effect, 100.0, 1.0, 1.0, bases=bases)
            assert [*self.given] == [name]

    def test_where_no_shape_can_be_told_it_stands(self, stock, monkeypatch):
        self.stands(monkeypatch, stock, "stribeck_friction", 100.0, 1e6, 1e6)
        f = a_torque_fit(a_hypothesis(stock, "stribeck_friction"), 100.0)
        problem = a_problem(ROWS)
        problem.generic_bases = {"speed": np.ones((ROWS, 2))}
        problem.with_generic_bases = lambda shapes: problem
        monkeypatch.setattr(own_shape, "screen_generic_bases", lambda *_: [])
        assert by_own_shape(problem, f) == ("stribeck_friction",)

    @pytest.mark.parametrize("shows", [True, False])
    def test_a_late_encoder_is_known_by_itself(self, shows, stock, monkeypatch):
        """Behind play it is told by how much of the encoders' difference it takes away."""
        monkeypatch.setattr(own_shape, "delay_shows", lambda *_: shows)
        h = a_hypothesis(stock, "encoder_delay")
        problem = a_problem(0, encoder_rows=(ROWS,))
        f = a_fit(h, np.ones(ROWS), 0)
        assert by_own_shape(problem, f) == (("encoder_delay",) if shows else ())
        bare = a_fit(h.without("encoder_delay"), np.full(ROWS, 30.0), 0)
        monkeypatch.setattr(own_shape, "fit", lambda *_, **__: bare)
        assert by_own_shape(problem, a_fit(h, np.ones(ROWS), 0, parted=True)) == ("encoder_delay",)

    @pytest.mark.parametrize(("share", "stands"), [(0.99 * (1.0 - MOSTLY), True), (1.01 * (1.0 - MOSTLY), False)])
    def test_an_error_of_an_encoder_must_take_most_of_how_they_part(self, share, stands, stock, monkeypatch):
        """Of the power beyond the noise."""
        h = a_hypothesis(stock, "encoder_eccentricity")
        bare = a_fit(h.without("encoder_eccentricity"), np.full(ROWS, math.sqrt(1.0 + 50.0)), 0)
        monkeypatch.setattr(own_shape, "fit", lambda *_, **__: bare)
        f = a_fit(h, np.full(ROWS, math.sqrt(1.0 + 50.0 * share)), 0)
        problem = a_problem(0, encoder_rows=(ROWS,))
        assert by_own_shape(problem, f) == (("encoder_eccentricity",) if stands else ())

    def test_of_encoders_that_part_by_less_than_their_noise_nothing_is_left(self, stock, monkeypatch):
        h = a_hypothesis(stock, "encoder_eccentricity")
        monkeypatch.setattr(own_shape, "fit", lambda *_, **__: a_fit(h, np.full(ROWS, 0.9), 0))
        f = a_fit(h, np.full(ROWS, 0.8), 0)
        assert by_own_shape(a_problem(0, encoder_rows=(ROWS,)), f) == ("encoder_eccentricity",)


class TestPartsTheEncoders:
    def told(self, monkeypatch, stock, effect, bare, left, rows=(ROWS,)):
        """Of encoders that part by these rms in their noise without the effect and with it; also the torque's rows."""
        h = a_hypothesis(stock, effect)
        (name,) = h.added
        count = sum(rows)
        at = [np.r_[np.full(50, 99.0), np.broadcast_to(rms, count)] for rms in (bare, left)]
        without = a_fit(h.without(name), at[0], 50, parted=False)
        monkeypatch.setattr(own_shape, "fit", lambda problem, h, *_: without)
        return parts_the_encoders(a_problem(50, encoder_rows=rows), a_fit(h, at[1], 50, parted=True), name)

    def test_a_spring_must_leave_no_more_than_lines_may(self, stock, monkeypatch):
        for effect in ("shaft_compliance", "encoder_eccentricity"):
            assert self.told(monkeypatch, stock, effect, 100.0, 0.99 * APART)
            assert not self.told(monkeypatch, stock, effect, 100.0, 1.01 * APART)

    def test_and_explain_most_of_it(self, stock, monkeypatch):
        most = math.sqrt(1.0 + 24.0 / (1.0 - MOSTLY))
        assert self.told(monkeypatch, stock, "shaft_compliance", 1.01 * most, 5.0)
        assert not self.told(monkeypatch, stock, "shaft_compliance", 0.99 * most, 5.0)

    def test_in_every_recording(self, stock, monkeypatch):
        left = np.r_[np.ones(300), np.full(20, 1.01 * APART)]
        assert not self.told(monkeypatch, stock, "shaft_compliance", 100.0, left, rows=(300, 20))
        assert self.told(monkeypatch, stock, "shaft_compliance", 100.0, np.ones(300), rows=(300, 0))

    def test_play_must_leave_little_of_it(self, stock, monkeypatch):
        little = math.sqrt(1.0 + (1.0 - NEARLY_ALL) * (100.0**2 - 1.0))
        assert self.told(monkeypatch, stock, "backlash", 100.0, 0.99 * little)
        assert not self.told(monkeypatch, stock, "backlash", 100.0, 1.01 * little)
        left = np.r_[np.ones(300), np.full(20, 1.01 * little)]
        assert not self.told(monkeypatch, stock, "backlash", 100.0, left, rows=(300, 20))
        left = np.r_[np.ones(300), np.full(20, 0.99 * little)]
        assert self.told(monkeypatch, stock, "backlash", 100.0, left, rows=(300, 20))

    def test_what_lines_part_as_well_is_no_play(self, stock, monkeypatch):
        lines = math.sqrt(1.0 + INTERPOLATED**2)
        assert self.told(monkeypatch, stock, "backlash", 1.001 * lines, 1.0)
        assert not self.told(monkeypatch, stock, "backlash", 0.999 * lines, 1.0)

    def test_nothing_else_does(self, stock, monkeypatch):
        """A gearbox that winds up looks like a late encoder."""
        assert not self.told(monkeypatch, stock, "encoder_delay", 100.0, 1.0)
        assert not self.told(monkeypatch, stock, "quadratic_drag", 100.0, 1.0)

    def test_play_is_what_has_a_width(self, stock):
        told = {
            effect: is_play(a_fit(a_hypothesis(stock, effect), ()), effect)
            for effect in ("backlash", "shaft_compliance", "encoder_eccentricity", "cogging")
        }
        assert told == {"backlash": True, "shaft_compliance": False, "encoder_eccentricity": False, "cogging": False}

    def test_its_teeth_alone_are_fitted_without_a_width(self, stock, monkeypatch):
        h = a_hypothesis(stock, "backlash")
        for share, alone in ((1.02, True), (0.98, False)):
            left = math.sqrt(1.0 + share * (1.0 - MOSTLY) * 50.0)
            asked = []

            def fit(problem, h, steps, asked=asked):
                asked.append(h)
                return a_fit(h, np.full(ROWS, math.sqrt(51.0)), 0, parted=True)

            monkeypatch.setattr(own_shape, "fit", fit)
            f = a_fit(h, np.full(ROWS, left), 0, parted=True)
            assert only_teeth(a_problem(0, encoder_rows=(ROWS,)), f, "backlash") == alone
            assert asked[0].by_path["effects.backlash.width"] == 0.0
            assert [f.upper for f in asked[0].free if f.path == "effects.backlash.width"] == [0.0]


class TestExplainsTheTorque:
    """Misfits of a row of torque without an effect and with it."""

    @pytest.mark.parametrize(
        ("without", "beside", "explains"),
        [
            (1.01 * MISFIT_LEFT, 0.99 * MISFIT_DOUBTED, True),
            (0.99 * MISFIT_LEFT, 0.99 * MISFIT_DOUBTED, False),  # it was hardly called for
            (1.01 * MISFIT_LEFT, 1.01 * MISFIT_DOUBTED, False),  # it took little, and something is left
            (9.0 * MISFIT_LEFT, 0.99 * MISFIT_LEFT, True),  # it took all but a little
            (9.0 * MISFIT_LEFT, 1.01 * MISFIT_LEFT, False),  # too much is left, whatever it took
        ],
    )
    def test_where_much_is_left_without_it_and_nothing_with_it(self, without, beside, explains, stock, monkeypatch):
        h = a_hypothesis(stock, "presliding_friction")
        (name,) = h.added
        bare = a_fit(h.without(name), np.ones(ROWS), misfits=(without * ROWS, 0.0))
        f = a_fit(h, np.ones(ROWS), misfits=(beside * ROWS, 0.0))
        f.problem = a_problem(ROWS)
        monkeypatch.setattr(own_shape, "fit", lambda *_: bare)
        assert explains_the_torque(f, name) == explains


class TestLikeness:
    """A load in whose place a basis of six columns gains so much, beyond what its five more numbers do by chance."""

    def told(self, monkeypatch, stock, gained, basis="output_position#load", left=0.9, needless=0.0, reduces=9.0,
             effect="constant_load", bases=True, share=0.5, **options):  # fmt: skip
        h = a_hypothesis(stock, effect)
        (name,) = h.added
        without = h.without(name)
        columns = 6
        more = len(without.free) + columns - len(h.free)
        misfit = left * ROWS
        instead = a_fit(
            without.with_generic_basis("b", columns),
            np.ones(ROWS),
            misfits=(misfit, 0.0),
            inflations=(SCALE, 7.0 * SCALE),
        )
        further = SCALE * (gained + 2.0 * more)
        f = a_fit(h, np.ones(ROWS), misfits=(misfit + further, 0.0), **options)
        bare = a_fit(without, np.ones(ROWS), misfits=(misfit + further + further / share, 0.0))
        monkeypatch.setattr(likeness, "fit", lambda *_, **__: bare)
        monkeypatch.setattr(likeness, "load_bases", lambda *_: {})
        monkeypatch.setattr(likeness, "screen_generic_bases", lambda *_: [(9.0, basis), (1.0, "x")] if bases else [])
        monkeypatch.setattr(
            likeness, "fit_with_basis", lambda problem, known, name: instead if known is bare else "both"
        )
        monkeypatch.setattr(likeness, "largest_rms_reduction", lambda problem, one, other: reduces)
        monkeypatch.setattr(
            likeness, "penalised_gain", lambda before, after: needless if (before, after) == (instead, "both") else 99.0
        )
        problem = a_problem(ROWS, coarse=self.coarse)
        problem.with_generic_bases = lambda shapes: problem
        return likenesses(problem, f) == (name,)

    coarse = False

    def test_is_what_a_dependence_explains_better_and_makes_needless(self, stock, monkeypatch):
        assert self.told(monkeypatch, stock, DEPENDS + 0.1)
        assert not self.told(monkeypatch, stock, DEPENDS - 0.1)
        assert not self.told(monkeypatch, stock, DEPENDS)

    def test_where_the_dependence_leaves_nothing(self, stock, monkeypatch):
        assert self.told(monkeypatch, stock, 99.0, left=0.99 * MISFIT_DOUBTED)
        assert not self.told(monkeypatch, stock, 99.0, left=1.01 * MISFIT_DOUBTED)

    def test_and_not_only_a_hundredth_more_than_the_effect(self, stock, monkeypatch):
        assert self.told(monkeypatch, stock, 99.0, share=1.01 * SMALL**2)
        assert not self.told(monkeypatch, stock, 99.0, share=0.99 * SMALL**2)

    def test_and_the_effect_gains_nothing_beside_it(self, stock, monkeypatch):
        assert not self.told(monkeypatch, stock, 99.0, needless=0.1)
        assert self.told(monkeypatch, stock, 99.0, needless=-0.1)

    def test_what_follows_the_load_must_be_worth_a_name(self, stock, monkeypatch):
        assert self.told(monkeypatch, stock, 99.0, "load", reduces=LEAST_SIZE)
        assert not self.told(monkeypatch, stock, 99.0, "load", reduces=0.99 * LEAST_SIZE)
        assert self.told(monkeypatch, stock, 99.0, "speed", reduces=0.0)

    def test_none_without_a_basis_behind_play_of_a_coarse_current_or_of_an_encoder(self, stock, monkeypatch):
        assert not self.told(monkeypatch, stock, 99.0, bases=False)
        assert not self.told(monkeypatch, stock, 99.0, parted=True)
        assert not self.told(monkeypatch, stock, 99.0, effect="encoder_eccentricity")
        monkeypatch.setattr(self, "coarse", True, raising=False)
        assert not self.told(monkeypatch, stock, 99.0)


@pytest.mark.parametrize(
    ("effect", "order", "over"),
    [
        ("cogging", "12", "order"),
        ("cogging", "0.5", "order"),  # of a gearbox: the output turns once in many of the motor
        ("cogging", "0.001", "output_position"),
        ("stribeck_friction", "", "speed"),
    ],
)
def test_a_wave_slower_than_the_output_is_a_shape_over_its_position(effect, order, over, stock):
    """A load that rests on the floor over a part of the way was named a wave of a fifth of a cycle per turn."""
    h = null_hypothesis(stock).with_effect(effect, {"order": order} if order else {}, {"torque": 0.01})
    (name,) = h.added
    assert shape_over(SimpleNamespace(hypothesis=h), name) == over
