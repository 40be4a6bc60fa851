"""The IP sockets of a process and of what it started, by the addresses that they are bound to."""

import ipaddress
import time
from typing import NamedTuple

import psutil


class Socket(NamedTuple):
    """A socket that is bound to an address of this machine."""

    process: str  # its name
    kind: str  # "udp", "listening" (tcp), or "tcp" (a connection)
    address: str
    port: int

    @property
    def loopback(self):
        """Whether nobody on another machine can reach it."""
        return ipaddress.ip_address(self.address).is_loopback


def family(process):
    """The process of that number and all that it started, and these in turn; those that ended are left out."""
    try:
        first = psutil.Process(process)
        return [first, *first.children(recursive=True)]
    except psutil.NoSuchProcess:
        return []


def sockets(process):
    """All bound sockets of the process of that number and of those that it started."""
    found = set()
    for one in family(process):
        try:
            name, held = one.name(), one.net_connections("inet")
        except psutil.NoSuchProcess:  # ended meanwhile
            continue
        kinds = {psutil.CONN_NONE: "udp", psutil.CONN_LISTEN: "listening"}
        found |= {Socket(name, kinds.get(c.status, "tcp"), c.laddr.ip, c.laddr.port) for c in held if c.laddr}
    return found


def sockets_during(process, seconds, over=lambda: False):
    """All that were there at any time of so many seconds, or until it is over: some come late or live shortly."""
    found, end = set(), time.monotonic() + seconds
    while time.monotonic() < end and not over():
        found |= sockets(process)
        time.sleep(0.2)
    return found
