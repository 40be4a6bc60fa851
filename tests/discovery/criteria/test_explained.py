"""Whether nothing is left that the noise does not account for: what is asked of rows that were made by hand."""

import math

import numpy as np
import pytest

from ema_twin_sim.criteria import (
    APART,
    BRISTLED,
    DEPENDS,
    FAR_OFF_ROW,
    FAR_OUT,
    INTERPOLATED,
    LEAST_SIZE,
    MISFIT_DOUBTED,
    MISFIT_LEFT,
    NEGLIGIBLE,
    PART,
    SHAKY,
    SMALL,
    STANDSTILL,
    UNEXPLAINED,
)
from ema_twin_sim.discovery.criteria import explained as explained_module
from ema_twin_sim.discovery.criteria.explained import apart, coarse, depends, explained, lagging, unexplained
from ema_twin_sim.plant.motion import SPEED
from tests.fits_by_hand import a_fit, a_hypothesis, a_problem
from tests.opened import an_open

ROWS = 100


class TestExplained:
    """Each of the four that are asked may refuse alone."""

    ASKED = ("unexplained", "apart", "strained", "only_constants")

    @pytest.mark.parametrize("refused", [None, *ASKED])
    def test_of_a_known_machine_all_four_must_be_well(self, refused, stock, monkeypatch):
        for name in self.ASKED:
            monkeypatch.setattr(explained_module, name, lambda *_, name=name: name == refused)
        f = a_fit(a_hypothesis(stock), np.ones(ROWS))
        assert explained(a_problem(ROWS), f, f) == (refused is None)

    @pytest.mark.parametrize("left", [0.99, 1.01])
    @pytest.mark.parametrize("parts", [True, False])
    def test_of_an_open_one_little_must_be_left_and_the_encoders_together(self, left, parts, stock, monkeypatch):
        """A tenth of the torque; strained it is not, as no constant is known."""
        for name in ("unexplained", "strained", "only_constants"):
            monkeypatch.setattr(explained_module, name, lambda *_: True)
        monkeypatch.setattr(explained_module, "apart", lambda *_: parts)
        problem = sliding(a_problem(ROWS, torque=0.5, noise=0.01))
        f = a_fit(a_hypothesis(an_open(stock)), np.full(ROWS, left * SMALL * 0.5 / 0.01))
        assert explained(problem, f, f) == (left < 1.0 and not parts)

    @pytest.mark.parametrize("reading", [0.0, 0.04])
    def test_of_an_open_one_what_its_sensors_read_is_not_left(self, reading, stock, monkeypatch):
        """Noise of a current that is a tenth of the torque was an unknown cause."""
        monkeypatch.setattr(explained_module, "apart", lambda *_: False)
        problem = sliding(a_problem(ROWS, torque=0.5, noise=0.01, reading=reading))
        f = a_fit(a_hypothesis(an_open(stock)), np.full(ROWS, 6.0))
        assert explained(problem, f, f) == (reading > 0.0)

    def test_rows_at_standstill_say_nothing_of_sliding_friction(self, stock, monkeypatch):
        monkeypatch.setattr(explained_module, "apart", lambda *_: False)
        speed = np.where(np.arange(ROWS) < 30, -0.99 * STANDSTILL, -1.01 * STANDSTILL)
        raw = np.where(np.arange(ROWS) < 30, 1e3, 1.0)
        f = a_fit(a_hypothesis(an_open(stock)), raw)
        assert explained(sliding(a_problem(ROWS, torque=0.5), speed), f, f)
        assert not explained(sliding(a_problem(ROWS, torque=0.5), speed, of_points=True), f, f)
        assert not explained(sliding(a_problem(ROWS, torque=0.5), np.full(ROWS, STANDSTILL)), f, f)


def sliding(problem, speed=5.0, of_points=False):
    """The problem with the motion of its rows [rad/s]."""
    (o,) = problem.observations
    o.motion = np.zeros((ROWS, 7))
    o.motion[:, SPEED] = speed
    o.of_points = np.full(ROWS, of_points)
    return problem


