"""How an answer is judged, on answers written by hand."""

from types import SimpleNamespace

import pytest

from .judge import judge

CASE = SimpleNamespace(
    name="", kind="plain", hidden=("gravity_load",), tolerated=(), restless=True, causes=(), parameters={}
)
GROUP = ("constant_load", "gravity_load")


@pytest.mark.parametrize(
    ("added", "groups", "found", "undecided", "wrong"),
    [
        (("gravity_load",), (), True, False, ()),
        (("gravity_load",), (GROUP,), True, False, ()),
        (("constant_load",), (GROUP,), False, True, ()),
        (("constant_load",), (), False, False, ("constant_load",)),
        (("constant_load", "cogging"), (GROUP,), False, False, ("cogging",)),
        ((), (), False, False, ()),
    ],
)
def test_what_shares_a_reported_group_with_what_is_hidden_is_neither_found_nor_wrong(
    added, groups, found, undecided, wrong
):
    answer = {"added": added, "verdict": "unknown", "groups": groups, "effects": {}}
    verdict = judge(CASE, answer, 1.0)
    assert (verdict.found, verdict.undecided, verdict.wrong) == (found, undecided, wrong)
