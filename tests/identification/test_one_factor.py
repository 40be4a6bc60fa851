"""All that a search refitted, off by one factor: the unit of the torque, and no machine."""

from dataclasses import replace

import pytest

from ema_twin_sim.identification.estimates import off_by_one_factor
from ema_twin_sim.model.check_comment import START_VALUE


def refitted(inertia, viscous, coulomb, std=0.01):
    nominal = {"inertia": 2e-4, "coefficient": 1e-3, "torque": 0.05}
    times = {"inertia": inertia, "coefficient": viscous, "torque": coulomb}
    units = {"inertia": "kg m^2", "coefficient": "N m s/rad", "torque": "N m"}
    entry = {
        name: {"value": factor * nominal[name], "nominal": nominal[name], "std": std * factor * nominal[name]}
        for name, factor in times.items()
    }
    return {
        "machine": {"motor_inertia": entry["inertia"] | {"unit": units["inertia"]}},
        "viscous_friction": {"coefficient": entry["coefficient"] | {"unit": units["coefficient"]}},
        "coulomb_friction": {"torque": entry["torque"] | {"unit": units["torque"]}},
    }


@pytest.mark.parametrize("factor", [1000.0, 1e-3, 57.3])
def test_one_factor_is_told(stock, factor):
    (said,) = off_by_one_factor(refitted(factor, 1.02 * factor, 0.98 * factor), stock)
    assert f"{factor:.3g} times" in said and "mA" in said


@pytest.mark.parametrize(
    "constants",
    [refitted(1.0, 1.0, 1.0), refitted(40.0, 5.0, 3.0), refitted(1000.0, 300.0, 1000.0), refitted(9.0, 9.0, 9.0), {}],
)
def test_a_machine_that_nobody_knew_is_not_accused(stock, constants):
    assert off_by_one_factor(constants, stock) == []


def test_start_values_of_a_draft_state_nothing(stock):
    """The placeholders of `init` are all larger than the constants of a small motor, here by chance as much."""
    path = "machine.motor_inertia"
    held = replace(stock.constants[path], source=START_VALUE)
    drafted = replace(stock, constants={**stock.constants, path: held})
    assert off_by_one_factor(refitted(1280.0, 1290.0, 1270.0), drafted) == []
    assert off_by_one_factor(refitted(1280.0, 1290.0, 1270.0), stock)


def test_what_is_hardly_told_is_not_asked(stock):
    assert off_by_one_factor(refitted(1000.0, 1000.0, 1000.0, std=0.2), stock) == []
