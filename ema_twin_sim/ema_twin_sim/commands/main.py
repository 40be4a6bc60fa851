"""The command ``ema-twin``: its verbs and its exit status.

Exit status: 0 done; 2 input refused, with one line that names file, place and remedy; 1 an internal error; 130
interrupted.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Collection
from importlib import import_module
from inspect import cleandoc
from keyword import iskeyword
from typing import Annotated

import typer

from ema_bench_replay.errors import InputError

from .. import interrupts
from ..version import VERSION
from .output import tell_of_compiling

VERBS = (
    "init", "import", "compare", "diagnose", "discover", "report", "fit", "plan", "campaign", "units", "sweep", "live",
    "simulate", "add", "remove", "effects", "info", "diff", "export", "recover", "demo",
)  # fmt: skip
"""The verbs in the order of the help; each is a file of this folder."""


def application(verbs: Collection[str] = VERBS) -> typer.Typer:
    """The command line with these verbs; whoever runs one verb need not wait for the others to be imported."""
    app = typer.Typer(
        name="ema-twin",
        no_args_is_help=True,
        rich_markup_mode="rich",
        pretty_exceptions_enable=False,
        context_settings={"help_option_names": ["-h", "--help"]},
        help="Digital twin of an electromechanical actuator: compare a model with recordings, see where it fails, "
        "add what is missing, watch the error fall.",
        callback=_options,
    )
    for verb in verbs:
        file = import_module(f".{verb}_" if iskeyword(verb) else f".{verb}", __package__)
        app.command(verb, help=_unfolded(file.run.__doc__ or ""), epilog=file.EXAMPLES)(file.run)
    return app


def _unfolded(text: str) -> str:
    """A docstring with one line for each paragraph: a terminal folds it to its own width."""
    return "\n\n".join(" ".join(paragraph.split()) for paragraph in cleandoc(text).split("\n\n"))


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"ema-twin {VERSION}")
        raise typer.Exit


def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    pass


def main() -> None:
    """Run the command line and end with the exit status listed above."""
    interrupts.watch()
    tell_of_compiling()
    named = [verb for verb in sys.argv[1:2] if verb in VERBS]
    try:
        status = application(named or VERBS)(standalone_mode=False, prog_name="ema-twin") or 0
        if status == interrupts.STATUS:  # how typer passes a KeyboardInterrupt on
            interrupts.end()
        interrupts.finish(status)
    except InputError as error:
        _end(f"error: {error}", 2)
    except (typer.Abort, KeyboardInterrupt):
        interrupts.end()
    except BrokenPipeError:
        os._exit(0)  # the reader of our output has gone: nobody would see a message
    except Exception as error:
        if interrupts.was_interrupted():
            interrupts.end()
        if hasattr(error, "format_message") and hasattr(error, "exit_code"):  # a usage error of the command line itself
            context = getattr(error, "ctx", None)
            usage = f" (see: {context.command_path} --help)" if context else ""
            if not error.format_message():  # called without a verb: the help has been printed
                interrupts.finish(2)
            refused = re.sub(r"^Invalid value for '([^']+)': ", r"\1: ", error.format_message())
            _end(f"error: {refused}{usage}", 2)
        if os.environ.get("EMA_TWIN_DEBUG"):
            raise
        kind = type(error).__name__
        _end(f"internal error: {kind}: {error}; please report it (EMA_TWIN_DEBUG=1 shows where)", 1)


def _end(message: str, status: int) -> None:
    print(" ".join(message.split()), file=sys.stderr)
    interrupts.finish(status)
