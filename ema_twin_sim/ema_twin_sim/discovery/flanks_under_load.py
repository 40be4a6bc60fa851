"""Play between two encoders without a torque, where a load that nobody recorded chooses the flank.

A model without that load lets friction choose: after a reversal the output rests on the other flank. Where the load
changes the flank instead, as gravity does, the model is on the wrong one for much of the time, and the width that fits
best is a compromise. The distance between the flanks is seen all the same, whatever load chooses them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ema_bench_replay.recording import Recording

from ..criteria import SMALL, TOO_MUCH
from ..identification.fit import Fit, fit
from ..measured.ratio_of_recordings import flanks_apart
from ..model.own_units import shown
from ..model.roles import PLAY, SPRING
from ..quantities import quantity
from .search.trace import Search


def with_play_between_flanks(found: Search, recordings: Sequence[Recording]) -> tuple[Search, dict[str, float]]:
    """The search, with play as wide as its flanks are apart if an unseen load chooses them; and how uncertain it is.

    The uncertainty [own rad], by the path of the width, is how far off the fitted width was. It is empty if a torque
    was recorded, if the fitted width is about that distance, if the model follows the encoders, or if something else
    gives way as well.
    """
    h = found.fit.hypothesis
    played = [name for name, instance in h.added.items() if instance.effect == PLAY]
    if found.problem.size or not played or SPRING in h.effects:
        return found, {}
    path = f"effects.{played[0]}.width"
    width = h.by_path[path]
    apart = flanks_apart(recordings, h.base.value("machine.gear_ratio"))
    if apart is None or abs(width - apart) <= SMALL * apart or not _leaves_more_than_noise(found.fit):
        return found, {}
    return found.with_numbers(fit(found.problem, h.put({path: apart}), 0)), {path: abs(width - apart)}


def of_unseen_load(f: Fit, uncertain: Mapping[str, float]) -> tuple[str, ...]:
    """Warning about play whose flanks an unseen load chooses."""
    now = f.hypothesis.by_path
    return tuple(
        "the model does not follow the output from flank to flank, as where a load that was not recorded, such as "
        f"gravity, moves it: the play of {quantity(*shown(f.hypothesis.base, now[path], 'rad'))} is the measured "
        "distance between the flanks, with what such a load winds up, and the fitted width was off by its ±. Record "
        "the drive's torque or current as well"
        for path in uncertain
        if path in now
    )


def _leaves_more_than_noise(f: Fit) -> bool:
    """Whether the error of the encoder difference is far above its noise, each piece having its own offset."""
    problem, squares = f.problem, []
    for o, part in zip(problem.observations, problem.encoder_parts, strict=True):
        error = (problem.measured - f.predicted.rows)[part]  # in units of noise
        squares += [(error[of] - error[of].mean()) ** 2 for of in _pieces(o.encoder_piece)]
    return float(np.mean(np.concatenate(squares))) > TOO_MUCH**2


def _pieces(of: np.ndarray) -> list[np.ndarray]:
    """The rows (n,) of each piece, by the piece (n,) that each row is ``of``."""
    return [of == piece for piece in np.unique(of)]
