"""Runs whose features are made by hand: a few healthy tests, and runs that are off in chosen features."""

import numpy as np

from ema_twin_sim.health.acquisition import Acquisition
from ema_twin_sim.health.baseline import Baseline, learn_from
from ema_twin_sim.health.features import Feature, Features
from ema_twin_sim.health.run_features import RunFeatures

SCATTER = 0.01
FINE = Acquisition(True, True, False, ())
HEALTHY = {
    "friction": Feature(1.0, "A"),
    "load": Feature(0.1, "A"),
    "settling": Feature(0.5, "A"),
    "breakaway": Feature(0.3, "A"),
    "roughness": Feature(-3.0, "(A rad)^0.5", logarithm=True),
    "fast_roughness": Feature(-4.0, "(A rad)^0.5", logarithm=True),
    "slow_roughness": Feature(-3.5, "(A rad)^0.5", logarithm=True),
    "rest_hunting": Feature(-3.0, "(A rad)^0.5", logarithm=True),
    "bump": Feature(1.0, "1", logarithm=True),
    "lost_motion": Feature(0.5, "rad", of_effort=False),
}


def run_by_hand(name, rng, *, lacks=(), still=(), times=1.0, turned=False, acquisition=FINE, scatter=SCATTER, **off):
    """A run that is ``off`` by so many standard deviations; efforts ``times`` as large, or with their sign ``turned``.

    Features of ``lacks`` are not recorded, those of ``still`` do not vary in healthy runs.
    """
    values = {}
    for feature, one in HEALTHY.items():
        if feature in lacks:
            continue
        noise = 0.0 if feature in still else scatter * float(rng.normal())
        value = one.value + noise + SCATTER * off.get(feature, 0.0)
        if one.unit == "A":
            value *= -times if turned and feature in ("friction", "load") else times
        elif one.of_effort and one.unit != "1":
            value += 0.5 * float(np.log(times))
        values[feature] = Feature(value, *one[1:])
    friction, load = values["friction"].value, values["load"].value
    features = Features(values, (friction + load, friction - load))
    return RunFeatures(name, name, acquisition, features, np.nan, (0.01, 10.0, 2.0), "rad", "A")


def healthy_by_hand(**given) -> Baseline:
    """What is learnt from a dozen healthy tests of one run."""
    rng = np.random.default_rng(1)
    return learn_from([run_by_hand(f"day {k}", rng, **given) for k in range(12)])
