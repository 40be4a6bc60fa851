"""The views for rerun, read back from their files: the numbers of compare and of the search, with names and units."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
import rerun as rr

from ema_bench_replay.errors import InputError
from ema_twin_sim.quantities import quantity
from ema_twin_sim.report.content import shown
from ema_twin_sim.report.residual_charts import failures
from ema_twin_sim.simulation.compared_signals import noise_floors
from ema_twin_sim.simulation.simulate import simulate
from ema_twin_sim.views import screen
from ema_twin_sim.views.bag_blueprint import save_blueprints
from ema_twin_sim.views.drawn_bars import END, START, THICKEST
from ema_twin_sim.views.recording_views import write_views
from ema_twin_sim.views.rerun_view import RerunView
from ema_twin_sim.views.rms_window import RmsWindow
from ema_twin_sim.views.sheet import linear_axis, log_axis
from tests.command_line import done, refused
from tests.report.test_report import findings, folder, models, recordings  # noqa: F401
from tests.rrd_content import RrdContent

NAMES = ("polito_bench", "better")
CONFIG = Path(__file__).resolve().parents[2] / "config"


@pytest.fixture(scope="module")
def given(recordings, models):  # noqa: F811
    return shown(recordings, models)


@pytest.fixture(scope="module")
def views(tmp_path_factory, given, models, findings):  # noqa: F811
    path = tmp_path_factory.mktemp("views") / "found.rrd"
    tabs = write_views(path, given, models, NAMES, findings)
    assert tabs == ["compare", "where it fails", "why", "after", "gear train"]
    return RrdContent(path)


class TestCompare:
    def test_measured_twin_and_what_is_left(self, views, recordings, models):  # noqa: F811
        for recording in recordings:
            twin = simulate(models[0], recording)
            at = f"/compare/{recording.name}/speed"
            time, measured = views.curve(f"{at}/curves/measured")
            assert time == pytest.approx(recording.time, abs=1e-9)
            assert measured.tolist() == recording.signals["speed"].tolist()
            left = recording.signals["speed"] - twin.signals["speed"]
            assert views.curve(f"{at}/curves/twin\\ polito_bench")[1] == pytest.approx(twin.signals["speed"])
            unit = re.search(r"\[(m?)rad/s]", views.name(f"{at}/residual/noise_above"))
            scale = 1e-3 if unit[1] else 1.0
            assert views.curve(f"{at}/residual/twin\\ polito_bench")[1] * scale == pytest.approx(left, abs=1e-12)

    def test_the_band_is_the_sensors_noise(self, views, given):
        recording = given.comparisons[0].recordings[0]
        for name, signal in recording.signals.items():
            at = f"/compare/{recording.name}/{name}/residual"
            if f"{at}/noise_above" in views.entities:
                (start, end), level = views.curve(f"{at}/noise_above")
                assert (start, end) == (0.0, pytest.approx(recording.duration))
                unit = re.search(r"\[(.+)]", views.name(f"{at}/noise_above"))[1]
                scale = {"m": 1e-3, "µ": 1e-6}.get(unit[0] if unit != signal["unit"] else "", 1.0)
                assert level * scale == pytest.approx(signal["noise_floor"])
                assert views.curve(f"{at}/noise_below")[1] == pytest.approx(-level)

    def test_names_and_units(self, views, recordings):  # noqa: F811
        at = f"/compare/{recordings[0].name}/output_position"
        assert views.name(f"{at}/curves/measured") == "measured [rad]"
        assert views.name(f"{at}/curves/twin\\ better") == "twin: better"
        assert {"output position [rad]: measured and twin", "current [A]: measured and twin"} <= views.view_names
        assert {recording.name for recording in recordings} <= views.view_names
        assert views.application == "ema-twin"


class TestWhereItFails:
    def test_the_lines_are_the_reports(self, views, given, models):  # noqa: F811
        for each in failures(given, models[0], NAMES):
            chart = each.charts[0]
            number, median = next((k, t) for k, t in enumerate(chart.traces) if t["line"]["width"] == 2.5)
            (drawn,) = views.strips(f"/where_it_fails/{each.signal}/speed/{number}\\ polito_bench")
            across = np.array([low for low, _ in drawn])
            assert np.corrcoef(across, median["x"])[0, 1] > 1.0 - 1e-9
            assert np.corrcoef(-drawn[:, 1], median["y"])[0, 1] > 1.0 - 1e-9

    def test_curves_of_backward_motion_are_dotted(self, views):
        at = "/where_it_fails/current/output_position"
        pieces = {of: len(views.strips(of)) for of in views.entities if of.startswith(at) and "ward" in of}
        forward, backward = ([n for of, n in pieces.items() if of.endswith(way)] for way in ("forward", "backward"))
        assert 1 in forward and 1 not in backward  # a curve is one strip, or the many pieces of a dotted one

    def test_titles_fit_a_third_of_a_small_window(self, views):
        """They were cut: a view of a third of 1280 pixels has room for some forty letters beside its buttons."""
        titles = {name for name in views.view_names if " against " in name and "gear" not in name}
        assert {"current against speed", "output position against direction"} <= titles
        assert max(map(len, titles)) < 40 and max(map(len, views.view_names)) < 120

    def test_axes_bear_quantities_and_units(self, views):
        words = views.words("/where_it_fails/current/speed")
        assert "speed of the motor [rad/s]" in words
        assert any(re.fullmatch(r"residual of the current \[m?A]", word) for word in words)
        assert {"polito_bench", "better", "± 2 σ of the sensors' noise"} <= words.keys()
        assert {"forward", "backward", "standstill"} <= views.words("/where_it_fails/current/direction").keys()
        for sheet in ("current/order", "output_position/speed", "output_position/output_position"):
            assert any("[" in word for word in views.words(f"/where_it_fails/{sheet}"))

    def test_orders_have_names_and_amplitudes(self, views, given, models):  # noqa: F811
        told = views.text("/where_it_fails/current/told")
        orders = next(each.orders for each in failures(given, models[0], NAMES) if each.signal == "current")
        assert len(orders.named) >= 10
        for number, (order, name, peaks) in enumerate(orders.named, 1):
            sizes = " → ".join(quantity(peak, "A") for peak in peaks)
            assert f"| {number}: {name} | {order:g} | {sizes} |" in told
        assert "first mesh" in told and "The error of the" in told


class TestWhyAndAfter:
    def test_bars_are_as_long_as_effects_are_probable(self, views, findings):  # noqa: F811
        for entry in findings.ranking:
            name = entry.effect.replace("_", "\\ ")
            words = views.words("/why/ranking")
            (said,) = (word for word in words if word.startswith(f"{100.0 * entry.probability:.0f} %, removes"))
            assert words[said][1] == words[entry.effect.replace("_", " ")][1]  # in one row
            if entry.probability > 0.5:
                (bar,) = views.strips(f"/why/ranking/{name}")
                share = (bar[1, 0] + THICKEST - START) / (END - START)
                assert share == pytest.approx(entry.probability, abs=0.002)

    def test_numbers_have_their_standard_errors(self, views):
        assert {"backlash, width", "4.000 ± 0.020 mrad (0.5 %)"} <= views.words("/why/sizes").keys()
        assert "/why/sizes/backlash\\,\\ width\\,\\ standard\\ error" in views.entities
        assert views.text("/why/verdict").startswith("## polito_bench lacks backlash")

    def test_errors_before_and_after_are_those_of_compare(self, views, given):
        words = views.words("/after/errors")
        for model, comparison in zip(NAMES, given.comparisons, strict=True):
            error = comparison.overall["output_position"]
            times = f"{error['rmse'] / error['noise_floor']:.3g} × noise"
            assert f"{quantity(error['rmse'], 'rad')}, {times}" in words
            assert f"/after/errors/{rr.escape_entity_path_part(f'output position, {model}')}" in views.entities
        assert "output position" in words

    def test_the_error_falls_step_by_step(self, views):
        words = views.words("/after/falling")
        assert {"start", "+ backlash", "RMSE [mA]", "the sensors' noise"} <= words.keys()
        (line,) = views.strips("/after/falling/2\\ all\\ recordings")
        assert line[1, 1] > line[0, 1]  # down, as y is counted from above
        assert {"2.00 mrad", "7.00 µrad"} <= views.words("/after/output").keys()


def test_one_model_alone_has_no_before_and_after(tmp_path, recordings, models):  # noqa: F811
    alone = shown(recordings[:1], models[:1])
    tabs = write_views(tmp_path / "one.rrd", alone, models[:1], NAMES[:1])
    assert tabs == ["compare", "where it fails", "gear train"]
    assert not any(entity.startswith("/after") for entity in RrdContent(tmp_path / "one.rrd").entities)


class TestLive:
    def test_values_are_in_the_units_of_their_names(self, tmp_path, stock):
        floors = noise_floors(stock)
        view = RerunView(tmp_path / "live.rrd", "a run", floors, model=stock)
        time = np.arange(1000) / 500.0
        for rows in np.array_split(np.arange(1000), 7):
            signals = {name: np.full(len(rows), 2.0) for name in ("current", "motor_position", "speed")}
            left = {"current": 10.0 * floors["current"], "unexplained_torque": 0.1}
            view.add(time[rows], signals, signals, {name: np.full(len(rows), value) for name, value in left.items()})
        view.tell(1.0, "something is switched on")
        view.close()
        content = RrdContent(tmp_path / "live.rrd")
        assert content.name("/live/current/residual/twin") == "measured − twin [mA]"
        assert content.curve("/live/current/residual/twin")[1] == pytest.approx(np.full(1000, 1e4 * floors["current"]))
        assert content.curve("/error/current")[1] == pytest.approx(np.full(1000, 20.0))  # ten times the noise
        assert content.curve("/unexplained_torque")[1] == pytest.approx(np.full(1000, 100.0))
        times, above = content.curve("/live/current/residual/noise_above")
        assert (times.min(), times.max()) == (0.0, pytest.approx(time[-1])) and set(above) == {1e3 * floors["current"]}
        assert content.column("/story", "TextLog:text") == [["something is switched on"]]
        assert len(content.column("/gear_train/wheels/sun", "Transform3D:quaternion")) == pytest.approx(50, abs=2)

    def test_the_train_turns_by_the_twin_where_the_motor_is_not_measured(self, tmp_path, stock):
        view = RerunView(tmp_path / "live.rrd", "a run", noise_floors(stock), model=stock)
        time = np.arange(200) / 200.0
        twin = {"motor_position": time, "current": np.ones(200)}
        view.add(time, dict.fromkeys(twin, np.full(200, math.nan)), twin, {})
        view.close()
        turned = RrdContent(tmp_path / "live.rrd").column("/gear_train/wheels/sun", "Transform3D:quaternion")
        assert len(turned) == pytest.approx(25, abs=2)

    def test_the_window_forgets(self):
        random = np.random.default_rng(3)
        time, values = np.cumsum(random.uniform(0.001, 0.02, 900)), random.normal(size=900)
        values[17] = math.nan
        window = RmsWindow(1.0)
        batches = np.array_split(np.arange(900), 40)
        found = np.concatenate([window.mean_squares(time[rows], values[rows]) for rows in batches])
        expected = [np.nanmean(values[(time >= now - 1.0) & (time <= now)] ** 2) for now in time]
        assert found == pytest.approx(expected)
        assert np.isnan(RmsWindow(1.0).mean_squares(time, np.full(900, math.nan))).all()

    def test_the_window_begins_again_after_a_jump_back(self):
        window = RmsWindow(1.0)
        window.mean_squares(np.arange(5.0), np.full(5, 9.0))
        assert window.mean_squares(np.array([0.5]), np.array([2.0])).tolist() == [4.0]


class TestLayouts:
    @pytest.mark.parametrize("name", ["bench.rbl", "live.rbl"])
    def test_files_are_what_the_code_makes(self, tmp_path, name):
        """Where this fails: make blueprints."""
        save_blueprints(tmp_path)
        kept, made = RrdContent(CONFIG / "blueprints" / name), RrdContent(tmp_path / name)
        assert kept.layout == made.layout and kept.application == made.application

    def test_they_name_topics_and_fields_that_exist(self, tmp_path):
        from ema_twin_msgs import msg

        text = "\n".join(RrdContent(CONFIG / "blueprints" / "bench.rbl").layout)
        fields = set(re.findall(r"'\.([a-z_.]+)'", text))
        assert {"current", "speed", "output_position", "residual.current"} <= fields
        for field in fields:
            message = msg.Residual() if field.startswith("residual.") else msg.EmaState()
            for part in field.split("."):
                message = getattr(message, part)


class TestSheet:
    def test_ticks_are_round_and_within(self):
        axis = linear_axis(-3.2, 7.1, "x [m]")
        assert axis.words == ("−2", "0", "2", "4", "6") and axis.share(np.array([-3.2, 7.1])).tolist() == [0.0, 1.0]
        assert linear_axis(0.0, 0.0, "").ticks and log_axis(0.5, 30.0, "").words == ("0.5", "1", "2", "5", "10", "20")
        assert log_axis(1.0, 100.0, "").share(10.0) == pytest.approx(0.5)


class TestCommands:
    @pytest.fixture
    def run(self, ramp):
        return [ramp, "--model", "polito_bench", "--to", "3"]

    def test_compare_writes_and_says_how_to_look(self, run, tmp_path, ramp):
        path = tmp_path / "run.rrd"
        out = done("compare", *run, "--rrd", path).stdout
        assert f"rerun {path}" in out and "compare, where it fails and gear train" in out
        time, _ = RrdContent(path).curve(f"/compare/{ramp.stem}/current/curves/measured")
        assert time[-1] == pytest.approx(3.0, abs=0.01)

    @pytest.mark.slow
    def test_what_exists_is_kept(self, run, tmp_path):
        path = tmp_path / "run.rrd"
        path.write_text("precious")
        for verb in ("compare", "diagnose"):
            refused(verb, *run, "--rrd", path, naming=("run.rrd", "--force"))
        refused("discover", *run, "-o", tmp_path / "new.yaml", "--rrd", path, naming=("run.rrd", "--force"))
        assert path.read_text() == "precious"
        done("compare", *run, "--rrd", path, "--force")
        assert RrdContent(path).entities

    @pytest.mark.slow
    def test_names_that_rerun_would_not_open_are_refused(self, run, tmp_path):
        for verb in ("compare", "diagnose", "live"):
            refused(verb, *run, "--rrd", tmp_path / "run.mcap", naming=("run.mcap", ".rrd"))

    def test_more_than_three_models_are_refused(self, run, tmp_path):
        more = ["--model", "polito_bench"] * 3
        refused("compare", *run, *more, "--rrd", tmp_path / "run.rrd", naming=("--rrd", "4 times"))

    def test_what_stands_in_the_way_of_the_viewer_is_said(self, monkeypatch):
        monkeypatch.setattr(screen, "display_available", lambda: False)
        assert screen.why_not_shown() == "there is no display"
        monkeypatch.setattr(screen, "display_available", lambda: True)
        monkeypatch.setattr(screen, "_GRAPHICS", ())
        assert "graphics driver" in screen.why_not_shown()
        monkeypatch.setattr(screen, "_VIEWER", Path("/nowhere/rerun"))
        assert "not installed" in screen.why_not_shown()


def test_a_file_that_cannot_be_written_is_one_line(tmp_path, stock):
    with pytest.raises(InputError, match="cannot be written"):
        RerunView(tmp_path, "x", noise_floors(stock))


def test_a_comparison_that_was_made_is_not_made_again(given, recordings, models, monkeypatch):  # noqa: F811
    monkeypatch.setattr("ema_twin_sim.report.content.compare_all", None)
    assert shown(recordings, models, comparisons=given.comparisons).comparisons == given.comparisons
