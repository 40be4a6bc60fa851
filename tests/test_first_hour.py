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


def swapped(files, folder, one, other):
    """The files with the units of two columns swapped in their headers."""
    written = []
    for file in files:
        header, _, rows = file.read_text().partition("\n")
        names = [f"{one[0]} [{one[1]}]", f"{other[0]} [{other[1]}]"]
        wrong = [f"{one[0]} [{other[1]}]", f"{other[0]} [{one[1]}]"]
        for right, name in zip(names, wrong, strict=True):
            assert right in header
            header = header.replace(right, name)
        written.append(folder / file.name)
        written[-1].write_text(f"{header}\n{rows}")
    return written


@pytest.mark.parametrize(
    ("one", "other", "said"),
    [
        (
            ("current", "A"),
            ("motor speed", "rad/s"),
            "current [rad/s]: its name says current, its unit rad/s",
        ),
        (("motor position", "rad"), ("motor speed", "rad/s"), "motor speed [rad]: its name says speed, its unit rad"),
    ],
    ids=["current and speed", "position and speed"],
)
def test_a_unit_that_contradicts_its_columns_name_is_told_at_once(servo, tmp_path, capsys, one, other, said):
    assert "its name says" not in drafted(servo, tmp_path, capsys)
    told = drafted(swapped(servo, tmp_path, one, other), tmp_path, capsys, force=True)
    assert told.count("its name says") == 2 and said in told
