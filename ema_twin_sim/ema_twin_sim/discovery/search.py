"""The search for the effects that a model lacks."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from ..effects import catalogue
from .candidates import Candidate, candidates, starts
from .decoys import order_decoys
from .equation import Equation, Fit, fit, prior_rows
from .hypothesis import Hypothesis
from .structure import NARROW, structural_fits

CORRELATION = 2.0  # neighbouring rows are correlated: what one row is worth less
COST_EFFECT = 9.0
COST_PARAMETER = 1.5
COST_DECOY = 6.0
CLIP = 30.0  # noise standard deviations at which a row is cut off where what is left over is judged
FLOOR = 0.35  # of a recording's noise: the smallest share worth a name
SHARE = 0.1  # of the excess that an effect must remove
ENTRANTS = 8
ROUNDS = 10
PARTED = 1.5  # noise standard deviations by which the encoders part where a gearbox is suspected
STRUCTURAL = ("backlash", "shaft_compliance")
POOL_SCREEN = ThreadPoolExecutor(2)


@dataclass(frozen=True, eq=False)
class Screened:
    """A candidate's gain in sum of squares by linear regression, and the parameters it begins with."""

    candidate: Candidate
    start: dict[str, float]
    gain: float


def projector(f: Fit) -> tuple[np.ndarray, np.ndarray]:
    """(orthonormal basis of what the fit's free numbers can do, residual), priors included."""
    pr, pj = prior_rows(f.hypothesis)
    full = np.concatenate([f.jacobian, pj])
    q, _ = np.linalg.qr(full / np.maximum(np.linalg.norm(full, axis=0), 1e-30))
    r = np.concatenate([f.residual, pr])
    return q, r - q @ (q.T @ r)


def screen(eq: Equation, f: Fit, options: Sequence[Candidate]) -> list[Screened]:
    """Each candidate's gain, at its best start, best first."""
    q, r = projector(f)
    pad = np.zeros(len(r) - len(f.raw))

    def column(c: Candidate, parameters: dict[str, float], per: float) -> np.ndarray:
        h = f.hypothesis.with_effect(c.effect, c.options, parameters)
        rows = eq.alone(f.predicted, h.instance(list(h.added)[-1])) if per != 1.0 else None
        if rows is None:
            rows = eq.centred(eq.predict(h).rows - f.predicted.rows, f.weights)
        return np.concatenate([rows * f.weights / per, pad])

    def one(c: Candidate) -> Screened | None:
        effect = catalogue()[c.effect]
        size = effect.parameters[0]
        best: Screened | None = None
        periodic = [p.name for p in effect.parameters if p.periodic and not p.starts]
        groups: dict[tuple, list[dict[str, float]]] = {}
        for s in starts(effect):
            groups.setdefault(tuple(v for k, v in s.items() if k not in periodic), []).append(s)
        for group in groups.values():
            per = 1.0 if size.neutral is None else 1e-2 * max(abs(size.default - size.neutral), 1e-9)
            given = group if size.neutral is None else [{**s, size.name: size.neutral + per} for s in group]
            a = np.stack([column(c, s, per) for s in given], 1)
            if not np.isfinite(a).all():
                continue
            a -= q @ (q.T @ a)
            start = dict(group[0])
            if size.neutral is None:
                left = r - a[:, 0]
                gain = float(r @ r - left @ left)
                norm = float(a[:, 0] @ a[:, 0])
                along = float(a[:, 0] @ r)
                if along > 0.0 and norm > 0.0:  # a share of it may fit better than all of it
                    gain = max(gain, 0.5 * along**2 / norm)
            else:
                if np.linalg.norm(a, axis=0).max() < 1e-9:
                    continue
                x, *_ = np.linalg.lstsq(a, r, rcond=1e-9)
                fitted = a @ x
                if periodic and len(group) == 2:
                    start[periodic[0]] = math.atan2(x[1], x[0])
                    value = size.neutral + math.hypot(*x)
                else:
                    value = size.neutral + float(x[0])
                clipped = min(max(value, size.lower), size.upper)
                if clipped != value:
                    fitted = fitted * ((clipped - size.neutral) / (value - size.neutral))
                gain = float(r @ r - (r - fitted) @ (r - fitted))
                start[size.name] = clipped
            if best is None or gain > best.gain:
                best = Screened(c, start, gain)
        return best

    found = [s for s in POOL_SCREEN.map(one, options) if s is not None]
    return sorted(found, key=lambda s: -s.gain)


