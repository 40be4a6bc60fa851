"""States that wait for their partner: kept as objects would be, in memory that is taken once."""

import math
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ema_bench_replay.nodes.sample_codec import FIELDS, State
from ema_twin_sim.live.pairing import Pairing
from ema_twin_sim.live.waiting import WaitingObjects
from ema_twin_sim.nodes.waiting_states import WaitingStates

ROOM = 8


def state(sequence, run=3):
    values = [math.nan if k % 5 == 4 else sequence + k / 7.0 for k in range(len(FIELDS))]
    return State(run, sequence, -5 + sequence % 1000 * 2_000_000, dict(zip(FIELDS, values, strict=True)))


def same(one, other):
    return repr(one) == repr(other)  # NaN is no other NaN


steps = st.lists(
    st.one_of(
        st.tuples(st.just("keep"), st.integers(0, ROOM - 1)),
        st.tuples(st.just("take"), st.integers(-3, ROOM + 2)),
        st.tuples(st.just("forget_before"), st.integers(-3, ROOM + 2)),
        st.tuples(st.just("clear"), st.none()),
    ),
    max_size=60,
)


@given(steps, st.sampled_from([0, 1, 1000, 2**63, 2**64 - 20]))
def test_behaves_as_what_keeps_objects(steps, begun):
    """Whatever is asked, among numbers that the ring has room for, however large they are."""
    ring, objects = WaitingStates(ROOM), WaitingObjects(ROOM)
    for what, number in steps:
        if what == "clear":
            ring.clear()
            objects.clear()
            continue
        at = max(begun + number, 0)
        if what == "keep":
            ring.keep(state(at))
            objects.keep(state(at))
        else:
            assert same(getattr(ring, what)(at), getattr(objects, what)(at))
        assert len(ring) == len(objects)


def test_the_oldest_go_where_there_is_no_room():
    ring = WaitingStates(ROOM)
    for number in range(3 * ROOM + 2):
        ring.keep(state(number))
    assert len(ring) == ROOM
    assert [number for number in range(4 * ROOM) if ring.take(number)] == [*range(2 * ROOM + 2, 3 * ROOM + 2)]
    assert len(ring) == 0


def test_a_state_that_comes_twice_waits_once():
    ring = WaitingStates(ROOM)
    ring.keep(state(1))
    ring.keep(state(1))
    assert len(ring) == 1
    assert same(ring.take(1), state(1))
    assert ring.take(1) is None


def test_what_waited_before_a_clearing_is_gone():
    """The number zero too, which a free row holds."""
    ring = WaitingStates(ROOM)
    assert ring.take(0) is None
    for run in range(3):
        ring.keep(state(0, run))
        ring.clear()
        assert (len(ring), ring.take(0)) == (0, None)


def test_no_more_memory_is_taken():
    ring = WaitingStates(ROOM)
    before = sys.getsizeof(ring._rows)
    for number in range(100):
        ring.keep(state(number))
    assert sys.getsizeof(ring._rows) == before


@pytest.mark.parametrize("order", [("bench", "twin"), ("twin", "bench")])
def test_pairs_are_whole(order):
    """Bench and twin of a run, all of the one before any of the other, then another run."""
    pairing = Pairing(lambda: WaitingStates(100))
    for run in (1, 2):
        add = {"bench": pairing.add_bench, "twin": pairing.add_twin}
        for n in range(50):
            add[order[0]](state(n, run))
        if order[0] == "twin":
            add["bench"](state(0, run))
        found = [add[order[1]](state(n, run)) for n in range(order[0] == "twin", 50)]
        expected = [state(n, run) for n in range(order[0] == "twin", 50)]
        assert all(map(same, found, expected))
        assert (pairing.compared, pairing.missing, pairing.waiting) == (50, 0, 0)
