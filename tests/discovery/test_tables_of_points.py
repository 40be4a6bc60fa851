"""Tables of operating points of machines that nobody here has seen: init tells them from samples of a motion."""

import numpy as np
import pytest

from ema_bench_replay.errors import InputError
from ema_twin_sim.commands.init import run as init
from ema_twin_sim.discovery.discover import discover
from tests.by_draft import by_draft
from tests.discovery.test_machines_of_others import level

CONSTANT = 0.3  # N m/A


def written(tmp_path, columns, delimiter=","):
    """A CSV of the columns: name → values (n,)."""
    path = tmp_path / "table.csv"
    lines = [delimiter.join(columns)]
    lines += [delimiter.join(f"{value:.6g}" for value in row) for row in np.stack([*columns.values()], axis=1)]
    path.write_text("\n".join(lines) + "\n")
    return path


def drafted(tmp_path, columns, delimiter=",", **said):
    """(recording, model) by what init drafts of such a table."""
    path = written(tmp_path, columns, delimiter)
    (recording,), model = by_draft(tmp_path, [path], torque_constant=CONSTANT, force=True, **said)
    return recording, model


def held(rng, angle, sense):
    """Current [A] that holds a motor with nine magnets' cogging of 20 mN m and dry friction of 6 mN m."""
    torque = 0.02 * np.sin(9.0 * angle + 0.4) + 0.006 * sense
    return torque / CONSTANT + 1e-3 * rng.standard_normal(len(angle))


def both_ways(count):
    there = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    return np.concatenate([there, there[::-1]]), np.repeat([1.0, -1.0], count)


@pytest.mark.parametrize("count", [120, 900])
def test_a_motor_held_at_angles_cogs(count, tmp_path):
    """Whether there are few rows or thousands, that follow each other as closely as samples do."""
    rng = np.random.default_rng(1)
    angle, sense = both_ways(count)
    recording, model = drafted(tmp_path, {"angle [deg]": np.degrees(angle), "current [A]": held(rng, angle, sense)})
    assert recording.of_points
    found = discover([recording], model)
    assert (found.verdict, found.added) == ("explained", ("cogging",))
    assert found.model.effects["cogging"].options["order"] == "9"
    assert level(found.model, "coulomb_friction", "torque") == pytest.approx(0.006, rel=0.05)


def test_rows_that_were_stamped_when_the_motor_had_settled_are_no_samples(tmp_path):
    """Several readings an angle, milliseconds or seconds apart; the speed's column is zero throughout."""
    rng = np.random.default_rng(2)
    angle, sense = (np.repeat(values, 3) for values in both_ways(400))
    steps = 0.001 * rng.integers(1, 16, len(angle))
    steps[::3] = rng.uniform(0.1, 1.2, len(steps[::3]))
    columns = {
        "t [s]": np.cumsum(steps),
        "pos [rad]": angle,
        "vel [rad/s]": np.zeros(len(angle)),
        "iq [A]": held(rng, angle, sense),
    }
    recording, model = drafted(tmp_path, columns)
    assert recording.of_points
    assert discover([recording], model).added == ("cogging",)


@pytest.mark.parametrize("stamped", [False, True])
def test_friction_at_constant_speeds(stamped, tmp_path):
    """Means of a speed each, in a German table; or stamped when each was steady, some seconds apart."""
    rng = np.random.default_rng(3)
    rpm = np.concatenate([sign * np.linspace(5.0, 1500.0, 45) for sign in (1.0, -1.0)])
    speed = rpm * 2.0 * np.pi / 60.0
    torque = 0.002 * speed + np.sign(speed) * (0.08 + 0.05 * np.exp(-np.abs(speed) / 6.0))
    columns = {"Drehzahl [1/min]": rpm, "Strom [A]": torque / CONSTANT + 2e-3 * rng.standard_normal(len(rpm))}
    if stamped:
        columns = {"Zeit [s]": np.cumsum(rng.choice([0.9, 4.0, 20.0], len(rpm))), **columns}
    recording, model = drafted(tmp_path, columns, ";")
    assert recording.of_points
    found = discover([recording], model)
    assert found.added == ("stribeck_friction",)
    assert level(found.model, "viscous_friction", "coefficient") == pytest.approx(0.002, rel=0.05)
    assert level(found.model, "coulomb_friction", "torque") == pytest.approx(0.08, rel=0.1)


