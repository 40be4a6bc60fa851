"""The measured proof (make accuracy): how well effects are named that are hidden in another plant than the twin's."""
