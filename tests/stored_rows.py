"""Rows of a campaign's results, as tests write them: the cells that matter, without the empty ones."""

from datetime import datetime, timezone

import numpy as np

from ema_twin_sim.campaign.results import DONE, SCHEMA

WEEK = 7 * 86400.0  # s


def complete(rows):
    """The rows with every column of the table, None where a row has no such cell."""
    return [{**dict.fromkeys(SCHEMA.names), **row} for row in rows]


def weekly(values, std=1.0, unit="A", owner="backlash", name="width", dated=True):
    """Results of a unit, one a week, each with a number [rad] as it was told, and how sure."""
    rows = []
    for k, (value, of) in enumerate(np.broadcast(values, std)):
        at = datetime.fromtimestamp(1.7e9 + k * WEEK, timezone.utc) if dated else None
        held = {"owner": owner, "name": name, "value": value, "std": of, "unit": "rad"}
        row = {"key": f"{unit} {k}", "unit": unit, "name": f"week {k}", "task": "fit", "status": DONE, "time": at}
        rows.append({**row, "duration": 20.0, "errors": [], "parameters": [held]})
    return complete(rows)
