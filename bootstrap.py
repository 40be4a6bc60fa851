"""Makes `.venv`: ROS 2 Jazzy and every library from wheels, with this project's packages built into it.

`make setup` runs it, with any Python from 3.10 and nothing else installed. Status 0: `.venv` is ready; 2: the machine
lacks something, and one line says what to install; 1: a step failed, and one line names the file that holds its output.

The virtual environment is one complete ROS prefix: libraries in `.venv/lib`, executables in `.venv/lib/PACKAGE`, where
`ros2 run` looks, package markers in `.venv/share`. Python sources and configuration are linked, not copied: an edit
acts at once. A stamp per step, written when the step has ended, holds a hash of what the step depends on.
"""

from __future__ import annotations

import fcntl
import hashlib
import importlib.util
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import sysconfig
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).resolve().parent
VENV = ROOT / ".venv"
STAMPS = VENV / "setup"
LOGS = VENV / "log"
LOCK = ROOT / "requirements.lock"
RECIPE = "1"  # another number makes every checkout install anew: change it with what install_libraries does
PYTHONS = ((3, 10), (3, 13))  # the versions that the ROS wheels are built for
PACKAGES = {  # folder of each ROS package
    "ema_twin_msgs": ROOT / "ema_twin_msgs",
    "ema_twin_config": ROOT / "config",
    "ema_bench_replay": ROOT / "ema_bench_replay",
    "ema_twin_sim": ROOT / "ema_twin_sim",
}
PYTHON_PACKAGES = ("ema_bench_replay", "ema_twin_sim")
# Variables of another ROS installation or virtual environment, which would mix their libraries into ours.
FOREIGN = (
    "_ROS_WHEELS_BOOTSTRAP_COMPLETE",
    "AMENT_PREFIX_PATH",
    "CMAKE_PREFIX_PATH",
    "COLCON_PREFIX_PATH",
    "LD_LIBRARY_PATH",
    "PYTHONHOME",
    "PYTHONPATH",
    "RMW_IMPLEMENTATION",
    "ROS_DISTRO",
    "VIRTUAL_ENV",
)


class SetupError(Exception):
    """One line for the user; `status` is what the process ends with."""

    def __init__(self, message: str, status: int = 1) -> None:
        super().__init__(message)
        self.status = status


def check_python() -> None:
    """Raise SetupError where this Python is not one that the ROS wheels are built for."""
    if not PYTHONS[0] <= sys.version_info[:2] <= PYTHONS[1]:
        low, high = (".".join(map(str, version)) for version in PYTHONS)
        raise SetupError(
            f"{sys.executable} is Python {sys.version.split()[0]}, the ROS 2 wheels need {low} to {high}; install one"
            " (sudo apt install python3.12-venv python3.12-dev) and name it: make setup PYTHON=python3.12",
            status=2,
        )


def check_prerequisites() -> None:
    """Raise SetupError that names the Debian/Ubuntu package of everything that building needs and the machine lacks."""
    python = f"python{sys.version_info[0]}.{sys.version_info[1]}"
    has_module = importlib.util.find_spec
    prerequisites = {
        ("a C compiler", "gcc"): any(map(shutil.which, (os.environ.get("CC", "cc"), "gcc", "clang"))),
        ("a C++ compiler", "g++"): any(map(shutil.which, (os.environ.get("CXX", "c++"), "g++", "clang++"))),
        ("cmake", "cmake"): shutil.which("cmake"),
        ("make", "make"): shutil.which("make"),
        (f"{python}'s venv", f"{python}-venv"): has_module("venv") and has_module("ensurepip"),
        (f"{python}'s headers", f"{python}-dev"): Path(sysconfig.get_paths()["include"], "Python.h").exists(),
    }
    missing = [names for names, there in prerequisites.items() if not there]
    if missing:
        what = ", ".join(name for name, _ in missing)
        packages = " ".join(package for _, package in missing)
        raise SetupError(f"missing: {what}; on Debian or Ubuntu: sudo apt install {packages}", status=2)


