"""An error of a user's code in one line: its place in the file, and the message of Python or the compiler."""

from __future__ import annotations

import re
import traceback
from pathlib import Path

_AROUND = ("Failed in ", "File ", "During", "There are", "Enable logging")
"""Beginnings of lines in the compiler's message that do not describe the mistake itself."""


def line_of(error: BaseException, file: Path) -> str:
    """``line N: ``, the innermost place in the file in an error's traceback; empty if there is none."""
    if isinstance(error, SyntaxError) and error.filename == str(file):
        return f"line {error.lineno}: "
    passed = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(file)]
    if passed:
        return f"line {passed[-1]}: "
    told = re.findall(rf'File "[^"\n]*{re.escape(file.name)}", line (\d+)', str(error))
    return f"line {told[-1]}: " if told else ""


def words(error: BaseException) -> str:
    """The kind of error and its text, or the most informative line of a compiler's message."""
    if isinstance(error, SyntaxError):
        return f"{type(error).__name__}: {error.msg}"
    lines = [line.strip() for line in str(error).splitlines()]
    telling = [line for line in lines if line and not line.startswith(_AROUND)]
    if not telling:
        return type(error).__name__
    text = " ".join(telling[:2]) if telling[0].endswith(":") else telling[0]
    if type(error).__module__.startswith("numba."):
        returned = re.match(r"No conversion from (.+?) to float64 for '\S*return_value", text)
        return f"it returns {returned[1]}, which is no number" if returned else text
    return f"{type(error).__name__}: {text}"
