"""A new machine: draft an import map and a model from a recording's header and from what its signals show."""
