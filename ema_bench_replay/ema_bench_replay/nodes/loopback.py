"""Restrict the nodes to this machine, and set how long they wait for a silent one, unless ROS's variables decide.

ROS looks for other nodes in the whole network and listens on every address. Neither node drives a bench, but anybody
who reaches them may pause a replay and switch effects on. So unless a range is chosen, nodes are discovered on this
machine only, and data use 127.0.0.1 only. All other nodes on the machine, of any range, can communicate with them.

A killed process does not sign off. Fast DDS waits 20 s for it, and a bench that loses no sample halts for as long. Here
a process counts as gone after 3 s of silence; it announces itself every second. That is less than the 5 s that the 5000
kept samples last at 1 kHz. Shared memory is not used: a reader killed while it holds one of its locks makes every
sender wait for that lock, up to 1 s. It does not take less processor time than UDP either.

The kernel drops UDP packets for a process that is not served in time: its buffer holds some 250 samples, of the 5000
that a node gets when it joins. A reader requests missing samples when the sender announces what it has sent. Fast DDS
does so every 3 s, so a busy machine waits 3 s repeatedly, and the bench halts meanwhile. Here it is every 0.02 s.

Once its history is full, Fast DDS also announces with every sample. A reader whose history is full then requests 256
samples each time, has to refuse them again, and has no time left for its work. This is disabled here.

For each sample that a reader requests, Fast DDS looks through all that it holds and its node has not taken: 500 here
instead of 5000, or a node that has fallen behind spends half its time on that. Nodes in one process also use sockets:
on the direct way, what a full reader refused last is not sent again until something else is sent.
"""

from __future__ import annotations

import os
from collections.abc import MutableMapping
from pathlib import Path

from rclpy.node import Node
from rclpy.utilities import get_rmw_implementation_identifier

from ema_bench_replay.errors import InputError

RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
"""ROS's variable: SUBNET opens the nodes to the network, as plain ROS does; others: LOCALHOST, SYSTEM_DEFAULT, OFF."""
PROFILES = ("FASTDDS_DEFAULT_PROFILES_FILE", "FASTRTPS_DEFAULT_PROFILES_FILE")
"""Variables with Fast DDS's transport profile: the present one, and that of older versions."""
LOOPBACK = Path(__file__).with_name("loopback.xml")
_LOOPBACK_ADDRESS = "0100007F"
"""127.0.0.1 as the kernel lists it."""
_FIRST_PORT, _PORTS = 7400, 250
"""First port of domain 0, and number of ports per domain (DDS-RTPS 2.5, 9.6.2: PB and DG)."""


def keep_to_this_machine(environment: MutableMapping[str, str] = os.environ) -> None:
    """Restrict the nodes of this process and its children to this machine; call before ROS starts.

    A range or transport profile that is already set in the environment is kept.
    """
    if environment.get(RANGE):
        return
    fast_dds = get_rmw_implementation_identifier().startswith("rmw_fastrtps")
    if not fast_dds or any(environment.get(name) for name in PROFILES):
        environment[RANGE] = "LOCALHOST"
        return
    environment[RANGE] = "SYSTEM_DEFAULT"  # uses the profile; for LOCALHOST, ROS would add shared memory
    environment.update(dict.fromkeys(PROFILES, str(LOOPBACK)))


def check_kept_to_this_machine(node: Node) -> None:
    """Raise InputError if Fast DDS has not applied our profile and this process listens on every address.

    Call it after the first node is created and before it is served: nobody has been answered until then. A range,
    profile or middleware chosen by the user is not checked, nor is a system without Linux's list of sockets.
    """
    table = Path("/proc/self/net/udp")
    ours = os.environ.get(RANGE) == "SYSTEM_DEFAULT" and os.environ.get(PROFILES[0]) == str(LOOPBACK)
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
    """Target of a descriptor of this process; empty if it was closed meanwhile."""
    try:
        return str(descriptor.readlink())
    except OSError:
        return ""
