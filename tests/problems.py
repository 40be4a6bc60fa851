"""Problems of recordings, and fits to them, as a search begins with them."""

from ema_twin_sim.identification.equation import EquationErrorProblem
from ema_twin_sim.identification.fit import fit
from ema_twin_sim.identification.null_hypothesis import null_hypothesis
from ema_twin_sim.measured.observe import observe_all


def problem_of(recordings, model):
    """The equation-error problem of recordings of the model's machine."""
    return EquationErrorProblem(observe_all(recordings, model))


def hypothesis_of(model, **effects):
    """The model's constants and effects beside them, EFFECT={parameter: start value}."""
    h = null_hypothesis(model)
    for effect, parameters in effects.items():
        h = h.with_effect(effect, {}, parameters)
    return h


def fit_of(recordings, model, iterations=8, **effects):
    """A fit of ``hypothesis_of`` to recordings of the model's machine."""
    return fit(problem_of(recordings, model), hypothesis_of(model, **effects), iterations)
