"""The report: what it says, that its numbers are those of compare, and that nothing in a file's name gets out of it."""

import base64
import json
import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from ema_bench_replay.recording import Recording
from ema_twin_sim.comparison.compare import compare
from ema_twin_sim.model import load_model, save_model
from ema_twin_sim.quantities import axis_unit, quantity
from ema_twin_sim.report.backwards import backwards
from ema_twin_sim.report.chart import Charts
from ema_twin_sim.report.content import Content, dates, shown
from ema_twin_sim.report.envelope import envelope_rows
from ema_twin_sim.report.markup import table, tag
from ema_twin_sim.report.page import page
from ema_twin_sim.report.ranking import signature_chart, told_signatures
from ema_twin_sim.words.findings import Signature, read_findings
from ema_twin_sim.words.sentences import removed_words
from ema_twin_sim.words.setpoint_shift import shift_sentence
from tests.command_line import done, refused
from tests.recorded import record, with_signals

LARGEST = 8_000_000  # bytes of a page
NASTY = "</script><img src=x onerror=alert(1)>&\"'"
WIDTH = {"value": 0.004, "std": 0.00002, "unit": "rad"}
FOUND = {
    "verdict": "explained",
    "added": ["backlash"],
    "ranking": [
        {
            "effect": "backlash", "options": {}, "probability": 0.98, "error_removed": 0.999,
            "parameters": {"width": WIDTH}, "found": True,
        },
        {
            "effect": "encoder_delay", "options": {}, "probability": 0.02, "error_removed": 0.1,
            "parameters": {}, "found": False,
        },
    ],
    "none": 0.0,
    "unknown": 0.0,
    "steps": [
        {
            "effect": "backlash", "instance": "backlash", "action": "add", "rmse_before": 0.03, "rmse_after": 0.003,
            "unit": "A", "output_before": 0.002, "output_after": 7e-6, "error_removed": 0.99, "reason": "largest gain",
            "tried": [{"names": ["backlash"], "gain": 100.0}, {"names": ["encoder_delay"], "gain": 12.0}],
        }
    ],
    "parameters": {"backlash": {"effect": "backlash", "options": {}, "width": WIDTH}},
    "constants": {"machine": {"motor_inertia": {"value": 7.8e-4, "std": 1e-6, "unit": "kg m^2", "nominal": 7.7e-4}}},
    "groups": [["backlash", "encoder_delay"]],
    "depends_on": [],
    "next_recording": "ramp:0.01 for 20 s: tells backlash from encoder delay",
    "stopped": "no effect explains more",
    "unseen": {
        "signal": "current", "unit": "A", "noise_floor": 0.003, "rmse": [0.03, 0.003],
        "recordings": [{"name": "run0", "rmse": [0.02, 0.003]}, {"name": "run1", "rmse": [0.04, 0.0031]}],
    },
    "warnings": [],
}  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory, stock):
    """A model with play, a search's findings of it, and short recordings of it."""
    folder = tmp_path_factory.mktemp("report")
    save_model(stock.with_effect("backlash", {"width": 0.004}), folder / "better.yaml")
    (folder / "found.json").write_text(json.dumps(FOUND))
    return folder


@pytest.fixture(scope="module")
def models(folder, stock):
    return stock, load_model(folder / "better.yaml")


@pytest.fixture(scope="module")
def recordings(models):
    return record(models[1], seconds=5.0)


@pytest.fixture(scope="module")
def findings(folder):
    return read_findings(folder / "found.json")


def content_of(models, recordings, findings=None, held_out=None, names=("polito_bench", "better")):
    apart = shown(held_out, models) if held_out else None
    return Content(models, names, shown(recordings, models), apart, findings, "1.2.3")


@pytest.fixture(scope="module")
def written(models, recordings, findings):
    """The page of all of it, one recording held out."""
    return page(content_of(models, recordings[:2], findings, recordings[2:]))


