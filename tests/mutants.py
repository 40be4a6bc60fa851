"""``make mutants``: faults are put into the code that decides, one at a time; good tests notice each of them.

python -m tests.mutants [--files worth pairing …] [--sample 100] [--seed 1] [--minutes 20]

A mutant has one comparison, one `and` or `or`, one `not` or one constant changed. It is noticed where one of the tests
that run its line fails, or takes far too long. Those that nothing notices are printed, with the share of the others.

A `<` that becomes `<=` differs in nothing where the numbers are measured ones, so such mutants are counted apart.
Nothing is written to the sources: each mutant is compiled in a process of its own, in the place of its file.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import random
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from importlib.machinery import SourceFileLoader
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.child import exit_status

ROOT = Path(__file__).resolve().parents[1]
_PACKAGE = ROOT / "ema_twin_sim" / "ema_twin_sim"
_CRITERIA = _PACKAGE / "discovery" / "criteria"
_OF_FEW_ROWS = ("tests/discovery/criteria", "tests/identification/test_frozen_problem.py")
TESTS = {
    "pairing": (_PACKAGE / "live" / "pairing.py", ("tests/live/test_pairing.py",)),
    "waiting": (_PACKAGE / "live" / "waiting.py", ("tests/live/test_waiting.py",)),
    **{
        name: (_CRITERIA / f"{name}.py", _OF_FEW_ROWS)
        for name in ("contradictions", "episodes", "worth", "plausible", "own_shape", "likeness", "explained")
    },
}
"""The files that are changed, and the tests that shall notice."""
_LONGEST = 20.0
"""s of tests that a mutant gets, the shortest first, as long as they take without a fault."""
_PATIENCE = 6.0
"""times as long as without a fault a mutant's tests may take."""
_START = 15.0
"""s that these may take to start."""
_NEXT_TO = {ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt}
_OPPOSITE = {
    **{ast.Lt: ast.GtE, ast.LtE: ast.Gt, ast.Gt: ast.LtE, ast.GtE: ast.Lt},
    **{ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.Is: ast.IsNot, ast.IsNot: ast.Is},
    **{ast.In: ast.NotIn, ast.NotIn: ast.In},
}


class Mutant(NamedTuple):
    """One fault."""

    file: str  # a key of TESTS
    number: int  # of the fault in that file
    line: int
    words: str  # what it does
    edge: bool  # whether it only moves equality from one side of a comparison to the other


def faults(tree: ast.AST) -> Iterator[tuple[ast.AST, str, bool, Callable[[], None]]]:
    """(node, words, whether only equality moves, what makes the fault in the tree) of all faults, in a fixed order."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Compare):
            for k, found in enumerate(node.ops):
                for edge, table in ((True, _NEXT_TO), (False, _OPPOSITE)):
                    if type(found) in table:
                        other = table[type(found)]()
                        words = f"{type(found).__name__} becomes {type(other).__name__}"
                        yield node, words, edge, lambda n=node, k=k, o=other: n.ops.__setitem__(k, o)
        elif isinstance(node, ast.BoolOp):
            other = ast.Or() if isinstance(node.op, ast.And) else ast.And()
            words = f"{type(node.op).__name__} becomes {type(other).__name__}"
            yield node, words, False, lambda n=node, o=other: setattr(n, "op", o)
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            yield node, "not is left out", False, lambda n=node: setattr(n, "op", ast.UAdd())
        elif isinstance(node, ast.Constant) and isinstance(node.value, int | float):
            value = node.value
            other = value + 1 if isinstance(value, int) else 2.0 * value or 1.0
            other = not value if isinstance(value, bool) else other
            yield node, f"{value} becomes {other}", False, lambda n=node, o=other: setattr(n, "value", o)


def mutants(name: str) -> list[Mutant]:
    """All mutants of a file."""
    tree = ast.parse(TESTS[name][0].read_text())
    return [Mutant(name, k, node.lineno, words, edge) for k, (node, words, edge, _) in enumerate(faults(tree))]


def bodies(path: Path) -> list[range]:
    """The lines of each function's body."""
    every = ast.walk(ast.parse(path.read_text()))
    return [range(node.body[0].lineno, node.end_lineno + 1) for node in every if isinstance(node, ast.FunctionDef)]


def put_in(mutant: Mutant) -> None:
    """Let this process import the mutant in the place of its file."""
    path = TESTS[mutant.file][0]
    tree = ast.parse(path.read_text())
    [make for *_, make in faults(tree)][mutant.number]()
    plain = SourceFileLoader.get_code

    def get_code(loader, name):
        if Path(loader.path) == path:
            return compile(tree, path, "exec")
        return plain(loader, name)

    SourceFileLoader.get_code = get_code


