"""Measured: a recording prepared once for all uses: its signals, its noise, and the scales of its machine."""