def digest(*parts: str | Path) -> str:
    """SHA-256 over strings, and over the names and contents of files, in the order given."""
    total = hashlib.sha256()
    for part in parts:
        total.update(f"\0{part}\0".encode())
        if isinstance(part, Path):
            total.update(part.read_bytes())
    return total.hexdigest()


def library_key() -> str:
    """What the installed libraries depend on: the lock, the recipe, where `.venv` lies and which Python is in it.

    That need not be the Python that runs this file: `.venv` keeps its own, until `make clean`.
    """
    return digest(LOCK, RECIPE, str(VENV), os.path.realpath(VENV / "bin/python"))


def package_key(name: str) -> str:
    """What a built package depends on. A linked file counts with its name only: its content is read where it lies."""
    built = {"CMakeLists.txt", "package.xml", "setup.cfg", "setup.py"}
    linked = {"blueprints", "launch", "layouts", "maps", "models", "resource", "scripts", "urdf"}
    folder = PACKAGES[name]
    parts: list[str | Path] = [library_key()]
    for path in sorted(folder.rglob("*")):
        if path.name in built or path.suffix in (".msg", ".srv"):
            parts.append(path)
        elif path.relative_to(folder).parts[0] in linked and "__pycache__" not in path.parts:
            parts.append(str(path))
    return digest(*parts)


def is_current(step: str, key: str) -> bool:
    """Whether `step` has ended with the same key."""
    try:
        return (STAMPS / step).read_text() == key and (VENV / "bin/python").exists()
    except OSError:
        return False


def stamp(step: str, key: str) -> None:
    """Note that `step` has ended, in one move: an interrupted write counts as not done."""
    STAMPS.mkdir(parents=True, exist_ok=True)
    fresh = STAMPS / f"{step}.new"
    fresh.write_text(key)
    fresh.replace(STAMPS / step)


def clean_environment() -> dict[str, str]:
    """The user's environment without what belongs to another ROS installation, with `.venv` as the only prefix."""
    kept = {name: value for name, value in os.environ.items() if name not in FOREIGN}
    ours = {
        "AMENT_PREFIX_PATH": VENV,
        "CMAKE_PREFIX_PATH": VENV,
        "COLCON_DEFAULTS_FILE": os.devnull,
        "COLCON_HOME": VENV / "etc/colcon",
        "PIP_DISABLE_PIP_VERSION_CHECK": 1,
        "PIP_NO_INPUT": 1,
        "PYTHONNOUSERSITE": 1,
    }
    return kept | {name: str(value) for name, value in ours.items()}


def uv_settings() -> dict[str, str]:
    """Where pip takes packages from (by its files and PIP_ variables), and how, as variables of uv."""
    names = {
        "find-links": "UV_FIND_LINKS",
        "trusted-host": "UV_INSECURE_HOST",
        "proxy": "ALL_PROXY",
        "cert": "SSL_CERT_FILE",
        "default-timeout": "UV_HTTP_TIMEOUT",
        "timeout": "UV_HTTP_TIMEOUT",
    }
    listed = subprocess.run(
        [VENV / "bin/python", "-m", "pip", "config", "list"],
        env=clean_environment(), stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False,
    ).stdout  # fmt: skip
    # uv takes the machine's certificates as pip does; links into its cache would carry edits of one .venv into the next
    settings = {"UV_LINK_MODE": "copy", "UV_SYSTEM_CERTS": "1", "UV_INDEX_STRATEGY": "unsafe-best-match"}
    # global, then install's own, then variables: the later one counts, as for pip
    found = re.findall(r"^(global|install|:env:)\.([\w-]+)='(.*)'$", listed, re.M)
    for _, option, value in sorted(found, key=lambda setting: ("global", "install", ":env:").index(setting[0])):
        # what is about an index, uv calls alike; pip takes an empty value as none
        name = f"UV_{option.upper().replace('-', '_')}" if "index" in option else names.get(option)
        if name is not None and value.strip():
            between = "," if option == "find-links" else " "
            settings[name] = between.join(value.replace("\\n", " ").split())
    return settings


