"""Health of a unit: judged by residual features against its own healthy recordings, and followed over time."""

from .baseline import Baseline, learn
from .families import Family
from .judgement import HealthJudgement, judge, judge_all, named_together
from .motion_record import MotionRecord

__all__ = ["Baseline", "Family", "HealthJudgement", "MotionRecord", "judge", "judge_all", "learn", "named_together"]
