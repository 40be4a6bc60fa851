"""What a live diagnosis has judged, as made by hand."""

from ema_twin_sim.discovery.cautions import ALONE


def entry(effect, probability, found, **parameters):
    numbers = {name: {"value": value, "std": 0.1 * value, "unit": "rad"} for name, value in parameters.items()}
    return {
        "instance": effect,
        "effect": effect, "options": {}, "probability": probability, "error_removed": 0.5, "parameters": numbers,
        "found": found,
    }  # fmt: skip


def judged(*ranking, verdict, none=0.0, unknown=0.0):
    return {"verdict": verdict, "ranking": list(ranking), "none": none, "unknown": unknown, "warnings": []}


BOTH = judged(
    entry("backlash", 0.98, True, width=0.004), entry("stribeck_friction", 0.97, True),
    entry("cogging", 0.1, False),
    verdict="backlash",
)  # fmt: skip
OF_BOTH = {
    **BOTH, "groups": [], "depends_on": [], "next_recording": "", "none": 0.0,
    "warnings": [*ALONE, "current: clipped"],
}  # fmt: skip
