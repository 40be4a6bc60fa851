"""Whether a step is large enough to be named: what is asked of each kind of effect, on rows made by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest

from ema_twin_sim.criteria import (
    COST_EFFECT,
    COST_PARAMETER,
    DEPENDS,
    LARGEST_EFFECT,
    LEAST_SIZE,
    LEAST_SIZE_BESIDE_IMPACTS,
    LEAST_SIZE_LIKE_FRICTION,
    NEGLIGIBLE,
    SHAKY,
    SMALL,
)
from ema_twin_sim.discovery.criteria import worth
from ema_twin_sim.discovery.criteria.worth import has_effect_size, is_lacked
from ema_twin_sim.plant.motion import MOTION, MOTOR_ANGLE
from tests.fits_by_hand import a_fit, a_hypothesis, a_problem
from tests.opened import an_open

ROWS = 100
LOADED = "gravity_load"
BIG = 1e9
"""Inflations by which no gain is worth a price."""


def step(stock, size, *effects, left=1.0, **options):
    """(before, after) that one effect more takes rows of this rms from, of which ``left`` is left; all in noise."""
    before = np.full(ROWS, math.sqrt(left**2 + size**2))
    raw = np.full(ROWS, left)
    options.setdefault("inflations", (BIG, BIG))
    bare, full = a_hypothesis(stock, *effects[:-1]), a_hypothesis(stock, *effects)
    return a_fit(bare, before, **options), a_fit(full, raw, **options)


def of_encoders_too(fits):
    """The fits before and after a step, with 50 rows of the encoders that leave as much as those of the torque."""
    before, after = fits
    before.raw, after.raw = np.full(ROWS + 50, 4.0), np.ones(ROWS + 50)
    before.weights = after.weights = np.ones(ROWS + 50)
    return before, after


def named(stock, size, *effects, problem=None, **options):
    return has_effect_size(problem or a_problem(ROWS), *step(stock, size, *effects, **options))


class TestFloor:
    @pytest.mark.parametrize(
        ("effects", "parted", "floor"),
        [
            (("quadratic_drag",), False, LEAST_SIZE),
            (("quadratic_drag",), True, LEAST_SIZE_BESIDE_IMPACTS),
            (("cogging",), False, 0.5 * LEAST_SIZE),
            (("cogging",), True, LEAST_SIZE_BESIDE_IMPACTS),
            (("mesh_friction",), False, LEAST_SIZE_LIKE_FRICTION),
            (("mesh_friction",), True, LEAST_SIZE_BESIDE_IMPACTS),
            ((LOADED, "mesh_friction"), False, LEAST_SIZE),
            ((LOADED, "mesh_friction"), True, LEAST_SIZE_BESIDE_IMPACTS),
            (("constant_load", "mesh_friction"), False, LEAST_SIZE_LIKE_FRICTION),
        ],
    )
    def test_an_effect_must_be_of_a_size(self, effects, parted, floor, stock):
        assert not named(stock, 0.98 * floor, *effects, parted=parted)
        assert named(stock, 1.02 * floor, *effects, parted=parted)

    def test_beside_more_that_is_left_it_must_be_larger(self, stock):
        assert not named(stock, 0.98 * 1.1 * LEAST_SIZE, "quadratic_drag", left=1.1)
        assert named(stock, 1.02 * 1.1 * LEAST_SIZE, "quadratic_drag", left=1.1)

    def test_less_than_the_noise_asks_for_no_less(self, stock):
        assert not named(stock, 0.98 * LEAST_SIZE, "quadratic_drag", left=0.1)

    @pytest.mark.parametrize(("over", "large_enough"), [(0.98, False), (1.02, True)])
    def test_where_much_is_left_it_must_take_a_share_of_it(self, over, large_enough, stock):
        """Of a torque that is ten times the noise, a tenth of the power; more than its size asks for."""
        excess = 100.0
        size = math.sqrt(over * SMALL * excess)
        left = math.sqrt(1.0 + excess - size**2)
        assert size > LEAST_SIZE * left
        assert named(stock, size, "quadratic_drag", left=left) == large_enough

    def test_under_a_load_half_of_a_size_is_enough_where_it_is_surely_gained(self, stock):
        """Beside an output that bounces, whose gains count for a third."""
        size = 0.6 * LEAST_SIZE_BESIDE_IMPACTS
        fall = ROWS * size**2
        price = COST_EFFECT + COST_PARAMETER
        for gain, large_enough in ((DEPENDS - 0.1, False), (DEPENDS + 0.1, True)):
            inflation = fall / (SHAKY * (gain + price))
            options = {"parted": True, "inflations": (inflation, inflation)}
            assert named(stock, size, LOADED, "mesh_friction", **options) == large_enough
            assert not named(stock, size, LOADED, "quadratic_drag", **options)
            assert not named(stock, 0.49 / 0.6 * size, LOADED, "mesh_friction", **options)

    def test_beside_impacts_half_of_a_size_is_enough_for_a_wave_that_is_surely_gained(self, stock):
        size = 0.6 * LEAST_SIZE_BESIDE_IMPACTS
        price = COST_EFFECT + 2.0 * COST_PARAMETER
        for gain, large_enough in ((DEPENDS - 0.1, False), (DEPENDS + 0.1, True)):
            inflation = ROWS * size**2 / (SHAKY * (gain + price))
            options = {"parted": True, "inflations": (inflation, inflation)}
            assert named(stock, size, "cogging", **options) == large_enough
            assert not named(stock, 0.49 / 0.6 * size, "cogging", **options)


class TestConstants:
    def test_what_only_constants_tell_need_only_be_worth_its_price(self, stock):
        """However little more than that."""
        tiny = 0.01 * LEAST_SIZE
        fall, price = ROWS * tiny**2, COST_EFFECT + COST_PARAMETER
        for effect in ("added_inertia", "torque_constant_error"):
            for gain, worth_it in ((1e-6, True), (-1e-6, False)):
                inflation = fall / (price + gain)
                assert named(stock, tiny, effect, inflations=(inflation, inflation)) == worth_it
        assert not named(stock, tiny, "quadratic_drag", inflations=(fall / 99.0, fall / 99.0))
        inflation = fall / (SHAKY * 99.0)
        assert not named(stock, tiny, "added_inertia", parted=True, inflations=(inflation, inflation))

    def test_what_is_worth_nothing_at_all_is_not_named(self, stock):
        before, after = step(stock, 0.0, "added_inertia")
        before.prior_cost = COST_EFFECT + COST_PARAMETER
        assert worth.penalised_gain(before, after) == 0.0
        assert not has_effect_size(a_problem(ROWS), before, after)

    @pytest.mark.parametrize(
        ("effect", "relief", "enough"),
        [
            ("viscous_friction", 1.001, True),
            ("viscous_friction", 1.0, False),
            ("quadratic_drag", 1.001, True),
            (LOADED, 1.001, False),
        ],
    )
    def test_it_may_put_constants_right_instead_if_it_acts_over_what_they_do(self, effect, relief, enough, stock):
        before, after = step(stock, 0.01 * LEAST_SIZE, effect)
        before.prior_cost, after.prior_cost = relief * (COST_EFFECT + COST_PARAMETER) + 3.0, 3.0
        assert has_effect_size(a_problem(ROWS), before, after) == enough


class TestNoSize:
    @pytest.mark.parametrize(
        ("torque", "size"),
        [(LARGEST_EFFECT, True), (-LARGEST_EFFECT, True), (1.01 * LARGEST_EFFECT, False),
         (-1.01 * LARGEST_EFFECT, False)],
    )  # fmt: skip
    def test_a_torque_beyond_all_that_was_measured_is_smoothings(self, torque, size, stock):
        problem = a_problem(ROWS, torque=1.0)
        problem.torque[3] = -1.0
        before, after = step(stock, 1.0, "constant_load")
        after.hypothesis = a_hypothesis(stock, "constant_load", constant_load={"torque": torque})
        assert has_effect_size(problem, before, after) == size

    def test_a_number_that_is_no_torque_may_be_any(self, stock):
        before, after = step(stock, 1.0, "quadratic_drag")
        after.hypothesis = a_hypothesis(stock, "quadratic_drag", quadratic_drag={"coefficient": 50.0})
        assert has_effect_size(a_problem(ROWS), before, after)

    def test_where_no_torque_was_measured_none_is_small_enough(self, stock):
        before, after = step(stock, 1.0, "constant_load")
        assert not has_effect_size(a_problem(ROWS, torque=0.0), before, after)

    def test_what_was_there_before_is_not_judged_again(self, stock):
        beyond = {"constant_load": {"torque": 10.0}}
        before, after = step(stock, 1.0, "constant_load", "quadratic_drag")
        before.hypothesis = a_hypothesis(stock, "constant_load", **beyond)
        after.hypothesis = a_hypothesis(stock, "constant_load", "quadratic_drag", **beyond)
        assert has_effect_size(a_problem(ROWS), before, after)

    @pytest.mark.parametrize(("of_upper", "size"), [(1.0 - NEGLIGIBLE, False), (0.97, True), (1.0, False)])
    def test_a_spring_as_stiff_as_it_may_be_does_nothing(self, of_upper, size, stock):
        problem = a_problem(ROWS, encoder_rows=(50,))
        before, after = of_encoders_too(step(stock, 3.0, "shaft_compliance"))
        upper = next(f.upper for f in after.hypothesis.free if f.path == "effects.shaft_compliance.stiffness")
        after.hypothesis = after.hypothesis.put({"effects.shaft_compliance.stiffness": of_upper * upper})
        assert has_effect_size(problem, before, after) == size

    def test_a_load_that_is_a_spring_may_be_as_stiff_as_it_is(self, stock):
        """It does nothing where its stiffness is nothing."""
        before, after = step(stock, 1.0, "spring_load")
        free = tuple(
            replace(f, upper=0.01) if f.path == "effects.spring_load.stiffness" else f for f in after.hypothesis.free
        )
        after.hypothesis = replace(after.hypothesis, free=free)
        assert has_effect_size(a_problem(ROWS), before, after)

    @pytest.mark.parametrize(("explained", "enough"), [((0.0, 8.0), False), ((0.9, 8.0), False), ((8.0, 8.0), True)])
    def test_a_wave_must_explain_what_it_repeats_in(self, explained, enough, stock):
        """Of two recordings the first shows many cycles of it, and the second a bend."""
        model = replace(stock, orders={}, other_orders=True)
        before, after = step(model, 8.0, "cogging")
        before.raw = np.sqrt(1.0 + np.repeat(explained, ROWS // 2) ** 2)
        problem = a_problem(ROWS // 2, ROWS // 2)
        (order,) = (float(i.options["order"]) for i in after.hypothesis.added.values())
        for o, cycles in zip(problem.observations, (9.0, 1.0), strict=True):
            o.motion = np.zeros((ROWS // 2, len(MOTION)))
            o.motion[:, MOTOR_ANGLE] = np.linspace(0.0, 2.0 * math.pi * cycles / order, ROWS // 2)
        assert has_effect_size(problem, before, after) is enough
        before.hypothesis, after.hypothesis = (replace(f.hypothesis, base=stock) for f in (before, after))
        assert has_effect_size(problem, before, after)  # an order that is known need not repeat

    @pytest.mark.parametrize(("output", "motor"), [(4096.0, 65536.0), (1e9, 16.0)])
    def test_an_angle_error_of_less_than_a_count_is_rounding(self, output, motor, stock, monkeypatch):
        """Of the coarser encoder, where the motor's is seen through the gears."""
        monkeypatch.setattr(worth, "delay_of_gearbox", lambda *_: False)
        model = stock.with_value("sensors.output_encoder_counts", output)
        model = model.with_value("sensors.motor_encoder_counts", motor)
        count = model.turn / min(output, motor * model.value("machine.gear_ratio"))
        problem = a_problem(ROWS, encoder_rows=(50,))
        for effect, size, enough in (
            ("encoder_eccentricity", 0.999, False),
            ("encoder_eccentricity", 1.0, True),
            ("rotor_eccentricity", 1e-6, True),
            ("encoder_delay", 1e-6, True),
        ):
            before, after = of_encoders_too(step(stock, 3.0, effect))
            name = "delay" if effect == "encoder_delay" else "amplitude"
            after.hypothesis = a_hypothesis(model, effect, **{effect: {name: size * count}})
            assert has_effect_size(problem, before, after) == enough, effect


