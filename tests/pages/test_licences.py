"""What is locked and installed may be used and passed on with this project: every licence is a permissive one."""

import re
import sys
import xml.etree.ElementTree as ElementTree
from importlib.metadata import PackageNotFoundError, metadata
from pathlib import Path

LOCK = Path(__file__).parents[2] / "requirements.lock"
ALLOWED = re.compile(
    r"\b(MIT|BSD|0BSD|Apache|MPL|Mozilla Public|PSF|Python Software Foundation|ISC|Zlib|Public Domain|CC0|any-OSI)"
)
"""A licence that offers several is as its kindest; MPL binds changes of its own files only."""

SILENT = {"ros-fastcdr": "Apache-2.0", "ros-fastrtps": "Apache-2.0", "setuptools": "MIT"}
"""Those that only hold the text of their licence."""


def locked():
    lines = LOCK.read_text().splitlines()
    return sorted({match[1] for match in map(re.compile(r"([\w.-]+)==").match, lines) if match})


def licence(name):
    """What an installed distribution says of its licence, empty where it says nothing; None where it is not here."""
    try:
        told = metadata(name)
    except PackageNotFoundError:  # of another Python or system
        return None
    kinds = [kind for kind in told.get_all("Classifier", []) if kind.startswith("License")]
    words = [told.get("License-Expression") or "", (told.get("License") or "")[:200], *kinds]
    package = re.sub("^ros-(jazzy-)?", "", name).replace("-", "_")
    file = Path(sys.prefix, "share", package, "package.xml")
    if not any(words) and file.exists():
        words += [one.text or "" for one in ElementTree.parse(file).iter("license")]
    return " ".join(filter(None, words)) or SILENT.get(name, "")


def test_every_licence_is_one_of_those_that_are_allowed():
    found = {name: words for name in locked() if (words := licence(name)) is not None}
    assert len(found) > 100
    assert {name: words for name, words in found.items() if not ALLOWED.search(words)} == {}