def test_a_dynamometers_sweep_of_loads(tmp_path):
    """Speeds times brake torques behind a gear of 10: the drive gives the load and the friction."""
    rng = np.random.default_rng(4)
    rpm, load = (grid.ravel() for grid in np.meshgrid(np.r_[-1200:-100:300, 300:1300:300], np.linspace(-4.0, 4.0, 9)))
    speed = rpm * 2.0 * np.pi / 60.0
    torque = load / 10.0 + 0.001 * speed + np.sign(speed) * (0.03 + 0.12 * np.abs(load) / 10.0)
    columns = {
        "motor speed [rpm]": rpm,
        "output torque [Nm]": load,
        "current [A]": torque / CONSTANT + 2e-3 * rng.standard_normal(len(rpm)),
    }
    recording, model = drafted(tmp_path, columns, gear_ratio=10.0)
    assert recording.of_points and recording.has("load_torque")
    found = discover([recording], model)
    assert found.added == ("mesh_friction",)
    assert level(found.model, "mesh_friction", "coefficient") == pytest.approx(0.12, rel=0.1)


def swung(count=3000):
    """A motion, as its samples have it."""
    time = np.arange(count) * 2e-3
    angle = 3.0 * np.sin(2.0 * time)
    return {"angle [rad]": angle, "speed [rad/s]": 6.0 * np.cos(2.0 * time), "current [A]": 0.1 * np.cos(2.0 * time)}


def points_only_if_said_so(tmp_path, columns, asked):
    with pytest.raises(InputError, match=rf"{asked}.*--operating-points"):
        drafted(tmp_path, columns)
    recording, _ = drafted(tmp_path, columns, operating_points=True)
    assert recording.of_points


@pytest.mark.parametrize("left_out", ["speed [rad/s]", "angle [rad]", ""])
def test_samples_without_their_time_are_no_points_unless_somebody_says_so(left_out, tmp_path):
    columns = {name: values for name, values in swung().items() if name != left_out}
    points_only_if_said_so(tmp_path, columns, "export the time too")


def test_a_clock_that_drops_samples_is_a_clock(tmp_path):
    """Even where the speed's column is dead."""
    rng = np.random.default_rng(5)
    kept = np.sort(rng.choice(3000, 2400, replace=False))
    columns = {"time [s]": kept * 2e-3, **{name: values[kept] for name, values in swung().items()}}
    columns["speed [rad/s]"] = np.zeros(len(kept))
    init(str(tmp_path / "m"), [written(tmp_path, columns)])
    assert "operating_points" not in (tmp_path / "m_map.yaml").read_text()


def test_slow_rows_are_asked_about(tmp_path):
    columns = {"time [s]": np.arange(90.0) * 2.0, "speed [rpm]": np.linspace(-900.0, 900.0, 90)}
    columns["current [A]"] = 0.1 * np.sign(columns["speed [rpm]"])
    points_only_if_said_so(tmp_path, columns, r"is it in ms\?")


def test_a_propeller_is_drag_although_the_draft_has_friction(tmp_path):
    """Its torque goes with the square of the speed; friction that is not there makes nothing unsure."""
    rng = np.random.default_rng(3)
    speed = np.linspace(300.0, 900.0, 16)
    torque = 4.8e-7 * speed**2 - 0.01 + 0.004 * rng.standard_normal(len(speed))  # the sensor is a little off
    columns = {"speed [rad/s]": speed, "current [A]": torque / CONSTANT}
    recording, model = drafted(tmp_path, columns, operating_points=True)
    found = discover([recording], model)
    assert found.added == ("quadratic_drag",)
    drag = found.parameters["quadratic_drag"]["coefficient"]
    assert drag["value"] == pytest.approx(4.8e-7, rel=0.1) and drag["std"] < 0.1 * drag["value"]
    assert level(found.model, "coulomb_friction", "torque") < 1e-3
