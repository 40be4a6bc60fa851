"""The stated rule for samples that are lost, late, repeated or step back."""

import pytest

from ema_twin_sim.live.sample_stream import REORDERED, Kind, SampleStream

PERIOD = 2_000_000


def accept(stream, sequences, run=1, offset=0):
    return [stream.accept(run, n, (n + offset) * PERIOD + 1) for n in sequences]


def test_samples_in_order_are_taken():
    stream = SampleStream()
    assert accept(stream, [0, 1, 2]) == [Kind.FIRST, Kind.NEXT, Kind.NEXT]
    assert (stream.received, stream.lost, stream.runs) == (3, 0, 1)


def test_a_gap_is_counted_and_crossed():
    stream = SampleStream()
    assert accept(stream, [0, 1, 5, 6]) == [Kind.FIRST, Kind.NEXT, Kind.NEXT, Kind.NEXT]
    assert stream.lost == 3


def test_samples_before_the_first_were_not_seen_unless_a_late_start_is_meant():
    """They are none that a twin could integrate across: it begins behind them."""
    stream = SampleStream()
    accept(stream, [7, 8])
    assert (stream.unseen, stream.lost) == (7, 0)
    stream = SampleStream(from_start=False)
    accept(stream, [7, 8])
    assert (stream.unseen, stream.lost, stream.first) == (0, 0, 7)


def test_a_late_sample_is_left_out():
    stream = SampleStream()
    assert accept(stream, [0, 1, 3, 2, 4]) == [Kind.FIRST, Kind.NEXT, Kind.NEXT, Kind.LEFT_OUT, Kind.NEXT]
    assert (stream.late, stream.duplicate, stream.backward, stream.lost) == (1, 0, 0, 1)


def test_a_duplicate_is_left_out():
    stream = SampleStream()
    assert accept(stream, [0, 1, 1, 2, 1, 3]) == [
        Kind.FIRST,
        Kind.NEXT,
        Kind.LEFT_OUT,
        Kind.NEXT,
        Kind.LEFT_OUT,
        Kind.NEXT,
    ]
    assert (stream.duplicate, stream.late, stream.lost) == (2, 0, 0)


def test_another_run_starts_again():
    stream = SampleStream()
    accept(stream, range(5))
    assert accept(stream, [0, 1], run=2) == [Kind.FIRST, Kind.NEXT]
    assert (stream.run, stream.received, stream.runs, stream.backward) == (2, 2, 2, 0)


def test_a_step_back_starts_again():
    stream = SampleStream()
    accept(stream, range(REORDERED + 5))
    assert accept(stream, [2, 3, 4]) == [Kind.LEFT_OUT, Kind.FIRST, Kind.NEXT]
    assert (stream.backward, stream.runs, stream.stray) == (1, 2, 0)


def test_a_bag_that_loops_starts_again_however_short():
    stream = SampleStream()
    accept(stream, range(4))
    assert accept(stream, range(4)) == [Kind.FIRST, Kind.NEXT, Kind.NEXT, Kind.NEXT]
    assert stream.backward == 1


def test_time_that_goes_back_under_a_growing_sequence_starts_again():
    stream = SampleStream()
    accept(stream, range(100))
    assert accept(stream, [100, 101], offset=-50) == [Kind.LEFT_OUT, Kind.FIRST]
    assert stream.backward == 1


@pytest.mark.parametrize(
    "sample",
    [
        (50, 1),  # a stamp of nearly nothing
        (50, 3600 * 10**9),  # of an hour later
        (2**40, 50 * PERIOD + 1),  # a number that no run reaches
        (3, 3 * PERIOD + 1),  # one that comes after all
    ],
)
def test_one_sample_with_a_wrong_stamp_or_number_changes_nothing(sample):
    stream = SampleStream()
    accept(stream, range(50))
    sequence, stamp = sample
    assert stream.accept(1, sequence, stamp) is Kind.LEFT_OUT
    assert accept(stream, range(51, 60)) == [Kind.NEXT] * 9
    assert (stream.stray, stream.backward, stream.runs, stream.lost) == (1, 0, 1, 1)


def test_a_bench_that_pauses_goes_on():
    """Its numbers go on where its clock has moved: the first of them is left out."""
    stream = SampleStream()
    accept(stream, range(50))
    assert accept(stream, [50, 51, 52], offset=10_000) == [Kind.LEFT_OUT, Kind.NEXT, Kind.NEXT]
    assert (stream.stray, stream.runs, stream.lost) == (0, 1, 1)


def test_a_bench_that_lost_an_hour_goes_on_at_once():
    stream = SampleStream()
    accept(stream, range(50))
    assert accept(stream, [1_800_000, 1_800_001]) == [Kind.NEXT, Kind.NEXT]


def test_strays_in_a_row_are_counted_each():
    stream = SampleStream()
    accept(stream, range(50))
    for sequence, stamp in ((50, 1), (51, 3600 * 10**9), (52, 7)):
        assert stream.accept(1, sequence, stamp) is Kind.LEFT_OUT
    assert accept(stream, [53, 54]) == [Kind.NEXT, Kind.NEXT]
    assert (stream.stray, stream.runs) == (3, 1)


def test_time_that_stands_still_is_left_out():
    stream = SampleStream()
    accept(stream, range(3))
    assert accept(stream, [3], offset=-1) == [Kind.LEFT_OUT]
