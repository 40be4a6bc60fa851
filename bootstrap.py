"""Makes `.venv`: ROS 2 Jazzy and every library from wheels, with this project's packages built into it.

    python3 bootstrap.py            what `make setup` runs; does only what changed since the last time
    python3 bootstrap.py --lock     refresh requirements.lock, what `make lock` runs

Needs nothing but Python itself. Ends with status 0 when `.venv` is ready, 2 when the machine lacks something (one line
says what to install), 1 when a step failed (the line names the step's log).

The virtual environment is one complete ROS prefix: libraries in `.venv/lib`, executables in `.venv/lib/PACKAGE`, where
`ros2 run` looks, package markers in `.venv/share`. Python sources and configuration are linked, not copied: an edit acts
at once. A stamp per step, written when the step has ended, holds a hash of what the step depends on.
"""

from __future__ import annotations

import argparse
import fcntl
import hashlib
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent
VENV = ROOT / ".venv"
STAMPS = VENV / "setup"
LOGS = VENV / "log"
LOCK = ROOT / "requirements.lock"
REQUIREMENTS = ("requirements.txt", "requirements-dev.txt", "requirements-ros.txt")
RECIPE = "1"  # another number makes every checkout install anew: change it when installing or patching changes
PYTHONS = ((3, 10), (3, 13))  # the versions that the ROS wheels are built for
PACKAGES = {  # folder of each ROS package, in the order in which they are built
    "ema_twin_msgs": ROOT / "ema_twin_msgs",
    "ema_twin_config": ROOT / "config",
    "ema_bench_replay": ROOT / "ema_bench_replay",
    "ema_twin_sim": ROOT / "ema_twin_sim",
}
# Variables of another ROS installation or virtual environment, which would mix their libraries into ours.
FOREIGN = (
    "_ROS_WHEELS_BOOTSTRAP_COMPLETE AMENT_PREFIX_PATH CMAKE_PREFIX_PATH COLCON_PREFIX_PATH LD_LIBRARY_PATH"
    " PYTHONHOME PYTHONPATH RMW_IMPLEMENTATION ROS_DISTRO VIRTUAL_ENV"
).split()


class SetupError(Exception):
    """One line for the user; `status` is what the process ends with."""

    def __init__(self, message: str, status: int = 1) -> None:
        super().__init__(message)
        self.status = status


def missing_prerequisites() -> list[tuple[str, str]]:
    """What the machine lacks, each as (what, Debian/Ubuntu package)."""
    python = f"python{sys.version_info.major}.{sys.version_info.minor}"
    header = Path(sysconfig.get_paths()["include"], "Python.h")
    found = {
        ("C compiler", "gcc"): any(map(shutil.which, (os.environ.get("CC", "cc"), "gcc", "clang"))),
        ("C++ compiler", "g++"): any(map(shutil.which, (os.environ.get("CXX", "c++"), "g++", "clang++"))),
        ("CMake", "cmake"): shutil.which("cmake"),
        ("make", "make"): shutil.which("make"),
        (f"{python} venv module", f"{python}-venv"): has_module("venv") and has_module("ensurepip"),
        (f"{python} headers", f"{python}-dev"): header.exists(),
    }
    return [what for what, there in found.items() if not there]


def has_module(name: str) -> bool:
    """Whether this Python has a module that Debian and Ubuntu package apart."""
    try:
        __import__(name)
    except ImportError:
        return False
    return True


def check_prerequisites() -> None:
    """Raise SetupError that names the Debian/Ubuntu package of everything that the machine lacks."""
    if not PYTHONS[0] <= sys.version_info[:2] <= PYTHONS[1]:
        low, high = (".".join(map(str, version)) for version in PYTHONS)
        raise SetupError(
            f"{sys.executable} is Python {sys.version.split()[0]}; ROS 2 Jazzy's wheels need {low} to {high}:"
            f" sudo apt install python3.12-venv python3.12-dev, then make setup PYTHON=python3.12",
            status=2,
        )
    missing = missing_prerequisites()
    if missing:
        what = ", ".join(f"{name} (package {package})" for name, package in missing)
        install = " ".join(package for _, package in missing)
        raise SetupError(f"missing: {what}; install with: sudo apt install {install}", status=2)