class Read(HTMLParser):
    """The words of a page between its scripts, its sections, links, charts, scripts and what its elements load."""

    def __init__(self, text):
        super().__init__()
        self.words, self.ids, self.links, self.tags, self.loads, self.handlers = [], set(), [], [], [], []
        self.charts = 0
        self._skipped = False
        self.feed(text)

    def handle_starttag(self, name, attributes):
        given = dict(attributes)
        self.tags.append(name)
        self._skipped = name in ("script", "style")
        self.ids.add(given.get("id"))
        self.charts += "data-chart" in given
        self.links += [given["href"]] if "href" in given else []
        self.loads += [given["src"]] if "src" in given else []
        self.handlers += [key for key in given if key.startswith("on")]

    def handle_endtag(self, name):
        self._skipped = self._skipped and name not in ("script", "style")

    def handle_data(self, data):
        if not self._skipped:
            self.words.append(data)

    @property
    def text(self):
        return " ".join(" ".join(self.words).replace("\N{NO-BREAK SPACE}", " ").split())


def charts_of(text):
    return json.loads(re.search(r'<script type="application/json" id="charts">(.*?)</script>', text, re.DOTALL)[1])


def test_the_head_tells_what_was_wrong_how_sure_that_is_and_what_is_left(written):
    text = Read(written).text
    assert "polito_bench lacks backlash (or encoder delay)." in text
    assert "width 4.000 ± 0.020 mrad" in text
    assert "Runner-up to backlash: encoder delay, 12 % of the step's gain." in text
    assert "Probability of each: backlash 98 %" in text
    assert "cannot tell apart: backlash or encoder delay" in text
    assert "no date in the files" in text and "2 recordings, 10.0 s" in text and "ema-twin 1.2.3" in text
    assert "Record ramp:0.01 for 20 s (position of the output: a ramp of 0.01 rad/s). Tells backlash from" in text
    assert "nan" not in text.lower().split() and "None" not in text


def test_the_head_leads_with_the_error_on_recordings_not_used_for_fitting(written, models, recordings, findings):
    head = Read(written).text.split("RMSE, measured minus twin")[0]
    begin = "On recordings not used for fitting, the error (RMSE) of the current is 30.0 mA before, 3.00 mA with the"
    assert head.index(begin) < head.index("On all recordings, with numbers fitted to all of them: from polito_bench")
    assert "Current: 3.00 mA on recordings not used for fitting; with numbers fitted to all recordings" in head
    others = replace(findings, unseen=replace(findings.unseen, recordings=(("x", (1.0,)), ("y", (1.0,)))))
    text = Read(page(content_of(models, recordings[:2], others))).text
    assert "From polito_bench to better, the error (RMSE) of" in text and begin not in text


def test_rivals_of_an_effect_that_was_dropped_again_are_not_told(models, recordings, findings):
    [step] = findings.steps
    other = replace(
        step, effect="cogging", instance="cogging", tried=({"names": ["cogging"], "gain": 9.0}, *step.tried)
    )
    gone = replace(other, action="drop", reason="needless beside backlash")
    text = Read(page(content_of(models, recordings[:1], replace(findings, steps=(other, step, gone))))).text
    assert "Runner-up to backlash" in text and "Runner-up to cogging" not in text


def test_its_errors_are_those_of_compare(written, models, recordings):
    text = Read(written).text
    for part in (recordings[:2], recordings[2:]):
        comparisons = [compare(part, model) for model in models]
        for comparison in comparisons:
            for name in ("current", "output_position", "speed"):
                error = comparison.overall[name]
                assert quantity(error["rmse"], error["unit"]) in text
                assert quantity(error["noise_floor"], error["unit"]) in text
            for recording in comparison.recordings:
                for name in ("current", "output_position"):
                    error = recording.signals[name]
                    assert quantity(error["rmse"], error["unit"]) in text


def test_it_needs_no_network_and_holds_plotly_once(written):
    read = Read(written)
    assert not read.loads and not {"link", "img", "iframe"} & set(read.tags)
    assert all(link.startswith("#") and link[1:] in read.ids for link in read.links) and len(read.links) >= 7
    assert "default-src 'none'" in written and written.count("plotly.js v") == 1
    assert len(written) < LARGEST


def test_every_chart_has_a_place_and_a_unit_on_each_axis(written):
    charts = charts_of(written)
    assert len(charts) == Read(written).charts >= 12
    for chart in charts:
        for each in chart.get("choices", [chart]):
            layout = {**chart["layout"], **each.get("layout", {})}
            titles = [layout[axis]["title"]["text"] for axis in ("xaxis", "yaxis") if "title" in layout.get(axis, {})]
            assert titles and all("[" in title or title in ("direction", "step") for title in titles), titles
            assert each["traces"]


