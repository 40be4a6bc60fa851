"""Simulation: turn a model into the compiled plant, a running twin, the twin of a recording, or the virtual bench."""