def run(title: str, log: str, *command: str | Path, variables: dict[str, str] | None = None) -> None:
    """Run one command with its output in `.venv/log/LOG`; say what it does and how long it took.

    `variables` are added to its environment.

    Raises SetupError when it fails, after the last lines of its output.
    """
    LOGS.mkdir(parents=True, exist_ok=True)
    path = LOGS / log
    print(f"  {title} ...", end=" ", flush=True)
    begin = time.monotonic()
    arguments = [str(part) for part in command]
    with path.open("w") as output, subprocess.Popen(
        arguments, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT,
        cwd=ROOT, env=clean_environment() | (variables or {}), start_new_session=True, close_fds=False,
    ) as process:  # fmt: skip
        try:
            status = process.wait()
        except BaseException:
            os.killpg(process.pid, signal.SIGKILL)  # its own children too: none may go on writing into .venv
            raise
    print(f"{time.monotonic() - begin:.0f} s" if status == 0 else "failed", flush=True)
    if status:
        for line in path.read_text(errors="replace").splitlines()[-10:]:
            print(f"    {line}", file=sys.stderr)
        what = title.partition(" (")[0]
        raise SetupError(f"{what}: failed with status {status}; its whole output is in {path}")


def site_packages() -> Path:
    """Where `.venv` keeps its Python libraries."""
    return next((VENV / "lib").glob("python3.*/site-packages"))


def install_libraries() -> None:
    """Make `.venv` afresh from the lock: nothing of an older lock or of an interrupted set-up stays."""
    if VENV.exists():
        shutil.rmtree(VENV)
    run("making .venv", "venv.log", sys.executable, "-m", "venv", VENV)
    pip = (VENV / "bin/python", "-m", "pip", "install", "--no-deps")
    title = "installing ROS 2 and the libraries"
    uv = next(line for line in LOCK.read_text().splitlines() if line.startswith("uv=="))
    try:  # uv takes a quarter of pip's time
        run("installing uv, which installs the libraries", "uv.log", *pip, uv)
        run(
            f"{title} (a minute, longer where 500 MB must be downloaded first)", "libraries.log",
            VENV / "bin/uv", "pip", "install", "--python", VENV / "bin/python", "--compile-bytecode", "--no-deps",
            "--requirement", LOCK, variables=uv_settings(),
        )  # fmt: skip
    except SetupError as error:
        print(f"  {error}; pip is tried in its place", file=sys.stderr)
        run(f"{title} with pip (some minutes)", "pip.log", *pip, "--requirement", LOCK)
    patch_cmake_paths()
    run(
        "turning off the usage statistics of rerun's viewer, in .venv/etc", "rerun.log",
        "env", f"XDG_CONFIG_HOME={VENV / 'etc'}", f"XDG_DATA_HOME={VENV / 'etc'}",
        VENV / "bin/rerun", "analytics", "disable",
    )  # fmt: skip


def patch_cmake_paths() -> None:
    """Put this machine's paths into the wheels' CMake files, which carry those of the machine that built them."""
    cpython = rb"/opt/python/cp\d+-cp\d+"
    paths = (
        (cpython + rb"/lib/python3\.\d+/site-packages", site_packages()),
        (cpython + rb"/include/python3\.\d+", sysconfig.get_paths()["include"]),
        (cpython, VENV),
    )
    for path in (VENV / "share").rglob("*"):
        text = path.read_bytes() if path.is_file() else b""
        if b"/opt/python/cp" not in text:
            continue
        for pattern, replacement in paths:
            text = re.sub(pattern, os.fsencode(replacement).replace(b"\\", rb"\\"), text)
        path.write_bytes(text)


