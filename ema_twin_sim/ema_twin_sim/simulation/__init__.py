"""Simulation: from a model to the compiled plant, a running twin, a recording's twin, the virtual bench."""
