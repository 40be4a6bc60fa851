"""The worked notebook runs from top to bottom, and finds what its bench hides."""

import re
import runpy

import pytest

import ema_twin_sim
from tests.tutorials import DOCS

NOTEBOOK = DOCS / "examples" / "notebook.py"


@pytest.fixture(scope="module")
def ran():
    return runpy.run_path(str(NOTEBOOK))


def test_it_finds_what_is_hidden(ran):
    found, hidden = ran["found"], ran["hidden"]
    assert (found.verdict, found.added) == ("explained", ("sun_runout",))
    for name in ("torque", "phase"):
        held = found.parameters["sun_runout"][name]
        assert held["value"] == pytest.approx(hidden.effects["sun_runout"].parameters[name], abs=5.0 * held["std"])


def test_the_error_falls_to_the_sensors_noise(ran):
    before, after = (ran[name].overall["current"] for name in ("before", "after"))
    assert before["rmse"] > 2.0 * before["noise_floor"] and after["rmse"] < 1.2 * after["noise_floor"]


def test_it_is_in_cells_and_asks_the_public_interface_only():
    text = NOTEBOOK.read_text()
    assert len(re.findall(r"^# %%", text, re.MULTILINE)) >= 8
    names = re.findall(r"^from ema_twin_sim import (.*)$", text, re.MULTILINE)
    assert set(", ".join(names).split(", ")) <= set(ema_twin_sim.__all__)


def test_the_reference_has_every_public_name():
    reference = (DOCS / "reference.md").read_text()
    for name in ema_twin_sim.__all__:
        assert f"ema_twin_sim.{name}\n" in reference, name
