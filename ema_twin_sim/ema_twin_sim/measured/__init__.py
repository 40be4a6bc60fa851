"""A recording made ready to judge, once, for everybody: its signals, its noise, the scales of its machine."""
