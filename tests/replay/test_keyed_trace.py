"""A trace of keys and values, as CODESYS writes it, is refused by its name."""

import pytest

from ema_bench_replay.errors import InputError
from tests.trace_text import read_text

KEYS = "Version; 0x03050000\nName; Application.Trace\n0.Variable; Axis.Position\n0.Data; \n; 2; 25\n; 22; 26\n"


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_a_trace_of_keys_and_values_is_refused_by_name(end, tmp_path):
    with pytest.raises(InputError, match=r"is a trace of CODESYS .* one column for the time and one for each variable"):
        read_text(tmp_path, f"[key]; [value]\n{KEYS}".replace("\n", end).encode())


def test_a_table_with_a_column_named_key_is_read(tmp_path):
    assert read_text(tmp_path, "key;value\n1;2\n2;3\n").header == ["key", "value"]
