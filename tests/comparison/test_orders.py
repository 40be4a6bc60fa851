"""The order of a residual: found with its amplitude, phase and kind."""

import itertools

import numpy as np
import pytest

from ema_twin_sim.comparison.orders import amplitude_spectrum, find_order
from ema_twin_sim.comparison.where import Stretch, find_dependences
from ema_twin_sim.measured import order_spectrum

TIME = np.arange(10_000) * 2e-3


def part(angle, wave, noise=0.003, seed=0):
    direction = np.sign(np.gradient(angle))
    return wave(angle, direction) + np.random.default_rng(seed).normal(0.0, noise, len(angle)), angle, direction


@pytest.mark.parametrize("order", [0.25, 1.0, 4.0, 15.75, 24.0])
def test_a_wave_is_found_with_order_amplitude_and_phase(order):
    found = find_order([part(6.2 * TIME + 1.0, lambda a, d: 0.01 * np.sin(order * a + 0.7))])
    assert found.order == pytest.approx(order, abs=0.03)
    assert found.amplitude == pytest.approx(0.01, rel=0.05)
    assert found.phase == pytest.approx(0.7, abs=0.7 if order > 10 else 0.2)
    assert found.share > 0.7


def back_and_forth():
    return np.concatenate([12.0 * TIME[:5000], 12.0 * (TIME[5000] - TIME[:5000])])


@pytest.mark.parametrize("dissipative", [True, False])
def test_reversals_tell_dissipative_from_conservative(dissipative):
    def wave(angle, direction):
        return 0.01 * np.sin(angle) * (direction if dissipative else 1.0)

    assert find_order([part(back_and_forth(), wave)]).dissipative is dissipative


def test_one_direction_does_not():
    found = find_order([part(6.2 * TIME, lambda a, d: 0.01 * np.sin(a))])
    assert found.dissipative is None


def test_noise_has_no_order_worth_naming():
    assert find_order([part(6.2 * TIME, lambda a, d: 0.0 * a)]).share < 0.01


def test_too_little_motion_has_none():
    assert find_order([]) is None
    assert find_order([part(1e-3 * TIME, lambda a, d: 0.01 * np.sin(a))]) is None


def test_turns_from_sample_to_sample_tell_no_order():
    """Whatever wave is there, its samples are those of any other; and a transform over so many turns takes long."""
    fast = part(17.0 * 2.0 * np.pi * np.arange(len(TIME)), lambda a, d: 0.01 * np.sin(0.3 * a))
    assert find_order([fast]) is None and amplitude_spectrum([fast[:2]]) is None
    slow = part(6.2 * TIME, lambda a, d: 0.01 * np.sin(a))
    assert find_order([fast, slow]).order == pytest.approx(1.0, abs=0.03)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("order", "turns"), [*itertools.product([0.74, 15.75, 15.7532, 93.411], [20, 300, 1000]), (15.7532, 5000)]
)
def test_a_line_is_found_however_narrow_many_turns_make_it(turns, order):
    """One over the turns wide: far narrower than the cells of the spectrum."""
    # at no steady speed, where so few samples a turn would show other orders in the place of one
    angle = 2.0 * np.pi * turns * np.sort(np.random.default_rng(1).uniform(0.0, 1.0, 200_000))
    found = find_order([part(angle, lambda a, d: 0.01 * np.sin(order * a + 0.7), noise=0.005)])
    assert found.order == pytest.approx(order, abs=0.25 / turns)
    assert found.amplitude == pytest.approx(0.01, rel=0.05)
    assert found.share == pytest.approx(2.0 / 3.0, abs=0.05)
    assert found.spectrum.max() == pytest.approx(0.01, rel=0.1)


def test_what_turns_too_far_for_one_transform_counts_by_its_pieces(monkeypatch):
    monkeypatch.setattr(order_spectrum, "_LARGEST", 512 * 300)  # turns 300 times at most
    angle = 2.0 * np.pi * 1000.0 * np.linspace(0.0, 1.0, 200_000)
    found = find_order([part(angle, lambda a, d: 0.01 * np.sin(15.7532 * a + 0.7), noise=0.005)])
    assert found.order == pytest.approx(15.7532, abs=2.5e-4)
    assert found.amplitude == pytest.approx(0.01, rel=0.05)
    assert found.spectrum.max() == pytest.approx(0.01, rel=0.1)


