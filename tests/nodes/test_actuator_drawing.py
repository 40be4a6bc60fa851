"""The URDF of the actuator: a parser reads it, its joints are those that nodes publish, RViz finds what it draws."""

import xml.etree.ElementTree as ET

import pytest
import yaml
from rerun.urdf import UrdfTree

from ema_bench_replay.nodes.messages import joint_message
from tests.launch_files import CONFIG, started

URDF = CONFIG / "urdf" / "ema.urdf"


def place(visual):
    return [float(number) for number in visual.find("origin").get("xyz").split()]


@pytest.fixture(scope="module")
def actuator():
    return UrdfTree.from_file_path(URDF)


def test_its_joints_are_those_that_the_nodes_publish(actuator):
    assert [joint.name for joint in actuator.joints()] == joint_message(0, {}).name


def test_both_shafts_turn_freely_about_one_axis(actuator):
    for joint in actuator.joints():
        assert joint.joint_type == "continuous" and joint.parent_link == "body"
        assert joint.axis == (1.0, 0.0, 0.0) and joint.origin_xyz[1:] == (0.0, 0.0)  # so they are in line


def test_the_limits_are_those_of_the_drive(actuator, stock):
    motor, output = actuator.joints()
    ratio = stock.value("machine.gear_ratio")
    assert motor.limit_velocity == pytest.approx(stock.value("drive.speed_limit"), rel=1e-3)
    assert motor.limit_effort == pytest.approx(stock.value("drive.torque_limit"), rel=1e-3)
    assert output.limit_velocity == pytest.approx(motor.limit_velocity / ratio, rel=1e-3)
    assert output.limit_effort == pytest.approx(motor.limit_effort * ratio, rel=1e-3)


def test_turning_is_seen(actuator):
    """All that turns is round, but for a marker, which lies off the axis and on the outside."""
    links = {link.get("name"): link for link in ET.parse(URDF).getroot().iter("link")}
    for joint in actuator.joints():
        round_parts, markers = [], []
        for part in links[joint.child_link].iter("visual"):
            (markers if part.find("geometry/box") is not None else round_parts).append(part)
        (marker,) = markers
        along, _, off_axis = place(marker)
        assert off_axis > 0.02
        assert all(place(part)[1:] == [0.0, 0.0] for part in round_parts)
        assert abs(along) > max(abs(place(part)[0]) for part in round_parts)


def test_rviz_and_launch_file_speak_of_the_same_topics_and_frames():
    layout = yaml.safe_load((CONFIG / "layouts" / "ema.rviz").read_text())["Visualization Manager"]
    nodes = started("actuator")
    publishers = [node for node in nodes if node["executable"] == "robot_state_publisher"]
    models = [display for display in layout["Displays"] if display["Class"].endswith("/RobotModel")]
    assert [model["Description Topic"]["Value"] for model in models] == [
        f"/{publisher['namespace']}/robot_description" for publisher in publishers
    ]
    assert [f"{model['TF Prefix']}/" for model in models] == [
        publisher["parameters"][0]["frame_prefix"] for publisher in publishers
    ]
    placed = [node["arguments"] for node in nodes if node["executable"] == "static_transform_publisher"]
    for arguments, model in zip(placed, models, strict=True):
        assert arguments[arguments.index("--frame-id") + 1] == layout["Global Options"]["Fixed Frame"]
        assert arguments[arguments.index("--child-frame-id") + 1] == f"{model['TF Prefix']}/body"
    assert all(publisher["parameters"][0]["robot_description"] == URDF.read_text() for publisher in publishers)
    rviz = nodes[-1]
    assert rviz["executable"] == "rviz2" and rviz["arguments"] == ["-d", str(CONFIG / "layouts" / "ema.rviz")]
    assert len(started("actuator", rviz="false")) == len(nodes) - 1
