"""The stated rule for samples that are lost, late, repeated or step back."""

from ema_twin_sim.nodes.sample_stream import REORDERED, Kind, SampleStream

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


def test_samples_before_the_first_are_lost_unless_a_late_start_is_meant():
    stream = SampleStream()
    accept(stream, [7])
    assert stream.lost == 7
    stream = SampleStream(from_start=False)
    accept(stream, [7])
    assert (stream.lost, stream.first) == (0, 7)


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
    assert accept(stream, [2, 3]) == [Kind.FIRST, Kind.NEXT]
    assert (stream.backward, stream.runs) == (1, 2)


def test_a_bag_that_loops_starts_again_however_short():
    stream = SampleStream()
    accept(stream, range(4))
    assert accept(stream, range(4)) == [Kind.FIRST, Kind.NEXT, Kind.NEXT, Kind.NEXT]
    assert stream.backward == 1


def test_time_that_goes_back_under_a_growing_sequence_starts_again():
    stream = SampleStream()
    accept(stream, range(100))
    assert accept(stream, [100], offset=-50) == [Kind.FIRST]
    assert stream.backward == 1


def test_time_that_stands_still_is_left_out():
    stream = SampleStream()
    accept(stream, range(3))
    assert accept(stream, [3], offset=-1) == [Kind.LEFT_OUT]
