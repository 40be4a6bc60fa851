"""A node that refuses what it was given is gone at once: a reader left behind would hold up who publishes."""

import gc

import pytest

from ema_bench_replay.errors import InputError
from ema_bench_replay.nodes.record import RecordNode
from ema_bench_replay.nodes.replay import ReplayNode
from ema_bench_replay.nodes.whole_or_none import whole_or_none
from ema_twin_sim.nodes.live import run_live
from ema_twin_sim.nodes.live_session import HealthAsked
from ema_twin_sim.nodes.monitor import MonitorNode
from ema_twin_sim.nodes.twin import TwinNode


@pytest.fixture
def observer(graph):
    """A node that sees the others; what Python has not freed by itself stays."""
    gc.collect()
    gc.disable()
    yield graph.plain_node("observer")
    gc.enable()


def alone(graph, observer):
    def names():
        return observer.get_node_names(), *(observer.count_subscribers(f"/{side}/state") for side in ("bench", "twin"))

    graph.spin_until(lambda: names() == (["observer"], 0, 0), 10.0)


@pytest.mark.parametrize(
    ("node_class", "parameters"),
    [
        (MonitorNode, {"window": -1.0}),
        (MonitorNode, {"results": "none"}),
        (TwinNode, {"input": "standalone", "command": "ramp"}),
        (TwinNode, {"effects.backlash.widht": 0.1}),
        (RecordNode, {"output": ""}),
        (ReplayNode, {"recording": "none.mcap"}),
    ],
)
def test_a_node_that_refuses_its_parameters(node_class, parameters, graph, observer):
    with pytest.raises(InputError) as kept:
        graph.add(node_class, **parameters)
    alone(graph, observer)
    assert kept.value.__traceback__ is not None  # holds the node


def test_a_node_that_fails_when_its_readers_are_there(graph, observer):
    @whole_or_none
    class Late(MonitorNode):
        def __init__(self, **given):
            super().__init__(**given)
            self.diagnosis_services.close()
            raise InputError("late")

    with pytest.raises(InputError, match="late") as kept:
        graph.add(Late)
    alone(graph, observer)
    assert kept.value.__traceback__ is not None


def test_a_live_run_that_is_refused(graph, observer, stock, tmp_path):
    with pytest.raises(InputError, match="no results") as kept:
        run_live(None, stock, health=HealthAsked(tmp_path, "", "", None))
    alone(graph, observer)
    assert kept.value.__traceback__ is not None
