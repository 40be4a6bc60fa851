"""Problems and fits of a few rows that tests make by hand: what a search compares, without anything that was fitted."""

from itertools import pairwise
from types import SimpleNamespace

import numpy as np

from ema_twin_sim.identification.null_hypothesis import null_hypothesis

COMPARES = SimpleNamespace(compares_with=lambda other: True)


def a_problem(
    *torque_rows,
    encoder_rows=(),
    calm=None,
    after_impact=None,
    noise=0.01,
    reading=0.0,
    torque=0.1,
    coarse=False,
    of_points=False,
):
    """Recordings of so many rows of torque, one after another, and then those of the encoders."""
    edges = np.cumsum([0, *torque_rows, *encoder_rows])
    parts = [slice(a, b) for a, b in pairwise(edges)]
    held = [
        SimpleNamespace(
            name=f"recording {k}",
            of_points=of_points,
            below_shock_limit=np.ones(rows, bool) if calm is None else calm,
            after_impact=np.zeros(rows, bool) if after_impact is None else after_impact,
            rows=np.arange(rows),
            torque_noise=np.full(rows, noise),
            torque_reading=reading,
            acceleration_noise=0.0,
            inertia=1.0,
            coarse=coarse,
        )
        for k, rows in enumerate(torque_rows)
    ]
    count, size, rows = len(torque_rows), int(edges[len(torque_rows)]), int(edges[-1])
    return SimpleNamespace(
        observations=held, torque_parts=parts[:count], encoder_parts=parts[count:], size=size, rows=rows, judged=rows,
        torque=np.full(size, torque), noise=np.full(size, noise), measured=np.zeros(rows), generic_bases={},
        noise_of_encoders=lambda part: np.full(part.stop - part.start, noise), compares_with=lambda other: True,
        costs=np.square, residual=lambda predicted: predicted.residual,
        bounds=lambda h: (np.array([free.lower for free in h.free]), np.array([free.upper for free in h.free])),
    )  # fmt: skip


def a_fit(hypothesis, raw, size=None, *, parted=False, prior=0.0, inflations=(2.0, 2.0), misfits=None, **more):
    """A fit of a hypothesis that leaves ``raw``, ``size`` rows of which are torque (all, where it is not given)."""
    raw = np.asarray(raw, float)
    size = len(raw) if size is None else size
    if misfits is None:
        misfits = float(np.sum(raw[:size] ** 2)), float(np.sum(raw[size:] ** 2))
    plant = {"two_inertia": np.array([float(parted)]), "bristle_stiffness": np.array([more.pop("bristle", 0.0)])}
    plant |= {"motor_inertia": np.ones(1), "output_inertia": np.zeros(1)}
    predicted = SimpleNamespace(plant=plant, residual=raw, rows=np.zeros(len(raw)))
    return SimpleNamespace(
        problem=COMPARES, hypothesis=hypothesis, raw=raw, weights=np.ones(len(raw)), parted=parted, prior_cost=prior,
        misfits=misfits, misfit=sum(misfits), variance_inflations=np.array(inflations), predicted=predicted,
        judged=(size, len(raw) - size), **more,
    )  # fmt: skip


def a_hypothesis(model, *effects, **parameters):
    """What is in the model's file, and these effects; of each the sizes that are given as EFFECT={…}, else of 0.01."""
    from ema_twin_sim.effects import catalogue

    h = null_hypothesis(model)
    for effect in effects:
        usual = {p.name: p.starts[0] if p.starts else 0.01 for p in catalogue()[effect].parameters}
        options = catalogue()[effect].default_options()
        h = h.with_effect(effect, options, {**usual, **parameters.get(effect, {})})
    return h