def test_a_wave_in_recordings_far_apart_is_one():
    """The second starts where the counter is after many turns more; the order must be as exact as that takes."""
    angle = 6.2 * TIME
    parts = [part(start + angle, lambda a, d: 0.01 * np.sin(15.7532 * a + 0.7)) for start in (0.0, 2000.0)]
    found = find_order(parts)
    assert found.order == pytest.approx(15.7532, abs=1e-3)
    assert found.amplitude == pytest.approx(0.01, rel=0.05)


@pytest.mark.parametrize(("order", "turns"), [(7.42857142857, 40), (15.7532, 400)])
def test_the_standard_error_of_an_order_is_true(order, turns):
    """Far better than a line is wide, where a wave is as large as its noise: the grid of a search is no limit."""
    off = []
    for seed in range(8):
        angle = 2.0 * np.pi * turns * np.sort(np.random.default_rng(seed).uniform(0.0, 1.0, 20_000))
        found = find_order([part(angle, lambda a, d: 0.01 * np.sin(order * a + 0.7), noise=0.005, seed=seed)])
        assert found.order_std < 0.01 / turns
        off.append((found.order - order) / found.order_std)
    assert 0.4 < np.sqrt(np.mean(np.square(off))) < 2.0


def test_a_spectrum_alone_is_that_of_the_strongest_order():
    parts = [part(back_and_forth(), lambda a, d: 0.01 * np.sin(6.0 * a))]
    found = find_order(parts)
    assert not found.dissipative
    assert np.array_equal(amplitude_spectrum([of[:2] for of in parts]), found.spectrum)
    assert amplitude_spectrum([part(1e-3 * TIME, lambda a, d: 0.01 * np.sin(a))[:2]]) is None


def steady(turns_per_sample, wave, noise=0.01, samples=20_000):
    """A shaft that turns steadily, but for a little, as under speed control."""
    angle = 2.0 * np.pi * turns_per_sample * (np.arange(samples) + 0.3 * np.sin(0.002 * np.arange(samples)))
    return part(angle, wave, noise)


def test_no_order_is_named_that_the_samples_do_not_show():
    """At 18.6 samples a turn, a constant looks like the orders 18.6, 37.2 …; the highest shown is 9.3."""
    turns = 1.0 / 18.6
    constant = [steady(turns, lambda a, d: np.full(len(a), 1.4))]
    assert find_order(constant, resolved=True).order < 9.3
    found = find_order([steady(turns, lambda a, d: 1.4 + 0.2 * np.sin(4.0 * a))], resolved=True)
    assert found.order == pytest.approx(4.0, abs=0.01) and found.amplitude == pytest.approx(0.2, rel=0.05)
    assert not found.spectrum[found.spectrum.size // 10 :].any()  # orders from 16 on


def test_each_recording_shows_the_orders_that_its_own_samples_do():
    """A slow recording shows order 24; a fast one of the same machine, which cannot, does not hide it."""

    def wave(angle, direction):
        return 0.2 * np.sin(24.0 * angle + 0.5)

    fast, slow = steady(1.0 / 18.6, lambda a, d: np.full(len(a), 1.4)), steady(1.0 / 150.0, wave)
    found = find_order([fast, slow], resolved=True)
    assert found.order == pytest.approx(24.0, abs=0.01)
    assert found.amplitude == pytest.approx(0.2, rel=0.05) and found.share > 0.9
    assert found.spectrum.max() == pytest.approx(0.2, rel=0.1)


def test_where_the_error_is_a_constant_no_order_is_named_in_its_place():
    angle = 2.0 * np.pi / 18.587 * np.arange(20_000)
    residual, _, direction = part(angle, lambda a, d: 1.4 + 0.1 * np.sin(0.01 * a), noise=0.05)
    stretch = Stretch(residual, 340.0 * direction, angle, angle / 12.0, 1e-3 * np.arange(len(angle)))
    found = {dependence.variable: dependence for dependence in find_dependences("current", "A", [stretch])}
    assert found["constant"].share > 0.99
    assert found["order"].lower < 9.3 and found["order"].share < 0.01
