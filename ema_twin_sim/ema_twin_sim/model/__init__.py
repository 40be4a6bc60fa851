"""Models: a machine's constants and effects, immutable, and their files."""

from .model import ConstantValue, EffectInstance, Model
from .model_file import load_model, save_model

__all__ = ["ConstantValue", "EffectInstance", "Model", "load_model", "save_model"]