def digest(*parts: str | Path) -> str:
    """SHA-256 over strings, and over the names and contents of files, in the order given."""
    total = hashlib.sha256()
    for part in parts:
        total.update(f"\0{part}\0".encode())
        if isinstance(part, Path):
            total.update(part.read_bytes())
    return total.hexdigest()


def library_key() -> str:
    """What the installed libraries depend on: the lock, the recipe, the interpreter, and where `.venv` lies."""
    return digest(LOCK, RECIPE, sys.version, os.path.realpath(sys.executable), str(VENV))


def package_key(name: str) -> str:
    """What the built package `name` depends on. Linked files count with their names only."""
    folder = PACKAGES[name]
    files = sorted(path for path in folder.rglob("*") if path.is_file() and "__pycache__" not in path.parts)
    build_files = ("CMakeLists.txt", "package.xml", "setup.cfg", "setup.py")
    parts: list[str | Path] = [library_key()]
    for path in files:
        if path.name in build_files or path.suffix in (".msg", ".srv"):
            parts.append(path)
        elif name == "ema_twin_config" or path.parent.name in ("resource", "scripts"):
            parts.append(str(path))
    return digest(*parts)


def is_current(step: str, key: str) -> bool:
    """Whether `step` ended once with the same key."""
    try:
        return (STAMPS / step).read_text() == key
    except OSError:
        return False


def stamp(step: str, key: str) -> None:
    """Note that `step` has ended, in one move, so that an interrupted write counts as not done."""
    STAMPS.mkdir(parents=True, exist_ok=True)
    fresh = STAMPS / f"{step}.new"
    fresh.write_text(key)
    fresh.replace(STAMPS / step)


def clean_environment() -> dict[str, str]:
    """The user's environment without what belongs to another ROS installation, with `.venv` as the only prefix."""
    kept = {name: value for name, value in os.environ.items() if name not in FOREIGN}
    kept |= {"AMENT_PREFIX_PATH": str(VENV), "CMAKE_PREFIX_PATH": str(VENV), "COLCON_HOME": str(VENV / "colcon")}
    kept |= {"PIP_DISABLE_PIP_VERSION_CHECK": "1", "PIP_NO_INPUT": "1", "PYTHONNOUSERSITE": "1"}
    return kept


def run(title: str, log: str, *command: str | Path) -> None:
    """Run one command with its output in `.venv/log/LOG`, and say what it does and how long it took.

    Raises SetupError, with the command's last lines, when it fails.
    """
    LOGS.mkdir(parents=True, exist_ok=True)
    path = LOGS / log
    print(f"  {title} ...", end=" ", flush=True)
    begin = time.monotonic()
    with path.open("w") as output:
        status = subprocess.call(
            [str(part) for part in command], stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT,
            cwd=ROOT, env=clean_environment(),
        )  # fmt: skip
    print(f"{time.monotonic() - begin:.0f} s" if status == 0 else "failed", flush=True)
    if status:
        tail = "\n".join(f"    {line}" for line in path.read_text(errors="replace").splitlines()[-12:])
        print(tail, file=sys.stderr)
        raise SetupError(f"{title} failed; all its output is in {path.relative_to(ROOT)}")


def install_libraries() -> None:
    """Make `.venv` afresh and install the lock into it: nothing of an older lock or an interrupted set-up stays."""
    if VENV.exists():
        shutil.rmtree(VENV)
    run("making .venv", "venv.log", sys.executable, "-m", "venv", VENV)
    pip = (VENV / "bin/python", "-m", "pip", "install", "--no-deps", "--requirement", LOCK)
    run("installing ROS 2 and the libraries (a minute or two, 600 MB to download)", "pip.log", *pip)
    patch_cmake_paths()


def site_packages() -> Path:
    """Where `.venv` keeps its Python libraries."""
    return next((VENV / "lib").glob("python3.*/site-packages"))