def price(f: Fit) -> float:
    """What a hypothesis costs beside its misfit: priors, effects, parameters."""
    parameters = sum(fr.path.startswith("effects.") for fr in f.hypothesis.free)
    decoys = sum(fr.path.startswith("decoy.") for fr in f.hypothesis.free)
    return f.prior_cost + COST_EFFECT * len(f.hypothesis.added) + COST_PARAMETER * parameters + COST_DECOY * decoys


def gain(eq: Equation, before: Fit, after: Fit) -> float:
    """How much better one fit is than another, prices paid; what remains of misfit makes differences count less."""
    temperature = CORRELATION * max(1.0, min(before.misfit, after.misfit) / eq.rows)
    return (before.misfit - after.misfit) / temperature + price(before) - price(after)


def unique(eq: Equation, before: Fit, after: Fit) -> float:
    """The largest rms, in units of noise, that an effect takes from some recording's rows."""
    best = 0.0
    for rows in (*eq.torque_parts, *eq.encoder_parts):
        if rows.stop - rows.start < 20:
            continue
        w = after.weights[rows] ** 2
        best = max(best, float(w @ (before.raw[rows] ** 2 - after.raw[rows] ** 2)) / (rows.stop - rows.start))
    return math.sqrt(best)


def matters(eq: Equation, before: Fit, after: Fit) -> bool:
    """Whether a step is large enough to be named."""
    fall = before.misfit - after.misfit
    excess = max(before.misfit - eq.rows, 0.0)
    if before.prior_cost - after.prior_cost > COST_EFFECT + COST_PARAMETER:
        return True
    left = math.sqrt(max(1.0, after.misfit / eq.rows))
    # an output that bounces is never known as well as one that does not
    floor = FLOOR * (2.0 if after.predicted.plant["two_inertia"][0] != 0.0 else 1.0)
    return fall >= SHARE * excess and unique(eq, before, after) >= floor * left


def settle(eq: Equation, f: Fit) -> Fit:
    """Fit, take weight from outliers, fit again."""
    for _ in range(4):
        parted = f.predicted.plant["two_inertia"][0] != 0.0
        if not eq.reweigh(f.raw, NARROW if parted else math.inf):
            break
        f = fit(eq, f.hypothesis)
    return f


def parted_encoders(eq: Equation, f: Fit) -> bool:
    """Whether the encoders part by more than their noise."""
    return any(p.stop > p.start and float(np.sqrt(np.mean(f.raw[p] ** 2))) > PARTED for p in eq.encoder_parts)


def screen_decoys(eq: Equation, f: Fit) -> list[tuple[float, str]]:
    """(gain in sum of squares, name) of each decoy by linear regression, best first."""
    q, r = projector(f)
    found = []
    for name, columns in eq.decoys.items():
        if name in f.hypothesis.decoys:
            continue
        a = np.concatenate([columns * f.weights[:, None], np.zeros((len(r) - len(f.raw), columns.shape[1]))])
        a -= q @ (q.T @ a)
        u, s, _ = np.linalg.svd(a, full_matrices=False)
        u = u[:, s > 1e-6 * max(s[0], 1e-12)]
        found.append((float(np.sum((u.T @ r) ** 2)) - 2.0 * CORRELATION * u.shape[1], name))
    return sorted(found, reverse=True)


@dataclass(frozen=True, eq=False)
class Trial:
    """One thing that was tried in a round: what would be added, and what it would gain."""

    names: tuple[str, ...]
    fit: Fit
    gain: float  # price paid, in units of the null's noise; above zero it is worth its price
    unique: float  # largest rms, in noise standard deviations, that it takes from some recording


@dataclass(frozen=True, eq=False)
class Round:
    """One round of the search: where it began, what was tried (best first), what came of it."""

    before: Fit
    tried: tuple[Trial, ...]
    after: Fit | None  # None: nothing was worth its price, and the search ended
    removed: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Search:
    """The end of a search and the way there."""

    fit: Fit
    rounds: tuple[Round, ...]


