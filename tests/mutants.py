"""``make mutants``: faults are put into the code that decides, one at a time; a good test notices each of them.

python -m tests.mutants [--files pairing worth …] [--sample 100] [--seed 1] [--minutes 20]

A mutant has one comparison, one `and` or `or`, one `not`, one sign of a sum or one number changed. It is noticed where a test fails or
takes ten times as long as it should. Prints those that no test notices, and the share of the others. Nothing is written: each
mutant lives in a process of its own, which compiles it in the place of the file.
"""

from __future__ import annotations

import argparse
import ast
import copy
import importlib
import os
import random
import signal
import sys
import time
from collections.abc import Iterator
from importlib.machinery import SourceFileLoader
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
_PACKAGE = ROOT / "ema_twin_sim" / "ema_twin_sim"
_CRITERIA = (
    "tests/discovery/test_criteria_of_few_rows.py",
    "tests/words/test_contradictions.py",
    "tests/discovery/test_own_shape.py",
    "tests/identification/test_frozen_problem.py",
    "tests/discovery/test_likeness.py",
    "tests/discovery/test_discovery_edges.py",
    "tests/discovery/test_discovery_plausible.py",
)
TESTS = {
    **{f"discovery/criteria/{name}.py": _CRITERIA
       for name in ("contradictions", "episodes", "explained", "likeness", "own_shape", "plausible", "worth")},
    "live/pairing.py": ("tests/live/test_pairing.py",),
}  # fmt: skip
"""The files that are changed, and the tests that shall notice."""
_PATIENCE = 10.0
"""times what the tests take without a fault."""
_COMPARED = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
}  # fmt: skip
_TURNED = {ast.Lt: ast.GtE, ast.LtE: ast.Gt, ast.Gt: ast.LtE, ast.GtE: ast.Lt}
_SIGNS = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult}
