"""The results of a campaign: written by many, read whole, told by unit and over time."""

import errno
import os
import subprocess
import sys
import threading
from datetime import datetime, timezone
from functools import partial

import numpy as np
import pyarrow.parquet as pq
import pytest

from ema_bench_replay.errors import InputError
from ema_twin_sim.campaign.copies import copies_across
from ema_twin_sim.campaign.healthy import BY_DEFAULT, Healthy
from ema_twin_sim.campaign.histories import outlooks, read_limits, stands_still
from ema_twin_sim.campaign.results import DONE, FAILED, REFUSED, SCHEMA
from ema_twin_sim.campaign.store import Store, writer_host
from ema_twin_sim.campaign.units import units_of
from ema_twin_sim.words.units import moving_words
from tests.command_line import done
from tests.stored_rows import complete, weekly


def a_row(unit="A", name="a", key="1", status=DONE, done=0, **others):
    row = {"unit": unit, "name": name, "key": key, "status": status, "task": "compare", "model": "m"}
    return complete([{**row, "done_at": datetime.fromtimestamp(done, timezone.utc), **others}])[0]


class TestStore:
    def test_two_campaigns_at_once_lose_nothing(self, tmp_path):
        stores = [Store.made(tmp_path / "r"), Store.made(tmp_path / "r")]

        def write(which):
            for k in range(20):
                stores[which].write([a_row(key=f"{which} {k}", name=f"{which} {k}")])
                if k % 5 == 0:
                    stores[which].merge_files()

        threads = [threading.Thread(target=write, args=(which,)) for which in (0, 1)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        stores[0].merge_files()
        assert len(stores[0].rows()) == 40
        assert len(stores[0].settled()) == 40

    def test_a_job_that_was_done_twice_counts_once(self, tmp_path):
        store = Store.made(tmp_path / "r")
        store.write([a_row(verdict="none", done=1)])
        store.write([a_row(verdict="unknown", done=2)])
        assert [row["verdict"] for row in store.rows()] == ["unknown"]

    def test_a_try_that_was_done_counts_before_a_later_one_that_failed_merged_or_not(self, tmp_path):
        """Two campaigns overlap: the second fails in a recording that the first has judged."""
        store = Store.made(tmp_path / "r")
        store.write([a_row(key="1", name=name, verdict="none", done=1) for name in "ab"])
        store.write([a_row(key="1", name="a", verdict="none", done=2), a_row(key="1", name="b", status=FAILED, done=2)])
        store.write([a_row(key="2", name="c", status=REFUSED, done=1)])
        store.write([a_row(key="2", name="c", status=FAILED, done=2)])
        store.write([a_row(key="3", name="d", verdict="unknown", done=1)])
        store.write([a_row(key="4", name="d", verdict="none", done=2)])  # the same recording, changed
        store.write([a_row(key="3", name="d", status=FAILED, done=3)])
        store.write([a_row(key="5", name="e", done=1)])

        def told():
            return [(row["name"], row["status"], row["done_at"].timestamp(), row["verdict"]) for row in store.rows()]

        before = told()
        assert before == [
            ("a", DONE, 1.0, "none"),
            ("b", DONE, 1.0, "none"),
            ("c", FAILED, 2.0, None),
            ("d", DONE, 2.0, "none"),
            ("e", DONE, 1.0, None),
        ]
        store.merge_files()
        assert len([*tmp_path.rglob("*.parquet")]) == 1 and told() == before

    def test_what_failed_is_to_be_done_again(self, tmp_path):
        store = Store.made(tmp_path / "r")
        store.write([a_row(key="1"), a_row(key="2", status=REFUSED), a_row(key="3", status=FAILED)])
        assert store.settled() == {"1", "2"}

    def test_what_a_killed_writer_had_begun_goes_and_what_a_living_one_writes_stays(self, tmp_path):
        store = Store.made(tmp_path / "r")
        store.write([a_row()])
        (file,) = tmp_path.rglob("*.parquet")
        ended = subprocess.Popen([sys.executable, "-c", ""])
        ended.wait()
        parts = [file.parent / f".x.{writer_host()}.{process}.part" for process in (ended.pid, os.getpid())]
        parts.append(file.parent / f".x.elsewhere.{ended.pid}.part")
        for part in parts:
            part.touch()
        store.merge_files()
        assert [part.exists() for part in parts] == [False, True, True]

    def test_units_are_told_as_they_are_written(self, tmp_path):
        store = Store.made(tmp_path / "r")
        names = ["007", "7", "a/b", "..", "Prüfstand 1", "x'y%z"]
        store.write([a_row(unit=name) for name in names])
        assert [row["unit"] for row in store.rows()] == sorted(names)
        assert all(file.parent.parent.parent == tmp_path / "r" for file in tmp_path.rglob("*.parquet"))

    def test_other_versions_and_other_folders_are_refused(self, tmp_path):
        (tmp_path / "photos").mkdir()
        (tmp_path / "photos" / "cat.jpg").touch()
        with pytest.raises(InputError, match="other files than results"):
            Store.made(tmp_path / "photos")
        with pytest.raises(InputError, match="holds no results"):
            Store.opened(tmp_path / "photos")
        store = Store.made(tmp_path / "r")
        store.write([a_row()])
        (file,) = tmp_path.rglob("*.parquet")
        pq.write_table(pq.read_table(file).replace_schema_metadata({"ema_twin.schema": "0"}), file)
        with pytest.raises(InputError, match="version 0"):
            Store.opened(tmp_path / "r")

    def test_a_full_disk_is_told_in_one_line_and_leaves_nothing_half_written(self, tmp_path, monkeypatch):
        store = Store.made(tmp_path / "r")

        def full(_):
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

        monkeypatch.setattr(os, "fsync", full)
        with pytest.raises(
            InputError, match=r"results cannot be written \(No space left on device\); make room"
        ) as told:
            store.write([a_row()])
        assert "\n" not in str(told.value) and not [file for file in tmp_path.rglob("*") if file.is_file()]

    def test_a_damaged_file_is_named(self, tmp_path):
        store = Store.made(tmp_path / "r")
        store.write([a_row(), a_row(unit="B", key="2")])
        file = min(tmp_path.rglob("*.parquet"))
        file.write_bytes(b"torn")
        for read in (store.rows, store.settled):
            with pytest.raises(InputError, match=f"{file}: cannot be read") as told:
                read()
            assert "\n" not in str(told.value)

    def test_a_store_without_results_has_no_rows(self, tmp_path):
        store = Store.made(tmp_path / "r")
        assert store.rows() == [] and store.settled() == set()

    def test_others_read_it(self, tmp_path):
        store = Store.made(tmp_path / "r")
        store.write([a_row(missing=["backlash"], parameters=[{"owner": "b", "name": "width", "value": 1.0}])])
        table = pq.read_table(tmp_path / "r" / "results")
        assert table.schema.remove_metadata() == SCHEMA.remove_metadata()
        assert table["missing"].to_pylist() == [["backlash"]]


class TestUnits:
    def test_what_does_not_go_together_is_named(self):
        of = {"motion": "rotary", "signals": ["current"], "content": ["x"], "errors": []}
        others = {"time": None, "duration": 1.0, "missing": [], "verdict": None}
        rows = [a_row(**of, **others), a_row(name="b", **{**of, "motion": "linear", "signals": ["speed"]}, **others)]
        (unit,) = units_of(rows)
        told = "\n".join(unit.remarks)
        for part in ("linear and rotary machines", "have different signals", "b is a copy of a", "one recording"):
            assert part in told

    def test_a_recording_that_stands_under_several_units_is_named_once(self):
        def units(*places):
            return units_of([a_row(unit, name, key=f"{unit} {name}", content=[of]) for unit, name, of in places])

        assert copies_across(units(("A", "a", "1"), ("A", "copy", "1"), ("B", "b", "2"))) == []
        (told,) = copies_across(units(("A", "a", "1"), ("B", "b", "1")))
        assert told.startswith("a recording stands under A (a) and B (b) with the same samples")
        assert copies_across(units(("A", "a", "1"), ("B", "b", "1"), ("C", "c", "2")), "C") == []
        (told,) = copies_across(units(*((unit, name, name) for unit in "ABCDEFG" for name in "123")))
        assert told.startswith("3 recordings of 7 units stand under several units with the same samples, the first ")
        assert "under A (1), B (1), C (1), D (1) and 3 more" in told

    def test_clocks_that_disagree_are_named(self):
        of = {"motion": "rotary", "signals": [], "errors": [], "duration": 10.0}
        at = partial(datetime.fromtimestamp, tz=timezone.utc)
        rows = [
            a_row(name=name, time=at(second), content=[name], **of) for name, second in (("a", 0), ("b", 20), ("c", 25))
        ]
        (unit,) = units_of(rows)
        assert unit.remarks == ("c begins before b ends: one of their clocks is wrong",)

    def test_the_worst_in_its_last_recording_comes_first(self):
        rows = [
            a_row(unit=unit, errors=[], beyond_noise=[{"signal": "current", "times": times}])
            for unit, times in (("A", 2.0), ("B", 7.0))
        ]
        assert [(unit.name, unit.beyond_noise) for unit in units_of(rows)] == [("B", 7.0), ("A", 2.0)]

    def test_whose_error_a_unit_is_shown_with_is_said(self, tmp_path):
        store = Store.made(tmp_path / "r")
        store.write([a_row(name=f"{k}", key=f"{k}", errors=[], beyond_noise=[{"signal": "current", "times": times}])
                     for k, times in enumerate((9.0, 2.0))])  # fmt: skip
        told = done("units", tmp_path / "r").stdout
        assert (
            "error left / noise" in told
            and "once the missing effects are added" in told
            and "the last recording that was judged" in told
        )
        assert "2.0 ×" in told and "9.0 ×" not in told


class TestHistories:
    @staticmethod
    def a_unit(values, std=1.0, **others):
        return units_of(weekly(values, std, **others))[0]

    def test_a_number_that_stays_has_no_change_and_no_trend(self):
        values = 100.0 + np.random.default_rng(3).normal(size=30)
        (look,) = outlooks(self.a_unit(values), {"backlash.width": 120.0})
        assert (look.change, look.trend, look.life) == (None, None, None)
        assert look.margin.share == pytest.approx(1.0, abs=0.05)

    def test_wear_is_told_with_its_begin_and_when_it_reaches_its_limit(self):
        wear = np.maximum(0.0, np.arange(40) - 20.0)  # one a week from week 20 on
        values = 100.0 + wear + np.random.default_rng(4).normal(size=40)
        (look,) = outlooks(self.a_unit(values), {"backlash.width": 130.0}, healthy=Healthy(15))
        assert 19 <= look.change.begin <= 26
        assert look.trend.slope * 7.0 == pytest.approx(1.0, rel=0.15)  # days
        assert look.life.earliest < 11 * 7.0 < look.life.latest  # 19 of 30 are gone

    def test_healthy_ones_by_a_pattern_count_wherever_they_are(self):
        """Recordings of a spare that stood in for some weeks are no baseline, and those after it are one again."""
        values = 100.0 + np.random.default_rng(7).normal(size=40)
        values[4:12] += 30.0
        healthy = Healthy.of("week ([0-3]|1[2-9]|2.|3.)$", 4)
        (look,) = outlooks(self.a_unit(values), {}, healthy=healthy)
        assert look.healthy == pytest.approx(100.0, abs=0.6) and look.history.healthy.sum() == 32
        assert (look.history.names[look.change.begin], look.history.names[look.change.alarm]) == ("week 4", "week 4")
        assert look.change.size == pytest.approx(30.0, abs=2.0) and look.history.as_asked

    def test_what_was_repaired_before_is_no_change(self):
        values = 100.0 + np.random.default_rng(3).normal(size=20)
        values[:8] += 30.0
        (look,) = outlooks(self.a_unit(values), {}, healthy=Healthy.of("week (1[4-9])$", 4))
        assert look.change is None and look.healthy == pytest.approx(100.0, abs=0.6)

    def test_too_few_healthy_ones_by_a_pattern_are_told(self):
        (look,) = outlooks(self.a_unit(100.0 + np.arange(30.0)), {}, healthy=Healthy.of("week 29", 4))
        assert not look.history.as_asked and look.history.healthy.tolist() == [True] * 10 + [False] * 20

    def test_a_day_is_healthy_where_all_its_results_are(self):
        unit = self.a_unit(100.0 + np.random.default_rng(8).normal(size=40))
        rows = [{**row, "time": datetime.fromtimestamp((k // 2) * 7 * 86400.0 + 60.0 * (k % 2), timezone.utc)}
                for k, row in enumerate(unit.rows)]  # fmt: skip
        (look,) = outlooks(units_of(rows)[0], {}, healthy=Healthy(11))
        assert look.history.healthy.tolist() == [True] * 5 + [False] * 15

    def test_what_all_recordings_share_hides_no_change(self):
        """A constant that is known to 10 % makes every value as uncertain, and no week unlike another."""
        values = 100.0 + np.random.default_rng(5).normal(size=40)
        values[25:] += 8.0
        (look,) = outlooks(self.a_unit(values, std=10.0), {}, healthy=Healthy(20))
        assert look.change.begin == 25
        assert look.share == pytest.approx(0.08, abs=0.02)

    def test_what_all_recordings_share_delays_no_change(self):
        """A torque constant beside an inertia that is known to 3 %: each test repeats it to 0.3 %."""
        values = 100.0 + np.random.default_rng(9).normal(size=24)
        values[15:] += 10.0
        (look,) = outlooks(self.a_unit(values, std=10.0), {}, healthy=Healthy(12))
        assert (look.change.begin, look.change.alarm) == (15, 15)

    def test_what_is_negligible_beside_its_kind_is_no_change_unless_it_has_a_limit(self):
        """Two dry frictions: 30 mN m at the motor, and one at the output that leaves its bound for 14 µN m."""
        drawn = np.random.default_rng(3)
        small = np.where(np.arange(30) < 20, 0.0, 14e-6) + 1e-7 * drawn.normal(size=30)
        unit = self.a_unit(small, 2e-7)
        for row, large in zip(unit.rows, 0.03 + 1e-4 * drawn.normal(size=30), strict=True):
            (held,) = row["parameters"]
            held |= {"owner": "coulomb_friction_2", "name": "torque", "unit": "N m"}
            other = {"owner": "coulomb_friction", "name": "torque", "value": large, "std": 1e-4, "unit": "N m"}
            row["parameters"].append(other)
        told = {look.history.owner: look for look in outlooks(unit, {})}
        assert told["coulomb_friction_2"].change is None and told["coulomb_friction_2"].trend is None
        (look, _) = outlooks(unit, {"coulomb_friction_2.torque": 1e-3})
        assert look.history.owner == "coulomb_friction_2" and look.change is not None
        for row in unit.rows:
            row["parameters"].pop()
        assert outlooks(unit, {})[0].change is not None  # alone of its kind, it is what there is

    def test_a_number_on_its_bound_is_as_sure_as_it_was_told(self):
        """No play is found as 0 again and again; the first fit that gives a little more is no change, and play is."""
        values = np.zeros(18)
        values[[1, 9, 13]] = 2.6e-9, 8.4e-8, 3.6e-8
        (look,) = outlooks(self.a_unit(values, std=2e-7), {}, healthy=Healthy(8))
        assert look.change is None
        values[11:] = 2.5e-4 * np.arange(1.0, 8.0)
        (look,) = outlooks(self.a_unit(values, std=2e-7), {}, healthy=Healthy(8))
        assert (look.change.begin, look.change.alarm) == (11, 11)

    def test_which_values_lie_on_a_bound_is_asked_of_those_that_are_healthy_in_the_end(self):
        """A pattern that finds one recording says nothing: the first ones are held against, as where none is given."""
        values = np.zeros(18)
        values[11] = 2e-7
        by_default, by_one = (
            outlooks(self.a_unit(values, std=2e-7), {}, healthy=healthy)[0]
            for healthy in (BY_DEFAULT, Healthy.of("week 0$", 4))
        )
        assert by_one.history.healthy.tolist() == by_default.history.healthy.tolist()
        assert by_one.history.shared == by_default.history.shared == 0.0

    def test_free_values_that_lie_near_each_other_lie_on_no_bound(self):
        values = 100.0 + 1e-5 * np.array([0.3, -0.4, 0.1, 0.2, -0.2, 0.4, -0.1, 0.0])
        assert not stands_still(values) and stands_still(np.where(np.arange(8) < 3, 100.0, values))

    def a_wave(self, phases, std):
        """A unit with the phase of a wave."""
        return self.a_unit(phases, std, dated=False, owner="sun_runout", name="phase")

    def test_the_phase_of_no_wave_is_not_followed(self):
        """A wave of no amplitude has any phase, one of hardly any a phase of half a radian's error."""
        drawn = np.random.default_rng(11)
        unit = self.a_wave(drawn.uniform(-3.1, 3.1, 20), drawn.choice([0.4, 2.0, 10.0], 20))
        assert outlooks(unit, {}, healthy=Healthy(8)) == []
        came = self.a_wave(drawn.uniform(-0.1, 0.1, 20), np.where(np.arange(20) < 10, 5.0, 0.03))
        assert outlooks(came, {}, healthy=Healthy.of("week [0-7]$", 4)) == []

    def test_a_phase_beside_half_a_turn_is_no_change_and_one_that_moves_is(self):
        phases = np.pi + 0.05 * np.random.default_rng(12).normal(size=20)
        phases = np.where(phases > np.pi, phases - 2.0 * np.pi, phases)
        (look,) = outlooks(self.a_wave(phases, 0.05), {}, healthy=Healthy(8))
        assert np.ptp(phases) > 6.0 and look.change is None
        phases[12:] += 0.8
        (look,) = outlooks(self.a_wave(phases, 0.05), {}, healthy=Healthy(8))
        assert look.share is None  # the zero of an angle says nothing
        assert look.change.begin == 12 and look.change.size == pytest.approx(0.8, abs=0.2)

    def test_healthy_units_seldom_seem_to_change(self):
        drawn = np.random.default_rng(6)
        units = [self.a_unit(100.0 + drawn.normal(size=30), std=std) for std in (1.0, 10.0) for _ in range(40)]
        assert sum(outlooks(unit, {})[0].change is not None for unit in units) <= 4

    def test_a_phase_whose_first_value_is_half_a_turn_off_moves_all_the_same(self):
        phases = np.pi - 1e-3 + 0.05 * np.random.default_rng(13).normal(size=20)
        phases[0] = 0.02
        phases[12:] += 0.8
        told = np.where(phases > np.pi, phases - 2.0 * np.pi, phases)
        (look,) = outlooks(self.a_wave(told, 0.05), {}, healthy=Healthy(12))
        assert look.now - look.history.values[5] == pytest.approx(0.8, abs=0.15)

    def test_wear_that_had_begun_before_the_healthy_results_is_told_by_its_limit(self):
        """No value left the healthy ones, which wear as the others do: the trend leads to the limit all the same."""
        values = 1e-3 + 3e-4 * np.arange(8.0)
        looks = outlooks(self.a_unit(values, std=1e-5, dated=False), {"backlash.width": 4e-3}, healthy=Healthy(4))
        assert looks[0].change is None
        assert moving_words(looks) == ["backlash width reaches its limit in 3 results"]

    def test_without_dates_the_results_are_counted(self):
        (look,) = outlooks(self.a_unit(np.arange(20.0), dated=False), {})
        assert not look.history.dated
        assert look.trend.slope == pytest.approx(1.0, rel=0.05)

    def test_numbers_that_were_held_or_are_few_are_not_followed(self):
        assert outlooks(self.a_unit(np.arange(4.0)), {}) == []
        assert outlooks(self.a_unit(np.arange(9.0), std=None), {}) == []

    @pytest.mark.slow
    @pytest.mark.parametrize("text", ["", "backlash.width: wide", "- 1"])
    def test_limits_that_are_none_are_refused(self, tmp_path, text):
        file = tmp_path / "limits.yaml"
        file.write_text(text)
        with pytest.raises(InputError, match=r"limits\.yaml"):
            read_limits(file)
