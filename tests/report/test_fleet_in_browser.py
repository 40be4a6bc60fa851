"""The pages of a fleet as a browser shows them: a thousand units, a filter that finds one, a click to its page."""

import time

import numpy as np
import pytest

from ema_twin_sim.campaign.histories import outlooks
from ema_twin_sim.campaign.units import units_of
from ema_twin_sim.report.fleet import write_fleet
from tests.browser import CHROMIUM, Browser
from tests.report.test_fleet import results

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="chromium is missing: sudo apt install chromium")

UNITS = 1000
SHOWN = "[...document.querySelectorAll('tbody tr')].filter(row => !row.hidden).length"


@pytest.fixture(scope="module")
def overview(tmp_path_factory):
    """A thousand units, one of which wears."""
    drawn = np.random.default_rng(5)
    ten = [[*results(f"EMA-{k:04}", 4e-5 if k == 7 else 0.0, drawn)] for k in range(10)]
    rows = [{**row, "unit": f"EMA-{k:04}"} for k in range(UNITS) for row in ten[k if k < 10 else 0]]
    units = units_of(rows)
    kept = {unit.name: outlooks(unit, {"backlash.width": 4e-3}) for unit in units_of(row for its in ten for row in its)}
    ahead = {unit.name: kept.get(unit.name, kept["EMA-0000"]) for unit in units}
    return write_fleet(tmp_path_factory.mktemp("fleet"), units, ahead, dict.fromkeys(ahead))


@pytest.mark.slow
def test_a_thousand_units_are_shown_filtered_and_led_to(overview, tmp_path):
    browser = Browser(tmp_path)
    try:
        begun, had = time.monotonic(), browser.processor_time
        browser.open(overview.as_uri())
        browser.wait(f"{SHOWN} === {UNITS}")
        clock, taken = time.monotonic() - begun, browser.processor_time - had
        print(f"{UNITS} units are shown after {clock:.2f} s, {taken:.2f} s of a processor")
        browser.ask(
            "(() => { const box = document.querySelector('input'); box.value = 'ema-0007';"
            "box.dispatchEvent(new Event('input')); return true; })()"
        )
        assert browser.ask(SHOWN) == 1
        browser.ask("(() => { [...document.querySelectorAll('tbody tr')].find(r => !r.hidden)"
                    ".querySelector('a').click(); return true; })()")  # fmt: skip
        browser.wait("document.querySelector('h1')?.textContent === 'EMA-0007'")
        assert browser.ask("document.querySelectorAll('svg circle').length") == 24
        assert "reaches its limit" in browser.ask("document.body.textContent")
        assert browser.errors == browser.warnings == []
        assert all(address.startswith(overview.parent.as_uri()) for address in browser.requested)
    finally:
        browser.close()
