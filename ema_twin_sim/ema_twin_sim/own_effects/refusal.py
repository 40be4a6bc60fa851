"""What a user's code raised, in one line: where it is in their file, and what Python or the compiler says."""

from __future__ import annotations

import re
import traceback
from pathlib import Path

_AROUND = ("Failed in ", "File ", "During", "There are", "Enable logging")
"""How the lines of the compiler's message begin that are not about the mistake itself."""


def line_of(error: BaseException, file: Path) -> str:
    """``line N: ``, the last place in the file that an error has passed; empty where it has passed none."""
    if isinstance(error, SyntaxError) and error.filename == str(file):
        return f"line {error.lineno}: "
    passed = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(file)]
    if passed:
        return f"line {passed[-1]}: "
    told = re.findall(rf'File "[^"\n]*{re.escape(file.name)}", line (\d+)', str(error))
    return f"line {told[-1]}: " if told else ""


def words(error: BaseException) -> str:
    """What went wrong: the kind of error and its text, or the one telling line of a compiler's page."""
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
