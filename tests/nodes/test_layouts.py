"""The launch file and the layouts for other tools name nodes, parameters and fields that exist."""

import json
import re
import xml.etree.ElementTree as ET

import pytest

from ema_bench_replay.nodes import record, replay
from ema_twin_msgs import msg
from ema_twin_sim.nodes import monitor, twin
from tests.launch_files import CONFIG, started

TYPES = {
    "/bench/state": msg.EmaState,
    "/twin/state": msg.EmaState,
    "/monitor/residual": msg.Residual,
    "/monitor/health": msg.Health,
    "/monitor/diagnosis": msg.Diagnosis,
}
NODES = {module.__name__.rpartition(".")[2]: module for module in (monitor, record, replay, twin)}


def assert_field_exists(path):
    """`path` as PlotJuggler writes it: topic and fields, all divided by slashes."""
    topic = next(topic for topic in TYPES if path.startswith(f"{topic}/"))
    message = TYPES[topic]()
    for name in path.removeprefix(f"{topic}/").split("/"):
        message = getattr(message, name)
    assert isinstance(message, float), path


def panels(layout, part):
    """The panels of a Foxglove layout, tabs with what is in them."""
    if isinstance(part, str):
        tabs = layout["configById"][part].get("tabs", [])
        return [part, *(name for tab in tabs for name in panels(layout, tab["layout"]))]
    return [*panels(layout, part["first"]), *panels(layout, part["second"])]


@pytest.fixture(scope="module")
def foxglove():
    return json.loads((CONFIG / "layouts" / "foxglove.json").read_text())


def test_foxglove_layout(foxglove):
    assert sorted(panels(foxglove, foxglove["layout"])) == sorted(foxglove["configById"])
    paths = re.findall(r'"value": "(/[^"]+)"', json.dumps(foxglove))
    assert len(paths) > 15 and any("rmse_trend" in path for path in paths)
    for path in paths:
        assert_field_exists(path.replace(".", "/"))


def test_foxglove_shows_the_diagnosis_and_both_actuators(foxglove):
    shown = foxglove["configById"]
    topic, _, field = shown["Table!ranking"]["topicPath"].partition(".")
    assert isinstance(getattr(TYPES[topic](), field), list)
    assert shown["RawMessages!diagnosis"]["topicPath"] in TYPES
    published = {
        f"/{node['namespace']}": node["parameters"][0]
        for node in started("actuator")
        if node["executable"] == "robot_state_publisher"
    }
    layers = shown["3D!actuator"]["layers"]
    assert len(layers) == len(published) == 2
    for layer in layers.values():
        side = layer["topic"].removesuffix("/robot_description")
        assert layer["framePrefix"] == published[side]["frame_prefix"]
        assert layer["jointStatesTopic"] == f"{side}/joint_states"


def test_plotjuggler_layout():
    root = ET.parse(CONFIG / "layouts" / "plotjuggler.xml").getroot()
    curves = list(root.iter("curve"))
    assert len(curves) > 16
    for curve in curves:
        for path in [curve.get("curve_x"), curve.get("curve_y")] if curve.get("curve_x") else [curve.get("name")]:
            assert_field_exists(path)
    for splitter in root.iter("DockSplitter"):
        assert int(splitter.get("count")) == len(splitter) == len(splitter.get("sizes").split(";"))


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ({}, ["twin", "monitor"]),
        ({"recording": "run.mcap", "rate": "5"}, ["twin", "monitor", "replay"]),
        ({"recording": "run.mcap", "record": "bag"}, ["twin", "monitor", "record", "replay"]),
        ({"input": "standalone"}, ["twin"]),
    ],
)
def test_launch_file(arguments, expected):
    nodes = started("ema_twin", **arguments)
    assert [node["executable"] for node in nodes] == expected
    for node in nodes:
        module = NODES[node["executable"]]
        assert "node has ended" in node["on_exit"].named["reason"]  # none runs on without the others
        assert module.__name__.startswith(node["package"])
        known = {declaration.name: declaration for declaration in module.PARAMETERS}
        for name, value in node["parameters"][0].items():
            known[name].checked(value)