def test_what_captions_call_dotted_is_dotted(written):
    traces = [trace for chart in charts_of(written) for trace in chart.get("traces", ())]
    for way, dash in (("forward", "solid"), ("backward", "dot")):
        curves = [trace["line"] for trace in traces if trace["name"].endswith(way) and trace["line"]["width"] > 0.0]
        assert curves and {style["dash"] for style in curves} == {dash}


def test_curves_are_measured_minus_twin(written, models, recordings):
    charts = charts_of(written)
    linked = [chart for chart in charts if chart["link"] == "time"]
    assert [len(chart["choices"]) for chart in linked] == [3, 3, 3]  # a choice a recording, the one held out too
    curves = linked[0]["choices"][2]["traces"]
    values = [np.frombuffer(base64.b64decode(curve["y"]["bdata"]), "<f4") for curve in curves]
    assert len({len(each) for each in values}) == 1
    rmse = compare(recordings[2:], models[0]).overall["output_position"]["rmse"]
    assert np.sqrt(np.mean((1e-3 * values[3]) ** 2)) == pytest.approx(rmse, rel=0.1)  # drawn in mrad
    assert np.abs(values[4]).max() < 0.1 * np.abs(values[3]).max()


def test_names_from_files_stay_names(folder, models, recordings, findings):
    bench = recordings[0]
    nasty = Recording(NASTY, bench.stamps, bench.signals, warnings=(f"{NASTY}: torn",))
    named = [replace(model, name=NASTY, machine=NASTY, orders={NASTY: 2.25}) for model in models]
    told = {**FOUND, "next_recording": NASTY, "stopped": NASTY, "warnings": [NASTY], "groups": [[NASTY, "backlash"]]}
    (folder / "nasty.json").write_text(json.dumps(told))
    plain = Read(page(content_of(models, recordings[:1], findings)))
    text = page(content_of(tuple(named), [nasty], read_findings(folder / "nasty.json"), names=(NASTY, NASTY)))
    read = Read(text)
    assert set(read.tags) == set(plain.tags) and read.tags.count("script") == 3 and not read.handlers
    assert NASTY in "".join(read.words).replace("\N{NO-BREAK SPACE}", " ")
    traces = [trace for chart in charts_of(text) for each in chart.get("choices", [chart]) for trace in each["traces"]]
    assert traces and not any("<" in trace["name"] for trace in traces)


def test_a_part_that_is_no_markup_is_escaped():
    assert tag("p", NASTY, title=NASTY).count("<") == 2
    assert table((NASTY,), [(NASTY,)]).count("<img") == 0
    assert "<" not in Charts().as_json()


def test_without_findings_it_says_so(models, recordings):
    text = Read(page(content_of(models, recordings[:1]))).text
    assert "polito_bench lacks backlash, which better has." in text and "No search was made" in text
    assert "holds no standard errors" in text and "None was given (--held-out)" in text


def test_nothing_found_is_told_honestly(models, recordings, folder, stock):
    for verdict, said in (
        ("none", "These recordings show nothing missing"),
        ("unknown", "no effect of the catalogue explains; the remaining error depends on time"),
    ):
        told = {
            **FOUND,
            "verdict": verdict,
            "added": [],
            "ranking": [],
            "steps": [],
            "groups": [],
            "depends_on": ["time"],
        }
        (folder / "other.json").write_text(json.dumps({**told, "parameters": {}, "constants": {}}))
        given = content_of((stock, stock), recordings[:1], read_findings(folder / "other.json"))
        assert said in Read(page(given)).text.split("What was wrong")[0]


def test_what_was_refused_is_shown_only_where_something_is_left(findings):
    """A plot of an effect that the search did not add explains nothing where all is explained."""
    curve = {"name": "after", "direction": "both", "x": (0.0,), "median": (1.0,), "lower": (0.0,), "upper": (2.0,)}
    found, refused_last = (
        Signature(name, taken, "", "torque", "N m", "speed", "rad/s", None, (curve,))
        for name, taken in (("backlash", True), ("mesh_friction", False))
    )
    both = replace(findings, signatures=(found, refused_last))
    assert told_signatures(both) == told_signatures(replace(both, verdict="none")) == [found]
    assert told_signatures(replace(both, verdict="unknown")) == [found, refused_last]
    assert "the search did not add it" in signature_chart(refused_last).caption


