"""Machine code that Numba keeps: under the content of its sources, and loaded without the compiler."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from ema_twin_sim.identification.encoder_offsets import remove_offsets
from ema_twin_sim.plant import machine_code

LOADED = """
import sys
import numpy as np
from numba import njit
import ema_twin_sim.discovery.discover
from ema_twin_sim.identification.encoder_offsets import remove_offsets

rows = np.array([1.0, 5.0, 6.0, 8.0])
remove_offsets(rows, np.array([[1, 4]]), 1, np.ones(3), np.full(4, 1e9))
print(rows.round(6).tolist())
print([name for name in ("numba.np.linalg", "numba.np.arraymath", "scipy.linalg") if name in sys.modules])

@njit
def total(values):
    return np.sum(values * 2.0)

print(total(rows))
"""


def test_code_that_is_kept_is_kept_under_the_content_of_its_sources():
    """Whatever numba keeps on disk is in the plant, is an effect (kept under its own content), or is named there."""
    package = Path(machine_code.__file__).parent.parent
    kept = {
        str(file.relative_to(package)) for file in package.rglob("*.py") if re.search(r"\bcache=True", file.read_text())
    }
    outside = {name for name in kept if not name.startswith(("plant/", "effects/"))}
    assert outside <= {*machine_code.COMPILED_OUTSIDE}
    assert all((package / name).is_file() for name in machine_code.COMPILED_OUTSIDE)


def test_kept_code_is_loaded_without_the_compiler_which_is_there_when_it_is_needed():
    def lines():
        ran = subprocess.run([sys.executable, "-c", LOADED], capture_output=True, text=True, check=True)
        return ran.stdout.splitlines()

    lines()  # compiles what is not kept yet
    offsets, loaded, compiled = lines()
    assert offsets == "[1.0, -1.333333, -0.333333, 1.666667]"
    assert loaded == "[]"
    assert float(compiled) == pytest.approx(2.0)


def test_offsets_begin_at_the_median_of_any_number_of_rows():
    rng = np.random.default_rng(4)
    for count in (1, 2, 3, 8, 257, 1000):
        rows = np.concatenate([rng.normal(size=3), np.round(rng.standard_cauchy(count), 1)])  # with equal values
        noise, scale = rng.uniform(0.5, 2.0, count), np.full(count + 3, 1e-6)
        part = rows[3:] - np.median(rows[3:] * noise) / noise
        weights = 1.0 / (1.0 + (part / 1e-6) ** 2) / noise
        expected = part - (weights @ part) / (weights @ (1.0 / noise)) / noise
        remove_offsets(rows, np.array([[3, count + 3]]), 3, noise, scale)
        np.testing.assert_allclose(rows[3:], expected, rtol=1e-12, atol=1e-9)
