"""Machines as textbooks write them: motions are prescribed, and the torque that each needs is computed exactly.

Nothing is simulated and nothing controls: only the friction of the equation differs from the twin's. It turns round
over a range of speeds, narrow as simulators take it for their step, or wide. Each machine has a size of its own.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

LAWS: Mapping[str, Callable[[np.ndarray], np.ndarray]] = {
    "tanh": np.tanh,
    "arctangent": lambda share: 2.0 / math.pi * np.arctan(3.0 * share),
    "root": lambda share: share / np.sqrt(1.0 + share**2),
}
"""Share of the dry level at a share of the transition speed."""
NARROW, WIDE = (0.002, 0.005, 0.01), 0.05  # of the top speed
SECONDS, RATES, NOISE = 24.0, (200.0, 500.0, 1000.0), 0.01  # noise of the current, of its rms


@dataclass(frozen=True)
class Machine:
    """One machine; ``effect`` is hidden, of ``size`` [N m] where that applies. SI, without a gear."""

    inertia: float
    dry: float
    viscous: float
    torque_constant: float
    top_speed: float
    transition: float
    stribeck: float  # rad/s at which what is hidden at low speed has faded
    size: float
    phase: float

    def beside(self, effect: str, share: np.ndarray, speed: np.ndarray, angle: np.ndarray) -> np.ndarray:
        """Torque (n,) [N m] of what is hidden; ``share`` is that of the dry level."""
        pace = np.abs(speed) / self.stribeck
        torques = {
            "exponential": lambda: self.size * np.exp(-pace) * share,
            "gaussian": lambda: self.size * np.exp(-(pace**2)) * share,
            "lorentzian": lambda: self.size / (1.0 + pace**2) * share,
            "gravity_load": lambda: self.size * np.sin(angle + self.phase),
            "cogging": lambda: 0.5 * self.size * np.sin(12.0 * angle + self.phase),
            "quadratic_drag": lambda: self.size * (speed / self.top_speed) ** 2 * np.sign(speed),
            "spring_load": lambda: 0.5 * self.size * angle / self.top_speed,
            "constant_load": lambda: np.full(len(speed), self.size),
            "asymmetric_friction": lambda: 0.2 * np.abs(self.dry * share + self.viscous * speed),
        }
        return torques[effect]() if effect in torques else np.zeros(len(speed))


TURNS = (
    *("none", "none", "exponential", "gaussian", "lorentzian", "gravity_load", "cogging", "quadratic_drag"),
    *("spring_load", "constant_load", "asymmetric_friction", "none", "smooth_friction", "none"),
)
"""What is hidden, in turn."""
_STRIBECK = ("exponential", "gaussian", "lorentzian")


@dataclass(frozen=True)
class Textbook:
    """One case: a machine, and the law by which its friction turns round."""

    name: str
    seed: tuple[int, ...]
    effect: str
    law: str
    machine: Machine
    rate: float  # Hz
    mistake: str = ""

    @property
    def hidden(self) -> tuple[str, ...]:
        """Ids of the effects that the drafted model cannot have."""
        return () if self.effect == "none" else ("stribeck_friction" if self.effect in _STRIBECK else self.effect,)

    @property
    def besides(self) -> tuple[str, ...]:
        """What is there as well, and right if it is named: a transition that shows."""
        return ("smooth_friction",) if self.machine.transition > 0.9 * NARROW[-1] * self.machine.top_speed else ()

    @property
    def options(self) -> list[str]:
        """What a person adds to ``init`` from the data sheet."""
        return ["--gear-ratio", "1", "--torque-constant", f"{self.machine.torque_constant:.6g}"]

    @property
    def constants(self) -> dict[str, float]:
        """True inertia and friction, SI."""
        return {"inertia": self.machine.inertia, "coefficient": self.machine.viscous, "torque": self.machine.dry}

    def write(self, folder: Path) -> list[Path]:
        """Four recordings of position and current as CSV."""
        folder.mkdir(parents=True, exist_ok=True)
        random = np.random.default_rng((*self.seed, 1))
        step = 2.0 * math.pi / 2 ** int(random.choice([16, 18, 20]))
        files = []
        for number, (motion, share) in enumerate(((_sines, 1.0), (_levels, 1.0), (_swing, 0.3), (_sines, 0.6))):
            time = np.arange(round(SECONDS * self.rate)) / self.rate
            speed = motion(random, time, share * self.machine.top_speed)
            angle = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]))]) / self.rate
            current = self._torque(speed, angle) / self.machine.torque_constant
            current += NOISE * np.std(current) * random.standard_normal(len(time))
            files.append(folder / f"run_{number}.csv")
            rows = np.c_[time, np.round(angle / step) * step, current]
            header = "time [s],position [rad],current [A]"
            np.savetxt(files[-1], rows, delimiter=",", header=header, comments="", fmt="%.9g")
        return files

    def _torque(self, speed: np.ndarray, angle: np.ndarray) -> np.ndarray:
        m = self.machine
        share = LAWS[self.law](speed / m.transition)
        moved = m.inertia * np.gradient(speed, 1.0 / self.rate) + m.dry * share + m.viscous * speed
        return moved + m.beside(self.effect, share, speed, angle)


def textbook_cases(seed: int, count: int) -> list[Textbook]:
    """Cases of all kinds in turn; the same seed gives the same cases."""
    return [_drawn(seed, number) for number in range(count)]


def _drawn(seed: int, number: int) -> Textbook:
    random = np.random.default_rng((seed, 8000, number))
    effect, law = TURNS[number % len(TURNS)], str(random.choice(list(LAWS)))

    def between(low: float, high: float) -> float:
        return math.exp(random.uniform(math.log(low), math.log(high)))

    top, inertia = between(2.0, 200.0), between(1e-5, 1e-1)
    dry = 2.0 * inertia * top * between(0.3, 3.0)
    machine = Machine(
        inertia=inertia,
        dry=dry,
        viscous=dry / top * random.uniform(0.2, 1.0),
        torque_constant=between(0.02, 2.0),
        top_speed=top,
        transition=top * (WIDE if effect == "smooth_friction" else float(random.choice(NARROW))),
        stribeck=top * random.uniform(0.04, 0.12),
        size=dry * random.uniform(0.25, 0.6),
        phase=random.uniform(0.0, 2.0 * math.pi),
    )
    name = f"{number:03d}_{effect}_{law}"
    return Textbook(name, (seed, 8000, number), effect, law, machine, float(random.choice(RATES)))


def _sines(random: np.random.Generator, time: np.ndarray, top: float) -> np.ndarray:
    waves = sum(
        share * np.sin(2.0 * math.pi * rate * time + phase)
        for share, rate, phase in zip(
            random.uniform(0.3, 1.0, 5),
            random.uniform(0.05, 0.6, 5),
            random.uniform(0.0, 2.0 * math.pi, 5),
            strict=True,
        )
    )
    return np.asarray(top * waves / np.max(np.abs(waves)))


def _levels(random: np.random.Generator, time: np.ndarray, top: float) -> np.ndarray:
    """A speed every two seconds, reached within 0.3 s."""
    rate = (len(time) - 1) / (time[-1] - time[0])
    held = random.choice([-1.0, -0.6, -0.3, -0.1, 0.1, 0.3, 0.6, 1.0], size=math.ceil(0.5 * time[-1]) + 1)
    speed = top * held[(0.5 * time).astype(int)]
    window = np.hanning(round(0.3 * rate))
    padded = np.pad(speed, len(window), mode="edge")
    return np.convolve(padded, window / window.sum(), "same")[len(window) : -len(window)]


def _swing(random: np.random.Generator, time: np.ndarray, top: float) -> np.ndarray:
    return top * np.cos(2.0 * math.pi / random.uniform(4.0, 8.0) * time)