def test_a_search_that_came_to_another_end_is_told(models, recordings, folder):
    (folder / "other.json").write_text(json.dumps({**FOUND, "added": ["gravity_load"], "groups": []}))
    text = Read(page(content_of(models, recordings[:1], read_findings(folder / "other.json")))).text
    assert "gives a different result from better: polito_bench lacks gravity load." in text


def test_models_in_the_other_order_are_told(models, recordings, findings, folder):
    none = {**FOUND, "verdict": "none", "added": [], "ranking": [], "steps": [], "groups": [], "parameters": {}}
    (folder / "none.json").write_text(json.dumps(none))
    for given in (findings, read_findings(folder / "none.json"), None):
        content = content_of(models[::-1], recordings[:1], given, names=("better", "polito_bench"))
        told = (
            "The second model, polito_bench, lacks backlash, which the first, better, has, and is farther from the "
            "recordings: were the two models given in the wrong order?"
        )
        assert backwards(content) == told
        text = Read(page(content)).text
        assert (
            text.count(told) == 2 and "same effects" not in text and "better lacks backlash" not in text
        )  # title and heading
        assert "polito_bench lacks: backlash : width 4.00 mrad" in text
        assert "Parameters of the effects that only better has" in text
        assert "larger error" in text.split("excess over noise removed")[1][:600] and not re.search(
            r"[-−]\d+\.\d %", text
        )
    assert "What polito_bench lacks: the diagnosis" in Read(page(replace(content, findings=findings))).text
    assert (
        "These recordings show nothing missing in better"
        in Read(page(replace(content, findings=read_findings(folder / "none.json")))).text
    )


def test_only_what_is_so_is_told_of_the_order(models, recordings, stock):
    assert not backwards(content_of(models, recordings[:1]))
    assert not backwards(content_of((stock, stock), recordings[:1]))
    rough = stock.with_effect("backlash", {"width": 0.02})
    farther = backwards(content_of((models[1], rough), recordings[:1]))
    assert farther.startswith("The second model, better, is farther from the recordings than the first, polito_bench")
    other = models[1].with_effect("cogging", {"torque": 1e-6})
    assert backwards(content_of((other, models[1]), recordings[:1])) == (
        "The second model, better, lacks cogging, which the first, polito_bench, has."
    )


@pytest.mark.parametrize(
    ("share", "after", "words"),
    [(None, 2.0, "–"), (0.9987, 0.1, "99.9 %"), (-0.0001, 1.0001, "0.0 %"), (-1916267.3, 1e3, "larger error")],
)
def test_an_error_that_grew_is_told_in_a_word(share, after, words):
    assert removed_words(share, 1.0, after) == words


@pytest.mark.parametrize("lacking", [("speed", "speed_setpoint"), ("output_position",)])
def test_recordings_with_fewer_signals(models, recordings, lacking):
    signals = {name: values for name, values in recordings[0].signals.items() if name not in lacking}
    text = page(content_of(models, [with_signals(recordings[0], signals)]))
    assert Read(text).charts >= 4


def test_recordings_that_tell_nothing(models, recordings):
    bench = recordings[0]
    text = Read(page(content_of(models, [with_signals(bench, {"current": bench.signals["current"]})]))).text
    assert "No signal in these recordings distinguishes the models" in text


@pytest.mark.slow
def test_long_recordings_stay_small(models, recordings):
    long = [record(models[1], ("sine:0.05:0.4",), seconds=20.0)[0]] * 12
    text = page(content_of(models, long))
    assert len(text) < LARGEST


def test_an_envelope_keeps_peaks():
    values = np.sin(np.linspace(0.0, 30.0, 100_003))
    values[51_234], values[77] = 9.0, np.nan
    rows = envelope_rows([values, -values], 1000)
    assert len(rows) <= 1100 and rows[0] == 0 and rows[-1] == len(values) - 1 and 51_234 in rows
    assert np.all(np.diff(rows) > 0) and np.array_equal(envelope_rows([values[:50]], 100), np.arange(50))


