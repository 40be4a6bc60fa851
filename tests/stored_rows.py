"""Rows of a campaign's results, as tests write them: the cells that matter, without the empty ones."""

from ema_twin_sim.campaign.results import SCHEMA


def complete(rows):
    """The rows with every column of the table, None where a row has no such cell."""
    return [{**dict.fromkeys(SCHEMA.names), **row} for row in rows]