def build_packages(names: list[str]) -> None:
    """Build ROS packages into `.venv`, after removing what an earlier build of them left."""
    site = site_packages()
    for name in names:
        (STAMPS / name).unlink(missing_ok=True)
        for folder in (VENV / "build", VENV / "include", VENV / "lib", VENV / "share", site):
            shutil.rmtree(folder / name, ignore_errors=True)
        for library in (VENV / "lib").glob(f"lib{name}__*"):
            library.unlink()
    run(
        f"building {', '.join(names)}", "colcon.log", VENV / "bin/python", "-m", "colcon",
        "--log-base", LOGS / "colcon", "build", "--merge-install", "--symlink-install",
        "--install-base", VENV, "--build-base", VENV / "build",
        "--base-paths", *(PACKAGES[name] for name in names),
        "--cmake-args", "-DBUILD_TESTING=OFF", "-DCMAKE_BUILD_TYPE=Release",
    )  # fmt: skip
    # colcon's links serve a sourced shell only; these lines make the checkout's packages, and the entry points that the
    # build wrote beside its links, known to .venv/bin/python with nothing sourced.
    folders = [PACKAGES[name] for name in PYTHON_PACKAGES] + [VENV / "build" / name for name in PYTHON_PACKAGES]
    (site / "ema_twin.pth").write_text("".join(f"{folder}\n" for folder in folders))
    # containers often set PYTHONDONTWRITEBYTECODE; every start would compile the sources again, for a quarter second
    run(
        "compiling the Python sources", "compileall.log", VENV / "bin/python", "-m", "compileall", "-q",
        *(PACKAGES[name] for name in PYTHON_PACKAGES),
    )  # fmt: skip


@contextmanager
def only_one() -> Iterator[None]:
    """Let one set-up of this checkout run at a time."""
    with (ROOT / ".venv.lock").open("w") as handle:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            print("waiting for another set-up of this checkout to end", flush=True)
            fcntl.flock(handle, fcntl.LOCK_EX)
        os.set_inheritable(handle.fileno(), True)  # a step that survives the killing of this process keeps the lock
        yield


def setup() -> None:
    """Bring `.venv` up to date; where nothing changed, start no process."""
    begin = time.monotonic()
    if not is_current("libraries", library_key()):
        check_python()
        check_prerequisites()
        print("Setting up .venv, once; a later run does only what changed", flush=True)
        lock = LOCK.read_bytes()
        install_libraries()
        if LOCK.read_bytes() != lock:
            raise SetupError(
                f"{LOCK.name} changed while it was being installed; set up again to install what it says now"
            )
        stamp("libraries", library_key())
    keys = {name: package_key(name) for name in PACKAGES}  # of what is built now, whatever is edited meanwhile
    outdated = [name for name in PACKAGES if not is_current(name, keys[name])]
    if outdated:
        build_packages(outdated)
        for name in outdated:
            stamp(name, keys[name])
        print(f"  .venv is ready after {time.monotonic() - begin:.0f} s", flush=True)


def print_next_steps() -> None:
    """Tell what can be done with `.venv`."""
    print(
        "Next: put ema-twin on your path, and see what it does:\n"
        f'  export PATH={shlex.quote(str(VENV / "bin"))}:"$PATH"\n'
        "  ema-twin --help\n"
        "  make demo",
        flush=True,
    )


def interrupt(signal_number: int, frame: object) -> None:
    """End on SIGTERM as on Ctrl-C."""
    raise KeyboardInterrupt


def main() -> int:
    """Set up, and with the argument --next tell how to go on; returns the process's status."""
    signal.signal(signal.SIGTERM, interrupt)
    try:
        with only_one():
            setup()
        if "--next" in sys.argv[1:]:
            print_next_steps()
    except (SetupError, OSError) as error:
        print(f"set-up: {error}", file=sys.stderr)
        return getattr(error, "status", 1)
    except KeyboardInterrupt:
        print("\nset-up: interrupted; the next run goes on", file=sys.stderr)
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
