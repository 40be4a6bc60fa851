"""Launch files as tests read them: `launch` and `launch_ros` are not on PyPI, so stand-ins keep what they are given."""

import runpy
import sys
import types
from pathlib import Path
from unittest import mock

CONFIG = Path(__file__).resolve().parent.parent / "config"


class Kept:
    def __init__(self, *given, **named):
        self.given, self.named = given, named


class Configuration(Kept):
    def perform(self, context):
        return context[self.given[0]]


STAND_INS = {
    "launch": {"LaunchDescription": list},
    "launch.actions": {"DeclareLaunchArgument": Kept, "OpaqueFunction": Kept, "Shutdown": Kept},
    "launch.launch_context": {"LaunchContext": dict},
    "launch.substitutions": {"LaunchConfiguration": Configuration},
    "launch_ros": {},
    "launch_ros.actions": {"Node": Kept},
}


def started(name, **arguments):
    """What each node of a launch file is started with, given these arguments."""
    modules = {}
    for module, content in STAND_INS.items():
        modules[module] = types.ModuleType(module)
        vars(modules[module]).update(content)
    with mock.patch.dict(sys.modules, modules):
        launch = runpy.run_path(str(CONFIG / "launch" / f"{name}.launch.py"))
    *declared, function = launch["generate_launch_description"]()
    context = {argument.given[0]: argument.named["default_value"] for argument in declared}
    assert arguments.keys() <= context.keys()
    return [node.named for node in function.named["function"](context | arguments)]
