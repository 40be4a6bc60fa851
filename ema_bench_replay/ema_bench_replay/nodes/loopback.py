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
3 s: again and again 3 s on a machine that is busy, and the bench halts meanwhile. Here it is told every 0.02 s.

Once all its places are full, Fast DDS tells it with every sample as well. A reader whose places are full then asks for
256 samples each time, has to refuse them again, and has no time left for its work. Here it does not.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, MutableMapping
from pathlib import Path

from rclpy.node import Node
from rclpy.utilities import get_rmw_implementation_identifier

from ema_bench_replay.errors import InputError

RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
"""ROS's variable: SUBNET opens the nodes to the network, as plain ROS has it; LOCALHOST, SYSTEM_DEFAULT, OFF."""
PROFILES = ("FASTDDS_DEFAULT_PROFILES_FILE", "FASTRTPS_DEFAULT_PROFILES_FILE")
"""Where Fast DDS looks for transports: today's variable, and that of older versions."""
LOOPBACK = Path(__file__).with_name("loopback.xml")
_LOOPBACK_ADDRESS = "0100007F"
"""127.0.0.1 as the kernel lists it."""
_FIRST_PORT, _PORTS = 7400, 250
"""The first port of domain 0, and how many each domain has (DDS-RTPS 2.5, 9.6.2: PB and DG)."""


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


def check_kept_to_this_machine(node: Node, environment: Mapping[str, str] = os.environ) -> None:
    """Raise InputError where Fast DDS has not taken our profile, and this process listens on every address.

    After the first node of a process is made, and before it is served: nobody was answered until then. What somebody
    has chosen himself is his: a range, a profile or a middleware of his own is not looked at, nor a system without
    Linux's list of sockets.
    """
    table = Path("/proc/self/net/udp")
    ours = environment.get(RANGE) == "SYSTEM_DEFAULT" and environment.get(PROFILES[0]) == str(LOOPBACK)
    if not ours or not table.exists():
        return
    first = _FIRST_PORT + _PORTS * node.context.get_domain_id()
    held = {_target(descriptor) for descriptor in Path("/proc/self/fd").iterdir()}
    for line in table.read_text().splitlines()[1:]:
        cells = line.split()
        address, port = cells[1].split(":")
        here = address == _LOOPBACK_ADDRESS and first <= int(port, 16) < first + _PORTS
        if here and f"socket:[{cells[9]}]" in held:
            return
    raise InputError(
        f"{LOOPBACK}: Fast DDS did not take this profile, and the node would be open to the network; run make setup, "
        f"which installs it anew, or open the node on purpose: export {RANGE}=SUBNET"
    )


def _target(descriptor: Path) -> str:
    """What a descriptor of this process is of; nothing where it was closed meanwhile."""
    try:
        return str(descriptor.readlink())
    except OSError:
        return ""
