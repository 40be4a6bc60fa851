"""What `init` says about the lines that it marked: why each is to be checked, and what is open in any case."""

from pathlib import Path

import numpy as np
import pytest

from ema_twin_sim.commands.init import run as init
from ema_twin_sim.commands.output import console
from ema_twin_sim.commands.shown_draft import say_what_to_look_at
from tests.trace_text import write_columns

OPEN = "inertia and friction are open: start values only, which fit or discover replace"
TIME = np.arange(2000) * 2e-3
SPEED = 20.0 * np.sin(3.1 * TIME) + 8.0 * np.sin(7.2 * TIME)


@pytest.fixture(autouse=True)
def unfolded(tmp_path, monkeypatch):
    """Lines are whole: names are short, and the terminal is wide."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(console, "width", 200)


def printed(capsys, speed=SPEED, **given):
    way = np.cumsum(SPEED) * 2e-3
    torque = 0.02 * np.gradient(SPEED, TIME) + 0.5 * np.sign(SPEED)
    columns = {"time [s]": TIME, "motor position [rad]": way, "motor speed [rad/s]": speed, "motor torque [Nm]": torque}
    file = write_columns(Path("run.csv"), columns)
    init("m", [file], gear_ratio=1.0, **given)
    return capsys.readouterr().out.splitlines(), file


def after(lines, name):
    """The line on a file, from its name on, and those below that are part of it."""
    place = next(k for k, line in enumerate(lines) if f"{name}: " in line and not line.startswith(" "))
    below = []
    for line in lines[place + 1 :]:
        if not line.startswith("  "):
            break
        below.append(line.strip())
    return lines[place].partition(f"{name}: ")[2], below


def test_of_a_model_without_a_mark_it_says_what_is_open(capsys):
    """It said that no line to check, though inertia and friction were."""
    lines, file = printed(capsys)
    assert after(lines, "m.yaml") == (OPEN, [])
    assert after(lines, "m_map.yaml") == ("no line to check", [])
    init("n", [file], gear_ratio=1.0, import_map="m_map.yaml")
    assert after(capsys.readouterr().out.splitlines(), "n.yaml") == (OPEN, [])


@pytest.mark.parametrize("factor", [1000.0, 0.01])
def test_the_factor_between_position_and_speed_is_printed(capsys, factor):
    """It was only in the map, and the terminal named one line to check."""
    lines, _ = printed(capsys, factor * SPEED)
    said, reasons = after(lines, "m_map.yaml")
    assert said == "1 line to check, marked CHECK"
    assert len(reasons) == 1 and reasons[0].startswith("motor_position: the position changes ")


def test_a_few_reasons_are_shown_each_once(capsys):
    marked = [f"  key_{k}: {{value: 1}}  # CHECK: reason {k}; told before" for k in range(7)]
    assumed = "  gear_ratio: {value: 1, source: assumed}  # CHECK: turns of the motor per turn of the output"
    text = "\n".join(["# of", "# CHECK", *marked, "  told: {}  # CHECK: told before", assumed])
    say_what_to_look_at(Path("m.yaml"), text, "Assumed: told before, and more")
    said, reasons = after(capsys.readouterr().out.splitlines(), "m.yaml")
    assert said == "9 lines to check, marked CHECK"
    assert reasons == [*(f"key_{k}: reason {k}" for k in range(4)), "and 3 more: see the file"]
