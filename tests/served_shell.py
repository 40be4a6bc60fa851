"""A shell in which ``ema-twin`` is a function: it hands its words to the command server, and ends as the command does.

The function writes into one pipe where it stands, where its own streams are and what it was given; from another it
reads how that ended. Its streams are told by descriptors of their own, since those of the shell are the pipes while it
writes and reads. Commands that start processes are started themselves.
"""

import os
import threading
from contextlib import contextmanager, suppress

from tests.command_line import STARTS_PROCESSES, server

_FUNCTION = """
shopt -s extglob
ema-twin() {
    case " $* " in *" "@(%s)" "*) command ema-twin "$@"; return;; esac
    local status streams=/proc/$BASHPID/fd in out err
    exec {in}<&0 {out}>&1 {err}>&2
    printf '%%s\\0' "$PWD" "$streams/$in" "$streams/$out" "$streams/$err" "$@" >&%d
    printf '\\n' >&%d
    read -r status <&%d || status=1
    exec {in}<&- {out}>&- {err}>&-
    return "$status"
}
"""


@contextmanager
def served(timeout):
    """The function, and the ends of its pipes that the shell has to be given."""
    (ours, asking), (answered, theirs) = os.pipe(), os.pipe()
    threading.Thread(target=_serve, args=(ours, theirs, timeout), daemon=True).start()  # until the shell is gone
    try:
        yield _FUNCTION % ("|".join(sorted(STARTS_PROCESSES)), asking, asking, answered), (asking, answered)
    finally:
        os.close(asking)
        os.close(answered)


def _serve(asked, answers, timeout):
    """Give each order to the server, and tell how it ended."""
    with suppress(BrokenPipeError), os.fdopen(asked) as orders, os.fdopen(answers, "w") as ends:
        for order in orders:
            cwd, given, printed, told, *arguments = order.removesuffix("\0\n").split("\0")
            status = server().give(arguments, cwd, timeout, [given, printed, told])
            print(1 if status is None else status, file=ends, flush=True)
