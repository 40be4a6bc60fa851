"""Sweeps: simulate models with other numbers, search them as if these were unknown, and compute the bounds."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timezone
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.stats import qmc

from ema_bench_replay.errors import InputError
from ema_bench_replay.recording import Recording

from ..effects import catalogue
from ..model import Model, load_model
from ..model.constants import CONSTANTS
from ..model.model import nearest
from ..model.model_file import model_files
from ..model.own_units import model_in, shown_entry
from ..simulation.command import parse_command
from ..simulation.virtual_bench import virtual_bench
from .campaign import stored
from .engine import Outcome
from .jobs import Job
from .results import DONE
from .work import Row, blank, discovered, errors_told_in

if TYPE_CHECKING:
    from distributed import Client

VERB = "sweep"
UNIT = "sweep"
"""The unit name of a sweep's points in the store."""


MOST_POINTS = 1_000_000
"""About a day's work of all cores."""


@dataclass(frozen=True)
class Varied:
    """A number and its values: ``count`` of them from ``low`` to ``high``, evenly or logarithmically spaced."""

    path: str  # OWNER.NUMBER: of the model's effects, of the catalogue's, or a constant
    low: float
    high: float
    count: int
    logarithmic: bool = False

    @classmethod
    def of(cls, text: str) -> Varied:
        """From ``PATH=LOW:HIGH:COUNT[:log]`` or ``PATH=VALUE``. Raises InputError for anything else."""
        path, _, values = text.partition("=")
        parts = values.split(":")
        logarithmic = len(parts) == 4 and parts[3] == "log"
        try:
            low, high, count = (float(parts[0]), float(parts[0]), 1) if len(parts) == 1 else (
                float(parts[0]), float(parts[1]), int(parts[2]))  # fmt: skip
        except (ValueError, IndexError):
            low, high, count = np.nan, np.nan, 0
        fits = len(parts) in (1, 3) or logarithmic
        if not fits or "." not in path or not np.isfinite([low, high]).all() or low > high or count < 1:
            raise InputError(
                f"--vary {text}: write it like backlash.width=0.0005:0.004:8; append :log for logarithmic spacing"
            )
        if logarithmic and low <= 0.0:
            raise InputError(f"--vary {text}: logarithmic spacing cannot begin at {low:g}; begin above zero")
        return cls(path, low, high, count, logarithmic)

    def at(self, shares: np.ndarray) -> np.ndarray:
        """Values (n,) at fractions (n,) of the way from low to high."""
        if self.logarithmic:
            return np.asarray(self.low * (self.high / self.low) ** shares)
        return self.low + (self.high - self.low) * shares


@dataclass(frozen=True)
class Study:
    """What is done with every point: it is simulated with each command, and searched with a model."""

    model: str
    commands: tuple[str, ...]
    seconds: float
    search: bool = True  # whether to look for what is missing; else only the bounds are computed

    def identity(self) -> str:
        """Text that identifies this study; a model counts by its content."""
        content = [hashlib.blake2b(file.read_bytes()).hexdigest() for file in model_files(self.model)]
        return json.dumps([VERB, content, self.commands, self.seconds, self.search])


@dataclass(frozen=True)
class Point(Job):
    """One model to simulate: the numbers to set in it, and the seed of the sensors' noise."""

    settings: tuple[tuple[str, float], ...] = ()
    seed: int = 0


def grid(varied: Sequence[Varied], study: Study, repeats: int) -> list[Point]:
    """All combinations, each with ``repeats`` seeds. Raises InputError if there are more than MOST_POINTS."""
    _refuse_many(math.prod(one.count for one in varied) * repeats)
    axes = [one.at(np.linspace(0.0, 1.0, one.count)) for one in varied]
    return _points(varied, list(itertools.product(*axes)), study, repeats)


def sample(varied: Sequence[Varied], study: Study, number: int, seed: int, repeats: int) -> list[Point]:
    """``number`` combinations of a Latin hypercube, each with ``repeats`` seeds.

    Raises InputError if there are more than MOST_POINTS.
    """
    _refuse_many(number * repeats)
    shares = qmc.LatinHypercube(len(varied), rng=np.random.default_rng(seed)).random(number)
    columns = [one.at(shares[:, k]) for k, one in enumerate(varied)]
    return _points(varied, list(zip(*columns, strict=True)), study, repeats)


def _refuse_many(points: int) -> None:
    if points > MOST_POINTS:
        raise InputError(f"sweep: these are more than {MOST_POINTS:.0e} points; vary fewer values")


def _points(varied: Sequence[Varied], values: Sequence[Sequence[float]], study: Study, repeats: int) -> list[Point]:
    identity = study.identity()
    found = []
    for of in values:
        settings = tuple((one.path, float(value)) for one, value in zip(varied, of, strict=True))
        for seed in range(repeats):
            key = hashlib.blake2b(json.dumps([identity, settings, seed]).encode(), digest_size=16).hexdigest()
            told = ", ".join(f"{path} {value:.6g}" for path, value in settings)
            # with the key, since points of another study in the same results may have the same numbers
            name = f"{told}, seed {seed} ({key[:8]})"
            found.append(Point(key, UNIT, name, (), settings=settings, seed=seed))
    return found


