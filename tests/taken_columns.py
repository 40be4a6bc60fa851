"""Which column ``init`` would take for each signal."""

from ema_twin_sim.new_machine.columns import guess_columns


def taken(columns, **more):
    """The column of each signal, of columns (n,) by their names."""
    return {guess.signal: guess.column for guess in guess_columns(list(columns), numbers=columns, **more).signals}
