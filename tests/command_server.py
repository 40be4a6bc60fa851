"""``ema-twin`` without its start: a process that has read all libraries, and gives each command to a child of its own.

A command takes one to two seconds to start, most of it for reading libraries, and the tests give some hundred. What a
child does is the command: its arguments, folder, streams and exit status are its own, and nothing of it is left behind.
What starts nodes or other processes is not given to it, nor what tests the start itself. Where a test process runs on
every core, commands run in one thread.
"""

import atexit
import gc
import json
import os
import subprocess
import sys
import tempfile
import threading
from importlib import import_module
from pathlib import Path

from tests.child import exit_status

_AGREED = "ema-twin command server"
_READ = ("discovery.diagnose", "discovery.plan", "fitting.fit", "new_machine.drafts", "report.page")
"""With what these import, what most commands need."""


class CommandServer:
    """The process, and how commands are given to it, one after another."""

    def __init__(self, environment):
        ours, theirs = os.pipe(), os.pipe()
        self._process = subprocess.Popen(
            [sys.executable, "-m", __name__, str(ours[0]), str(theirs[1])],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            env=environment, cwd=Path(__file__).resolve().parents[1], pass_fds=(ours[0], theirs[1]),
        )  # fmt: skip
        os.close(ours[0])
        os.close(theirs[1])
        self._orders, self._answers = os.fdopen(ours[1], "w"), os.fdopen(theirs[0])
        assert self._answers.readline().strip() == _AGREED, self._process.communicate()[1].decode()
        atexit.register(self.close)

    def run(self, arguments, cwd, timeout, answers):
        """As ``subprocess.run`` with captured text. Raises subprocess.TimeoutExpired."""
        with tempfile.TemporaryDirectory() as folder:
            streams = [Path(folder) / name for name in ("in", "out", "err")]
            streams[0].write_text(answers or "")
            status = self.give(arguments, cwd or Path.cwd(), timeout, streams)
            if status is None:
                raise subprocess.TimeoutExpired(["ema-twin", *arguments], timeout)
            out, err = (path.read_text() for path in streams[1:])
            return subprocess.CompletedProcess(["ema-twin", *arguments], status, out, err)

    def give(self, arguments, cwd, timeout, streams, **environment):
        """The exit status of a command that reads from the first of three files, and writes to the others.

        ``environment`` is its own beside the server's. None where it took too long.
        """
        order = {"arguments": arguments, "cwd": str(cwd), "timeout": timeout, "streams": [*map(str, streams)]}
        order["environment"] = environment
        print(json.dumps(order), file=self._orders, flush=True)
        return json.loads(self._answers.readline())

    def close(self):
        self._orders.close()
        self._process.wait()


def serve(orders, answers):
    """Take orders, a line each, until nobody can give any more."""
    for name in _READ:
        import_module(f"ema_twin_sim.{name}")
    from ema_twin_sim import compare, load_model, parse_command, virtual_bench
    from ema_twin_sim.commands.main import application

    application()  # imports every verb
    stock = load_model("polito_bench")
    compare([virtual_bench(stock, parse_command("ramp:0.05"), 0.2)], stock)  # its kernels are loaded
    gc.collect()
    gc.freeze()
    print(_AGREED, file=answers, flush=True)
    for line in orders:
        print(json.dumps(_given_to_a_child(json.loads(line))), file=answers, flush=True)


def _given_to_a_child(order):
    """The exit status of a command; None where it took too long."""
    child = os.fork()
    if child == 0:
        _become(order)
    return exit_status(child, order["timeout"])


def _become(order):
    """The command itself, from its arguments to its exit."""
    from ema_twin_sim.entry import main
    from ema_twin_sim.parallel import one_after_another

    if "PYTEST_XDIST_WORKER" in os.environ:
        one_after_another()
    status = 1
    try:
        os.setsid()
        os.chdir(order["cwd"])
        flags = (os.O_RDONLY, *[os.O_WRONLY | os.O_CREAT | os.O_TRUNC] * 2)
        for number, (path, flag) in enumerate(zip(order["streams"], flags, strict=True)):
            os.dup2(os.open(path, flag | os.O_NOCTTY, 0o600), number)
        if order["environment"]:
            os.environ.update(order["environment"])
            for name in [name for name in sys.modules if name.startswith("ema_twin_sim.commands")]:
                del sys.modules[name]  # how wide the output is, is decided as they are read
        sys.argv = ["ema-twin", *order["arguments"]]
        main()
        status = 0
    except SystemExit as ending:
        status = ending.code if isinstance(ending.code, int) else int(ending.code is not None)
    except BaseException:
        sys.excepthook(*sys.exc_info())
    finally:
        threading._shutdown()
        atexit._run_exitfuncs()
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        os._exit(status)


if __name__ == "__main__":
    serve(os.fdopen(int(sys.argv[1])), os.fdopen(int(sys.argv[2]), "w"))
