"""Machine code that Numba keeps: under the content of its sources, and loaded without the compiler."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from numba.core import caching

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
OF_OTHERS = """
import ema_twin_sim.plant
from numba import vectorize

@vectorize(["float64(float64)"], cache=True)
def twice(x):
    return 2.0 * x

print(twice(3.0))
"""


def lines_of(program):
    """What a Python file prints in its second process, where all that it keeps is kept."""
    for _ in range(2):
        ran = subprocess.run([sys.executable, str(program)], capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
    return ran.stdout.splitlines()


@pytest.mark.slow
def test_kept_code_is_loaded_without_the_compiler_which_is_there_when_it_is_needed(tmp_path):
    program = tmp_path / "loaded.py"
    program.write_text(LOADED)
    offsets, loaded, compiled = lines_of(program)
    assert offsets == "[1.0, -1.333333, -0.333333, 1.666667]"
    assert loaded == "[]"
    assert float(compiled) == pytest.approx(2.0)


@pytest.mark.slow
def test_kept_code_of_others_is_loaded_as_ever(tmp_path):
    program = tmp_path / "of_others.py"
    program.write_text(OF_OTHERS)
    assert lines_of(program) == ["6.0"]


def test_numba_loads_kept_code_in_the_steps_that_are_known():
    """If this fails, Numba has changed: look at its ``load_overload``, then at ``machine_code``."""
    assert caching.Cache.load_overload.__qualname__.startswith("load_without_compiler")


def test_kept_code_is_kept_under_the_content_of_its_sources(tmp_path, monkeypatch):
    package = Path(machine_code.__file__).parent.parent
    for name in ("plant", "identification", "measured"):
        shutil.copytree(package / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(machine_code, "__file__", str(tmp_path / "plant" / "machine_code.py"))
    folders = {machine_code.folder()}
    for edited in ("plant/kernel.py", machine_code.COMPILED_OUTSIDE[0]):
        source = tmp_path / edited
        source.write_text(source.read_text() + "# edited")
        folders.add(machine_code.folder())
    assert len(folders) == 3


def test_all_that_is_kept_is_part_of_that_content():
    """Whatever numba keeps on disk is in the plant, is an effect (kept under its own content), or is named there."""
    package = Path(machine_code.__file__).parent.parent
    kept = {
        str(file.relative_to(package)) for file in package.rglob("*.py") if re.search(r"\bcache=True", file.read_text())
    }
    outside = {name for name in kept if not name.startswith(("plant/", "effects/"))}
    assert outside <= {*machine_code.COMPILED_OUTSIDE}
    assert all((package / name).is_file() for name in machine_code.COMPILED_OUTSIDE)
