"""The actuator in RViz, bench and twin side by side: `ros2 launch ema_twin_config actuator.launch.py`.

Run it together with the nodes that publish `/bench/joint_states` and `/twin/joint_states`: `ema_twin.launch.py`, or
`ema-twin live`. With `rviz:=false` it publishes only what other tools (Foxglove) need to draw both:
`/bench/robot_description`, `/twin/robot_description` and the frames.
"""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.launch_context import LaunchContext
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

SHARE = Path(__file__).resolve().parent.parent
SIDES = {"bench": 0.0, "twin": 0.4}
"""Namespaces, and their positions in m to the left."""
ARGUMENTS = {
    "rviz": ("true", "open RViz"),
    "use_sim_time": (
        "true",
        "take the time from /clock, which begins anew with every run of a replay; false: real bench",
    ),
}


def nodes(context: LaunchContext) -> list[Node]:
    """The nodes that draw both, and RViz unless disabled."""
    given = {name: LaunchConfiguration(name).perform(context).lower() == "true" for name in ARGUMENTS}
    clock = {"use_sim_time": given["use_sim_time"]}
    description = (SHARE / "urdf" / "ema.urdf").read_text()
    started = []
    for side, left in SIDES.items():
        drawn = {"robot_description": description, "frame_prefix": f"{side}/", **clock}
        place = ["--y", str(left), "--frame-id", "world", "--child-frame-id", f"{side}/body"]
        states = Node(
            package="robot_state_publisher", executable="robot_state_publisher", namespace=side, parameters=[drawn]
        )
        placed = Node(package="tf2_ros", executable="static_transform_publisher", name=f"place_{side}", arguments=place)
        started += [states, placed]
    if given["rviz"]:
        layout = ["-d", str(SHARE / "layouts" / "ema.rviz")]
        started.append(Node(package="rviz2", executable="rviz2", arguments=layout, parameters=[clock], output="screen"))
    return started


def generate_launch_description() -> LaunchDescription:
    """Entry point of `ros2 launch`."""
    arguments = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, description) in ARGUMENTS.items()
    ]
    return LaunchDescription([*arguments, OpaqueFunction(function=nodes)])
