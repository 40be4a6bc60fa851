"""Effects written by users, one Python file each, without changing the package."""

from .effect_file import load_effect, load_effects

__all__ = ["load_effect", "load_effects"]
