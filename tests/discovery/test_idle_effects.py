"""Effects that a simulation of held-out recordings does not support, on searches and errors made by hand."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from ema_twin_sim.discovery.idle_effects import idle_effects
from ema_twin_sim.discovery.unseen import Unseen
from ema_twin_sim.identification.fit import fit
from tests.problems import fit_of
from tests.recorded import COMMANDS, record

FLOOR = 1.0


def searched(*effects, is_open=True):
    """A search that added these effects, one a round."""
    fits = [
        SimpleNamespace(
            hypothesis=SimpleNamespace(
                base=SimpleNamespace(is_open=is_open),
                added={name: SimpleNamespace(effect=name) for name in effects[:k]},
                generic_bases=(),
            )
        )
        for k in range(len(effects) + 1)
    ]
    turns = [
        SimpleNamespace(before=before, after=after, added=(name,), reason="")
        for before, after, name in zip(fits, fits[1:], effects, strict=False)
    ]
    return SimpleNamespace(fit=fits[-1], taken=turns, rounds=turns)


def seen(*errors):
    """The errors at the start and after each round."""
    return Unseen(
        signal="unexplained_torque", unit="N m", noise_floor=FLOOR, rmse=errors, recordings=(), output=(),
        encoders=False, given=errors[0], given_recordings=(), given_output=None, moving=errors, settled=errors,
        judged_from=errors[0], judged_from_output=None,
    )  # fmt: skip


TWO = ("gravity_load", "cogging")


@pytest.mark.parametrize(("settled", "idle"), [
    ((15.0, 4.0, 2.0), ()),
    ((15.0, 4.0, 3.9), ("cogging",)),  # no more than what it happens to do to the slow motion
    ((15.0, 4.0, 4.0), ("cogging",)),
])  # fmt: skip
def test_what_clearly_explains_motion_is_not_idle_for_what_filters_carry_on_from_standstill(settled, idle):
    unseen = replace(seen(20.0, 5.0, 6.0), settled=settled)
    assert idle_effects(searched(*TWO), unseen) == (idle, False)


@pytest.mark.parametrize(("errors", "idle"), [
    ((20.0, 5.0, 4.0), ()),
    ((20.0, 5.0, 6.0), ("cogging",)),  # its own step removed nothing
    ((20.0, 1.2, 1.21), ()),  # beside the noise, by no more than right models differ
    ((20.0, 1.2, 1.3), ("cogging",)),
])  # fmt: skip
def test_what_adds_to_the_error_is_idle_where_constants_are_open(errors, idle):
    assert idle_effects(searched(*TWO), seen(*errors))[0] == idle
    assert idle_effects(searched(*TWO, is_open=False), seen(*errors)) == ((), False)


def test_what_others_need_is_left_out():
    assert idle_effects(searched(*TWO), seen(20.0, 5.0, 6.0), {frozenset({"cogging"})}) == ((), False)


def test_all_that_came_after_the_smallest_error_is_idle():
    """Each step after it was small, beside the noise; together they are not."""
    found = searched("gravity_load", "cogging", "spring_load", "quadratic_drag")
    idle, _ = idle_effects(found, seen(20.0, 1.2, 1.215, 1.23, 1.245))
    assert idle == ("cogging", "spring_load", "quadratic_drag")


def test_effects_that_need_each_other_are_idle_together():
    """Each makes the others worse by its absence, yet without any of them the error was smaller."""
    found, errors = searched(*TWO), seen(1.0, 1.3, 1.2)
    alone = {frozenset({name}) for name in TWO}
    assert set(idle_effects(found, errors, alone)[0]) == {*TWO}
    assert idle_effects(found, errors, {*alone, frozenset(TWO)}) == ((), False)


def test_backlash_that_removes_little_is_idle_with_known_constants_too():
    for is_open in (True, False):
        assert idle_effects(searched("backlash", is_open=is_open), seen(20.0, 19.0)) == (("backlash",), True)
        assert idle_effects(searched("backlash", is_open=is_open), seen(20.0, 10.0)) == ((), False)


@pytest.mark.parametrize(
    ("each", "stays"),
    [
        ((4.5, 4.5, 4.8), False),  # each by less than half: the shape is another's
        ((4.5, 1.5, 1.5), True),
        ((4.5, 4.8, 1.5), False),
        ((4.5, 1.5), True),  # as many as not
        ((1.1, 1.1, 1.5), True),  # those without an excess tell nothing
        ((4.5, 30.0, 30.0), True),  # nor do those in which the loop hunts
    ],
)
def test_backlash_that_leaves_more_than_it_removes_is_another_cause(each, stays):
    """Play and a shaft that winds up look alike to slow encoders; the loop is shaken by each in its own way."""
    begun = [1.2 if end < 1.4 else 40.0 if end > 20.0 else 6.0 for end in each]
    recordings = tuple((f"run {k}", (before, after)) for k, (before, after) in enumerate(zip(begun, each, strict=True)))
    loop = replace(seen(6.0, 4.8), signal="current", unit="A", recordings=recordings)
    idle = idle_effects(searched("backlash", is_open=False), loop)
    assert idle == (((), False) if stays else (("backlash",), True))
    assert idle_effects(searched("backlash", is_open=False), replace(loop, moving=(6.0, 3.0))) == ((), False)


def test_backlash_is_judged_by_what_was_there_when_it_came():
    """Another effect had made the loop worse before."""
    runs = tuple((f"run {k}", (6.0, 7.5, 5.0)) for k in range(3))
    loop = replace(seen(6.0, 7.5, 5.0), signal="current", unit="A", recordings=runs)
    assert idle_effects(searched("cogging", "backlash", is_open=False), loop) == ((), False)


@pytest.mark.parametrize(("output", "idle"), [((1.0, 0.95), ("encoder_delay",)), ((1.0, 0.2), ())])
def test_an_encoders_error_in_one_recording_shows_in_the_output(output, idle):
    found = searched("encoder_delay", is_open=False)
    found.fit.parted = False
    found.fit.problem = SimpleNamespace(observations=(None,))
    assert idle_effects(found, replace(seen(1.2, 1.2), output=output)) == (idle, False)


@pytest.mark.parametrize(("runs", "delay", "idle"), [
    (COMMANDS, 3e-4, ()),
    (COMMANDS, 0.0, ("encoder_delay",)),  # nothing is late
    (COMMANDS[:1], 3e-4, ("encoder_delay",)),  # no other recording tells it
])  # fmt: skip
def test_an_encoders_error_that_other_recordings_tell_stands(stock, runs, delay, idle):
    bare = fit_of(record(stock.with_effect("encoder_delay", {"delay": delay}), runs), stock)
    late = fit(bare.problem, bare.hypothesis.with_effect("encoder_delay", {}, {"delay": 1e-4}))
    turn = SimpleNamespace(before=bare, after=late, added=("encoder_delay",), reason="")
    found = SimpleNamespace(fit=late, taken=[turn], rounds=[turn])
    assert idle_effects(found, replace(seen(1.2, 1.2), output=(1.0, 0.95))) == (idle, False)


def test_beside_play_an_encoders_error_is_not_judged_by_it():
    found = searched("encoder_delay", is_open=False)
    found.fit.parted = True
    assert idle_effects(found, replace(seen(1.2, 1.2), output=(1.0, 0.95))) == ((), False)
