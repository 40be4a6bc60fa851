"""What an effect must gain to be named: prices, the size that counts, and what is left unexplained."""

from types import SimpleNamespace

import numpy as np
import pytest

from ema_twin_sim.criteria import (
    COST_EFFECT,
    COST_OF_BASIS_COLUMN,
    COST_PARAMETER,
    FAR_OFF_ROW,
    FEWEST_ROWS,
    SHAKY,
)
from ema_twin_sim.discovery.criteria.worth import (
    STRAY_ROWS,
    complexity_penalty,
    largest_rms_reduction,
    left_over,
    noise_per_unit,
    penalised_gain,
    size_where_it_acts,
)
from tests.fits_by_hand import COMPARES, a_problem


def a_fit(raw=(), parted=False, prior=0.0, added=(), free=(), misfits=(0.0, 0.0), inflations=(1.0, 1.0), weights=1.0):
    """What a search compares, without a problem that it was fitted to."""
    raw = np.asarray(raw, float)
    hypothesis = SimpleNamespace(
        added=dict.fromkeys(added), effects=tuple(added), free=[SimpleNamespace(path=path) for path in free]
    )
    return SimpleNamespace(
        raw=raw, weights=np.full(len(raw), weights), parted=parted, prior_cost=prior, hypothesis=hypothesis,
        misfits=np.array(misfits), variance_inflations=np.array(inflations), problem=COMPARES,
    )  # fmt: skip


class TestPrices:
    def test_each_effect_each_number_and_each_column_has_its_price(self):
        free = ["effects.a.torque", "effects.a.angle", "effects.b.width", "basis.load.0", "scale.inertia", "sensors.x"]
        told = complexity_penalty(a_fit(prior=2.5, added=("a", "b"), free=free))
        assert told == pytest.approx(2.5 + 2 * COST_EFFECT + 3 * COST_PARAMETER + COST_OF_BASIS_COLUMN)

    def test_a_gain_is_the_fall_of_the_misfit_less_what_came_at_a_price(self):
        before = a_fit(misfits=(140.0, 60.0), inflations=(2.0, 4.0), prior=9.0)
        after = a_fit(misfits=(100.0, 40.0), inflations=(4.0, 2.0), prior=1.0, added=("a",), free=("effects.a.torque",))
        assert noise_per_unit(before, after) == pytest.approx([2.0, 2.0])
        assert penalised_gain(before, after) == pytest.approx(20.0 + 10.0 + 8.0 - COST_EFFECT - COST_PARAMETER)
        assert penalised_gain(after, before) == pytest.approx(-penalised_gain(before, after))

    def test_beside_an_output_that_bounces_a_difference_counts_for_less(self):
        free, bounces = a_fit(), a_fit(parted=True)
        assert noise_per_unit(bounces, bounces) == pytest.approx([SHAKY, SHAKY])
        assert noise_per_unit(free, bounces) == pytest.approx([1.0, 1.0])


