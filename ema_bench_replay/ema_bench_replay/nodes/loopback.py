"""Who hears the nodes, and for how long a silent one is waited for, unless ROS's own variables say otherwise.

ROS looks for other nodes in the whole network and listens on every address. A bench's drive is steered by neither, but
whoever is heard may pause a replay and switch effects on. So where nobody has chosen a range, nodes are looked for on
this machine, and data go by 127.0.0.1 alone. Other nodes of the machine, of whatever range, are heard and hear.

A process that is killed takes no leave. Fast DDS waits 20 s for it, and a bench of which no sample is lost halts as
long. Here a process counts as gone once nothing was heard of it for 3 s; it announces itself every second. That is less
than the 5 s that the 5000 kept samples last at 1 kHz. Shared memory is left out: a reader that is killed while it holds
one of its locks makes every sender wait for that lock, up to 1 s. It takes no less processor time than UDP.

The kernel drops UDP packets for a process that is not served in time: its buffer holds some 250 samples, of the 5000
that a node gets as it joins. A reader asks for them when the sender tells what it has sent, which Fast DDS does every
3 s: again and again 3 s on a machine that is busy, and the bench halts meanwhile. Here it is told every 0.1 s.
"""

from __future__ import annotations

import os
from collections.abc import MutableMapping
from pathlib import Path

from rclpy.utilities import get_rmw_implementation_identifier

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
    fast_dds = get_rmw_implementation_identifier().startswith("rmw_fastrtps")
    if not fast_dds or any(environment.get(name) for name in PROFILES):
        environment[RANGE] = "LOCALHOST"
        return
    environment[RANGE] = "SYSTEM_DEFAULT"  # what the profile says; for LOCALHOST, ROS would add shared memory to it
    environment.update(dict.fromkeys(PROFILES, str(LOOPBACK)))
