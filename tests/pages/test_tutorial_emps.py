"""What the tutorial of EMPS tells to write into a drafted map."""

import re
import shutil

import pytest

from tests.command_line import done, twin
from tests.tutorials import page

pytestmark = pytest.mark.slow


def test_its_gain_makes_the_drafted_map_complete(real, tmp_path):
    shutil.copy(real / "emps_train.csv", tmp_path)
    done("init", "emps_train.csv", "-o", "carriage", cwd=tmp_path)
    drafted = (tmp_path / "carriage_map.yaml").read_text()
    gain = re.search(r"^    (motor_torque: .*)$", page("emps"), re.MULTILINE)[1]
    (tmp_path / "carriage_map.yaml").write_text(
        re.sub(r"^  voltage: .*$", f"  {gain}".replace("\\", r"\\"), drafted, flags=re.M)
    )
    shown = twin("info", "emps_train.csv", "--map", "carriage_map.yaml", cwd=tmp_path)
    assert shown.returncode == 0, shown.stderr
    assert "motor_torque" in shown.stdout
