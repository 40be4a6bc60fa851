"""The messages are what plotters, recordings and the nodes rely on: header first, units given, NaN kept."""

import math
import re
from pathlib import Path

import pytest
from rclpy.serialization import deserialize_message, serialize_message

from ema_bench_replay.units import SIGNALS
from ema_twin_msgs import msg, srv
from ema_twin_sim.simulation.compared_signals import COMPARED

MESSAGES = Path(__file__).resolve().parents[2] / "ema_twin_msgs"
PUBLISHED = (msg.EmaState, msg.Residual, msg.Health, msg.Diagnosis, msg.Run)


@pytest.mark.parametrize("path", sorted(MESSAGES.glob("msg/*.msg")), ids=lambda path: path.stem)
def test_installed_messages_are_those_of_the_checkout(path):
    lines = [line.partition("#")[0].split() for line in path.read_text().splitlines()]
    names = [line[1] for line in lines if line and "=" not in "".join(line)]
    installed = list(getattr(msg, path.stem).get_fields_and_field_types())
    assert installed == names, f"messages are older than {path.name}; run `make setup`"


@pytest.mark.parametrize("message", PUBLISHED, ids=lambda message: message.__name__)
def test_header_and_run_come_first(message):
    names = list(message.get_fields_and_field_types())
    assert names[:2] == ["header", "run"]


@pytest.mark.parametrize("message", [msg.EmaState, msg.Signals], ids=lambda message: message.__name__)
def test_signals_are_flat_floats_that_keep_nan(message):
    fields = message.get_fields_and_field_types()
    floats = [name for name, kind in fields.items() if kind == "double"]
    assert set(fields) - set(floats) <= {"header", "run", "sequence"}
    sent = message(**dict.fromkeys(floats, math.nan))
    received = deserialize_message(serialize_message(sent), message)
    assert all(math.isnan(getattr(received, name)) for name in floats)


@pytest.mark.parametrize("path", sorted(MESSAGES.glob("*/*.*")), ids=lambda path: path.stem)
def test_every_number_states_its_unit(path):
    floats = re.findall(r"^float64 .*", path.read_text(), re.M)
    assert [line for line in floats if not re.search(r"# \[.+\]", line)] == []


def test_a_state_holds_every_signal_of_a_recording():
    missing = [*{*SIGNALS}.difference(msg.EmaState.get_fields_and_field_types())]
    assert missing == [], "add a float64 to EmaState.msg and run `make setup`, or take it out of units.py"


def test_every_compared_signal_is_in_a_residual():
    missing = [*{*COMPARED}.symmetric_difference(msg.Signals.get_fields_and_field_types())]
    assert missing == [], "Signals.msg and compared_signals.py differ: add it there too, and run `make setup`"


def test_compared_signals_are_signals_of_the_state():
    assert set(msg.Signals.get_fields_and_field_types()) <= set(msg.EmaState.get_fields_and_field_types())


def test_health_levels_are_those_of_diagnostics():
    from diagnostic_msgs.msg import DiagnosticStatus

    for level in ("OK", "WARN", "ERROR", "STALE"):
        assert getattr(msg.Health, level) == getattr(DiagnosticStatus, level)


@pytest.mark.parametrize("service", [srv.Apply, srv.Diagnose, srv.Seek], ids=lambda service: service.__name__)
def test_services_answer_whether_and_why(service):
    fields = service.Response.get_fields_and_field_types()
    assert (fields["success"], fields["message"]) == ("boolean", "string")
