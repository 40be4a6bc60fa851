"""Strangers' cases: a servo drawn from a seed, what it hides, and its recordings as CSV in somebody's own words."""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from .servo import BEHIND_THE_GEAR, HIDDEN, Run, Servo, run
from .words import BESIDE, QUANTITY, UNITS, named, spelt, with_unit

BUS = 600.0
"""V, more than which no drive has: what a motor induces at its top speed."""

MISTAKES = ("mA as A", "current turned", "deg as rad", "rpm as rad/s", "ms as s", "speed turned", "A as mA")
"""What a header may say wrongly, or a wire be wrong in."""

PLAIN = {
    "time": "time [s]",
    "motor_position": "motor position [rad]",
    "output_position": "output position [rad]",
    "speed": "motor speed [rad/s]",
    "speed_setpoint": "speed setpoint [rad/s]",
    "current": "current [A]",
    "motor_torque": "motor torque [Nm]",
}
"""The names and units of the tutorial."""


@dataclass(frozen=True)
class Stranger:
    """One case: a servo, how it was recorded, and how it is told."""

    name: str
    seed: tuple[int, ...]
    servo: Servo
    period: float  # s
    seconds: float
    signals: tuple[str, ...]
    language: str
    mistake: str = ""
    plain: bool = False  # told in the tutorial's words
    knows: tuple[str, ...] = ()  # what the data sheet tells: torque_constant, gear_ratio
    alone: int | None = None  # of the three recordings, the only one that is there

    @property
    def hidden(self) -> tuple[str, ...]:
        """Ids of the effects that the drafted model cannot have."""
        return tuple(self.servo.hidden)

    @property
    def besides(self) -> tuple[str, ...]:
        """What is there as well, and right if it is named."""
        return ()

    @property
    def constants(self) -> dict[str, float]:
        """True inertia and friction, as they are told; without a torque constant, a torque is told in amperes."""
        servo = self.servo
        amperes = "current" in self.signals and "torque_constant" not in self.knows
        told = 1.0 / servo.torque_constant if amperes else 1.0
        return {"inertia": servo.inertia * told, "coefficient": servo.viscous * told, "torque": servo.dry * told}

    @property
    def options(self) -> list[str]:
        """What a person adds to ``init`` from the data sheet."""
        told = {"torque_constant": self.servo.torque_constant, "gear_ratio": self.servo.ratio}
        return [word for name in self.knows for word in (f"--{name.replace('_', '-')}", f"{told[name]:.6g}")]

    def write(self, folder: Path) -> list[Path]:
        """Its recordings as CSV, three if it is not ``alone``, and ``answer.json`` beside them."""
        folder.mkdir(parents=True, exist_ok=True)
        random = np.random.default_rng((*self.seed, 2))
        told = _Told(self, random)
        files = []
        for number, setpoint in enumerate(self._setpoints()):
            if self.alone not in (None, number):
                continue
            true = run(self.servo, setpoint, self.period, origin=0.4)
            files.append(folder / f"{self.name}_{number}.csv")
            files[-1].write_text(told.text(true, random), "utf-8")
        answer = {"hidden": self.servo.hidden, "mistake": self.mistake, "options": self.options}
        (folder / "answer.json").write_text(json.dumps(answer, indent=1), "utf-8")
        return files

    def _setpoints(self) -> Sequence[np.ndarray]:
        """Speeds (n,) [rad/s]: far and back, two sines, and slowly to and fro."""
        random = np.random.default_rng((*self.seed, 1))
        time = np.arange(round(self.seconds / self.period)) * self.period
        top, whole = self.servo.top_speed, self.seconds
        far = np.interp(time / whole, (0.0, 0.05, 0.12, 0.45, 0.6, 0.9, 0.97, 1.0), (0, 0, 0.6, 0.6, -0.5, -0.5, 0, 0))
        slow, quick = random.uniform(0.6, 1.2), random.uniform(2.0, 4.0)
        sines = 0.2 * np.sin(2.0 * math.pi * slow * time) + 0.1 * np.sin(2.0 * math.pi * quick * time)
        turns = time / whole * random.integers(2, 5)
        creep = 0.08 * (4.0 * np.abs(np.mod(turns + 0.25, 1.0) - 0.5) - 1.0)
        return [top * far, top * sines, top * creep]