def search(
    eq: Equation,
    null: Fit,
    without: frozenset[str] = frozenset(),
    progress: Callable[[str], None] = lambda text: None,
    decoyed: bool = False,
) -> Search:
    """Add effects one after another as long as each is worth its price, and drop what later ones make needless.

    ``decoyed`` lets decoys stand beside the effects.
    """
    current = settle(eq, null)
    rounds: list[Round] = []
    banned: frozenset[str] = frozenset()
    looked_for_structure = bool(without >= set(STRUCTURAL))
    for _ in range(ROUNDS):
        structural = not looked_for_structure and parted_encoders(eq, current)
        if structural:
            eq.reach = np.full(eq.rows, NARROW)
            current = fit(eq, current.hypothesis)
        progress("looking at " + ("the gearbox and " if structural else "") + "all effects")
        hypotheses = entrants(eq, current, without | banned)
        tried = [fit(eq, h, 6, known=current) for h in hypotheses]
        if decoyed:
            eq.decoys.update(order_decoys(eq, current))
            for _, name in screen_decoys(eq, current)[:2]:
                tried.append(fit(eq, current.hypothesis.with_decoy(name, eq.decoys[name].shape[1]), 3, known=current))
        if structural:
            looked_for_structure = True
            tried += [f for f in structural_fits(eq, current) if not without & set(f.hypothesis.effects)]
        trials = sorted(
            (Trial(new_names(current, g), g, gain(eq, current, g), unique(eq, current, g)) for g in tried),
            key=lambda trial: -trial.gain,
        )
        took = next((t for t in trials if t.gain > 0.0 and matters(eq, current, t.fit)), None)
        if took is None:
            rounds.append(Round(current, tuple(trials), None))
            break
        progress("found " + " and ".join(took.names))
        after = prune(eq, settle(eq, fit(eq, took.fit.hypothesis)))
        removed = new_names(after, took.fit)
        banned |= {i.effect for n, i in took.fit.hypothesis.added.items() if n in removed and n in took.names}
        rounds.append(Round(current, tuple(trials), after, removed))
        current = after
    return Search(current, tuple(rounds))


def entrants(eq: Equation, current: Fit, without: frozenset[str]) -> list[Hypothesis]:
    """The current hypothesis with each of the most promising effects added."""
    options = [c for c in candidates(current.hypothesis, without) if c.effect not in STRUCTURAL]
    ranked = screen(eq, current, options)
    picked: list[Screened] = []
    for s in ranked:
        alike = sum(p.candidate.effect == s.candidate.effect for p in picked)
        if alike < 2 and len(picked) < ENTRANTS and s.gain > 0.02 * ranked[0].gain:
            picked.append(s)
    return [current.hypothesis.with_effect(s.candidate.effect, s.candidate.options, s.start) for s in picked]


def new_names(before: Fit, after: Fit) -> tuple[str, ...]:
    """The effects and decoys that one fit has and another has not."""
    held = {*before.hypothesis.added, *before.hypothesis.decoys}
    return tuple(n for n in (*after.hypothesis.added, *after.hypothesis.decoys) if n not in held)


def left_over(eq: Equation, f: Fit) -> list[float]:
    """Torque [N m] that each recording keeps unexplained beyond its noise, where nothing has been shaken."""
    found = []
    for o, part in zip(eq.observations, eq.torque_parts, strict=True):
        z = f.raw[part][o.calm]
        if len(z) < 20:
            found.append(0.0)
            continue
        excess = max(float(np.mean(np.minimum(np.abs(z), CLIP) ** 2)) - 1.0, 0.0)
        found.append(math.sqrt(excess) * float(np.median(o.torque_noise)))
    return found


def prune(eq: Equation, f: Fit) -> Fit:
    """Take out effects that are not, or no longer, worth their price, the last added included."""
    while f.hypothesis.added or f.hypothesis.decoys:
        trials = [fit(eq, f.hypothesis.without(n), 6, known=f) for n in f.hypothesis.added]
        trials += [fit(eq, f.hypothesis.without_decoy(n), 4, known=f) for n in f.hypothesis.decoys]
        best = max(trials, key=lambda g: gain(eq, f, g))
        if gain(eq, f, best) < 0.0 and matters(eq, best, f):
            break
        f = best
    return f
