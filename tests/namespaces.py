"""A network, or a disk, that a process has to itself, where the kernel lets its user make one."""

import shutil
import subprocess

import pytest

ALONE = ["unshare", "--map-root-user", "--net", "sh", "-c", 'ip link set lo up && exec "$@"', "sh"]
"""In a network without another machine: what starts open tells nobody, and its bytes are those of the test."""

needs_own_network = pytest.mark.skipif(
    not all(map(shutil.which, ("unshare", "ip"))) or subprocess.run([*ALONE, "true"], capture_output=True).returncode,
    reason="needs unshare and ip, and a kernel that lets users make networks",
)


def on_own_disk(folder, size, script):
    """The command that runs a shell's script where the folder is a disk of that size; the test is skipped without."""
    alone, mount = ["unshare", "-rm", "sh", "-c"], f"mount -t tmpfs -o size={size} tmpfs {folder}"
    if subprocess.run([*alone, mount], capture_output=True, check=False).returncode:
        pytest.skip("this user may mount no file system of its own: unshare -rm mount -t tmpfs is refused")
    return [*alone, f"{mount} && {script}"]
