"""A campaign's results of units whose health was computed, as tests write them: features, without recordings."""

from datetime import datetime, timezone

import numpy as np

from ema_twin_sim.campaign.health_rows import health_row
from ema_twin_sim.campaign.results import DONE
from ema_twin_sim.health.acquisition import Acquisition
from ema_twin_sim.health.features import Feature, Features
from ema_twin_sim.health.run_features import RunFeatures
from tests.stored_rows import complete

DAY = 86400.0


def health_results(unit, friction, seed=0):
    """One result a day, whose friction [A] differs by 1 % from day to day besides what ``friction`` says."""
    drawn = np.random.default_rng(seed)
    return complete(_row(unit, day, level * (1.0 + 0.01 * drawn.normal()), drawn) for day, level in enumerate(friction))


def _row(unit, day, friction, drawn):
    at = datetime.fromtimestamp(1.7e9 + day * DAY, timezone.utc)
    scatters = {name: Feature(0.02 * drawn.normal(), "A", True) for name in ("roughness", "rest_hunting")}
    features = Features({"friction": Feature(friction, "A"), **scatters}, (friction, friction))
    run = RunFeatures(
        f"{at:%Y-%m-%d}.csv", f"{at:%Y-%m-%d}", Acquisition(True, True, False, ()), features, np.nan,
        (0.01, 1.0, 1.0), "rad", "A",
    )  # fmt: skip
    of = {"task": "health", "model": "", "status": DONE, "time": at, "duration": 9.0, "content": [f"{unit} {day}"]}
    return {"key": f"{unit} {day}", "unit": unit, "name": run.name, "health": health_row(run), **of}
