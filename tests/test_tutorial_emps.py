"""The tutorial's commands give the tutorial's figures."""

import re
import shlex
import shutil

import pytest

from tests.command_line import done, twin

FIGURES = {
    "fit": ("94.9 ± 0.3 kg", "205 ± 6 N s/m", "20.3 ± 0.4 N", "3.18 ± 0.12 N", "3.89 %"),
    "discover": (
        "Your model lacks Coulomb friction, viscous friction, asymmetric friction and constant load.",
        *("37.5 N", "8.55 N", "4.23 N", "2.63 N", "2.46 N"),
    ),
    "compare": ("77.56 %", "75.09 %", "3.89 %", "4.97 %", "3.00 %", "4.31 %"),
    "--input": ("3.09 µm",),
}


@pytest.fixture(scope="module")
def tutorial(request):
    return (request.config.rootpath / "docs" / "tutorial_emps.md").read_text()


def test_every_command_runs_and_says_what_the_tutorial_says(real, tutorial, tmp_path):
    for file in real.glob("emps_*.csv"):
        shutil.copy(file, tmp_path)
    commands = re.findall(r"^    ema-twin (.*)$", tutorial, re.MULTILINE)
    assert len(commands) == 5
    told = tutorial.replace("−", "-")
    for command in commands:
        words = shlex.split(command)
        printed = done(*words, cwd=tmp_path, timeout=120).stdout
        for figure in FIGURES.get("--input" if "--input" in words else words[0], ()):
            assert figure in printed, (command, figure)
            assert figure in told, figure


def test_its_gain_makes_the_drafted_map_complete(real, tutorial, tmp_path):
    shutil.copy(real / "emps_train.csv", tmp_path)
    done("init", "emps_train.csv", "-o", "carriage", cwd=tmp_path)
    drafted = (tmp_path / "carriage_map.yaml").read_text()
    gain = re.search(r"^    (motor_torque: .*)$", tutorial, re.MULTILINE)[1]
    (tmp_path / "carriage_map.yaml").write_text(
        re.sub(r"^  voltage: .*$", f"  {gain}".replace("\\", r"\\"), drafted, flags=re.M)
    )
    shown = twin("info", "emps_train.csv", "--map", "carriage_map.yaml", cwd=tmp_path)
    assert shown.returncode == 0, shown.stderr
    assert "motor_torque" in shown.stdout
