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
COST_EFFECT = 7.0
COST_PARAMETER = 4.0
SHAKY = 3.0
COST_DECOY = 6.0
DECOY_SHARE = 0.85
CLIP = 30.0  # noise standard deviations at which a row is cut off where what is left over is judged
FLOOR = 0.35  # of a recording's noise: the smallest share worth a name
SHARE = 0.1  # of the excess that an effect must remove
ENTRANTS = 8
ROUNDS = 10
PARTED = 1.2  # noise standard deviations by which the encoders part where a gearbox is suspected
STRUCTURAL = ("backlash", "shaft_compliance")
ENCODER_ONLY = frozenset({"encoder_delay", "encoder_eccentricity"})
LIKE_STRUCTURE = frozenset({"added_inertia", "torque_constant_error", "mesh_friction", "presliding_friction"})
"""What a gearbox that rings or bounces looks like in the torque alone."""
POOL_SCREEN = ThreadPoolExecutor(2)


@dataclass(frozen=True, eq=False)
class Screened:
    """A candidate's gain in sum of squares by linear regression, and the parameters it begins with."""

    candidate: Candidate
    start: dict[str, float]
    gain: float
    shift: np.ndarray  # (k,) by how much the numbers that were free before give way to it


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
    slopes = np.concatenate([f.jacobian, prior_rows(f.hypothesis)[1]])

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
            raw = a
            a = a - q @ (q.T @ a)
            start = dict(group[0])
            shift = np.zeros(slopes.shape[1])
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
                if clipped == value:
                    shift = -np.linalg.lstsq(slopes, raw @ x, rcond=1e-9)[0]
            if best is None or gain > best.gain:
                best = Screened(c, start, gain, shift)
        return best

    found = [s for s in POOL_SCREEN.map(one, options) if s is not None]
    return sorted(found, key=lambda s: -s.gain)


def judged(eq: Equation) -> int:
    """How many rows are judged."""
    return eq.rows if eq.use_encoder else eq.size


def price(f: Fit) -> float:
    """What a hypothesis costs beside its misfit: priors, effects, parameters."""
    parameters = sum(fr.path.startswith("effects.") for fr in f.hypothesis.free)
    decoys = sum(fr.path.startswith("decoy.") for fr in f.hypothesis.free)
    return f.prior_cost + COST_EFFECT * len(f.hypothesis.added) + COST_PARAMETER * parameters + COST_DECOY * decoys


def gain(eq: Equation, before: Fit, after: Fit) -> float:
    """How much better one fit is than another, prices paid; what remains of misfit makes differences count less."""
    temperature = CORRELATION * max(1.0, min(before.misfit, after.misfit) / judged(eq))
    if _parted(before) and _parted(after):
        temperature *= SHAKY  # beside an output that bounces, more is fitted by chance
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
    excess = max(before.misfit - judged(eq), 0.0)
    if before.prior_cost - after.prior_cost > COST_EFFECT + COST_PARAMETER:
        return True
    left = math.sqrt(max(1.0, after.misfit / judged(eq)))
    # an output that bounces is never known as well as one that does not
    floor = FLOOR * (2.0 if _parted(after) else 1.0)
    return fall >= SHARE * excess and unique(eq, before, after) >= floor * left


def settle(eq: Equation, f: Fit) -> Fit:
    """Fit, take weight from outliers, fit again."""
    for _ in range(4):
        if not eq.reweigh(f.raw, NARROW if _parted(f) else math.inf):
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
    after: Fit
    added: tuple[str, ...] = ()  # empty: nothing was worth its price
    removed: tuple[str, ...] = ()  # what was needless beside it, which may be itself

    def effect_of(self, name: str) -> str:
        """The effect, or the decoy, behind a name that was tried."""
        held = next((t.fit.hypothesis.added[name] for t in self.tried if name in t.fit.hypothesis.added), None)
        return held.effect if held else name


@dataclass(frozen=True, eq=False)
class Search:
    """The end of a search and the way there."""

    fit: Fit
    rounds: tuple[Round, ...]

    @property
    def taken(self) -> tuple[Round, ...]:
        """The rounds in which something was added."""
        return tuple(turn for turn in self.rounds if turn.added)


def search(
    eq: Equation,
    null: Fit,
    without: frozenset[str] = frozenset(),
    progress: Callable[[str], None] = lambda text: None,
    decoyed: bool = False,
) -> Search:
    """Add effects one after another as long as each is worth its price, and drop what later ones make needless.

    Where the encoders part, what the torque alone tells is found first, then play and spring, then all together: a
    gearbox can only be simulated with the right loads. ``decoyed`` lets decoys stand beside the effects.
    """
    current = settle(eq, null)
    rounds: list[Round] = []
    if parted_encoders(eq, current) and not without >= set(STRUCTURAL):
        eq.use_encoder = False
        progress("looking at the torque alone")
        current, by_torque = _add_effects(
            eq, fit(eq, current.hypothesis), without | _misleading(null), progress, decoyed
        )
        rounds += by_torque
        eq.use_encoder = True
        eq.reach = np.full(eq.rows, NARROW)
        current = fit(eq, current.hypothesis)
        if parted_encoders(eq, current):
            progress("looking at the gearbox")
            current, by_gearbox = _add_structure(eq, current, without)
            rounds += by_gearbox
    else:
        without = without | ENCODER_ONLY  # whose place is with the gearbox, which the encoders do not call for
    current, by_all = _add_effects(eq, current, without, progress, decoyed)
    return Search(current, (*rounds, *by_all))


