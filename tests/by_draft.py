"""Recordings and model of a machine as a stranger gets them: by what ``init`` drafts of its CSVs, nothing edited."""

from ema_bench_replay.load import load
from ema_twin_sim.commands.init import run as init
from ema_twin_sim.model import load_model


def by_draft(folder, traces, shown=None, **known):
    """(recordings, model) of ``traces``; ``known`` is what their user tells, ``shown`` the CSVs that init reads."""
    init(str(folder / "machine"), shown or traces, **known)
    recordings = [load(trace, import_map=folder / "machine_map.yaml") for trace in traces]
    return recordings, load_model(folder / "machine.yaml")
