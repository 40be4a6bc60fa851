"""Of effects that are not sure to be there, which one a search takes out."""

from types import SimpleNamespace

import pytest

from ema_twin_sim.criteria import DEPENDS, SMALL
from ema_twin_sim.discovery.search import removing

MUCH = 100.0 * DEPENDS


def gone(monkeypatch, lost, unsure_without, standing=None):
    """What goes where `first` is uncertain: by what each loses, and what is uncertain still without each.

    ``standing`` tells what stands on which dry friction.
    """
    less_one = {name: SimpleNamespace(without=name) for name in lost}
    fit = SimpleNamespace(hypothesis=SimpleNamespace(added=dict.fromkeys(lost)), without=None)
    found = SimpleNamespace(problem=None, fit=fit, taken=())
    end = SimpleNamespace(problem=None, fit=SimpleNamespace(without="all"), taken=())
    went = []

    def uncertain(problem, f):
        return iter(
            {None: ["first"], "all": []}[f.without] if f.without in (None, "all") else unsure_without[f.without]
        )

    monkeypatch.setattr(removing, "is_play", lambda f, name: False)
    monkeypatch.setattr(removing, "standing_on", lambda h, name: (standing or {}).get(name, ()))
    monkeypatch.setattr(removing, "uncertain", uncertain)
    monkeypatch.setattr(removing, "insignificant", lambda problem, f: next(uncertain(problem, f), None))
    monkeypatch.setattr(removing, "less_each", lambda f, names: [less_one[name] for name in names])
    monkeypatch.setattr(removing, "penalised_gain", lambda before, after: -lost[after.without])
    monkeypatch.setattr(removing, "less", lambda found, names, reason: went.extend(names) or end)
    monkeypatch.setattr(removing, "with_what_made_room", lambda found: found)
    assert removing.significant(found) is end
    return went


@pytest.mark.parametrize(
    ("lost", "unsure_without", "goes"),
    [
        # it explains next to nothing itself
        ({"first": 0.9 * DEPENDS, "other": 0.0}, {"other": [], "first": []}, "first"),
        # another stands in its way, which hardly explains more
        ({"first": MUCH, "other": 0.9 * DEPENDS}, {"other": [], "first": []}, "other"),
        ({"first": MUCH, "other": 0.9 * SMALL * MUCH}, {"other": [], "first": []}, "other"),
        # or explains a good part of it
        ({"first": MUCH, "other": 1.1 * SMALL * MUCH}, {"other": [], "first": []}, "first"),
        # it is no surer without the other, whatever is named before it then
        ({"first": MUCH, "other": 0.0}, {"other": ["third", "first"], "first": []}, "first"),
    ],
)
def test_the_one_without_which_little_is_lost_and_the_other_is_sure(lost, unsure_without, goes, monkeypatch):
    assert gone(monkeypatch, lost, unsure_without) == [goes]


def test_what_stands_on_dry_friction_goes_before_it(monkeypatch):
    lost = {"first": 0.0, "other": MUCH}
    assert gone(monkeypatch, lost, {}, {"first": ("other",)}) == ["other"]


def test_dry_friction_does_not_make_room_for_what_stands_on_it(monkeypatch):
    lost = {"first": MUCH, "dry": 0.0}
    assert gone(monkeypatch, lost, {"dry": [], "first": []}, {"dry": ("first",)}) == ["first"]