class TestApart:
    """Encoders whose rows are of this rms, in their noise, before and after."""

    def told(self, model, before, after, parted=False, rows=(ROWS,)):
        problem = a_problem(ROWS, encoder_rows=rows)
        count = sum(rows)
        start = a_fit(a_hypothesis(model), np.r_[np.full(ROWS, 99.0), np.full(count, before)], ROWS)
        left = np.broadcast_to(after, count)
        return apart(problem, a_fit(a_hypothesis(model), np.r_[np.full(ROWS, 99.0), left], ROWS, parted=parted), start)

    @pytest.fixture(autouse=True)
    def no_lag(self, monkeypatch):
        monkeypatch.setattr(explained_module, "lagging", lambda *_: {})

    def test_an_encoder_may_err_between_its_lines(self, stock):
        assert not self.told(stock, 1.0, 0.99 * INTERPOLATED)
        assert not self.told(stock, 1.0, INTERPOLATED)
        assert self.told(stock, 1.0, 1.01 * INTERPOLATED)

    def test_behind_play_it_may_by_a_little_of_how_they_parted(self, stock):
        for parted in (0.0, 10.0):
            limit = 1.0 + LEAST_SIZE * parted
            assert not self.told(stock, parted, 0.99 * limit, parted=True)
            assert self.told(stock, parted, 1.01 * limit, parted=True)

    def test_but_no_more_than_is_far_unless_they_parted_by_very_much(self, stock):
        assert not self.told(stock, 100.0, 0.99 * APART, parted=True)
        assert self.told(stock, 100.0, 1.01 * APART, parted=True)
        very = 2.0 * APART / NEGLIGIBLE
        assert not self.told(stock, very, 1.98 * APART, parted=True)
        assert self.told(stock, very, 2.02 * APART, parted=True)
        assert not self.told(stock, 1e6, 0.495 * FAR_OFF_ROW, parted=True)
        assert self.told(stock, 1e6, 0.505 * FAR_OFF_ROW, parted=True)

    def test_a_row_that_is_far_off_counts_as_no_more_than_that(self, stock):
        """A few such rows in a hundred are as far as an encoder's lines."""
        few = int(ROWS * (INTERPOLATED / FAR_OFF_ROW) ** 2)
        after = np.where(np.arange(ROWS) < few, -1e6, 0.0)
        assert not self.told(stock, 1.0, after)
        after[few] = 1e6
        assert self.told(stock, 1.0, after)

    def test_one_recording_is_enough(self, stock):
        after = np.r_[np.zeros(300), np.full(20, 1.01 * INTERPOLATED)]
        assert self.told(stock, 1.0, after, rows=(300, 20))
        assert not self.told(stock, 1.0, np.zeros(300), rows=(300, 0))

    def test_of_an_open_machine_little_must_be_left(self, stock):
        model = an_open(stock)
        assert not self.told(model, 100.0, 0.99 * PART * 100.0)
        assert self.told(model, 100.0, 1.01 * PART * 100.0)
        assert not self.told(model, 1.0, 0.99 * APART)
        assert self.told(model, 1.0, 1.01 * APART)
        assert not self.told(model, 1.0, (), rows=())

    def test_an_output_that_has_lagged_since_the_start_is(self, stock, monkeypatch):
        monkeypatch.setattr(explained_module, "lagging", lambda *_: {"recording 0": 1.0})
        assert self.told(stock, 0.0, 0.0)


