"""The set-up does only what changed, says what the machine lacks, and leaves packages that ROS 2's own tools find."""

import importlib.util
import os
import re
import shutil
import stat
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
VENV = ROOT / ".venv"
EXECUTABLES = {"ema_bench_replay": {"record", "replay"}, "ema_twin_sim": {"ema-twin", "monitor", "twin"}}
SETUP_FILES = ("bootstrap.py", "requirements.lock", "ema_twin_msgs", "config", "ema_bench_replay", "ema_twin_sim")
BARE = {name: os.environ[name] for name in ("HOME", "PATH") if name in os.environ}


@pytest.fixture
def checkout(tmp_path):
    """A copy of what the set-up reads."""
    for name in SETUP_FILES:
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(ROOT / name, tmp_path)
    return tmp_path


def bootstrap_of(checkout):
    """The checkout's bootstrap.py as a module."""
    spec = importlib.util.spec_from_file_location("bootstrap", checkout / "bootstrap.py")
    bootstrap = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(bootstrap)
    return bootstrap


def load_bootstrap(checkout):
    """The same, with its steps noted instead of run."""
    bootstrap = bootstrap_of(checkout)
    bootstrap.steps = []

    def note(title, log, *command, variables=None):
        step = log.removesuffix(".log")
        built = [name for name, folder in bootstrap.PACKAGES.items() if folder in command]
        if step not in ("compileall", "uv"):  # one follows every build, the other installs what installs
            bootstrap.steps.append((step, *built) if built else step)
        (checkout / ".venv/lib/python3.11/site-packages").mkdir(parents=True, exist_ok=True)
        (checkout / ".venv/bin").mkdir(exist_ok=True)
        if not (checkout / ".venv/bin/python").exists():
            (checkout / ".venv/bin/python").symlink_to(sys.executable)

    bootstrap.run = note
    return bootstrap


def set_up_again(bootstrap):
    """The steps of another set-up."""
    bootstrap.steps.clear()
    bootstrap.setup()
    return bootstrap.steps


@contextmanager
def after_step(bootstrap, step, act):
    """Within, something happens as soon as a step has been run."""
    note = bootstrap.run

    def run(title, log, *command, **settings):
        note(title, log, *command, **settings)
        if log == f"{step}.log":
            act()

    bootstrap.run = run
    yield
    bootstrap.run = note


def append(path, text):
    with path.open("a") as file:
        file.write(text)


def interrupt():
    raise KeyboardInterrupt


@pytest.fixture
def done(checkout):
    """A checkout whose set-up has ended."""
    bootstrap = load_bootstrap(checkout)
    bootstrap.setup()
    bootstrap.steps.clear()
    return bootstrap


ALL = ("colcon", "ema_twin_msgs", "ema_twin_config", "ema_bench_replay", "ema_twin_sim")


def test_first_setup_does_everything_and_a_second_nothing(checkout):
    bootstrap = load_bootstrap(checkout)
    bootstrap.setup()
    assert bootstrap.steps == ["venv", "libraries", "rerun", ALL]
    assert set_up_again(bootstrap) == []


def test_a_lock_edited_while_it_is_installed_does_not_count_as_installed(checkout):
    bootstrap = load_bootstrap(checkout)
    with (
        after_step(bootstrap, "libraries", lambda: append(bootstrap.LOCK, "# edited\n")),
        pytest.raises(bootstrap.SetupError, match=r"requirements\.lock changed while"),
    ):
        bootstrap.setup()
    assert set_up_again(bootstrap) == ["venv", "libraries", "rerun", ALL]


def test_a_message_edited_while_it_is_built_is_built_again(checkout):
    bootstrap = load_bootstrap(checkout)
    message = checkout / "ema_twin_msgs/msg/Signals.msg"
    with after_step(bootstrap, "colcon", lambda: append(message, "# edited\n")):
        bootstrap.setup()
    assert set_up_again(bootstrap) == [("colcon", "ema_twin_msgs")]


