"""Registers of servos whose highest bit is the sign: which they are, and what init says of them."""

import numpy as np
import pytest

from ema_twin_sim.new_machine.sign_bits import sign_bit

TIME = np.arange(600) * 0.02
STEPS = np.rint(2048.0 + 800.0 * np.sin(1.7 * TIME))
SPEED = np.rint(1360.0 * np.cos(1.7 * TIME))  # steps/s
LOAD = np.rint(300.0 * np.cos(1.7 * TIME) + 40.0 * np.sign(SPEED))


def register(values, bit):
    """Signed whole numbers (n,) as a register with a bit for the sign holds them."""
    return np.where(values < 0.0, 2.0**bit - values, values)


@pytest.mark.parametrize(("values", "bit"), [(SPEED, 15), (LOAD, 10)])
def test_the_bit_of_the_sign_is_known(values, bit):
    assert sign_bit(register(values, bit)) == bit
    assert sign_bit(np.append(register(values, bit), np.nan)) == bit
    assert sign_bit(values) is None and sign_bit(np.abs(values)) is None
    assert sign_bit(register(values, bit) + 0.5) is None


def test_large_numbers_are_no_sign():
    steps = np.where(np.sin(3.0 * TIME) > 0.0, 40_000.0, 0.0)  # a speed in counts that is switched on and off
    assert sign_bit(steps) is None
    assert sign_bit(np.abs(30.0 * SPEED)) is None  # up to 40 800, all along
    assert sign_bit(np.mod(SPEED, 65_536.0)) is None  # two's complement


def test_init_says_what_such_registers_are_and_reads_the_others(drafted, read):
    """By the numbers as they are the motor moved by 70.8 krad, and a position that moves was left out as standing."""
    drive = np.rint(np.abs(LOAD) / 10.0)
    columns = {"t": TIME, "pos": STEPS, "speed": register(SPEED, 15), "load": register(LOAD, 10), "current": drive}
    draft = drafted(columns)
    assert "speed: not used, since its whole numbers look like a register whose bit 15 is the sign" in draft.said
    assert "load: not used, since its whole numbers look like a register whose bit 10 is the sign" in draft.said
    assert "write 32768 minus the number in place of each number from 32768 on, and run init again" in draft.said
    assert "stands still" not in draft.told
    assert "CHECK: whole numbers, beside a speed whose bit 15 is the sign" in draft.line("motor_position")
    assert np.ptp(read().signals["motor_position"]) == pytest.approx(2.0 * np.pi * 1600.0 / 4096.0, rel=1e-2)
