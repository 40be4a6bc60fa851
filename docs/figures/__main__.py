"""``python -m docs.figures``: draw the figures of docs/physics.md and docs/architecture.md, print the numbers of the
former and put them into it.

``--speed`` also measures what a step costs, which is another number at every run. Takes some minutes.
"""

import argparse

from . import drives, efficiency, energies, friction_coefficient, mesh_stiffness, phase_currents, rooms, spectrum
from .page import DOCS, FOLDER, PAGE, quoted, renewed
from .quick import quick_numbers
from .speed import timings
from .style import save

FIGURES = {
    "mesh_stiffness": mesh_stiffness.draw,
    "friction_coefficient": friction_coefficient.draw,
    "efficiency": efficiency.draw,
    "efficiency_map": efficiency.draw_map,
    "spectrum": spectrum.draw,
    "spectrum_damages": spectrum.draw_damages,
    "energies": energies.draw,
    "phase_currents": phase_currents.draw,
    "drives": drives.draw,
}
ROOMS = DOCS / "architecture.svg"


def main() -> None:
    """Draw, measure, renew the page."""
    options = argparse.ArgumentParser(prog="python -m docs.figures", description=__doc__)
    options.add_argument("--speed", action="store_true", help="measure what a step costs too")
    options.add_argument("--only", choices=[*FIGURES, "rooms"], nargs="+", help="draw these, measure nothing")
    asked = options.parse_args()
    FOLDER.mkdir(exist_ok=True)
    for name in asked.only or [*FIGURES, "rooms"]:
        path = ROOMS if name == "rooms" else FOLDER / f"{name}.svg"
        if name == "rooms":
            save(rooms.draw(), path, "; ".join(rooms.in_words()))
        else:
            save(FIGURES[name](), path)
        print(f"  {path.relative_to(PAGE.parents[1])}  {path.stat().st_size // 1000} kB", flush=True)
    if asked.only:
        return
    numbers = quick_numbers() | efficiency.slow_numbers() | spectrum.slow_numbers()
    if asked.speed:
        numbers |= timings()
    used = {name for name, _ in quoted(PAGE.read_text())} if PAGE.exists() else set()
    for name, number in numbers.items():
        print(f"  {name:<28}{number.text:>10}{'' if name in used else '   (not on the page)'}")
    if PAGE.exists():
        PAGE.write_text(renewed(PAGE.read_text(), numbers))


if __name__ == "__main__":
    main()
