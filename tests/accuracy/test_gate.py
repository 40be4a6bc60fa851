"""The gate: ten cases of both benches, drawn from one seed.

Who changes a rule of the search sees at once that it names other effects; what that is worth, sixty cases tell
(``make accuracy``).
"""

from dataclasses import replace

import pytest

from tests.accuracy.cases import drawn_cases
from tests.accuracy.other_machines import other_machine_cases
from tests.accuracy.tables import totals
from tests.accuracy.work import solve

pytestmark = pytest.mark.slow
SEED = 2026
CASES = [
    *(replace(case, seconds=10.0) for case in drawn_cases(SEED, 8)),
    *(case for case in other_machine_cases(SEED, 4) if case.name in ("000_plain", "003_none")),
]
"""Of one bench, half as long as others: one effect, two, three, none, and what no catalogue holds; of other machines,
none of them kind, one effect and none. More of those: test_known.py.
"""


@pytest.fixture(scope="module")
def verdicts():
    return [solve(case) for case in CASES]


def told(verdicts):
    return "\n".join(verdict.line() for verdict in verdicts)


def test_every_kind_of_case_is_among_them():
    assert {case.kind for case in CASES} == {"plain", "pairs", "triples", "none", "unknown"}
    assert len({effect for case in CASES for effect in case.hidden}) >= 8


@pytest.mark.timeout(900)
def test_none_is_confidently_wrong_and_nothing_breaks(verdicts):
    sums = totals(verdicts)
    assert (sums["wrong"], sums["broken"], sums["false_alarms"]) == (0, 0, 0), told(verdicts)


def test_nine_of_ten_are_named_exactly(verdicts):
    """All ten when this was written."""
    assert totals(verdicts)["found"] >= 9, told(verdicts)


def test_their_numbers_are_right_and_so_are_the_standard_errors(verdicts):
    sums = totals(verdicts[:8])
    assert sums["parameters"] >= 10
    assert sums["median_parameter_error"] < 0.02 and sums["within_three_errors"] >= 0.9, told(verdicts)
