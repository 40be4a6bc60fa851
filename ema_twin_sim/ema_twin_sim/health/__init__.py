"""Health of a unit: judged by residual features against its own healthy recordings, and followed over time."""

from .baseline import Baseline, learn, learn_from
from .families import Family
from .judgement import HealthJudgement, judge, judge_run, named_together
from .motion_record import MotionRecord
from .run_features import RunFeatures, run_features

__all__ = [
    "Baseline",
    "Family",
    "HealthJudgement",
    "MotionRecord",
    "RunFeatures",
    "judge",
    "judge_run",
    "learn",
    "learn_from",
    "named_together",
    "run_features",
]