def _misleading(null: Fit) -> frozenset[str]:
    """Effects that the torque alone must not be asked for while the gearbox is in doubt."""
    held = {instance.effect for instance in null.hypothesis.base.effects.values()}
    return ENCODER_ONLY | LIKE_STRUCTURE | (held & {"viscous_friction", "coulomb_friction"})


def _parted(f: Fit) -> bool:
    return bool(f.predicted.plant["two_inertia"][0] != 0.0)


def _add_effects(
    eq: Equation, current: Fit, without: frozenset[str], progress: Callable[[str], None], decoyed: bool
) -> tuple[Fit, list[Round]]:
    """One effect a round, until none is worth its price."""
    rounds: list[Round] = []
    banned: frozenset[str] = frozenset()
    for _ in range(ROUNDS):
        progress("trying all effects")
        tried = [fit(eq, h, 6, known=current) for h in entrants(eq, current, without | banned)]
        if decoyed:
            eq.decoys.update(order_decoys(eq, current))
            for _, name in screen_decoys(eq, current)[:2]:
                tried.append(fit(eq, current.hypothesis.with_decoy(name, eq.decoys[name].shape[1]), 3, known=current))
        turn = _turn(eq, current, tried)
        rounds.append(turn)
        if not turn.added:
            break
        progress("found " + " and ".join(turn.added))
        banned |= {turn.effect_of(n) for n in turn.removed if n in turn.added}
        current = turn.after
    return current, rounds


def _add_structure(eq: Equation, current: Fit, without: frozenset[str]) -> tuple[Fit, list[Round]]:
    """Play, spring, both, or an encoder that is late or off its centre: whatever explains the encoders best."""
    tried = [f for f in structural_fits(eq, current) if not without & set(f.hypothesis.effects)]
    sensors = frozenset(c.effect for c in candidates(current.hypothesis) if c.effect not in ENCODER_ONLY)
    tried += [fit(eq, h, 6) for h in entrants(eq, current, without | sensors)]
    turn = _turn(eq, current, tried)
    return turn.after, [turn]


def _turn(eq: Equation, current: Fit, tried: Sequence[Fit]) -> Round:
    """Take the best of what was tried, if it is worth its price, and drop what it makes needless."""
    trials = sorted(
        (Trial(new_names(current, g), g, gain(eq, current, g), unique(eq, current, g)) for g in tried),
        # a decoy fits anything: an effect that does nearly as well goes first
        key=lambda trial: -trial.gain * (DECOY_SHARE if set(trial.names) & set(trial.fit.hypothesis.decoys) else 1.0),
    )
    took = next((t for t in trials if t.gain > 0.0 and matters(eq, current, t.fit)), None)
    if took is None:
        return Round(current, tuple(trials), current)
    after = prune(eq, settle(eq, fit(eq, took.fit.hypothesis)))
    return Round(current, tuple(trials), after, took.names, new_names(after, took.fit))


def entrants(eq: Equation, current: Fit, without: frozenset[str]) -> list[Hypothesis]:
    """The current hypothesis with each of the most promising effects added."""
    options = [c for c in candidates(current.hypothesis, without) if c.effect not in STRUCTURAL]
    ranked = screen(eq, current, options)
    picked: list[Screened] = []
    for s in ranked:
        alike = sum(p.candidate.effect == s.candidate.effect for p in picked)
        if alike < 2 and len(picked) < ENTRANTS and s.gain > 0.02 * ranked[0].gain:
            picked.append(s)
    lower = np.array([free.lower for free in current.hypothesis.free])
    upper = np.array([free.upper for free in current.hypothesis.free])
    return [
        current.hypothesis.at(np.clip(current.hypothesis.values + s.shift, lower, upper)).with_effect(
            s.candidate.effect, s.candidate.options, s.start
        )
        for s in picked
    ]


def new_names(before: Fit, after: Fit) -> tuple[str, ...]:
    """The effects and decoys that one fit has and another has not."""
    held = {*before.hypothesis.added, *before.hypothesis.decoys}
    return tuple(n for n in (*after.hypothesis.added, *after.hypothesis.decoys) if n not in held)


def left_over(eq: Equation, f: Fit) -> list[float]:
    """Torque [N m] that each recording keeps unexplained beyond its noise, where nothing has been shaken."""
    parted = _parted(f)
    found = []
    for o, part in zip(eq.observations, eq.torque_parts, strict=True):
        z = f.raw[part][o.calm & ~o.thrown if parted else o.calm]
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
