"""Who hears the nodes: programs of this machine alone, unless ROS's own variable says otherwise.

ROS looks for other nodes in the whole network and listens on every address. A bench's drive is steered by neither, but
whoever is heard may pause a replay and switch effects on. So where nobody has chosen a range, nodes are looked for on
this machine, and data go by shared memory and 127.0.0.1 alone. Other nodes of the machine, of whatever range, are
heard and hear.
"""

from __future__ import annotations

import os
from collections.abc import MutableMapping
from pathlib import Path

RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
"""ROS's variable: SUBNET opens the nodes to the network, as plain ROS has it; LOCALHOST, SYSTEM_DEFAULT, OFF."""
PROFILES = ("FASTDDS_DEFAULT_PROFILES_FILE", "FASTRTPS_DEFAULT_PROFILES_FILE")
"""Where Fast DDS looks for transports: today's variable, and that of older versions."""
LOOPBACK = Path(__file__).with_name("loopback.xml")


def keep_to_this_machine(environment: MutableMapping[str, str] = os.environ) -> None:
    """Let the nodes of this process, and of its children, hear this machine alone; before ROS starts.

    A range, or a profile of transports, that the environment holds already stays as it is.
    """
    if environment.get(RANGE):
        return
    environment[RANGE] = "LOCALHOST"
    if not any(environment.get(name) for name in PROFILES):
        environment.update(dict.fromkeys(PROFILES, str(LOOPBACK)))
