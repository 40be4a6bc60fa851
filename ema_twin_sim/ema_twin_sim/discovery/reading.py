"""Reading: the recordings and the model of a discovery, in SI for the judge and in the machine's own units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from ema_bench_replay.recording import Recording

from ..identification.equation import EquationErrorProblem
from ..identification.fit import fit
from ..identification.hypothesis import Hypothesis
from ..identification.null_hypothesis import null_hypothesis
from ..measured.consistency import refuse_inconsistent
from ..measured.folds import operating_point_folds
from ..measured.noise import NoiseFloor, noise_of
from ..measured.observability import at_rest
from ..measured.observe import observe_all
from ..measured.quieter_motion import as_measured
from ..measured.scales import to_own_units, to_rotary_equivalent, with_output_held
from ..measured.switching_ripple import with_switching_ripple
from ..model import Model
from .differing_zeros import as_recorded, differing_zeros, with_zeros_moved
from .torque_constant import with_assumed_constant_free
from .zeros_by_load import zeros_by_load


@dataclass(frozen=True, eq=False)
class Reading:
    """What a discovery works on.

    ``zeros`` is how far the zeros of the ``given`` recordings' positions were moved to be one, in their own unit.
    """

    given: Sequence[Recording]
    zeros: Mapping[str, float]
    noise: NoiseFloor
    rotary: list[Recording]  # SI, of a drum if the machine is linear
    began: Model  # SI, the model as it was given, for these
    recordings: list[Recording]  # own units
    model: Model  # own units, without the effects that these recordings do not show
    awake: Model  # the same with them
    problem: EquationErrorProblem
    null: Hypothesis
    doubts: tuple[str, ...]  # what may be wrong with them: questions


def read_with_one_zero(recordings: Sequence[Recording], given: Model) -> Reading:
    """Recordings (SI) and a ``given`` model, with the zeros of the positions moved to one where they differ.

    Raises InputError if the recordings cannot be judged.
    """
    read = _read(recordings, given)
    if not all(recording.has("motor_position") for recording in recordings):
        return read  # an integrated speed has no zero to move
    without = fit(read.problem, read.null)
    zeros = as_recorded(recordings, zeros_by_load(without) or differing_zeros(without), read.model)
    return replace(_read(with_zeros_moved(recordings, zeros), given), zeros=zeros) if zeros else read


def _read(recordings: Sequence[Recording], given: Model) -> Reading:
    measured = as_measured(recordings, given)
    rotary, began = to_rotary_equivalent(measured, given)
    own, awake = to_own_units(measured, given)
    own = operating_point_folds(own, awake)
    model = with_output_held(at_rest(awake, own), own)
    doubts = refuse_inconsistent(own, model)
    problem = EquationErrorProblem([with_switching_ripple(o, model) for o in observe_all(list(own), model)])
    return Reading(
        given=recordings,
        zeros={},
        noise=noise_of(measured, given),
        rotary=operating_point_folds(rotary, began),
        began=began,
        recordings=own,
        model=model,
        awake=awake,
        problem=problem,
        null=with_assumed_constant_free(null_hypothesis(model, by_torque=problem.size > 0), own),
        doubts=doubts,
    )
