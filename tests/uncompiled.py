"""The plant without a compiler, so that coverage sees its branches: a plugin of pytest.

python -m coverage run --branch --source ema_twin_sim/ema_twin_sim/plant -m pytest -p tests.uncompiled tests/plant

What Numba would compile runs as the Python that it is written in, a thousand times slower: tests of milliseconds of
motion take seconds, and one that takes more than UNCOMPILED_SECONDS (of the environment; 60) of the processor's time is
skipped from there: what it has run counts. Records are read by their fields' names, as Numba reads them; what divides
by zero gives what Numba's code gives.
"""

import ctypes
import math
import os
import signal
from functools import wraps

import numba
import numpy as np
import pytest

_LONGEST = float(os.environ.get("UNCOMPILED_SECONDS", "60"))
_acts = []
"""Effects by what stands for their addresses: one more than their place."""


def _as_numba_reads(value):
    """A record, or an array or tuple of such, whose fields are read by their names."""
    if isinstance(value, np.ndarray) and value.dtype.names:
        return value.view(np.recarray)
    if isinstance(value, np.void) and value.dtype.names and not isinstance(value, np.record):
        place, _ = value.__array_interface__["data"]
        same = (ctypes.c_char * value.dtype.itemsize).from_address(place)  # not a copy: what is written counts
        return np.ndarray((1,), value.dtype, same).view(np.recarray)[0]
    if type(value) is tuple:
        return tuple(_as_numba_reads(one) for one in value)
    return np.float64(value) if type(value) is float else value


def _njit(*given, **options):
    def decorate(function):
        @wraps(function)
        def run(*arguments):
            with np.errstate(all="ignore"):
                return function(*map(_as_numba_reads, arguments))

        run.py_func = function
        return run

    return decorate(given[0]) if len(given) == 1 and callable(given[0]) and not options else decorate


def _call_effect(address, at, parameters):
    try:
        return _acts[int(address) - 1](at, parameters)
    except (ArithmeticError, ValueError):
        return math.nan


def _compile_effect(act, *, on_disk):
    function = getattr(act, "py_func", act)
    if function not in _acts:
        _acts.append(function)
    return _acts.index(function) + 1


numba.njit = _njit
from ema_twin_sim.plant import operating_point  # noqa: E402 - the first that reads numba

operating_point.call_effect = _call_effect
operating_point.compile_effect = _compile_effect


class TookTooLong(BaseException):
    """No test catches it."""


def _too_long(_number, frame):
    if "coverage" in frame.f_code.co_filename:  # it holds a lock, which nobody would let go
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.001)
    else:
        raise TookTooLong


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_call(item):
    """End a test that takes too long."""
    signal.signal(signal.SIGVTALRM, _too_long)
    signal.setitimer(signal.ITIMER_VIRTUAL, _LONGEST)
    outcome = yield
    signal.setitimer(signal.ITIMER_VIRTUAL, 0)
    if outcome.excinfo is not None and issubclass(outcome.excinfo[0], TookTooLong):
        outcome.force_exception(pytest.skip.Exception(f"longer than {_LONGEST:g} s without a compiler"))
