"""Two machines in one: network namespaces with a cable between them. A node runs in one, a stranger is in the other.

unshare --map-root-user --net python -m tests.two_machines [VARIABLE=VALUE]…     (variables of the node)

Prints JSON: packets that left the node's machine before the stranger came, the nodes and topics that the stranger sees,
and whether it could set a parameter.
"""

from __future__ import annotations

import contextlib
import ctypes
import fcntl
import json
import os
import struct
import subprocess
import sys
import threading
import time
from pathlib import Path

NODE, STRANGER = "10.77.0.1", "10.77.0.2"
DOMAIN = "42"
"""Nobody else is in these networks."""
_TUNSETIFF = 0x400454CA
_TAP_WITHOUT_HEAD = 0x1002
_LONGEST = 60.0
"""s until a node is there."""
_ALONE = 3.0
"""s for which packets are counted: Fast DDS announces a participant three times in it."""
_LOOK = 8.0
"""s for which the stranger looks."""

_STRANGER = f"""
import json, time
import rclpy
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
rclpy.init()
node = rclpy.create_node("stranger")
client = node.create_client(SetParameters, "/twin/set_parameters")
until = time.monotonic() + {_LOOK}
while time.monotonic() < until and not (client.service_is_ready() and "twin" in node.get_node_names()):
    rclpy.spin_once(node, timeout_sec=0.1)
was_set = False
if client.service_is_ready():
    wanted = Parameter("effects.backlash.enabled", value=True).to_parameter_msg()
    future = client.call_async(SetParameters.Request(parameters=[wanted]))
    rclpy.spin_until_future_complete(node, future, timeout_sec={_LOOK})
    was_set = future.done() and future.result().results[0].successful
nodes = [name for name in node.get_node_names() if name != "stranger"]
topics = [name for name, _ in node.get_topic_names_and_types() if name.startswith("/twin")]
print(json.dumps({{"nodes": nodes, "topics": topics, "was_set": was_set}}), flush=True)
"""


def lay_cable() -> int:
    """Connect this network with another one; returns the process that holds that one.

    A thread carries frames between two taps: not every kernel has pairs of virtual Ethernet interfaces.
    """
    held = subprocess.Popen(["unshare", "--net", "sleep", "600"])
    here, there = (Path(f"/proc/{process}/ns/net") for process in ("self", held.pid))
    own = os.open(here, os.O_RDONLY)
    while there.stat().st_ino == here.stat().st_ino:
        time.sleep(0.05)
    ends = [_tap()]
    _enter(os.open(there, os.O_RDONLY))
    ends.append(_tap())
    _enter(own)
    inside = f"nsenter --target {held.pid} --net"
    for command in (
        "ip link set lo up",
        f"ip address add {NODE}/24 dev cable",
        "ip link set cable up",
        f"{inside} ip link set lo up",
        f"{inside} ip address add {STRANGER}/24 dev cable",
        f"{inside} ip link set cable up",
    ):
        subprocess.run(command.split(), check=True)
    for frames, to in (ends, ends[::-1]):
        threading.Thread(target=_carry, args=(frames, to), daemon=True).start()
    return held.pid


def _tap() -> int:
    """An interface named `cable` in the present network, whose frames are read and written by this process."""
    descriptor = os.open("/dev/net/tun", os.O_RDWR)
    fcntl.ioctl(descriptor, _TUNSETIFF, struct.pack("16sH22x", b"cable", _TAP_WITHOUT_HEAD))
    return descriptor


def _enter(network: int) -> None:
    if ctypes.CDLL(None, use_errno=True).setns(network, 0):
        raise OSError(ctypes.get_errno(), "setns")


def _carry(frames: int, to: int) -> None:
    while True:
        with contextlib.suppress(OSError):  # a network that is not up yet
            os.write(to, os.read(frames, 65536))


def packets_out() -> int:
    """Packets that this machine has sent into the cable."""
    line = next(line for line in Path("/proc/self/net/dev").read_text().splitlines() if "cable:" in line)
    return int(line.partition(":")[2].split()[9])


def main() -> None:
    """Run the node with the given variables, count, and let the stranger look."""
    for kind in ("all", "default"):  # the kernel's own packets of IPv6 would be counted
        Path(f"/proc/sys/net/ipv6/conf/{kind}/disable_ipv6").write_text("1")
    other = lay_cable()
    plain = {name: value for name, value in os.environ.items() if not name.startswith(("ROS_AUTO", "FAST"))}
    plain["ROS_DOMAIN_ID"] = DOMAIN
    node = subprocess.Popen(
        [sys.executable, "-m", "ema_twin_sim.nodes.twin", "--ros-args", "-p", "input:=standalone"],
        env={**plain, **dict(word.split("=", 1) for word in sys.argv[1:])},
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        before = packets_out()
        while "runs" not in (line := node.stderr.readline()):
            if not line:
                raise RuntimeError("the twin has ended")
        time.sleep(_ALONE)
        left = packets_out() - before
        looked = subprocess.run(
            ["nsenter", "--target", str(other), "--net", sys.executable, "-c", _STRANGER],
            env={**plain, "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET", "ROS_STATIC_PEERS": NODE},
            stdout=subprocess.PIPE,
            text=True,
            timeout=_LONGEST,
            check=True,
        )
        print(json.dumps({"left": left, **json.loads(looked.stdout.splitlines()[-1])}), flush=True)
    finally:
        node.kill()
        os.kill(other, 9)


if __name__ == "__main__":
    main()
