"""Models of every fidelity, for tests."""

from ema_bench_replay.configuration import find_configuration

KINDS = ("switching, rigid", "switching, planetary", "averaged, planetary", "switching, two inertias")
LONGEST = 600  # s, where a kernel is compiled first, on a busy machine


def write_model(folder, name, base="polito_hff", **sections):
    """A model file over a shipped one, with entries of its own by section."""
    file = folder / f"{name}.yaml"
    below = find_configuration("models", f"{base}.yaml")
    lines = ["version: 1", f"base: {below}"]
    for section, entries in sections.items():
        lines += [f"{section}:", *(f"  {key}: {entry}" for key, entry in entries.items())]
    file.write_text("\n".join(lines) + "\n")
    return file


def models_in(folder):
    """A model of each of KINDS: a shipped name, or a file."""
    return {
        "switching, rigid": "polito_hf",
        "switching, planetary": "polito_hff",
        "averaged, planetary": write_model(folder, "avpl", "polito_bench", transmission={"kind": "planetary"}),
        "switching, two inertias": write_model(folder, "swti", "polito_hf", transmission={"kind": "two_inertia"}),
    }


def entry(number, unit):
    """A constant's entry in a model file."""
    return f"{{value: {number}, unit: {unit}}}"
