"""Health of a unit: judged by residual features against its own healthy recordings, and followed over time."""

from ema_twin_sim.health.baseline import Baseline, learn
from ema_twin_sim.health.families import Family
from ema_twin_sim.health.judgement import HealthJudgement, judge, judge_all, named_together
from ema_twin_sim.health.motion_record import MotionRecord

__all__ = ["Baseline", "Family", "HealthJudgement", "MotionRecord", "judge", "judge_all", "learn", "named_together"]
