"""Bench and twin samples find each other by run and sequence, whichever comes first."""

import math

from hypothesis import given
from hypothesis import strategies as st

from ema_bench_replay.sample import VALUES, State
from ema_twin_sim.live.pairing import Pairing

PERIOD = 2_000_000


def sample(run, sequence):
    return State(run, sequence, 1 + sequence * PERIOD, dict.fromkeys(VALUES, math.nan))


def bench(pairing, *sequences, run=1):
    return [pair and pair.sequence for pair in (pairing.add_bench(sample(run, n)) for n in sequences)]


def twin(pairing, *sequences, run=1):
    return [pair and pair.sequence for pair in (pairing.add_twin(sample(run, n)) for n in sequences)]


def test_either_may_come_first():
    pairing = Pairing()
    assert bench(pairing, 0, 1) == [None, None]
    assert twin(pairing, 0, 1, 2) == [0, 1, None]
    assert bench(pairing, 2) == [2]
    assert (pairing.compared, pairing.seen, pairing.missing, pairing.waiting) == (3, 3, 0, 0)


@given(st.lists(st.booleans(), min_size=150, max_size=150), st.integers(1, 3))
def test_every_sample_is_compared_in_any_interleaving(order, runs):
    """Each stream is in order; how they mix does not matter, as long as the bench leaves a run when it was answered."""
    pairing = Pairing()
    samples = [(run, n) for run in range(1, runs + 1) for n in range(20)]
    to_bench, to_twin = samples.copy(), samples.copy()
    pairs = []
    for from_bench in [*order, *[True, False] * len(samples)]:
        if from_bench and to_bench and not (to_twin and to_twin[0][0] < to_bench[0][0]):
            run, n = to_bench.pop(0)
            paired = pairing.add_bench(sample(run, n))
        elif not from_bench and to_twin:
            run, n = to_twin.pop(0)
            paired = pairing.add_twin(sample(run, n))
        else:
            continue
        if paired is not None:
            pairs.append((run, n))
    assert pairs == samples
    assert (pairing.compared, pairing.missing, pairing.waiting, pairing.outdated) == (20, 0, 0, 0)


def test_the_twin_may_begin_a_run_before_the_bench_is_seen_to():
    pairing = Pairing()
    bench(pairing, 0, 1)
    twin(pairing, 0, 1)
    assert twin(pairing, 0, 1, run=2) == [None, None]
    assert bench(pairing, 2) == [None]
    assert bench(pairing, 0, 1, 2, run=2) == [0, 1, None]
    assert twin(pairing, 2, run=2) == [2]
    assert (pairing.run, pairing.compared, pairing.missing) == (2, 3, 0)


def test_answers_to_a_run_that_the_bench_left_are_outdated():
    pairing = Pairing()
    bench(pairing, 0, 1, 2)
    twin(pairing, 0)
    bench(pairing, 0, run=2)
    assert twin(pairing, 1, 2) == [None, None]
    assert pairing.outdated == 2
    assert twin(pairing, 0, run=2) == [0]
    assert pairing.compared == 1


def test_a_run_that_was_never_answered_is_passed_over():
    pairing = Pairing()
    bench(pairing, 0, 1, run=1)
    twin(pairing, 0, 1, run=1)
    bench(pairing, 0, run=2)
    bench(pairing, 0, 1, run=3)
    assert twin(pairing, 0, run=3) == [0]
    assert twin(pairing, 1, run=3) == [1]


def test_old_answers_that_arrive_first_do_no_harm():
    """A monitor that joins late is given what the twin said to an earlier replay."""
    pairing = Pairing()
    bench(pairing, 0, run=9)
    twin(pairing, 4000, 4001, run=8)
    assert twin(pairing, 0, run=9) == [0]
    assert bench(pairing, 1, run=9) == [None]
    assert twin(pairing, 1, run=9) == [1]
    assert (pairing.compared, pairing.missing, pairing.outdated) == (2, 0, 2)


def test_a_bag_that_loops_with_one_run_number():
    pairing = Pairing()
    for _ in range(3):
        assert bench(pairing, 0, 1, 2) == [None, None, None]
        assert twin(pairing, 0, 1, 2) == [0, 1, 2]
        assert pairing.compared == 3
    assert pairing.passes == 3


def test_a_bag_that_loops_is_seen_to_by_the_twin_first():
    """All was answered when the twin goes back: it has seen the bench do so, and was not started again."""
    pairing = Pairing()
    bench(pairing, 0, 1, 2)
    twin(pairing, 0, 1, 2)
    for _ in range(3):
        assert twin(pairing, 0, 1, 2) == [None, None, None]
        assert bench(pairing, 0, 1, 2) == [0, 1, 2]
    assert (pairing.compared, pairing.missing, pairing.waiting, pairing.passes) == (3, 0, 0, 4)


