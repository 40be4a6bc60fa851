"""Samples that wait for their partner: kept as objects would be, in memory that is taken once."""

import math
import sys

from hypothesis import given
from hypothesis import strategies as st

from ema_bench_replay.sample import VALUES, State
from ema_twin_sim.live.waiting import Waiting

ROOM = 8


def state(sequence, run=3):
    values = [math.nan if k % 5 == 4 else sequence + k / 7.0 for k in range(len(VALUES))]
    return State(run, sequence, -5 + sequence % 1000 * 2_000_000, dict(zip(VALUES, values, strict=True)))


def same(one, other):
    return repr(one) == repr(other)  # NaN is no other NaN


steps = st.lists(
    st.one_of(
        st.tuples(st.just("keep"), st.integers(0, ROOM - 1)),
        st.tuples(st.just("take"), st.integers(-3, ROOM + 2)),
        st.tuples(st.just("forget_before"), st.integers(-3, ROOM + 2)),
        st.tuples(st.just("clear"), st.just(0)),
    ),
    max_size=60,
)


@given(steps, st.sampled_from([0, 1, 1000, 2**63, 2**64 - 20]))
def test_behaves_as_a_mapping(steps, begun):
    """Whatever is asked, among numbers that the ring has room for, however large they are."""
    ring, held = Waiting(ROOM), {}
    for what, number in steps:
        at = max(begun + number, 0)
        if what == "clear":
            ring.clear()
            held.clear()
        elif what == "keep":
            ring.keep(state(at))
            held[at] = state(at)
        elif what == "take":
            assert same(ring.take(at), held.pop(at, None))
        else:
            ring.forget_before(at)
            held = {number: kept for number, kept in held.items() if number >= at}
        assert len(ring) == len(held)


def test_the_oldest_go_where_there_is_no_room():
    ring = Waiting(ROOM)
    for number in range(3 * ROOM + 2):
        ring.keep(state(number))
    assert len(ring) == ROOM
    assert [number for number in range(4 * ROOM) if ring.take(number)] == [*range(2 * ROOM + 2, 3 * ROOM + 2)]
    assert len(ring) == 0


def test_what_waited_before_a_clearing_is_gone():
    """The number zero too, which a free row holds."""
    ring = Waiting(ROOM)
    assert ring.take(0) is None
    for run in range(3):
        ring.keep(state(0, run))
        ring.clear()
        assert (len(ring), ring.take(0)) == (0, None)


def test_no_more_memory_is_taken():
    ring = Waiting(ROOM)
    before = sys.getsizeof(ring._rows)
    for number in range(100):
        ring.keep(state(number))
    assert sys.getsizeof(ring._rows) == before
