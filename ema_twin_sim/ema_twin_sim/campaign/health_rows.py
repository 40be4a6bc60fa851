"""Convert the health features of a run to and from the store's column ``health``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..health.acquisition import Acquisition, Extent
from ..health.features import Feature, Features
from ..health.run_features import RunFeatures

_MOTION = ("period", "travel", "top_speed")
_OTHERWISE = "otherwise_"
"""Before the names of features with the effort read the other way."""


def health_row(run: RunFeatures) -> dict[str, Any]:
    """The value of the column ``health`` for a run."""
    acquisition, features = run.acquisition, run.features
    return {
        "test": run.test,
        "usable": acquisition.usable,
        "effort_usable": acquisition.effort_usable,
        "unsigned": run.unsigned,
        "findings": list(acquisition.findings),
        "wavelength": _known(run.wavelength),
        **{name: _known(value) for name, value in zip(_MOTION, run.motion, strict=True)},
        **({} if features is None else dict(zip(("forward", "backward"), map(_known, features.sides), strict=True))),
        "strokes": acquisition.extent.strokes,
        "position_unit": run.position_unit,
        "effort_unit": run.effort_unit,
        "features": None
        if features is None
        else [*_told(features), *([] if run.otherwise is None else _told(run.otherwise, _OTHERWISE))],
    }


def run_of(name: str, held: Mapping[str, Any], duration: float | None = None) -> RunFeatures:
    """The run from a value of the column ``health`` and its duration in s."""
    features, otherwise = None, None
    if held["features"] is not None:
        values = {
            one["name"]: Feature(one["value"], one["unit"], one["logarithm"], one["of_effort"])
            for one in held["features"]
        }
        others = {name.removeprefix(_OTHERWISE): values.pop(name) for name in [*values] if name.startswith(_OTHERWISE)}
        forward, backward = _number(held["forward"]), _number(held["backward"])
        features = Features(values, (forward, backward))
        otherwise = Features(others, (forward, -backward)) if others else None
    period, travel, top_speed = (_number(held[what]) for what in _MOTION)
    return RunFeatures(
        name=name,
        test=held["test"],
        acquisition=Acquisition(
            held["usable"],
            held["effort_usable"],
            held["unsigned"],
            tuple(held["findings"] or ()),
            Extent(duration or 0.0, held["strokes"]),
            certain_of_sign=otherwise is None,
        ),
        features=features,
        wavelength=_number(held["wavelength"]),
        motion=(period, travel, top_speed),
        position_unit=held["position_unit"],
        effort_unit=held["effort_unit"],
        otherwise=otherwise,
    )


def _told(features: Features, prefix: str = "") -> list[dict[str, Any]]:
    return [{"name": prefix + name, **feature._asdict()} for name, feature in features.values.items()]


def _known(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _number(value: float | None) -> float:
    return float("nan") if value is None else value
