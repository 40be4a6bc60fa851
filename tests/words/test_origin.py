"""A result tells what it was computed from, and a page takes none of another machine."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from ema_bench_replay.errors import InputError
from ema_twin_sim.report.content import Content, shown
from ema_twin_sim.report.page import page
from ema_twin_sim.words.findings import read_findings
from ema_twin_sim.words.origin import Origin, read_origin, refuse_foreign
from tests.recorded import record
from tests.report.test_report import FOUND, Read

FILE = Path("found.json")
ORIGIN = Origin("A", "motor a", ("run_1", "run_2"))


def test_a_result_of_another_machine_is_refused(stock):
    own = replace(stock, name="A", machine="motor a")
    refuse_foreign("--discovery", FILE, ORIGIN, [own, stock], ["run_1"])
    refuse_foreign("--discovery", FILE, ORIGIN, [replace(own, name="renamed"), stock], ["run_2", "run_3"])
    refuse_foreign("--discovery", FILE, None, [stock], ["run_9"])  # an older file, which does not tell
    told = r"found\.json: is the result for model A of machine motor a, but the models given are polito_bench; give"
    with pytest.raises(InputError, match=told):
        refuse_foreign("--discovery", FILE, ORIGIN, [stock], ["run_1"])


def test_a_result_of_other_recordings_is_refused(stock):
    own = replace(stock, name="A")
    told = r"computed from run_1 and run_2, but the recordings given are run_3; .* leave out --fit"
    with pytest.raises(InputError, match=told):
        refuse_foreign("--fit", FILE, ORIGIN, [own], ["run_3"])
    refuse_foreign("--fit", FILE, ORIGIN, [own], ["run_1 (monday)"])  # told apart from another of that name
    copy = replace(ORIGIN, recordings=("run (1)",))
    refuse_foreign("--fit", FILE, copy, [own], ["run (1)", "run (2)"])
    with pytest.raises(InputError, match=r"computed from run \(1\)"):
        refuse_foreign("--fit", FILE, copy, [own], ["run (2)"])


def test_an_origin_is_read_where_it_is_told():
    told = {"model": "A", "machine": "motor a", "recordings": ["run_1", "run_2"]}
    assert read_origin(told) == ORIGIN
    assert read_origin({"model": "A"}) is None  # what fit wrote before
    with pytest.raises(ValueError, match="no list"):
        read_origin({**told, "recordings": "run_1"})


def test_a_page_tells_which_recordings_the_search_used(tmp_path, stock):
    recordings = record(stock, seconds=3.0)[:1]
    told = {"model": "polito_bench", "machine": "bench", "recordings": [recordings[0].name, "another"]}
    (tmp_path / "found.json").write_text(json.dumps({**FOUND, **told}))
    models = (stock, stock.with_effect("backlash", {"width": 0.004}))
    content = Content(models, ("a", "b"), shown(recordings, models), None, read_findings(tmp_path / "found.json"), "1")
    sentence = f"The search used the recordings {recordings[0].name} and another, and model polito_bench."
    assert sentence in Read(page(content)).text
    (tmp_path / "found.json").write_text(json.dumps({**FOUND, **told, "recordings": [recordings[0].name]}))
    same = replace(content, findings=read_findings(tmp_path / "found.json"))
    assert "The search used" not in Read(page(same)).text