def test_dates_of_recordings(recordings):
    made = Recording("made", recordings[0].stamps, recordings[0].signals, start=1_773_480_060_000_000_000)
    assert dates([made]) == "2026-03-14 09:21 UTC"
    assert dates([made, recordings[0]]) == "2026-03-14 09:21 UTC (1 without a date)"


@pytest.mark.parametrize(
    ("first", "said"),
    [("01.03.2026 12:00:00,00{k}", "2026-03-01 12:00"), ("12:00:00,00{k}", "no date in the files")],
)
def test_the_date_of_a_trace_is_that_of_its_time_stamps(tmp_path, first, said):
    rows = (f"{first.format(k=k)};0,1;{0.01 * k:.2f}".replace("0.", "0,") for k in range(9))
    (tmp_path / "a.csv").write_text("\n".join(["Zeit;Strom [A];Winkel [rad]", *rows]))
    (tmp_path / "map.yaml").write_text(
        "version: 1\ntime: {column: Zeit, unit: s}\nsignals:\n"
        "  current: {columns: ['Strom \\[A\\]'], unit: A}\n"
        "  motor_position: {columns: ['Winkel \\[rad\\]'], unit: rad}\n"
    )
    assert dates([load(tmp_path / "a.csv", import_map=tmp_path / "map.yaml")]) == said


def test_axes_take_a_unit_that_reads_well():
    assert axis_unit(0.9, "rad") == (1.0, "rad") and axis_unit(0.02, "A") == (1e-3, "mA")
    assert axis_unit(0.0, "A") == (1.0, "A") and axis_unit(float("nan"), "A") == (1.0, "A")


@pytest.mark.parametrize(
    "content",
    [
        "",
        "[]",
        "{}",
        '{"verdict": "none"}',
        json.dumps({**FOUND, "none": "often"}),
        json.dumps({**FOUND, "steps": [{}]}),
    ],
)
def test_files_that_no_search_wrote_are_refused(tmp_path, content):
    (tmp_path / "found.json").write_text(content)
    with pytest.raises(InputError, match=r"found\.json: is (not JSON|not what discover --json)"):
        read_findings(tmp_path / "found.json")


def test_the_command_writes_it(tmp_path, folder, ramp, traces):
    before_and_after = (
        "--model",
        "polito_bench",
        "--model",
        folder / "better.yaml",
        "--discovery",
        folder / "found.json",
    )
    apart = ("--held-out", next(path for path in traces if path != ramp))
    result = done("report", ramp, *before_and_after, *apart, "-o", tmp_path / "r.html", "--to", 4)
    assert "r.html" in result.stdout and "held out" in (tmp_path / "r.html").read_text()
    assert "other order" not in result.stderr
    backward = ("--model", folder / "better.yaml", *before_and_after[:2], "--discovery", folder / "found.json")
    result = done("report", ramp, *backward, "-o", tmp_path / "b.html", "--to", 4)
    assert re.search("warning: The second model, .* lacks backlash, which .* the wrong order", result.stderr)
    refused("report", ramp, *before_and_after, "-o", tmp_path / "r.html", naming=("r.html", "--force"))
    refused("report", ramp, *before_and_after, "-o", tmp_path / "r.pdf", naming=("r.pdf", ".html"))
    refused("report", ramp, *before_and_after[:2], "-o", tmp_path / "s.html", naming=("two models",))
    refused("report", ramp, *before_and_after, "-o", folder / "found.json", naming=("is an input",))
    other = {**FOUND, "model": "other", "machine": "another", "recordings": [ramp.stem]}
    (tmp_path / "other.json").write_text(json.dumps(other))
    foreign = (*before_and_after[:5], tmp_path / "other.json", "-o", tmp_path / "s.html")
    refused("report", ramp, *foreign, naming=("other.json", "is the result for model other of machine another"))


def test_what_puts_every_number_in_doubt_is_right_below_the_verdict(models, recordings, findings):
    """A current in mA that is read as A: the verdict stays the headline, and the doubt is the first that follows."""
    milliamperes = [with_signals(r, {**r.signals, "current": 1e3 * r.signals["current"]}) for r in recordings[:2]]
    text = page(content_of(models, milliamperes, findings))
    assert re.search("<h1>polito_bench lacks backlash.*?</h1><p class=.warning doubt.>Check this before", text)
    assert "Check this before you trust the page: 2 of 2 recordings, the worst is " in Read(text).text
    assert "as if current were in mA and read as A" in Read(text).text
    assert "Check this before" not in Read(page(content_of(models, recordings[:2], findings))).text


