"""The stated rule for samples that are lost, late, repeated or step back."""

from collections.abc import Iterable
from dataclasses import dataclass

import pytest

from ema_twin_sim.live.sample_stream import REORDERED, Kind, SampleStream

PERIOD = 2_000_000


def accept(stream, sequences, run=1, offset=0):
    return [stream.accept(run, n, (n + offset) * PERIOD + 1) for n in sequences]


@dataclass(frozen=True)
class Case:
    """Samples of a run before, those that are judged, and what is counted in all; other counts are 0."""

    before: Iterable[int]
    sequences: Iterable[int]
    kinds: str  # first letter of each
    run: int = 1
    offset: int = 0  # periods by which stamps are later than their numbers say
    late: int = 0
    duplicate: int = 0
    backward: int = 0
    stray: int = 0
    lost: int = 0
    runs: int = 1


@pytest.mark.parametrize(
    "case",
    [
        pytest.param(Case((), [0, 1, 2], "FNN"), id="in order"),
        pytest.param(Case((), [0, 1, 5, 6], "FNNN", lost=3), id="a gap"),
        pytest.param(Case((), [0, 1, 3, 2, 4], "FNNLN", late=1, lost=1), id="late"),
        pytest.param(Case((), [0, 1, 1, 2, 1, 3], "FNLNLN", duplicate=2), id="duplicates"),
        pytest.param(Case(range(5), [0, 1], "FN", run=2, runs=2), id="another run"),
        pytest.param(Case(range(REORDERED + 5), [2, 3, 4], "LFN", backward=1, runs=2), id="a step back"),
        pytest.param(Case(range(4), range(4), "FNNN", backward=1, runs=2), id="a bag that loops, however short"),
        pytest.param(
            Case(range(100), [100, 101], "LF", offset=-50, backward=1, runs=2), id="time back, with growing numbers"
        ),
        # its numbers go on where its clock has moved: the first of them is left out
        pytest.param(Case(range(50), [50, 51, 52], "LNN", offset=10_000, lost=1), id="a bench that pauses"),
        pytest.param(Case(range(50), [1_800_000, 1_800_001], "NN", lost=1_799_950), id="a bench that lost an hour"),
        pytest.param(Case(range(3), [3], "L", offset=-1, duplicate=1), id="time that stands still"),
    ],
)
def test_what_a_sample_is_and_what_is_counted(case):
    stream = SampleStream()
    accept(stream, case.before)
    found = accept(stream, case.sequences, case.run, case.offset)
    assert "".join(kind.name[0] for kind in found) == case.kinds
    counted = ("late", "duplicate", "backward", "stray", "lost", "runs")
    assert {name: getattr(stream, name) for name in counted} == {name: getattr(case, name) for name in counted}
    assert stream.run == case.run


def test_a_run_counts_what_it_received():
    stream = SampleStream()
    accept(stream, range(5))
    assert stream.received == 5
    accept(stream, [0, 1], run=2)
    assert stream.received == 2


def test_samples_before_the_first_were_not_seen_unless_a_late_start_is_meant():
    """They are none that a twin could integrate across: it begins behind them."""
    stream = SampleStream()
    accept(stream, [7, 8])
    assert (stream.unseen, stream.lost) == (7, 0)
    stream = SampleStream(from_start=False)
    accept(stream, [7, 8])
    assert (stream.unseen, stream.lost, stream.first) == (0, 0, 7)


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


def test_strays_in_a_row_are_counted_each():
    stream = SampleStream()
    accept(stream, range(50))
    for sequence, stamp in ((50, 1), (51, 3600 * 10**9), (52, 7)):
        assert stream.accept(1, sequence, stamp) is Kind.LEFT_OUT
    assert accept(stream, [53, 54]) == [Kind.NEXT, Kind.NEXT]
    assert (stream.stray, stream.runs) == (3, 1)