class TestLagging:
    NOISE = 1e-5

    def told(self, model, counts, rows=50, piece=None, parted=False):
        """By the reading of an encoder whose rows, smoothed to half its noise, are off by so many readings."""
        problem = a_problem(0, encoder_rows=(rows,))
        (o,) = problem.observations
        o.encoder_rows, o.encoder_noise = np.arange(rows), np.full(rows, self.NOISE)
        o.encoder_piece = np.zeros(rows, int) if piece is None else piece
        o.kernel = np.full(4, 0.25)  # of norm one half
        problem.measured = np.broadcast_to(np.asarray(counts, float) * 2.0, rows).copy()
        return lagging(problem, a_fit(a_hypothesis(model), np.zeros(rows), 0, parted=parted))

    @pytest.mark.parametrize("sign", [1.0, -1.0])
    def test_tells_how_far_the_output_lies_off_the_motor(self, sign, stock):
        assert self.told(stock, sign * 0.99 * FAR_OUT) == {}
        found = self.told(stock, sign * 1.01 * FAR_OUT)
        assert found == {"recording 0": pytest.approx(sign * 1.01 * FAR_OUT * 2.0 * self.NOISE)}

    def test_by_the_first_piece_alone(self, stock):
        """Behind a gap in the recording, its zero is another."""
        piece = np.r_[np.full(20, 3), np.full(30, 4)]
        assert self.told(stock, np.where(piece == 3, 0.0, 99.0), piece=piece) == {}
        assert self.told(stock, np.where(piece == 3, 99.0, 0.0), piece=piece) != {}
        one_row = np.r_[3, np.full(49, 4)]
        assert self.told(stock, np.where(one_row == 3, 0.0, 99.0), piece=one_row) == {}

    def test_nothing_where_it_may_begin_anywhere_or_is_not_known(self, stock):
        assert self.told(stock, 99.0, parted=True) == {}
        assert self.told(an_open(stock), 99.0) == {}
        assert self.told(stock, (), rows=0) == {}


class TestDepends:
    @pytest.mark.parametrize(
        ("screened", "reduces", "told"),
        [
            ([(1.01 * DEPENDS, "speed")], 0.0, True),
            ([(0.99 * DEPENDS, "speed")], 9.0, False),
            ([(DEPENDS, "speed")], 9.0, False),
            ([(1.01 * DEPENDS, "output_position#3")], 0.0, True),
            ([(1.01 * DEPENDS, "load")], 0.99 * LEAST_SIZE, False),
            ([(1.01 * DEPENDS, "load")], LEAST_SIZE, True),
            ([(0.99 * DEPENDS, "load")], 9.0, False),
            ([(99.0, "load"), (1.01 * DEPENDS, "speed")], 0.0, True),
            ([], 9.0, False),
        ],
    )
    def test_what_follows_the_load_must_be_worth_a_name(self, screened, reduces, told, stock, monkeypatch):
        monkeypatch.setattr(explained_module, "beside_generic_bases", lambda problem, f: problem)
        monkeypatch.setattr(explained_module, "screen_generic_bases", lambda *_: screened)
        monkeypatch.setattr(explained_module, "fit_with_basis", lambda problem, f, name: name)
        monkeypatch.setattr(explained_module, "largest_rms_reduction", lambda problem, f, with_basis: reduces)
        assert depends(a_problem(ROWS), a_fit(a_hypothesis(stock), np.ones(ROWS))) == told


def test_a_current_is_coarse_where_one_that_is_judged_is():
    problem = a_problem(ROWS, ROWS)
    assert not coarse(problem)
    problem.observations[1].coarse = True
    assert coarse(problem)
    problem.observations[1].rows = np.arange(0)
    assert not coarse(problem)