@pytest.mark.parametrize(
    ("changed", "steps"),
    [
        ("ema_twin_sim/ema_twin_sim/__init__.py", []),
        ("ema_bench_replay/ema_bench_replay/new_module.py", []),
        ("config/README.md", []),
        ("ema_twin_msgs/msg/Signals.msg", [("colcon", "ema_twin_msgs")]),
        ("config/models/new_machine.yaml", [("colcon", "ema_twin_config")]),
        ("ema_twin_sim/setup.py", [("colcon", "ema_twin_sim")]),
        ("requirements.lock", ["venv", "libraries", "rerun", ALL]),
    ],
)
def test_only_what_changed_is_done(done, changed, steps):
    path = done.ROOT / changed
    append(path, "\n")
    done.setup()
    assert done.steps == steps


def test_an_edited_model_needs_no_setup(done):
    for model in (done.ROOT / "config").rglob("*.yaml"):
        append(model, "\n# edited\n")
    done.setup()
    assert done.steps == []


@pytest.mark.parametrize(
    ("interrupted", "remaining"), [("libraries", ["venv", "libraries", "rerun", ALL]), ("colcon", [ALL])]
)
def test_interrupted_setup_goes_on_at_the_step_that_did_not_end(checkout, interrupted, remaining):
    bootstrap = load_bootstrap(checkout)
    with after_step(bootstrap, interrupted, interrupt), pytest.raises(KeyboardInterrupt):
        bootstrap.setup()
    assert set_up_again(bootstrap) == remaining


def test_interrupted_rebuild_is_not_taken_for_done_when_the_change_is_undone(done):
    message = done.ROOT / "ema_twin_msgs/msg/Signals.msg"
    original = message.read_text()
    message.write_text(original + "float64 another  # [1]\n")
    with after_step(done, "colcon", interrupt), pytest.raises(KeyboardInterrupt):
        done.setup()
    message.write_text(original)
    assert set_up_again(done) == [("colcon", "ema_twin_msgs")]


def run_bootstrap(checkout, tools):
    """Run the set-up where only the named tools exist."""
    path = checkout / "tools"
    path.mkdir()
    for tool in tools:
        (path / tool).symlink_to(shutil.which(tool))
    command = [sys.executable, checkout / "bootstrap.py"]
    flag = {"_ROS_WHEELS_BOOTSTRAP_COMPLETE": "1"}  # no second start of Python, which would look for itself on PATH
    return subprocess.run(command, env={"PATH": str(path), **flag}, capture_output=True, text=True)


def test_missing_tools_are_named_with_their_packages(checkout):
    result = run_bootstrap(checkout, [])
    assert result.returncode == 2
    assert result.stderr.count("\n") == 1
    assert "sudo apt install gcc g++ cmake make" in result.stderr
    assert not (checkout / ".venv").exists()


def test_one_missing_tool_is_named_alone(checkout):
    result = run_bootstrap(checkout, ["cc", "c++", "make"])
    assert result.returncode == 2
    assert result.stderr == "set-up: missing: cmake; on Debian or Ubuntu: sudo apt install cmake\n"


def test_missing_venv_module_is_named(checkout, monkeypatch):
    bootstrap = load_bootstrap(checkout)
    monkeypatch.setattr(bootstrap.importlib.util, "find_spec", lambda name: None)
    version = f"{sys.version_info[0]}.{sys.version_info[1]}"
    with pytest.raises(bootstrap.SetupError, match=f"sudo apt install python{version}-venv") as error:
        bootstrap.check_prerequisites()
    assert error.value.status == 2


def test_unsupported_python_is_refused_with_a_remedy(checkout, monkeypatch):
    bootstrap = load_bootstrap(checkout)
    monkeypatch.setattr(bootstrap.sys, "version_info", (3, 9, 18))
    with pytest.raises(bootstrap.SetupError, match=r"need 3\.10 to 3\.13; .*PYTHON=python3\.12") as error:
        bootstrap.check_python()
    assert error.value.status == 2


def test_failed_step_names_its_log(checkout, capsys):
    fresh = bootstrap_of(checkout)
    with pytest.raises(fresh.SetupError, match=r"trying: failed with status 3; .*trying\.log"):
        fresh.run("trying", "trying.log", sys.executable, "-c", "print('why it failed'); raise SystemExit(3)")
    assert "why it failed" in capsys.readouterr().err
    assert "why it failed" in (checkout / ".venv/log/trying.log").read_text()


