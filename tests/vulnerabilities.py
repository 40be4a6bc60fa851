"""``make vulnerabilities``: which locked libraries have known vulnerabilities, as the package index tells.

python tests/vulnerabilities.py PIP_AUDIT [REQUIREMENTS]

pip-audit says "No known vulnerabilities found", with status 0, of libraries too that it could learn nothing about:
where the index is not reached, or is a mirror that holds no such list. Here that is status 2.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

LOCK = Path(__file__).resolve().parents[1] / "requirements.lock"
_OPTIONS = ("--no-deps", "--disable-pip", "--progress-spinner", "off", "--format", "json", "--requirement")


def judge(audit: Mapping[str, list[dict]]) -> tuple[list[str], int]:
    """What pip-audit's answer says, in lines, and the exit status: 1 where a vulnerability is known, 2 where not all
    could be asked about.
    """
    libraries = audit["dependencies"]
    silent = [library["name"] for library in libraries if "vulns" not in library]
    lines = [
        f"{library['name']} {library['version']}: {known['id']}, mended in {', '.join(known['fix_versions']) or 'none'}"
        for library in libraries
        for known in library.get("vulns", ())
    ]
    found = bool(lines)
    asked = len(libraries) - len(silent)
    nothing = "; nothing is known of them" if asked and not found else ""
    lines.append(f"{asked} of {len(libraries)} libraries were asked about{nothing}")
    if silent:
        named = ", ".join(silent[:5]) + (", …" if len(silent) > 5 else "")
        lines.append(f"{len(silent)} could not be asked about: the package index tells nothing of {named}")
    return lines, 1 if found else 2 if silent or not libraries else 0


def main() -> int:
    """Ask, and print what is known."""
    tool, *file = sys.argv[1:]
    try:
        asked = subprocess.run([tool, *_OPTIONS, *(file or [str(LOCK)])], capture_output=True, text=True, check=False)
        lines, status = judge(json.loads(asked.stdout))
    except OSError as error:
        lines, status = [f"could not be asked: {error}"], 2
    except ValueError:
        lines, status = [f"could not be asked: {' '.join(asked.stderr.split()[-30:]) or 'pip-audit says nothing'}"], 2
    print("\n".join(lines))
    return status


if __name__ == "__main__":
    raise SystemExit(main())