class Watch:
    """A plugin of pytest that tells which lines of some files each test runs, and how long it takes [s]."""

    def __init__(self, files: Sequence[Path]) -> None:
        self._lines = {str(file): set() for file in files}
        self.ran: dict[str, tuple[float, dict[str, list[int]]]] = {}

    @pytest.hookimpl(hookwrapper=True)
    def pytest_runtest_protocol(self, item):
        for lines in self._lines.values():
            lines.clear()
        begun = time.monotonic()
        sys.settrace(self._called)
        yield
        sys.settrace(None)
        ran = {file: sorted(lines) for file, lines in self._lines.items() if lines}
        self.ran[item.nodeid] = time.monotonic() - begun, ran

    def _called(self, frame, event, argument):
        lines = self._lines.get(frame.f_code.co_filename)
        if lines is None:
            return None

        def ran(frame, event, argument):
            lines.add(frame.f_lineno)
            return ran

        return ran(frame, event, argument)


def in_a_child(work: Callable[[], int], longest: float) -> int | None:
    """The exit status of what a child of this process does silently; None where it took longer than so many s."""
    child = os.fork()
    if child == 0:
        os.setpgid(0, 0)
        silence = os.open(os.devnull, os.O_RDWR)
        for number in (0, 1, 2):
            os.dup2(silence, number)
        status = 99
        try:
            status = int(work())
        finally:
            os._exit(status)
    return exit_status(child, longest)


def run_tests(tests: Sequence[str], *plugins: object) -> int:
    """The exit status of pytest, which stops at the first test that fails."""
    options = ["-x", "-q", "-p", "no:cacheprovider", "-m", "not slow", "-p", "no:xdist", "-p", "no:benchmark"]
    return pytest.main([*options, *tests], plugins=list(plugins))


def lines_of_tests(name: str) -> dict[str, tuple[float, dict[str, list[int]]]]:
    """Of each test: how long it takes [s], and which lines of which files it runs.

    Raises RuntimeError where one fails.
    """
    files = [path for path, tests in TESTS.values() if tests == TESTS[name][1]]
    with tempfile.TemporaryDirectory() as folder:
        told = Path(folder) / "ran.json"

        def work() -> int:
            watch = Watch(files)
            status = run_tests(TESTS[name][1], watch)
            told.write_text(json.dumps(watch.ran))
            return status

        if status := in_a_child(work, 3600.0):
            raise RuntimeError(f"tests of {name}: pytest ends with {status} without a fault")
        return json.loads(told.read_text())


def is_noticed(mutant: Mutant, ran: dict[str, tuple[float, dict[str, list[int]]]]) -> bool:
    """Whether a test that runs the mutant's line fails; of those at most _LONGEST s, or one.

    What no function holds is run as the file is read, whatever is tested. What no test runs, none notices.
    """
    file = str(TESTS[mutant.file][0])
    always = not any(mutant.line in body for body in bodies(Path(file)))
    chosen, total = [], 0.0
    for test, (seconds, lines) in sorted(ran.items(), key=lambda one: one[1][0]):
        runs = file in lines if always else mutant.line in lines.get(file, ())
        if runs and (not chosen or total + seconds <= _LONGEST):
            chosen.append(test)
            total += seconds

    def work() -> int:
        put_in(mutant)
        return run_tests(chosen)

    return bool(chosen) and in_a_child(work, _PATIENCE * total + _START) != 0


def main() -> int:
    """Make the mutants that are asked for and print what is noticed."""
    parser = argparse.ArgumentParser(prog="make mutants", description=__doc__.partition("\n")[0])
    parser.add_argument("--files", nargs="+", default=list(TESTS), choices=list(TESTS), help="what is changed")
    parser.add_argument("--sample", type=int, default=100, help="mutants, drawn of all")
    parser.add_argument("--seed", type=int, default=1, help="of the draw")
    parser.add_argument("--minutes", type=float, default=20.0, help="after which no further mutant is tried")
    asked = parser.parse_args()
    every = [mutant for name in asked.files for mutant in mutants(name)]
    drawn = random.Random(asked.seed).sample(every, min(asked.sample, len(every)))
    os.chdir(ROOT)
    import numba  # noqa: F401 - read once, not by each child
    import scipy.optimize  # noqa: F401

    import ema_twin_sim.fitting.fit
    import ema_twin_sim.simulation.virtual_bench  # noqa: F401

    assert not any(str(TESTS[name][0]) == getattr(module, "__file__", "")
                   for name in TESTS for module in [*sys.modules.values()])  # fmt: skip
    ran: dict[tuple[str, ...], dict[str, tuple[float, dict[str, list[int]]]]] = {}
    begun, counts = time.monotonic(), {False: [0, 0], True: [0, 0]}
    for mutant in drawn:
        tests = TESTS[mutant.file][1]
        if tests not in ran:
            ran[tests] = lines_of_tests(mutant.file)
            print(f"{len(ran[tests])} tests in {sum(s for s, _ in ran[tests].values()):.0f} s", flush=True)
        if time.monotonic() - begun > 60.0 * asked.minutes:
            break
        noticed = is_noticed(mutant, ran[tests])
        counts[mutant.edge][0] += noticed
        counts[mutant.edge][1] += 1
        if not noticed:
            edge = " (equality)" if mutant.edge else ""
            print(f"not noticed: {mutant.file}.py line {mutant.line}: {mutant.words}{edge}", flush=True)
    (other, others), (edge, edges) = counts[False], counts[True]
    print(f"{len(every)} mutants, {others + edges} tried: noticed {other} of {others}, and {edge} of {edges} that only "
          f"move equality")  # fmt: skip
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
