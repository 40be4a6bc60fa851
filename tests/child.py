"""A child that was forked: how it ended, and its end where it takes too long."""

import os
import select
import signal


def exit_status(child, longest):
    """The exit status of a ``child`` that leads a group of its own; None where it took longer than so many s.

    It is ended then, and all that it started with it.
    """
    waiting = os.pidfd_open(child)
    try:
        ended, _, _ = select.select([waiting], [], [], longest)
        if not ended:
            os.killpg(child, signal.SIGKILL)
        _, status = os.waitpid(child, 0)
        return os.waitstatus_to_exitcode(status) if ended else None
    finally:
        os.close(waiting)
