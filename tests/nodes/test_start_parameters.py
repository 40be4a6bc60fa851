"""A parameter given at a node's start is refused with its range, told once and with its unit."""

from types import SimpleNamespace

import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.nodes.parameters import Declaration, declare


def test_the_range_is_told_once():
    node = SimpleNamespace(get_name=lambda: "twin", _parameter_overrides={"rate": SimpleNamespace(value=-5.0)})
    with pytest.raises(InputError) as told:
        declare(node, [Declaration("rate", 1.0, "rate", "Hz", 0.0, 5.0)])
    assert str(told.value) == "twin: parameter rate: -5.0 is refused; give 0 to 5 Hz"