def test_pip_installs_the_libraries_where_uv_fails(checkout, capsys):
    bootstrap = load_bootstrap(checkout)
    note = bootstrap.run

    def fail_uv(title, log, *command, **settings):
        if "bin/uv" in str(command[0]):
            raise bootstrap.SetupError("installing ROS 2 and the libraries: failed with status 2")
        note(title, log, *command, **settings)

    bootstrap.run = fail_uv
    bootstrap.setup()
    assert bootstrap.steps == ["venv", "pip", "rerun", ALL]
    assert "failed with status 2; pip is tried in its place" in capsys.readouterr().err


def test_uv_installs_from_where_pip_would(done, checkout, monkeypatch):
    for name in [name for name in os.environ if name.startswith("PIP_")]:
        monkeypatch.delenv(name)
    configuration = checkout / "pip.conf"
    configuration.write_text(
        "[global]\nproxy = http://of.all:3128\nno-index = true\nfind-links =\n  /opt/wheels\n  /srv/wheels\n"
        "[install]\nproxy = http://of.installs:3128\nno-cache-dir = false\n"
    )
    monkeypatch.setenv("PIP_CONFIG_FILE", str(configuration))
    monkeypatch.setenv("PIP_DEFAULT_TIMEOUT", "180")
    settings = done.uv_settings()
    assert settings["ALL_PROXY"] == "http://of.installs:3128"
    assert settings["UV_FIND_LINKS"] == "/opt/wheels,/srv/wheels"
    assert settings["UV_HTTP_TIMEOUT"] == "180" and settings["UV_NO_INDEX"] == "true"
    assert not any("CACHE" in name for name in settings)
    monkeypatch.setenv("PIP_PROXY", "http://own:3128")
    monkeypatch.setenv("PIP_FIND_LINKS", "")
    settings = done.uv_settings()
    assert settings["ALL_PROXY"] == "http://own:3128"
    assert settings["UV_FIND_LINKS"] == "/opt/wheels,/srv/wheels"


def test_who_asks_for_the_setup_alone_is_told_the_next_step(checkout, done, monkeypatch, capsys):
    for arguments, told in (([], False), (["--next"], True)):
        monkeypatch.setattr(sys, "argv", ["bootstrap.py", *arguments])
        assert done.main() == 0
        lines = capsys.readouterr().out.splitlines()
        assert ("  ema-twin --help" in lines) is told
    assert any(f"{checkout}/.venv/bin" in line for line in lines)
    commands = {
        goal: subprocess.run(["make", "-n", goal], cwd=ROOT, capture_output=True, text=True, check=True).stdout
        for goal in ("setup", "demo")
    }
    assert "bootstrap.py --next" in commands["setup"] and "--next" not in commands["demo"]


def test_foreign_variables_are_cleared_everywhere(done, monkeypatch):
    for name in done.FOREIGN:
        monkeypatch.setenv(name, "foreign")
    environment = done.clean_environment()
    assert "foreign" not in environment.values()
    makefile = (ROOT / "Makefile").read_text()
    unexported = re.search(r"^unexport ((?:.*\\\n)*.*)", makefile, re.M)[1].replace("\\", "").split()
    assert sorted(unexported) == sorted(done.FOREIGN)


@pytest.fixture
def prefix(tmp_path):
    """A prefix whose command prints its environment."""
    root = tmp_path / "a prefix"
    for folder in ("bin", "lib/ema_twin_sim", "lib/python3.11/site-packages/ros_rclpy.libs"):
        (root / folder).mkdir(parents=True)
    shutil.copy(ROOT / "ema_twin_sim/scripts/ema-twin", root / "bin")
    command = root / "lib/ema_twin_sim/ema-twin"
    command.write_text('#!/bin/sh\nprintf "%s\\n" "$@"\nenv\n')
    command.chmod(command.stat().st_mode | stat.S_IXUSR)
    return root