class _Told:
    """How one person's logger writes what is true."""

    def __init__(self, case: Stranger, random: np.random.Generator) -> None:
        self.case = case
        german = case.language == "german" and not case.plain
        self.delimiter, self.comma = (";", True) if german else (str(random.choice([",", ";", "\t"])), False)
        self.place = str(random.choice(["[]", "()", "/", "tight", "in", "," if self.delimiter != "," else "()", "_"]))
        self.units = {name: self._unit(name, random) for name in ("time", *case.signals)}
        self.header = [self._name(name, random) for name in ("time", *case.signals)]
        beside = [] if case.plain else list(random.choice(list(BESIDE), random.integers(0, 4), replace=False))
        self.beside = [str(name) for name in beside]
        self.order = random.permutation(len(self.header) - 1) + 1
        # of a counter per turn of either shaft
        self.counts = {"motor": float(2 ** random.integers(12, 19)), "output": float(2 ** random.integers(17, 22))}
        self.start = float(random.uniform(-3.0, 3.0)), float(random.uniform(-1.0, 1.0))

    def _unit(self, signal: str, random: np.random.Generator) -> str:
        units = list(UNITS[QUANTITY[signal]])
        wrong = {"deg as rad": "position", "rpm as rad/s": "speed", "ms as s": "time"}.get(self.case.mistake)
        misread = wrong == QUANTITY[signal] or ("A" in self.case.mistake and signal == "current")
        return units[0] if self.case.plain or misread else str(random.choice(units))

    def _name(self, signal: str, random: np.random.Generator) -> str:
        if self.case.plain:
            return PLAIN[signal]
        name = named(signal, self.case.language, random)
        unit = "mA" if self.case.mistake == "A as mA" and signal == "current" else self.units[signal]
        return with_unit(name, spelt(unit, QUANTITY[signal], self.case.language, random), self.place)

    def text(self, true: Run, random: np.random.Generator) -> str:
        """The CSV of a run."""
        count = len(true.time)
        servo = self.case.servo
        values = {
            "time": true.time,
            "motor_position": self._counted("motor", true.motor + self.start[0], random),
            "output_position": self._counted("output", true.output + self.start[1], random),
            "speed": true.speed + random.normal(0.0, 3e-4 * servo.top_speed, count),
            "speed_setpoint": true.setpoint,
            "current": true.current + random.normal(0.0, 2e-3 * servo.top_current, count),
        }
        values["motor_torque"] = values["current"] * servo.torque_constant
        factors = {"current turned": ("current", -1.0), "speed turned": ("speed", -1.0), "mA as A": ("current", 1e3)}
        factors |= {"rpm as rad/s": ("speed", 30.0 / math.pi), "ms as s": ("time", 1e3)}
        wrong, factor = factors.get(self.case.mistake, ("", 1.0))
        if wrong:
            values[wrong] = values[wrong] * factor
        if self.case.mistake == "deg as rad":
            values["motor_position"] = values["motor_position"] * 180.0 / math.pi
        cells = []
        for name in ("time", *self.case.signals):
            told = values[name] / UNITS[QUANTITY[name]][self.units[name]][0]
            cells.append([f"{value:.9g}" for value in told])
        order = [0, *self.order]
        names = [self.header[k] for k in order] + self.beside
        columns = [[text.replace(".", ",") if self.comma else text for text in cells[k]] for k in order]
        for name in self.beside:
            possible = BESIDE[name] or tuple(str(k) for k in range(count))
            columns.append([possible[k % len(possible)] for k in range(count)])
        rows = [self.delimiter.join(row) for row in zip(*columns, strict=True)]
        return "\n".join([self.delimiter.join(names), *rows]) + "\n"

    def _counted(self, side: str, angle: np.ndarray, random: np.random.Generator) -> np.ndarray:
        per_radian = self.counts[side] / (2.0 * math.pi)
        return np.rint(angle * per_radian + random.normal(0.0, 0.3, len(angle))) / per_radian


def stranger_cases(seed: int, count: int, *, plain: bool = False, alone: bool = False) -> list[Stranger]:
    """Cases of every effect and of none, told by three recordings or by one of them ``alone``.

    The same seed gives the same cases.
    """
    turns = itertools.cycle(np.random.default_rng((seed, 7000)).permutation([*HIDDEN, ""]).tolist())
    return [
        replace(_drawn(f"{number:03d}", (seed, 7001, number), effect), plain=plain, alone=number % 3 if alone else None)
        for number, effect in enumerate(itertools.islice(turns, count))
    ]