def with_settings(model: Model, settings: Sequence[tuple[str, float]]) -> tuple[Model, dict[str, dict[str, float]]]:
    """The model with these numbers set, and the effects that it lacked (by id, with their numbers).

    Raises InputError if a path is unknown, or a number out of range.
    """
    lacked: dict[str, dict[str, float]] = {}
    for path, value in settings:
        owner, _, name = path.partition(".")
        if owner in model.effects:
            model = model.with_value(f"effects.{path}", value)
        elif path in CONSTANTS:
            model = model.with_value(path, value)
        elif owner in catalogue():
            lacked.setdefault(owner, {})[name] = value
        else:
            known = [
                f"{id}.{one.name}"
                for id, effect in catalogue().items()
                for one in effect.parameters_with(effect.default_options())
            ]
            raise InputError(f"--vary {path}: unknown parameter of this model; {nearest(path, (*CONSTANTS, *known))}")
    for id, numbers in lacked.items():
        model = model.with_effect(id, numbers)
    return model, lacked


def sweep(client: Client, points: Sequence[Point], study: Study, store: Path) -> Iterator[Outcome]:
    """Yield the outcomes of points as they finish; their rows are in the store."""
    nothing = partial(blank, verb=VERB, model=study.model)
    yield from stored(client, points, store, partial(_rows, study=study), nothing)


def _rows(point: Point, study: Study, tell: Callable[[str], None]) -> list[Row]:
    return [swept(point, study)]


def swept(point: Point, study: Study) -> Row:
    """The row of a point: the effects that a search names, its estimates, and the bounds of their errors."""
    begun = time.perf_counter()
    row = blank(point, VERB, study.model)
    with errors_told_in(row):
        model = load_model(study.model)
        true, lacked = with_settings(model, point.settings)
        row["settings"] = [{"path": path, "value": value, "unit": _unit(true, path)} for path, value in point.settings]
        row["lacked"] = [*lacked]
        recordings = [
            virtual_bench(true, parse_command(command), study.seconds, seed=1000 * point.seed + k, name=f"{k}")
            for k, command in enumerate(study.commands)
        ]
        row |= {
            "duration": sum(recording.duration for recording in recordings),
            "samples": sum(len(recording) for recording in recordings),
            "motion": model.motion,
            "bounds": bounds(recordings, model, true, lacked),
        }
        if study.search:
            row |= discovered(recordings, model)
        row["status"] = DONE
    return row | {"seconds": time.perf_counter() - begun, "done_at": datetime.now(timezone.utc)}


def bounds(
    recordings: Sequence[Recording], model: Model, true: Model, lacked: Mapping[str, Mapping[str, float]]
) -> list[dict[str, Any]]:
    """Each free number of the true model, with the Cramér-Rao bound of its standard error, in SI units.

    The numbers are those of the search: the parameters of the effects that the model lacked, inertia and friction.
    """
    from ..discovery.search.adding import settle
    from ..identification.cramer_rao import cramer_rao
    from ..identification.equation import EquationErrorProblem
    from ..identification.estimates import constants, standard_errors
    from ..identification.fit import fit
    from ..identification.null_hypothesis import null_hypothesis
    from ..measured.observe import observe_all
    from ..measured.scales import to_own_units

    given, own = to_own_units(recordings, model)
    problem = EquationErrorProblem(observe_all(list(given), own))
    hypothesis = null_hypothesis(own)
    assert own.units is not None  # own units were asked for
    for id, instance in model_in(true, own.units).effects.items():
        if id in lacked:
            hypothesis = hypothesis.with_effect(id, instance.options, instance.parameters)
    f = settle(fit(problem, hypothesis))
    sure = standard_errors(f.problem, f, cramer_rao(f.problem, f))
    found = []
    for id in lacked:
        for p in catalogue()[id].parameters:
            std = sure.get(f"effects.{id}.{p.name}")
            if std is not None:
                told = shown_entry(own, 0.0, std, p.unit, angle=p.periodic)
                value = true.effects[id].parameters[p.name]
                found.append({"owner": id, "name": p.name, "value": value, "std": told["std"], "unit": told["unit"]})
    for owner, numbers in constants(f, sure, true).items():
        of_effect: Mapping[str, Any] = true.effects[owner].parameters if owner in true.effects else {}
        for name, of in numbers.items():
            value = of_effect.get(name, of["nominal"])
            found.append({"owner": owner, "name": name, "value": value, "std": of["std"], "unit": of["unit"]})
    return found


def _unit(model: Model, path: str) -> str:
    owner, _, name = path.partition(".")
    if owner not in model.effects:
        return model.unit(path)
    return model.parameter_unit(model.effects[owner].effect, name)
