"""Commands of the virtual bench and of a standalone twin: ramp, step, sine, triangle, or a file of points.

A YAML file (``ema-twin plan`` writes one) holds a command and how long to record it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import yaml

from ema_bench_replay.checked_yaml import Checker, read_yaml
from ema_bench_replay.errors import InputError
from ema_bench_replay.units import unit_in

from ..listing import number_of

_SHAPES = {
    "ramp": ("rad/s or m/s", None),
    "sine": ("rad or m", "Hz"),
    "triangle": ("rad/s or m/s", "s (half period)"),
    "step": ("rad or m", "s (half period)"),
}
_FORMS = {
    "ramp": "ramp:SPEED",
    "sine": "sine:SIZE:HZ",
    "triangle": "triangle:SPEED:HALF_PERIOD_S",
    "step": "step:SIZE:HALF_PERIOD_S",
}
FORMS = (
    f"{', '.join(_FORMS.values())} (rad and rad/s; m and m/s of a linear machine), prefix speed- for a speed command, "
    "a CSV file of time [s], position [rad or m], or a YAML file that plan wrote"
)
_WORDS = {
    "ramp": "a ramp of {0:g} {unit}/s",
    "sine": "a sine of ±{0:g} {unit} at {1:g} Hz",
    "triangle": "a triangle of ±{0:g} {unit}/s that turns every {1:g} s",
    "step": "steps between 0 and {0:g} {unit} every {1:g} s",
}

LARGEST = 1e6
"""Largest command: rad or rad/s (m or m/s) of the output, and Hz or s of a shape."""


@dataclass(frozen=True)
class Command:
    """A command of the output: position [rad] over time [s], or speed [rad/s] if ``speed``; m and m/s if it is linear.

    Calling it with times (n,) gives values (n,).
    """

    text: str
    speed: bool
    function: Callable[[np.ndarray], np.ndarray]
    seconds: float | None = None
    """Intended recording time, if its file gives one."""
    frequency: float = 0.0
    """Repetitions per second [Hz]; 0 if it does not repeat."""

    @property
    def name(self) -> str:
        """Stem of a file name for it: ``ramp_0.05``."""
        return re.sub(r"[^\w.+-]+", "_", Path(self.text).stem if self.text.endswith(".csv") else self.text)

    def __call__(self, time: np.ndarray) -> np.ndarray:
        """Values (n,) at times [s] (n,). Raises InputError if one is larger than LARGEST."""
        with np.errstate(all="ignore"):  # overflow is refused below
            values = self.function(np.asarray(time, np.float64))
        if not np.all(np.abs(values) <= LARGEST):
            unit = "rad/s or m/s" if self.speed else "rad or m"
            raise InputError(
                f"command '{self.text}': grows beyond {LARGEST:g} {unit}; give a smaller one, or less time"
            )
        return values

    def highest_speed(self, time: np.ndarray) -> float:
        """The highest commanded speed [rad/s] at times [s] (n,); position jumps do not count."""
        values = self(time)
        if not self.speed:
            rates = np.abs(np.diff(values) / np.diff(time))
            values = np.minimum(rates[1:], rates[:-1])
        return float(np.abs(values).max(initial=0.0))


def parse_command(text: str, *, start: float = 0.0, phase: float = 0.0) -> Command:
    """The command given by ``KIND:A[:B]`` or a file, shifted by ``start`` [rad or rad/s] and ``phase`` [rad].

    Raises InputError if the text is not a command.
    """
    kind, *numbers = text.split(":")
    speed = kind.startswith("speed-")
    shape = kind.removeprefix("speed-")
    if shape not in _SHAPES:
        if Path(text).suffix.lower() in (".yaml", ".yml"):
            return _from_yaml(Path(text), start, phase)
        if Path(text).suffix.lower() == ".csv" or Path(text).exists():
            return Command(text, False, _from_file(Path(text), start))
        raise InputError(f"command '{text}': unknown kind '{kind}'; give {FORMS}")
    units = [unit for unit in _SHAPES[shape] if unit]
    rotary, linear = units[0].split(" or ")
    per_second = ("/s" if "/" not in rotary else "²") if speed else ""
    form = (
        f"{'speed-' if speed else ''}{_FORMS[shape]}, the first number in {rotary}{per_second} "
        f"({linear}{per_second} if the machine is linear)"
    )
    if len(numbers) != len(units):
        raise InputError(f"command '{text}': {shape} takes {number_of(len(units), 'number')}; give {form}")
    try:
        values = [float(number) for number in numbers]
    except ValueError:
        raise InputError(f"command '{text}': '{':'.join(numbers)}' is no number; give {form}") from None
    if not all(abs(value) <= LARGEST for value in values) or (len(values) == 2 and values[1] <= 0.0):
        raise InputError(
            f"command '{text}': numbers must be up to {LARGEST:g}, frequency and half period positive; give {form}"
        )
    frequency = 0.0 if shape == "ramp" else values[1] if shape == "sine" else 0.5 / values[1]
    return Command(text, speed, _shape(shape, values, start, phase), frequency=frequency)


def _shape(shape: str, values: list[float], start: float, phase: float) -> Callable[[np.ndarray], np.ndarray]:
    size = values[0]
    if shape == "ramp":
        return lambda t: start + size * t
    if shape == "sine":
        omega = 2.0 * math.pi * values[1]
        return lambda t: start + size * (np.sin(omega * t + phase) - math.sin(phase))
    half = values[1]
    shift = phase / math.pi * half

    def triangle(t: np.ndarray) -> np.ndarray:
        within = np.mod(t + shift, 2.0 * half)
        return size * np.where(within < half, within, 2.0 * half - within)

    if shape == "triangle":
        return lambda t: start + triangle(t) - triangle(np.zeros(1))
    return lambda t: start + size * (np.mod(t + shift, 2.0 * half) < half)


def in_words(text: str, motion: str = "rotary") -> str:
    """``KIND:A[:B]`` in words: ``position: a triangle of ±0.04 rad/s that turns every 2 s``; m/s if linear."""
    kind, *numbers = parse_command(text).text.split(":")
    speed = kind.startswith("speed-")
    shape, values = kind.removeprefix("speed-"), [*map(float, numbers)]
    if "±" in _WORDS[shape]:  # a negative size only begins the other way
        values[0] = abs(values[0])
    words = _WORDS[shape].format(*values, unit=unit_in("rad/s" if speed else "rad", motion))
    return f"{'speed' if speed else 'position'} of the output: {words.replace('/s/s', '/s²')}"


def write_command(text: str, seconds: float, why: str, motion: str = "rotary") -> bytes:
    """A YAML file for ``parse_command``, for a command to be recorded for ``seconds`` s."""
    content = {"version": 1, "command": text, "seconds": seconds, "why": why}
    head = f"# {in_words(text, motion)}\n"
    return (head + yaml.safe_dump(content, sort_keys=False, allow_unicode=True, width=120)).encode()


def _from_yaml(path: Path, start: float, phase: float) -> Command:
    """The command in a YAML file: ``{version: 1, command, seconds, why}``, the last two optional."""
    content, _ = read_yaml(path, "give a YAML file that plan wrote, or KIND:A[:B]")
    check = Checker(path)
    table = check.mapping(content, "", ("version", "command", "seconds", "why"), ("version", "command"))
    check.choice(table["version"], "version", (1,))
    text = check.text(table["command"], "command")
    if text.partition(":")[0].removeprefix("speed-") not in _SHAPES:
        raise check.error("command", f"'{text}' is no command", f"give {FORMS.partition(', a CSV')[0]}")
    seconds = check.number(table["seconds"], "seconds", 0.0) if "seconds" in table else None
    try:
        return replace(parse_command(text, start=start, phase=phase), seconds=seconds)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _from_file(path: Path, start: float) -> Callable[[np.ndarray], np.ndarray]:
    """Points from a file, one line each with time [s] and value [rad or m]; interpolated linearly."""
    points: list[tuple[float, float]] = []
    try:
        lines = path.read_text("utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(
            f"{path}: cannot be read as a command ({error}); give a text file of time,value lines"
        ) from None
    for number, line in enumerate(lines, 1):
        fields = [field for field in re.split(r"[;,\s]+", line.split("#")[0].strip()) if field]
        if not fields or (number == 1 and not re.match(r"[-+.\d]", fields[0])):
            continue
        try:
            time, value = map(float, fields)
        except ValueError:
            raise InputError(
                f"{path}:{number}: '{line.strip()}' is not time [s], position [rad or m]; mend the line"
            ) from None
        if not (math.isfinite(time) and math.isfinite(value)) or (points and time <= points[-1][0]):
            raise InputError(f"{path}:{number}: time must grow and numbers be finite; mend the line")
        points.append((time, value))
    if len(points) < 2:
        raise InputError(
            f"{path}: holds {number_of(len(points), 'point')}; a command needs at least two lines of time,value"
        )
    times, values = np.array(points).T
    return lambda t: start + np.interp(t, times, values)