class TestEncoders:
    """Steps that the encoders' rows tell, or both."""

    def step(self, model, effect, torque, encoders, parted=(False, False)):
        """(before, after): rms of the torque's and of the encoders' rows before, 1 after."""
        raw = [np.r_[np.full(ROWS, a), np.full(ROWS, b)] for a, b in ((torque, encoders), (1.0, 1.0))]
        several = a_hypothesis(model), a_hypothesis(model, effect)
        return [
            a_fit(h, r, ROWS, parted=p, inflations=(BIG, BIG)) for h, r, p in zip(several, raw, parted, strict=True)
        ]

    @pytest.fixture
    def problem(self):
        return a_problem(ROWS, encoder_rows=(ROWS,))

    def test_encoders_that_do_not_fit_are_no_matter_of_torques(self, problem, stock):
        """Else a share of all that is left would be asked of a torque."""
        size = 1.1 * LEAST_SIZE
        drag = self.step(stock, "quadratic_drag", math.hypot(1.0, size), 9.0)
        drag[1].raw[ROWS:] = 9.0
        drag[1].misfits, drag[1].misfit = (ROWS, ROWS * 81.0), ROWS * 82.0
        assert has_effect_size(problem, *drag)

    def test_of_play_all_rows_count(self, problem, stock):
        """The torque became worse by as much as the encoders became better, and is judged beside them."""
        size = 2.0
        for parted in ((False, True), (False, False)):
            play = self.step(stock, "backlash", 1.0, math.hypot(1.0, size), parted)
            assert has_effect_size(problem, *play)
            play[0].misfits, play[0].misfit = (ROWS, ROWS), 2.0 * ROWS + 50.0 * ROWS
            play[1].misfits, play[1].misfit = (ROWS, ROWS), 2.0 * ROWS + 49.0 * ROWS
            assert not has_effect_size(problem, *play)

    @pytest.mark.parametrize(("shows", "parted", "large_enough"), [
        (True, False, True), (False, False, False), (True, True, False),
    ])  # fmt: skip
    def test_a_delay_that_shows_is_worth_a_name_beside_lines_that_err_more(
        self, shows, parted, large_enough, problem, stock, monkeypatch
    ):
        monkeypatch.setattr(worth, "delay_shows", lambda *_: shows)
        monkeypatch.setattr(worth, "delay_of_gearbox", lambda *_: False)
        late = self.step(stock, "encoder_delay", 1.0, 30.0, (parted, parted))
        late[1].raw[ROWS:] = 29.5  # a thirtieth of the power
        late[1].misfits = ROWS, ROWS * 29.5**2
        late[1].misfit = sum(late[1].misfits)
        late[0].raw[ROWS:] = np.hypot(29.5, 30.0)  # of a size, so that the share decides
        assert has_effect_size(problem, *late) == large_enough
        if large_enough:  # and no other effect has it easier for it
            wave = self.step(stock, "encoder_eccentricity", 1.0, 30.0)
            wave[0].raw, wave[1].raw = late[0].raw, late[1].raw
            wave[1].misfits, wave[1].misfit = late[1].misfits, late[1].misfit
            assert not has_effect_size(problem, *wave)
            assert not has_effect_size(a_problem(0, encoder_rows=(ROWS,)), *late)
            monkeypatch.setattr(worth, "delay_of_gearbox", lambda *_: True)
            assert not has_effect_size(problem, *late)

    @pytest.mark.parametrize(("share", "enough"), [(0.9 * NEGLIGIBLE, False), (1.1 * NEGLIGIBLE, True)])
    def test_of_an_open_machine_a_share_of_how_the_encoders_part_is_all_that_can_be_asked(
        self, share, enough, problem, stock
    ):
        """It is of how they part about their mean: where they began, nobody knows."""
        model = an_open(stock)
        assert model.is_open and not stock.is_open
        swing = 40.0 * np.tile([-1.0, 1.0], ROWS // 2)
        problem.measured[ROWS:] = 7.0 + swing
        before, after = self.step(model, "backlash", 1.0, 0.0)
        before.raw[ROWS:] = np.sqrt(share) * swing + 0.0
        after.raw[ROWS:] = 0.0
        before.misfits, after.misfits = (ROWS, 1600.0 * ROWS * share), (ROWS, 0.0)
        before.misfit, after.misfit = sum(before.misfits), sum(after.misfits)
        assert has_effect_size(problem, before, after) == enough
        before.hypothesis = a_hypothesis(model, "encoder_delay")  # which may explain nearly all of it
        after.hypothesis = a_hypothesis(model, "encoder_delay", "backlash")
        assert has_effect_size(problem, before, after)
        before.hypothesis, after.hypothesis = a_hypothesis(stock), a_hypothesis(stock, "backlash")
        assert has_effect_size(problem, before, after)

    def test_where_no_torque_was_measured_play_is_judged_by_what_an_encoders_error_leaves(self, stock):
        """The error may be far larger than the play beside it."""
        model = an_open(stock)
        problem = a_problem(0, encoder_rows=(ROWS,))
        swing = np.tile([-1.0, 1.0], ROWS // 2)
        problem.measured[:] = 1000.0 * swing
        for effect, enough in (("backlash", True), ("encoder_eccentricity", False)):
            before = a_fit(a_hypothesis(model), 3.0 * swing, 0, inflations=(BIG, BIG))
            after = a_fit(a_hypothesis(model, effect), swing, 0, inflations=(BIG, BIG))
            assert has_effect_size(problem, before, after) == enough, effect


class TestLacked:
    def test_an_effect_that_every_machine_has_and_the_model_does_not(self, stock):
        bare = stock.without_effect("viscous_friction")
        assert is_lacked(a_hypothesis(bare, "viscous_friction"), "viscous_friction")
        assert not is_lacked(a_hypothesis(stock, "viscous_friction"), "viscous_friction")
        assert not is_lacked(a_hypothesis(bare, "quadratic_drag"), "quadratic_drag")
        assert not is_lacked(a_hypothesis(bare, "viscous_friction", "viscous_friction"), "viscous_friction")
