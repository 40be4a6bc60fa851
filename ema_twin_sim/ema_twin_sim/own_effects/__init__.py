"""Effects that users write themselves, one Python file each, without touching the package."""

from .effect_file import load_effect, load_effects

__all__ = ["load_effect", "load_effects"]