def environment_of_command(command, *arguments):
    """Arguments that the command was started with, and its environment, when started from a foreign one."""
    foreign = dict.fromkeys(("LD_LIBRARY_PATH", "PYTHONPATH", "AMENT_PREFIX_PATH", "RMW_IMPLEMENTATION"), "foreign")
    result = subprocess.run([command, *arguments], env={**BARE, **foreign}, capture_output=True, text=True, check=True)
    lines = result.stdout.splitlines()
    return lines[: len(arguments)], dict(line.split("=", 1) for line in lines[len(arguments) :] if "=" in line)


def test_command_uses_its_own_virtual_environment_whole(prefix, tmp_path):
    (prefix / "pyvenv.cfg").touch()
    python = prefix / "bin/python"
    python.write_text('#!/bin/sh\nshift 3\nprintf "%s\\n" "$@"\nenv\n')  # without -S -c PROGRAM
    python.chmod(0o755)
    link = tmp_path / "link"
    link.symlink_to(prefix / "bin/ema-twin")
    for command in (prefix / "bin/ema-twin", link):
        arguments, environment = environment_of_command(command, "compare", "two words")
        assert arguments == ["compare", "two words"]
        assert "foreign" not in environment.values()
        assert environment["AMENT_PREFIX_PATH"] == str(prefix)
        libraries = environment["LD_LIBRARY_PATH"].split(":")
        assert libraries == [str(prefix / "lib"), str(prefix / "lib/python3.11/site-packages/ros_rclpy.libs")]


def test_command_leaves_a_sourced_environment_alone(prefix):
    _, environment = environment_of_command(prefix / "bin/ema-twin")
    assert environment["AMENT_PREFIX_PATH"] == environment["LD_LIBRARY_PATH"] == "foreign"


@pytest.mark.parametrize("package", ["ema_twin_msgs", "ema_twin_config", *EXECUTABLES])
def test_packages_lie_where_ros_looks(package):
    assert (VENV / "share/ament_index/resource_index/packages" / package).exists()
    assert (VENV / "share" / package / "package.xml").is_file()
    for executable in EXECUTABLES.get(package, ()):
        assert os.access(VENV / "lib" / package / executable, os.X_OK)


def test_every_configuration_file_is_installed():
    files = [path.relative_to(ROOT / "config") for path in (ROOT / "config").glob("*/**/*") if path.is_file()]
    files = [path for path in files if "__pycache__" not in path.parts]
    assert files
    for path in files:
        assert (VENV / "share/ema_twin_config" / path).resolve() == ROOT / "config" / path


def test_packages_import_from_the_checkout_with_nothing_sourced():
    program = (
        "import ema_bench_replay, ema_twin_sim, ema_twin_msgs.msg, ema_twin_msgs.srv, rclpy\n"
        "print(ema_bench_replay.__file__, ema_twin_sim.__file__, rclpy.__file__, sep='\\n')"
    )
    command = [VENV / "bin/python", "-c", program]
    result = subprocess.run(command, cwd="/", env=BARE, capture_output=True, text=True, check=True)
    replay, sim, rclpy = map(Path, result.stdout.splitlines())
    assert (replay.parents[2], sim.parents[2]) == (ROOT, ROOT)
    assert VENV in rclpy.parents


def test_lock_pins_every_requirement():
    lines = [line for line in (ROOT / "requirements.lock").read_text().splitlines() if line and line[0] != "#"]
    assert [line for line in lines if not re.fullmatch(r"[\w.-]+==[\w.+-]+( ; .+)?", line)] == []
    pinned = {line.partition("==")[0] for line in lines}
    for file in ROOT.glob("requirements*.txt"):
        named = re.findall(r"^[\w.-]+", file.read_text(), re.M)
        assert {name.lower().replace("_", "-") for name in named} <= pinned


@pytest.mark.parametrize("package", EXECUTABLES)
def test_package_declares_the_ros_packages_that_it_imports(package):
    known = {path.name for path in (VENV / "share/ament_index/resource_index/packages").iterdir()}
    sources = "\n".join(path.read_text() for path in (ROOT / package).rglob("*.py"))
    imported = set(re.findall(r"^ *(?:from|import) (\w+)", sources, re.M)) & known - {package}
    declared = set(re.findall(r"<exec_depend>(\w+)</exec_depend>", (ROOT / package / "package.xml").read_text()))
    assert imported <= declared
    assert declared & known <= imported | {"ema_twin_config"}
