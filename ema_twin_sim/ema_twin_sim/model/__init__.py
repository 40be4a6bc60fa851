"""Models: the machine's constants and its effects, frozen, and the files they come from."""

from .model import ConstantValue, EffectInstance, Model
from .model_file import load_model, save_model

__all__ = ["ConstantValue", "EffectInstance", "Model", "load_model", "save_model"]