def test_nothing_is_missing_before_both_have_begun():
    pairing = Pairing()
    assert (pairing.seen, pairing.missing, pairing.waiting, pairing.passes) == (0, 0, 0, 0)
    bench(pairing, 0, 1)
    assert (pairing.seen, pairing.missing, pairing.waiting, pairing.passes) == (2, 0, 2, 1)


def test_a_twin_that_was_started_again_is_compared_again():
    """It answers the run from its beginning, as samples are kept for who comes late; the bench never goes back."""
    pairing = Pairing()
    bench(pairing, *range(40))
    assert twin(pairing, *range(30)) == list(range(30))
    assert twin(pairing, *range(40)) == [None] * 30 + list(range(30, 40))
    assert bench(pairing, *range(40, 60)) == [None] * 20
    assert twin(pairing, *range(40, 60)) == list(range(40, 60))
    assert (pairing.compared, pairing.missing, pairing.outdated) == (60, 0, 0)


def test_a_twin_that_was_started_again_before_the_bench_was_seen_to_go_on():
    pairing = Pairing()
    bench(pairing, *range(30))
    twin(pairing, *range(30))
    assert twin(pairing, *range(32)) == [None] * 32  # it might have seen the bench go back
    assert bench(pairing, *range(30, 40)) == [30, 31, *[None] * 8]
    assert twin(pairing, *range(32, 40)) == list(range(32, 40))
    assert (pairing.compared, pairing.missing) == (40, 0)


@given(st.integers(1, 40), st.integers(0, 60), st.integers(0, 60), st.booleans())
def test_what_a_twin_that_was_started_again_missed_is_missing_and_nothing_else(answered, begins, bench_at, from_start):
    """Its earlier self answered so many; it begins anywhere, when the bench is anywhere: at no time fewer than none."""
    pairing = Pairing(from_start=from_start)
    sent = max(answered, bench_at)
    bench(pairing, *range(sent))
    twin(pairing, *range(answered))
    for sequence in range(begins, 100):
        bench(pairing, *range(sent, sequence + 1))
        sent = max(sent, sequence + 1)
        twin(pairing, sequence)
        assert 0 <= pairing.missing <= max(0, begins - answered)
    assert (pairing.missing, pairing.waiting) == (max(0, begins - answered),) * 2
    assert pairing.compared + pairing.missing == 100


def test_what_is_missing_on_either_side_is_counted():
    pairing = Pairing()
    bench(pairing, 0, 1, 3, 4)
    twin(pairing, 0, 2, 3, 4)
    assert (pairing.compared, pairing.missing, pairing.seen) == (3, 2, 5)
    assert (pairing.bench.lost, pairing.twin.lost) == (1, 1)


def test_what_has_not_come_yet_is_not_missing():
    pairing = Pairing()
    bench(pairing, *range(100))
    twin(pairing, *range(60))
    assert (pairing.compared, pairing.missing, pairing.waiting) == (60, 0, 40)


def test_duplicates_are_compared_once():
    pairing = Pairing()
    bench(pairing, 0, 1, 1, 2)
    twin(pairing, 0, 1, 1, 2, 2)
    assert (pairing.compared, pairing.missing) == (3, 0)
    assert (pairing.bench.duplicate, pairing.twin.duplicate) == (1, 2)


def test_memory_is_bounded():
    pairing = Pairing(10)
    bench(pairing, *range(1000))
    assert pairing.waiting == 10
    assert twin(pairing, *range(985, 1000)) == [None] * 5 + list(range(990, 1000))
    assert pairing.missing == 990


def test_a_twin_as_far_behind_as_the_middleware_lets_it_be_is_compared_whole():
    """5000 samples wait at the bench for the twin, 500 in the twin, as many at the twin and in the monitor, or more."""
    pairing = Pairing()
    bench(pairing, *range(20_000))
    assert twin(pairing, *range(20_000)) == [*range(20_000)]
    assert (pairing.compared, pairing.missing, pairing.waiting) == (20_000, 0, 0)


def test_a_late_start_counts_from_there():
    pairing = Pairing(from_start=False)
    bench(pairing, 500, 501, 502, 503)
    twin(pairing, 502, 503)
    assert (pairing.compared, pairing.seen, pairing.missing) == (2, 2, 0)