def patch_cmake_paths() -> None:
    """Put this machine's paths into the wheels' CMake files, which carry those of the machine that built them."""
    cpython = r"/opt/python/cp\d+-cp\d+"
    paths = (
        (re.compile(cpython + r"/lib/python3\.\d+/site-packages"), str(site_packages())),
        (re.compile(cpython + r"/include/python3\.\d+"), sysconfig.get_paths()["include"]),
        (re.compile(cpython), str(VENV)),
    )
    for path in (VENV / "share").rglob("*"):
        if not path.is_file() or b"/opt/python/cp" not in path.read_bytes():
            continue
        try:
            text = path.read_text()
        except UnicodeDecodeError:
            continue
        for pattern, replacement in paths:
            text = pattern.sub(replacement, text)
        path.write_text(text)


def build_packages(names: list[str]) -> None:
    """Build ROS packages into `.venv`, where what an earlier build of them left is removed first."""
    site = site_packages()
    for name in names:
        for stale in (VENV / "build" / name, VENV / "share" / name, VENV / "include" / name, site / name):
            shutil.rmtree(stale, ignore_errors=True)
        for library in (VENV / "lib").glob(f"lib{name}__*"):
            library.unlink()
    run(
        f"building {', '.join(names)}", "colcon.log", VENV / "bin/python", "-m", "colcon",
        "--log-base", VENV / "log/colcon", "build", "--merge-install", "--symlink-install",
        "--install-base", VENV, "--build-base", VENV / "build",
        "--base-paths", *PACKAGES.values(), "--packages-select", *names,
        "--cmake-args", "-DBUILD_TESTING=OFF", "-DCMAKE_BUILD_TYPE=Release",
    )  # fmt: skip

    link_sources(site)


def link_sources(site: Path) -> None:
    """Let `.venv/bin/python` import the Python packages from the checkout, and find their entry points, with nothing sourced."""
    python_packages = [name for name, folder in PACKAGES.items() if (folder / "setup.py").exists()]
    lines = [str(PACKAGES[name]) for name in python_packages] + [str(VENV / "build" / name) for name in python_packages]
    (site / "ema_twin.pth").write_text("\n".join(lines) + "\n")


def setup() -> None:
    """Bring `.venv` up to date, one caller at a time."""
    with (ROOT / ".setup.lock").open("w") as handle:
        fcntl.flock(handle, fcntl.LOCK_EX)
        begin = time.monotonic()
        libraries = library_key()
        outdated = [name for name in PACKAGES if not is_current(name, package_key(name))]
        if is_current("libraries", libraries) and not outdated:
            return
        check_prerequisites()
        print("Setting up .venv (once; a later run only does what changed)", flush=True)
        if not is_current("libraries", libraries):
            install_libraries()
            stamp("libraries", libraries)
        build_packages(outdated)
        for name in outdated:
            stamp(name, package_key(name))
        print(f"Set-up done in {time.monotonic() - begin:.0f} s", flush=True)


def refresh_lock() -> None:
    """Resolve the requirements anew, for all Python versions at once, and write requirements.lock."""
    with tempfile.TemporaryDirectory() as folder:
        run("getting the resolver", "lock.log", sys.executable, "-m", "venv", folder)
        python = Path(folder, "bin/python")
        run("getting the resolver", "lock.log", python, "-m", "pip", "install", "uv")
        low = ".".join(map(str, PYTHONS[0]))
        run(
            "resolving", "lock.log", python, "-m", "uv", "pip", "compile", "--universal", "--upgrade",
            "--python-version", low, "--no-annotate", "--custom-compile-command", "make lock",
            *REQUIREMENTS, "--output-file", LOCK,
        )  # fmt: skip


def main() -> int:
    """Command line; returns the process's status."""
    parser = argparse.ArgumentParser(description="Make .venv, with ROS 2 and this project's packages in it.")
    parser.add_argument("--lock", action="store_true", help="refresh requirements.lock instead")
    arguments = parser.parse_args()
    try:
        refresh_lock() if arguments.lock else setup()
    except SetupError as error:
        print(f"set-up: {error}", file=sys.stderr)
        return error.status
    except KeyboardInterrupt:
        print("\nset-up: interrupted; run it again to go on", file=sys.stderr)
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
