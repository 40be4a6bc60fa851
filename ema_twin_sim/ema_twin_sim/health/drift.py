"""Drift of a feature or a parameter: a level, then wear from an unknown onset on, by an unknown law.

Wear grows with a power of the time since its onset, or exponentially if damage causes more damage. It also has random
steps of unknown size, as a gamma process has. For each possible onset, law and size of steps, a Kalman filter estimates
the level, the change until now and the sum of the steps. Each is weighted by its marginal likelihood, and each law by
how common it is, so the slope or a later value includes the uncertainty about all of them. The scatter of the values is
estimated from their second differences, which hardly contain wear, and from the given errors.
(Gamma processes of wear: van Noortwijk, Reliability Engineering & System Safety 94, 2009.)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ema_bench_replay.errors import InputError

from ..criteria import CONTRADICTED
from .change_point import inflation

_FEWEST = 5  # values
_ONSETS = 40  # number of onsets to try, about
_POWERS = np.exp2(np.arange(-2.0, 5.0) / 3.0)  # 0.63 to 2.5, by thirds of an octave
_RATES = np.array([0.5, 1.0, 2.0, 3.5])  # of exponential growth until now
_USUAL = np.append(np.exp(-0.5 * np.log2(_POWERS) ** 2), np.ones(len(_RATES)))  # prior weights of laws
_STEPS = np.array([0.0, 0.05, 0.1, 0.2])  # sizes of random steps: standard deviation as a share of the wear until now
_HARDLY = 1e-4  # of the weight of the likeliest part: less likely parts are dropped
_SECOND_DIFFERENCES = 18.0 / 35.0  # degrees of freedom of each second difference: neighbours share values
_DIFFUSE = 30.0  # times the range of the values: prior standard deviation of level and change


@dataclass(frozen=True, eq=False)
class Law:
    """How wear grows from its onsets (k,), with powers (k,) or rates (k,) of the time; a rate of 0 is a power law."""

    onsets: np.ndarray
    powers: np.ndarray
    rates: np.ndarray
    last: float  # the time at which the wear until now is 1

    def gone(self, time: float | np.ndarray) -> np.ndarray:
        """Wear (k, ...) at times (...), relative to the wear until the last time."""
        shape = (-1, *[1] * np.ndim(time))
        onsets, powers, rates = (of.reshape(shape) for of in (self.onsets, self.powers, self.rates))
        since = np.maximum(0.0, time - onsets) / (self.last - onsets)
        safe = np.where(rates > 0.0, rates, 1.0)
        with np.errstate(over="ignore"):
            growth = np.expm1(np.minimum(safe * since, 600.0)) / np.expm1(safe)
        return np.where(rates > 0.0, growth, since**powers)

    @property
    def by_time(self) -> np.ndarray:
        """Rate of wear at the last time, relative to the wear until then (k,)."""
        safe = np.where(self.rates > 0.0, self.rates, 1.0)
        return np.where(self.rates > 0.0, safe / -np.expm1(-safe), self.powers) / (self.last - self.onsets)

    def of(self, which: np.ndarray) -> Law:
        """Some of the laws."""
        return Law(self.onsets[which], self.powers[which], self.rates[which], self.last)


@dataclass(frozen=True, eq=False)
class Drift:
    """How the values change over time, in parts (k,) by onset, law and size of random steps."""

    times: np.ndarray  # (n,)
    law: Law
    weights: np.ndarray  # (k,), of sum 1
    fits: np.ndarray  # (k, 3): level, change by the law until the last time, change by random steps
    covariances: np.ndarray  # (k, 3, 3)
    steps: np.ndarray  # (k,) variance of random steps for as much wear as until the last time
    freedom: float  # degrees of freedom of the errors' size
    is_trend: bool  # whether the change is beyond chance: mean over the parts, each in its own standard errors

    @property
    def slope(self) -> float:
        """Change per unit of time at the last time."""
        return float(self.weights @ (self.fits[:, 1] * self.law.by_time))

    @property
    def slope_error(self) -> float:
        """Standard error of the slope, including the uncertainty of onset and law."""
        slopes = self.fits[:, 1] * self.law.by_time
        spread = self.weights @ (self.covariances[:, 1, 1] * self.law.by_time**2 + (slopes - self.slope) ** 2)
        return float(np.sqrt(spread))

    def at(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """Value and standard error (k,) of each part at the last time or after it."""
        gone = self.law.gone(time)
        rows = np.column_stack([np.ones_like(gone), gone, np.ones_like(gone)])
        values = np.einsum("ij,ij->i", rows, self.fits)
        variances = np.einsum("ij,ijk,ik->i", rows, self.covariances, rows)
        return values, np.sqrt(variances + self.steps * np.maximum(0.0, gone - 1.0))

    def now(self) -> tuple[float, float]:
        """Value and standard error at the last time."""
        values, errors = self.at(float(self.times[-1]))
        mean = float(self.weights @ values)
        return mean, float(np.sqrt(self.weights @ (errors**2 + (values - mean) ** 2)))


def drift(times: np.ndarray, values: np.ndarray, errors: np.ndarray) -> Drift:
    """Estimate the drift of values (n,) with standard errors (n,) at rising times (n,).

    Raises InputError if there are fewer than 5 values, or the times do not rise.
    """
    times, values, errors = (np.asarray(x, dtype=np.float64) for x in (times, values, errors))
    if len(times) < _FEWEST or not (np.diff(times) > 0.0).all():
        raise InputError(f"{len(times)} values cannot show a drift; give {_FEWEST} or more, at rising times")
    curved = values[:-2] - 2.0 * values[1:-1] + values[2:]
    expected = errors[:-2] ** 2 + 4.0 * errors[1:-1] ** 2 + errors[2:] ** 2
    share = _SECOND_DIFFERENCES
    widened, freedom = inflation(share * float(np.sum(curved**2 / expected)), share * len(curved))
    errors = widened * errors
    candidates = times[: -2 : max(1, len(times) // _ONSETS)]
    number = len(_POWERS) + len(_RATES)
    law = Law(
        np.repeat(candidates, number),
        np.tile(np.append(_POWERS, np.ones(len(_RATES))), len(candidates)),
        np.tile(np.append(np.zeros(len(_POWERS)), _RATES), len(candidates)),
        float(times[-1]),
    )
    usual = np.log(np.tile(_USUAL, len(candidates)))
    plain = _filtered(law, np.zeros(len(usual)), times, values, errors)
    weights = _weights(plain[2] + usual)
    distance = np.abs(plain[0][:, 1]) / np.sqrt(plain[1][:, 1, 1])
    if float(weights @ distance) <= CONTRADICTED:
        return _kept(times, law, weights, *plain[:2], np.zeros(len(usual)), freedom, is_trend=False)
    which = np.repeat(np.arange(len(usual)), len(_STEPS))
    steps = (np.tile(_STEPS, len(usual)) * plain[0][which, 1]) ** 2
    fits, covariances, likelihoods = _filtered(law.of(which), steps, times, values, errors)
    weights = _weights(likelihoods + usual[which])
    return _kept(times, law.of(which), weights, fits, covariances, steps, freedom, is_trend=True)


def like_a_step(times: np.ndarray, values: np.ndarray, errors: np.ndarray) -> bool:
    """Whether one step explains values (n,) with standard errors (n,) as well as steady growth from some onset on.

    A step that stays is no trend, and few values after it do not tell it from wear.
    """
    steps = [(times >= begin).astype(float) for begin in times[1:]]
    growths = [np.maximum(0.0, times - onset) for onset in times[:-1]]
    step, growth = (min(_misfit(shape, values, errors) for shape in shapes) for shapes in (steps, growths))
    widened, _ = inflation(growth, max(len(values) - 3, 0))
    return step - growth < (CONTRADICTED * widened) ** 2


def _misfit(shape: np.ndarray, values: np.ndarray, errors: np.ndarray) -> float:
    """Sum of squares, in standard errors, that a level and a multiple of a shape (n,) leave of values (n,)."""
    columns = np.column_stack([np.ones_like(shape), shape]) / errors[:, None]
    fit = np.linalg.lstsq(columns, values / errors, rcond=None)[0]
    return float(np.sum((values / errors - columns @ fit) ** 2))


def _filtered(
    law: Law, steps: np.ndarray, times: np.ndarray, values: np.ndarray, errors: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(states (k, 3), covariances (k, 3, 3), logarithms of the likelihood (k,)) after all values.

    The random steps are a random walk whose variance grows as the wear does.
    """
    gone = law.gone(times)
    grown = steps[:, None] * np.diff(gone, prepend=gone[:, :1], axis=1)
    middle = float(np.mean(values))
    diffuse = (_DIFFUSE * (float(np.ptp(values)) + float(errors.max()))) ** 2
    states = np.zeros((len(steps), 3))
    covariances = np.zeros((len(steps), 3, 3))
    covariances[:, 0, 0] = covariances[:, 1, 1] = diffuse
    likelihoods = np.zeros(len(steps))
    for k in range(len(times)):
        covariances[:, 2, 2] += grown[:, k]
        row = np.ones((len(steps), 3))
        row[:, 1] = gone[:, k]
        seen = np.einsum("kij,kj->ki", covariances, row)
        variance = np.einsum("ki,ki->k", row, seen) + errors[k] ** 2
        off = values[k] - middle - np.einsum("ki,ki->k", row, states)
        gain = seen / variance[:, None]
        states += gain * off[:, None]
        covariances -= gain[:, :, None] * seen[:, None, :]
        likelihoods -= 0.5 * (off**2 / variance + np.log(variance))
    states[:, 0] += middle
    return states, covariances, likelihoods


def _weights(logarithms: np.ndarray) -> np.ndarray:
    weights = np.exp(logarithms - logarithms.max())
    return np.asarray(weights / weights.sum())


def _kept(
    times: np.ndarray, law: Law, weights: np.ndarray, fits: np.ndarray, covariances: np.ndarray, steps: np.ndarray,
    freedom: float, *, is_trend: bool,
) -> Drift:  # fmt: skip
    """The drift without very unlikely parts."""
    kept = weights > _HARDLY * weights.max()
    shares = weights[kept] / weights[kept].sum()
    return Drift(times, law.of(kept), shares, fits[kept], covariances[kept], steps[kept], freedom, is_trend)
