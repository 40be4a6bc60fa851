"""Replay, twin and monitor: `ros2 launch ema_twin_config ema_twin.launch.py recording:=RUN.mcap model:=polito_bench`.

Without `recording:=`, the twin answers the publisher of `/bench/state`: the real bench. `record:=FOLDER` records all
topics. If one node ends, for instance because it refuses its recording or model, the others end, too.
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.launch_context import LaunchContext
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

ARGUMENTS = {
    "model": ("polito_bench", "model of the machine: a shipped name or a YAML file"),
    "effect_files": ("", "Python files with effects of your own, between commas; they are run"),
    "recording": ("", "recording to play: an MCAP, its folder, or a CSV trace; none: a bench that is running"),
    "map": ("siemens", "import map that names a CSV's columns"),
    "rate": ("1.0", "speed of playing, 1 is real time; 0 plays as fast as it goes"),
    "loop": ("false", "play the recording again and again"),
    "input": ("auto", "what drives the twin: setpoint, current, standalone, or auto"),
    "command": ("sine:0.02:1", "command of a standalone twin"),
    "record": ("", "folder to record all topics into; none: do not record"),
    "max_bagfile_size": ("0", "bytes at which the recording's next file begins; 0: it is one file"),
    "max_bagfile_duration": ("0.0", "longest span of a file of the recording, s; 0: it is one file"),
}


def nodes(context: LaunchContext) -> list[Node]:
    """The nodes for these arguments."""
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    shown = {"output": "screen", "on_exit": Shutdown(reason="a node has ended; its last lines say why")}
    from_start = bool(given["recording"])
    standalone = given["input"] == "standalone"
    twin = {"model": given["model"], "input": given["input"], "from_start": from_start, "command": given["command"]}
    if given["effect_files"]:
        twin["effect_files"] = given["effect_files"].split(",")
    started = [Node(package="ema_twin_sim", executable="twin", parameters=[twin], **shown)]
    if not standalone:
        monitor = {name: value for name, value in twin.items() if name != "command"}
        started.append(Node(package="ema_twin_sim", executable="monitor", parameters=[monitor], **shown))
    if given["record"]:
        record = {
            "output": given["record"],
            "max_bagfile_size": int(given["max_bagfile_size"]),
            "max_bagfile_duration": float(given["max_bagfile_duration"]),
        }
        started.append(Node(package="ema_bench_replay", executable="record", parameters=[record], **shown))
    if given["recording"] and not standalone:
        replay = {
            "recording": given["recording"],
            "map": given["map"],
            "rate": float(given["rate"]),
            "loop": given["loop"].lower() == "true",
            "on_end": "wait",
            "subscribers": len(started),
            "patience": 60.0,  # on first use the twin compiles its model's equations before it listens
        }
        started.append(Node(package="ema_bench_replay", executable="replay", parameters=[replay], **shown))
    return started


def generate_launch_description() -> LaunchDescription:
    """Entry point of `ros2 launch`."""
    arguments = [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, description) in ARGUMENTS.items()
    ]
    return LaunchDescription([*arguments, OpaqueFunction(function=nodes)])
