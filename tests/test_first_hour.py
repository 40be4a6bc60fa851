"""The first hour with one's own machine: what is wrong in what one has is said at once, with what to do."""

import re

import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from ema_twin_sim.commands import init
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.model import load_model
from tests.servo_csv import TORQUE_CONSTANT, write_servo


@pytest.fixture(scope="module")
def servo(tmp_path_factory):
    return write_servo(tmp_path_factory.mktemp("servo"))


def drafted(files, folder, capsys, **options):
    """What `init` says of these files, in one line; its drafts are the folder's servo_map.yaml and servo.yaml."""
    init.run(str(folder / "servo"), list(files), torque_constant=TORQUE_CONSTANT, **options)
    printed = capsys.readouterr()
    return re.sub(r"\s+", " ", printed.out + printed.err)


def test_a_gear_ratio_that_the_encoders_contradict_is_asked_about_and_refused(servo, tmp_path, capsys):
    assert "both positions make it" not in drafted(servo, tmp_path, capsys, gear_ratio=80.0)
    told = drafted(servo, tmp_path, capsys, gear_ratio=50.0, force=True)
    assert "the gear ratio was given as 50, and both positions make it 80; leave --gear-ratio out" in told
    recordings = [load(file, import_map=tmp_path / "servo_map.yaml") for file in servo]
    with pytest.raises(InputError, match=r"0\.625 times .* machine\.gear_ratio \(with 80 they fit\)"):
        discover(recordings, load_model(tmp_path / "servo.yaml"))
