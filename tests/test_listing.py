"""Warnings of many recordings in few lines."""

from ema_twin_sim.listing import by_recording


def test_the_same_of_several_recordings_is_told_once():
    assert by_recording(["a: torn", "b: torn", "c: late"]) == ["a and b: torn", "c: late"]


def test_many_that_differ_only_in_numbers_are_told_by_their_first():
    """The current's size differs from recording to recording; what is wrong is the same."""
    told = [f"day {k}: current reaches 0.0{k} A only" for k in range(15)]
    assert by_recording(["a: late", *told]) == ["a: late", "day 0: current reaches 0.00 A only (and 14 more like it)"]
    assert by_recording([*told, "day 15: current reaches 0.07 A only"])[0].endswith("(and 15 more like it)")
    assert by_recording(told[:5]) == told[:5]
