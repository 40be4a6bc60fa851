"""A new machine: a first import map and a first model, from a recording's header and what its signals show."""