class TestUnexplained:
    def told(self, monkeypatch, stock, raw, *effects, follows=False, before=99.0, rows=(ROWS,), model=None, **options):
        monkeypatch.setattr(explained_module, "depends", lambda *_: follows)
        is_coarse = options.pop("coarse", False)
        problem = a_problem(*rows, noise=0.01, coarse=is_coarse)
        count = sum(rows)
        start = a_fit(a_hypothesis(stock), np.broadcast_to(before, count), **options)
        f = a_fit(a_hypothesis(model or stock, *effects), np.broadcast_to(raw, count), **options)
        return unexplained(problem, f, start)

    @pytest.fixture
    def no_leftover(self, monkeypatch):
        """Let nothing be left of any recording: the mean square decides."""
        monkeypatch.setattr(explained_module, "left_over", lambda problem, f: [0.0] * len(problem.observations))

    @pytest.mark.parametrize(
        ("misfit", "follows", "effects", "told"),
        [
            (1.01 * MISFIT_LEFT, False, (), True),
            (0.99 * MISFIT_LEFT, False, (), False),
            (0.99 * MISFIT_LEFT, True, (), True),
            (1.01 * MISFIT_DOUBTED, True, (), True),
            (0.99 * MISFIT_DOUBTED, True, (), False),
            (0.5, True, ("quadratic_drag",), True),
            (0.5, False, ("quadratic_drag",), False),
        ],
    )
    def test_a_mean_square_that_is_large_or_depends_on_something(
        self, misfit, follows, effects, told, stock, monkeypatch, no_leftover
    ):
        assert self.told(monkeypatch, stock, math.sqrt(misfit), *effects, follows=follows) == told
        assert not self.told(monkeypatch, stock, math.sqrt(misfit), *effects, follows=follows, parted=True)

    def test_a_coarse_current_has_a_shape_of_its_own(self, stock, monkeypatch, no_leftover):
        assert not self.told(monkeypatch, stock, 0.7, "quadratic_drag", follows=True, coarse=True)
        assert self.told(monkeypatch, stock, 1.1, "quadratic_drag", follows=True, coarse=True)

    def test_a_friction_that_bends_leaves_twice_as_much(self, stock, monkeypatch, no_leftover):
        for factor, told in ((0.99, False), (1.01, True)):
            raw = math.sqrt(factor * BRISTLED * MISFIT_LEFT)
            assert self.told(monkeypatch, stock, raw, "presliding_friction", bristle=0.5) == told

    def test_where_no_torque_was_measured_none_is_left(self, stock, monkeypatch):
        assert not self.told(monkeypatch, stock, (), rows=(0,))

    @pytest.fixture
    def left(self, monkeypatch):
        """Let so much torque [N m] be left of each recording, and before."""

        def give(now, before):
            given = {"now": now, "before": before}
            monkeypatch.setattr(
                explained_module, "left_over", lambda problem, f: given["before" if f.raw[0] > 50.0 else "now"]
            )

        return give

    @pytest.mark.parametrize(
        ("left_now", "follows", "told"),
        [(0.99, True, False), (1.01, True, True), (1.01, False, False), (1.99, False, False), (2.01, False, True)],
    )
    def test_of_a_recording_what_is_beyond_the_noise(self, left_now, follows, told, stock, monkeypatch, left):
        left([0.0, left_now * UNEXPLAINED * 0.01], [9.0, 9.0])
        assert self.told(monkeypatch, stock, 0.5, rows=(ROWS, ROWS), follows=follows) == told

    def test_a_friction_that_bends_leaves_twice_as_much_of_it(self, stock, monkeypatch, left):
        for factor, told in ((0.99, False), (1.01, True)):
            left([factor * BRISTLED * UNEXPLAINED * 0.01], [9.0])
            assert self.told(monkeypatch, stock, 0.5, bristle=0.5, follows=True) == told

    @pytest.mark.parametrize("before", [0.0, 1.0])
    def test_behind_play_as_much_as_a_part_of_what_was_left_before(self, before, stock, monkeypatch, left):
        limit = max(SHAKY * UNEXPLAINED * 0.01, PART * before)
        for factor, told in ((0.99, False), (1.01, True)):
            left([factor * limit], [before])
            assert self.told(monkeypatch, stock, 0.5, parted=True) == told

    def test_a_recording_without_rows_leaves_nothing(self, stock, monkeypatch, left):
        left([0.0, 9.0], [9.0, 9.0])
        assert not self.told(monkeypatch, stock, 0.5, rows=(ROWS, 0))
        left([0.0, 9.0, 9.0], [9.0, 9.0, 9.0])
        assert self.told(monkeypatch, stock, 0.5, rows=(ROWS, 0, ROWS))


def test_a_bristle_of_no_stiffness_is_none(stock, monkeypatch):
    monkeypatch.setattr(explained_module, "left_over", lambda problem, f: [0.0])
    f = a_fit(a_hypothesis(stock), np.full(ROWS, math.sqrt(1.01 * MISFIT_LEFT)))
    assert f.predicted.plant["bristle_stiffness"][0] == 0.0
    assert unexplained(a_problem(ROWS), f, f)
