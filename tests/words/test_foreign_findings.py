"""Findings from a file that somebody else may have written: text stays text in the charts, what is wrong is refused."""

import json
import math

import pytest

from ema_bench_replay.errors import InputError
from ema_twin_sim.report.ranking import signature_chart
from ema_twin_sim.report.steps import falling
from ema_twin_sim.words.findings import read_findings
from tests.report.test_report import FOUND

LINK = '<a href="https://example.org">rad & more</a>'
ESCAPED = "&lt;a href"


def evidence(curve="after"):
    numbers = {field: [0.0, 1.0] for field in ("x", "median", "lower", "upper")}
    view = {
        "left_over": "torque", "unit": LINK, "against": LINK, "against_unit": LINK, "order": None,
        "curves": [{"name": curve, "direction": "both", **numbers}],
    }  # fmt: skip
    return {"steps": [{"title": "backlash", "taken": True, "runner_up": "", "views": [view]}]}


@pytest.fixture
def read(tmp_path):
    def read(**changed):
        (tmp_path / "found.json").write_text(json.dumps({**FOUND, **changed}))
        return read_findings(tmp_path / "found.json")

    return read


def test_titles_of_axes_hold_no_tags(read):
    findings = read(evidence=evidence(), unseen={**FOUND["unseen"], "unit": LINK})
    charts = signature_chart(findings.signatures[0]), falling(findings, findings.unseen)
    titles = [chart.layout[axis]["title"]["text"] for chart in charts for axis in ("xaxis", "yaxis")]
    assert not any("<" in title for title in titles) and sum(ESCAPED in title for title in titles) == 3


@pytest.mark.parametrize(
    ("changed", "named"),
    [
        ({"evidence": evidence("afterwards")}, "afterwards"),
        ({"unseen": {**FOUND["unseen"], "rmse": []}}, "unseen.rmse"),
    ],
)
def test_what_could_not_be_drawn_is_refused(read, changed, named):
    with pytest.raises(InputError, match=rf"found\.json: is not what discover --json.*{named}"):
        read(**changed)


def test_an_error_beside_a_noise_of_zero_is_read_as_it_is_written(read):
    assert read(beyond_noise={"motor_torque": None, "speed": 7.0}).beyond_noise == {
        "motor_torque": math.inf,
        "speed": 7.0,
    }