def test_an_error_far_below_the_noise_is_told_as_within_it(models, recordings):
    given = shown(recordings[:1], models)
    quiet = {"rmse": 1e-9, "relative": 1e-9, "noise_floor": 1e-3, "unit": "A", "driven": False}
    before, after = given.comparisons
    given = replace(given, comparisons=(before, replace(after, overall={**after.overall, "current": quiet})))
    text = Read(page(Content(models, ("a", "b"), given, None, None, "1.2.3"))).text
    assert "1.00 nA (within the noise)" in text and "(0.0×)" not in text


def test_a_draft_is_no_measure_of_what_was_gained(models, recordings, findings):
    """Of start values that are orders off, only that is told; the constants refitted are what effects are held to."""
    unseen = replace(findings.unseen, given=175.0, given_recordings=(150.0, 200.0))
    text = Read(page(content_of(models, recordings[:2], replace(findings, unseen=unseen)))).text
    assert "of the current is 30.0 mA with the constants alone refitted, 3.00 mA with the effects found." in text
    assert "alone brings the error of the current to 30.0 mA; its start values are far off" in text
    head, *_ = text.split("Step by step")
    assert "175 A" not in head and "constants refitted of start values 30.0 mA" in text


@pytest.mark.parametrize(("end", "does"), [(0.003, "account for the rest"), (0.031, "do not lower it")])
def test_effects_account_for_the_rest_only_if_they_lower_the_error(models, recordings, findings, end, does):
    """Those that the encoders alone show leave the torque's error where the constants brought it."""
    unseen = replace(findings.unseen, rmse=(0.03, end), given=0.05, given_recordings=(0.04, 0.06))
    text = Read(page(content_of(models, recordings[:2], replace(findings, unseen=unseen)))).text
    assert f"from 50.0 mA to 30.0 mA. The effects found {does}" in text


@pytest.mark.parametrize(("shift", "when"), [(0.2e-3, "earlier"), (-0.2e-3, "later")])
def test_a_shift_between_setpoint_and_motion_is_told_as_what_it_is(stock, shift, when):
    """No effect of the catalogue is a fraction of a sample between setpoint and motion."""
    (run,) = record(stock, commands=("sine:0.3:0.5",), seconds=8.0)
    moved = {
        name: np.interp(run.time + shift, run.time, values) if name.endswith("position") else values
        for name, values in run.signals.items()
    }
    given = shown([with_signals(run, moved)], (stock, stock))
    told = shift_sentence(given.comparisons[1])
    assert f"setpoint 200 µs ({0.2e-3 / run.sample_period:.1f} of a sample) {when} than the twin" in told.replace(
        "0.20 ms", "200 µs"
    )
    assert told in Read(page(Content((stock, stock), ("a", "b"), given, None, None, "1.2.3"))).text
    one = {**moved, "motor_position": run.signals["motor_position"]}
    for signals in (run.signals, one):  # without a shift, and with one of an encoder alone
        assert not shift_sentence(compare([with_signals(run, signals)], stock))


def test_axes_leave_out_a_guess_that_hides_the_rest_and_say_so(models, recordings, written):
    """The twin of start values ran off to kA, so that the plots showed nothing of the found model's error."""
    guess = models[0].with_value("effects.viscous_friction.coefficient", 1.0)
    text = page(content_of((guess, models[1]), recordings[:2], names=("guess", "better")))
    assert "the error of guess goes beyond the axis; double-click shows all" in Read(text).text
    assert "goes beyond the axis" not in Read(written).text
    of_current = [chart["layout"]["yaxis"] for chart in charts_of(text) if "residual of the current" in str(chart)]
    assert of_current and all(max(map(abs, axis["range"])) < 100.0 for axis in of_current)  # mA
    curves = next(chart for chart in charts_of(text) if "current [" in str(chart) and "choices" in chart)
    layout = curves["choices"][0]["layout"]
    assert "[mA]" in layout["yaxis2"]["title"]["text"] and max(layout["yaxis2"]["range"]) < 100.0
