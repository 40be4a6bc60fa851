"""A refusal as everybody gets it: one line with the file, what is wrong there, and a remedy."""

from contextlib import contextmanager

import pytest

from ema_bench_replay.errors import InputError


@contextmanager
def refused_in_one_line(path, *words):
    """What is done within is refused, in one line that names the ``path``, the ``words`` and a remedy."""
    with pytest.raises(InputError) as caught:
        yield
    message = str(caught.value)
    assert "\n" not in message
    for word in (str(path), "; ", *words):
        assert word in message, message
