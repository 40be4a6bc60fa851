"""Which column ``init`` would take for each signal."""

from ema_twin_sim.new_machine.columns import guess_columns


def guessed(columns, **more):
    """What the columns (n,) by their names seem to be."""
    return guess_columns(list(columns), numbers=columns, **more)


def taken(columns, **more):
    """The column of each signal, of columns (n,) by their names."""
    return {guess.signal: guess.column for guess in guessed(columns, **more).signals}


def signals(*header):
    """The signal of each column that is taken for one, by names alone."""
    return {guess.column: guess.signal for guess in guess_columns(header).signals}
