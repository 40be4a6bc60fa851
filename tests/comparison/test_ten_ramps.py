"""The thesis's experiment: ten ramps, its table 5.1 with a column a model, and what discover makes of half of them."""

import json
import re

import pytest

from ema_bench_replay.load import load
from ema_twin_sim import compare, discover
from ema_twin_sim.comparison.closeness import closer
from ema_twin_sim.model import save_model
from tests.command_line import MODEL, done
from tests.commands.test_terminal import check, on_terminal
from tests.conftest import outside

SPEEDS = [f"{0.01 * k:g}" for k in range(1, 11)]


@pytest.fixture(scope="module")
def ramps():
    folder = outside("ten_ramps")
    return [folder / f"BancoEMA_ramp_{speed}.CSV" for speed in SPEEDS]


@pytest.fixture(scope="module")
def found_on_odd(ramps, stock):
    return discover([load(path) for path in ramps[::2]], stock)


@pytest.fixture(scope="module")
def found_on_even(ramps, stock):
    return discover([load(path) for path in ramps[1::2]], stock)


@pytest.mark.slow
@pytest.mark.parametrize("fitted, judged", [("odd", "even"), ("even", "odd")])
def test_what_five_ramps_find_is_ten_times_closer_on_each_of_the_other_five(fitted, judged, ramps, stock, request):
    found = request.getfixturevalue(f"found_on_{fitted}")
    hidden = json.loads((ramps[0].parent / "answer.json").read_text())["hidden"]
    assert sorted(found.added) == sorted(hidden) and found.verdict == "explained"
    others = ramps[1::2] if judged == "even" else ramps[::2]
    recordings = [load(path) for path in others]
    close = closer(compare(recordings, stock), compare(recordings, found.model))
    assert [name for name, _ in close.recordings] == [path.stem for path in others]
    times = {name: signals["current"].times for name, signals in close.recordings}
    assert min(times.values()) >= 10.0 and close.overall["current"].times >= 10.0, times


@pytest.mark.slow
def test_the_table_has_a_row_a_ramp_and_a_column_a_model(found_on_odd, ramps, tmp_path):
    file = save_model(found_on_odd.model, tmp_path / "found.yaml")
    shuffled = [*ramps[5:], *ramps[:5]]
    models = (*MODEL, "--model", "polito_hff", "--model", file)
    lines = on_terminal("compare", *shuffled, *models, "--to", 1, "--json", tmp_path / "c.json")
    check(lines)
    text = "\n".join(lines)
    for signal, unit in (("current", "mA"), ("output position", "µrad")):
        table = text[text.index(f"RMSE of the {signal}") :]
        rows = re.findall(rf"BancoEMA_ramp_(\S+) +[\d.]+ {unit} +[\d.]+ {unit} +\S.*× +[\d.]+ {unit} ", table)
        assert rows[:10] == SPEEDS, signal  # sorted as people count, whatever their order on the command line
    assert "polito_hff" in text and "found: " in text and "all recordings" in text
    first, fine, better = json.loads((tmp_path / "c.json").read_text())
    assert "times_closer" not in first and fine["times_closer"]["than"] == "polito_bench"
    assert [r["name"] for r in better["times_closer"]["recordings"]] == [path.stem for path in shuffled]
    before, after = (c["recordings"][0]["signals"]["current"] for c in (first, fine))
    excesses = [(error["rmse"] ** 2 - error["noise_floor"] ** 2) ** 0.5 for error in (before, after)]
    times = fine["times_closer"]["recordings"][0]["signals"]["current"]
    assert times == {"times": pytest.approx(excesses[0] / excesses[1])}


@pytest.mark.slow
def test_a_single_recording_is_compared_in_one_table(ramps):
    text = done("compare", ramps[0], *MODEL, "--model", "polito_hf", "--to", 1).stdout
    assert "RMSE of BancoEMA_ramp_0.01, measured minus twin" in text and "all recordings" not in text
