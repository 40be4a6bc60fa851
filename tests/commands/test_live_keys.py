"""The keys of a live run: what they diagnose, add and answer."""

import threading
from pathlib import Path
from types import SimpleNamespace

import pytest

from ema_bench_replay.errors import InputError
from ema_twin_sim.commands.live_keys import Keys, told
from ema_twin_sim.live.diagnosing.apply import Busy, NotDiagnosed
from ema_twin_sim.nodes.diagnosing.answer import diagnosis_message
from tests.judged_effects import OF_BOTH, entry


class Services:
    """What the keys ask, without a graph."""

    def __init__(self, found=None, words="", refused=None):
        self.found, self.words, self.refused = found, words, refused

    def diagnose(self):
        if self.refused is not None:
            raise self.refused
        return self.found

    def apply(self, effects):
        if self.refused is not None:
            raise self.refused
        return self.words


class TestTheKeysOfALiveRun:
    def pressed(self, key, capsys, services, **options):
        keys = Keys(threading.Event(), **options)
        comparison, model = SimpleNamespace(beyond_noise={}), SimpleNamespace(motion="rotary")
        keys.begin(SimpleNamespace(diagnosis_services=services, comparison=comparison, model=model))
        keys.press(key)
        for thread in keys._threads:
            thread.join()
        return " ".join(capsys.readouterr().out.split())

    def test_effects_that_are_all_missing_are_each_likely(self, capsys):
        said = self.pressed("d", capsys, Services(diagnosis_message(OF_BOTH, 0, 1, 12.0)))
        assert said.startswith("Diagnosing; this takes some seconds")
        assert "backlash: 98 % likely" in said and "Stribeck friction: 97 % likely" in said
        assert "cogging: 10 % likely" in said and "Press a to add them" in said
        assert "current: clipped" in said and "give several" not in said

    def test_a_key_that_does_nothing_is_answered_once_with_those_that_do(self, capsys):
        said = self.pressed("x", capsys, Services())
        assert said == "'x' does nothing. Keys: d diagnose a add the effects found q quit"
        stop = threading.Event()
        Keys(stop).take("\x1b[D")  # an arrow, which ends in the code of another key
        assert capsys.readouterr().out.startswith("That key does nothing") and not stop.is_set()
        Keys(stop).take("\nq")
        assert stop.is_set() and not capsys.readouterr().out

    def test_one_that_is_missing_is_likely(self):
        one = {**OF_BOTH, "ranking": [entry("backlash", 1.0, True, width=0.004)]}
        lines = told(diagnosis_message(one, 0, 1, 12.0), {})
        assert lines[1].startswith("  backlash: 100 % likely") and "Press a to add it" in lines[2]

    def test_adding_before_anything_was_looked_for(self, capsys):
        said = self.pressed("a", capsys, Services(refused=NotDiagnosed("call monitor/diagnose first")))
        assert "press d to diagnose first" in said and "monitor/diagnose" not in said
        assert "nothing to add" in self.pressed("a", capsys, Services(refused=InputError("nothing to add")))

    @pytest.mark.parametrize("key", ["a", "d"])
    def test_a_key_while_a_diagnosis_runs_is_answered_for_a_person(self, capsys, key):
        said = self.pressed(key, capsys, Services(refused=Busy("call again")))
        assert "wait for its result, then press the key again" in said and "call again" not in said

    def test_what_to_record_is_in_words(self):
        why = "stribeck_friction(law=exponential) and a model without it would come apart by 29 standard deviations"
        found = {**OF_BOTH, "next_recording": f"ramp:0.05 for 12 s: {why}, over the whole recording"}
        line = next(line for line in told(diagnosis_message(found, 0, 1, 12.0), {}) if line.startswith("Record next"))
        assert "Stribeck friction (law exponential) and a model" in line and "over the whole recording" in line

    def test_what_was_added_is_told_with_the_constants_and_where_it_is_kept(self, capsys):
        services = Services(words="backlash width 4.0 mrad; and 7 constants refitted")
        assert "and 7 constants refitted. Watch" in self.pressed("a", capsys, services)
        assert "live with -o NEW to save it" in self.pressed("a", capsys, services)
        assert "written to new.yaml at the end" in self.pressed("a", capsys, services, output=Path("new.yaml"))
