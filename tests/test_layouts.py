"""The launch file and the layouts for other tools name nodes, parameters and fields that exist."""

import json
import re
import runpy
import sys
import types
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from ema_bench_replay.nodes import record, replay
from ema_twin_msgs import msg
from ema_twin_sim.nodes import monitor, twin

CONFIG = Path(__file__).resolve().parent.parent / "config"
TYPES = {
    "/bench/state": msg.EmaState,
    "/twin/state": msg.EmaState,
    "/monitor/residual": msg.Residual,
    "/monitor/health": msg.Health,
}
NODES = {module.__name__.rpartition(".")[2]: module for module in (monitor, record, replay, twin)}


def assert_field_exists(path):
    """`path` as PlotJuggler writes it: topic and fields, all divided by slashes."""
    topic = next(topic for topic in TYPES if path.startswith(f"{topic}/"))
    message = TYPES[topic]()
    for name in path.removeprefix(f"{topic}/").split("/"):
        message = getattr(message, name)
    assert isinstance(message, float), path


def test_foxglove_layout():
    layout = json.loads((CONFIG / "layouts" / "foxglove.json").read_text())

    def panels(part):
        return [part] if isinstance(part, str) else [*panels(part["first"]), *panels(part["second"])]

    assert sorted(panels(layout["layout"])) == sorted(layout["configById"])
    paths = re.findall(r'"value": "(/[^"]+)"', json.dumps(layout))
    assert len(paths) > 10
    for path in paths:
        assert_field_exists(path.replace(".", "/"))


def test_plotjuggler_layout():
    root = ET.parse(CONFIG / "layouts" / "plotjuggler.xml").getroot()
    curves = list(root.iter("curve"))
    assert len(curves) > 8
    for curve in curves:
        for path in [curve.get("curve_x"), curve.get("curve_y")] if curve.get("curve_x") else [curve.get("name")]:
            assert_field_exists(path)
    for splitter in root.iter("DockSplitter"):
        assert int(splitter.get("count")) == len(splitter) == len(splitter.get("sizes").split(";"))


@pytest.fixture
def launch(monkeypatch):
    """`launch` and `launch_ros` are not on PyPI: stand-ins that keep what they are given."""

    class Kept:
        def __init__(self, *given, **named):
            self.given, self.named = given, named

    class Configuration(Kept):
        def perform(self, context):
            return context[self.given[0]]

    modules = {
        "launch": {"LaunchDescription": list},
        "launch.actions": {"DeclareLaunchArgument": Kept, "OpaqueFunction": Kept},
        "launch.launch_context": {"LaunchContext": dict},
        "launch.substitutions": {"LaunchConfiguration": Configuration},
        "launch_ros": {},
        "launch_ros.actions": {"Node": Kept},
    }
    for name, content in modules.items():
        module = types.ModuleType(name)
        vars(module).update(content)
        monkeypatch.setitem(sys.modules, name, module)
    return runpy.run_path(str(CONFIG / "launch" / "ema_twin.launch.py"))


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ({}, ["twin", "monitor"]),
        ({"recording": "run.mcap", "rate": "5"}, ["twin", "monitor", "replay"]),
        ({"recording": "run.mcap", "record": "bag"}, ["twin", "monitor", "record", "replay"]),
        ({"input": "standalone"}, ["twin"]),
    ],
)
def test_launch_file(launch, arguments, expected):
    *declared, function = launch["generate_launch_description"]()
    context = {argument.given[0]: argument.named["default_value"] for argument in declared} | arguments
    nodes = function.named["function"](context)
    assert [node.named["executable"] for node in nodes] == expected
    for node in nodes:
        module = NODES[node.named["executable"]]
        assert module.__name__.startswith(node.named["package"])
        known = {declaration.name: declaration for declaration in module.PARAMETERS}
        for name, value in node.named["parameters"][0].items():
            known[name].checked(value)
