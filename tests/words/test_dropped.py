"""Effects that a search added and dropped again take one sentence, and no two rows each."""

from types import SimpleNamespace

from ema_twin_sim.words.dropped import less_dropped

UNSURE = "its numbers are too uncertain, or those of no machine"


def step(action, effect, instance="", reason=UNSURE):
    return SimpleNamespace(action=action, effect=effect, instance=instance or effect, reason=reason)


def pairs(*named):
    return [step(action, *name) for name in named for action in ("add", "remove")]


def test_many_are_told_in_one_sentence_by_reason():
    tried = pairs(("cogging",), ("cogging", "cogging_2"), ("cogging", "cogging_3"), ("gravity_load", "", "too small"))
    kept, said = less_dropped([step("add", "backlash"), *tried])
    assert [one.effect for one in kept] == ["backlash"]
    assert said == f"Tried and dropped again: cogging at 3 orders: {UNSURE}; gravity load: too small."


def test_what_came_back_keeps_its_rows():
    back = [*pairs(("backlash",)), step("add", "backlash")]
    kept, said = less_dropped([*back, *pairs(("cogging",), ("gravity_load",), ("mesh_friction",))])
    assert kept == back and "backlash" not in said


def test_few_keep_their_rows():
    tried = pairs(("cogging",), ("gravity_load",))
    assert less_dropped(tried) == (tried, "")