class TestSize:
    def test_the_recording_counts_that_shows_most(self):
        problem = a_problem(50, 50)
        before = a_fit([1.0] * 50 + [2.0] * 50)
        after = a_fit([1.0] * 100, added=("gravity_load",))
        assert largest_rms_reduction(problem, before, after) == pytest.approx(np.sqrt(3.0))

    @pytest.mark.parametrize("share", [1.0, 0.1, 0.01])
    def test_an_action_has_its_size_however_few_rows_it_acts_on(self, share):
        way = np.linspace(-1.0, 1.0, 20_001)
        pull = way / share * np.exp(0.5 - 0.5 * (way / share) ** 2) if share < 1.0 else np.ones(len(way))
        assert 0.4 <= size_where_it_acts(2.0 * pull) / 2.0 <= 1.0

    def test_what_acts_nowhere_has_no_size(self):
        assert size_where_it_acts(np.zeros(50)) == size_where_it_acts(np.zeros(0)) == 0.0

    def test_what_became_worse_is_none(self):
        before, after = a_fit([1.0] * 50), a_fit([2.0] * 50, added=("gravity_load",))
        assert largest_rms_reduction(a_problem(50), before, after) == 0.0

    def test_rows_that_are_weighted_less_show_less(self):
        problem, before = a_problem(50), a_fit([2.0] * 50)
        whole, half = (
            largest_rms_reduction(problem, before, a_fit([0.0] * 50, added=("gravity_load",), weights=weight))
            for weight in (1.0, 0.5)
        )
        assert (whole, half) == (pytest.approx(2.0), pytest.approx(1.0))

    @pytest.mark.parametrize(("rows", "size"), [(FEWEST_ROWS - 1, 0.0), (FEWEST_ROWS, 3.0)])
    def test_a_few_rows_show_nothing(self, rows, size):
        before, after = a_fit([3.0] * rows), a_fit([0.0] * rows, added=("gravity_load",))
        assert largest_rms_reduction(a_problem(rows), before, after) == pytest.approx(size)
        encoders = a_problem(encoder_rows=(rows,))
        assert largest_rms_reduction(encoders, before, after) == pytest.approx(size)

    def test_beside_an_output_that_bounces_a_torque_must_show_in_calm_torque(self):
        calm = np.arange(100) < 60
        raw = np.where(calm, 1.0, 9.0)
        problem = a_problem(100, encoder_rows=(50,), calm=calm)
        before = a_fit([*raw, *[5.0] * 50], parted=True)
        told = {
            effect: largest_rms_reduction(problem, before, a_fit(np.zeros(150), parted=True, added=(effect,)))
            for effect in ("gravity_load", "encoder_delay")
        }
        assert told["gravity_load"] == pytest.approx(1.0)
        assert told["encoder_delay"] == pytest.approx(np.sqrt(np.mean(raw**2)))


class TestLeftOver:
    def test_is_the_torque_beyond_the_noise_of_each_recording(self):
        """Rows at 3 times a noise of 0.01 N m hold 0.01 √(9 − 1) N m more than noise."""
        f = a_fit([3.0] * 100 + [1.0] * 100)
        assert left_over(a_problem(100, 100), f) == [pytest.approx(0.01 * np.sqrt(8.0)), 0.0]

    def test_what_lies_within_the_noise_is_nothing(self):
        assert left_over(a_problem(100), a_fit([0.5] * 100)) == [0.0]

    def test_a_few_stray_rows_and_a_few_rows_are_no_torque(self):
        strays = [1.0] * (100 - STRAY_ROWS) + [25.0] * STRAY_ROWS
        assert left_over(a_problem(100), a_fit(strays)) == [0.0]
        assert left_over(a_problem(100), a_fit([*strays[1:], 25.0]))[0] > 0.01
        assert left_over(a_problem(1000), a_fit([1.0] * 990 + [25.0] * 10)) == [0.0]
        assert left_over(a_problem(FEWEST_ROWS - 1), a_fit([3.0] * (FEWEST_ROWS - 1))) == [0.0]
        assert left_over(a_problem(FEWEST_ROWS), a_fit([3.0] * FEWEST_ROWS))[0] > 0.01

    def test_of_operating_points_half_as_many_tell_as_much(self):
        """They have no neighbours that resemble them."""
        half = FEWEST_ROWS // 2
        assert left_over(a_problem(half, of_points=True), a_fit([3.0] * half))[0] > 0.01
        assert left_over(a_problem(half - 1, of_points=True), a_fit([3.0] * (half - 1))) == [0.0]

    def test_a_row_that_is_far_off_counts_as_no_more_than_that(self):
        sizes = [1.0] * 80 + [1e6] * 20
        kept = 20 - STRAY_ROWS
        mean = (80 + kept * FAR_OFF_ROW**2) / (100 - STRAY_ROWS)
        assert left_over(a_problem(100), a_fit(sizes)) == [pytest.approx(0.01 * np.sqrt(mean - 1.0))]

    def test_what_was_shaken_is_left_out_and_after_an_impact_where_the_output_bounces(self):
        calm = np.arange(100) < 80
        after_impact = (np.arange(100) >= 40) & calm
        raw = np.where(calm, np.where(after_impact, 5.0, 1.0), 20.0)
        problem = a_problem(100, calm=calm, after_impact=after_impact)
        assert left_over(problem, a_fit(raw, parted=True)) == [0.0]
        free = left_over(problem, a_fit(raw))
        mean = (40 * 1.0 + (40 - STRAY_ROWS) * 25.0) / (80 - STRAY_ROWS)
        assert free == [pytest.approx(0.01 * np.sqrt(mean - 1.0))]