def mistaken_cases(seed: int, count: int) -> list[Stranger]:
    """Cases with nothing hidden but a wrong unit or sign."""
    turns = itertools.islice(itertools.cycle(MISTAKES), count)
    return [_drawn(f"{k:03d}", (seed, 7002, k), "", mistake) for k, mistake in enumerate(turns)]


def _drawn(name: str, seed: tuple[int, ...], effect: str, mistake: str = "") -> Stranger:
    random = np.random.default_rng(seed)

    def between(low: float, high: float) -> float:
        return math.exp(random.uniform(math.log(low), math.log(high)))

    inertia, top = between(1e-6, 1e-2), between(80.0, 500.0)
    spring_up = inertia * top * 6.0  # N m, of the quickest motion
    dry = spring_up * between(0.08, 0.4)
    viscous = dry * between(0.2, 1.0) / top
    top_torque = 2.2 * (0.3 * spring_up + 2.5 * dry)
    current = max(between(0.5, 40.0), top_torque * top / BUS)
    servo = Servo(
        inertia=inertia,
        viscous=viscous,
        dry=dry,
        torque_constant=top_torque / current,
        top_speed=top,
        top_current=current,
        ratio=float(random.choice([1.0, 5.0, 10.0, 16.0, 30.0, 50.0, 80.0, 100.0, 121.0, 200.0])),
        share_behind=random.uniform(0.15, 0.4),
        bandwidth=between(80.0, 250.0),
        integral_time=between(0.015, 0.06),
        speed_filter=between(2e-4, 2e-3),
    )
    servo = replace(servo, hidden={effect: _sizes(effect, servo, random)} if effect else {})
    period = 1.0 / float(random.choice([250.0, 500.0, 1000.0, 2000.0, 4000.0, 8000.0]))
    once_round = 1.3 * 2.0 * math.pi * servo.ratio / (0.6 * 0.4 * top)
    signals = ["motor_position"]
    if random.random() < 0.85 or mistake in ("deg as rad", "rpm as rad/s", "speed turned", "ms as s"):
        signals.append("speed")
    if random.random() < 0.4:
        signals.append("speed_setpoint")
    signals.append("motor_torque" if random.random() < 0.12 and "A" not in mistake else "current")
    if effect in BEHIND_THE_GEAR or random.random() < 0.35:
        signals.append("output_position")
    if "current" not in signals and mistake == "current turned":
        signals[signals.index("motor_torque")] = "current"
    knows = tuple(what for what in ("torque_constant", "gear_ratio") if random.random() < 0.6)
    if effect == "gravity_load" and "output_position" not in signals:
        knows = tuple(dict.fromkeys((*knows, "gear_ratio")))  # else nobody could know whose turns they are
    return Stranger(
        name=name,
        seed=seed,
        servo=servo,
        period=period,
        seconds=min(max(once_round, 5.0), 10.0),
        signals=tuple(signals),
        language=str(random.choice(["english", "german", "symbols"])),
        mistake=mistake,
        knows=knows,
    )


def _sizes(effect: str, servo: Servo, random: np.random.Generator) -> Mapping[str, float]:
    def of_dry(low: float, high: float) -> float:
        return servo.dry * float(random.uniform(low, high))

    angle = float(random.uniform(-math.pi, math.pi))
    gap = float(random.uniform(0.08, 0.5))  # rad of the motor
    return {
        "gravity_load": lambda: {"torque": of_dry(0.5, 1.5), "angle": angle},
        "stribeck_friction": lambda: {
            "torque": of_dry(0.4, 1.0),
            "speed": servo.top_speed * random.uniform(0.01, 0.04),
        },
        "constant_load": lambda: {"torque": of_dry(0.3, 1.0)},
        "asymmetric_friction": lambda: {"fraction": float(random.choice([-1.0, 1.0]) * random.uniform(0.1, 0.3))},
        "quadratic_drag": lambda: {"coefficient": of_dry(0.6, 2.0) / (0.6 * servo.top_speed) ** 2},
        "cogging": lambda: {"torque": of_dry(0.3, 0.8), "phase": angle},
        "backlash": lambda: {"width": gap / servo.ratio},
        "encoder_eccentricity": lambda: {"amplitude": float(random.uniform(1e-3, 6e-3)), "phase": angle},
    }[effect]()
