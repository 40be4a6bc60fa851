"""``python -m ema_twin_sim.views.bag_blueprint FOLDER``: write the layouts that rerun's viewer opens with a file.

Rerun reads our MCAP files directly: a topic becomes an entity, and its message a component whose fields a layout can
plot. It keeps layouts per application, and takes the name of a bare MCAP for the application; so convert it once:

    rerun mcap convert --application-id ema-twin run.mcap -o run.rrd
    rerun run.rrd config/blueprints/bench.rbl
"""

from __future__ import annotations

import sys
from pathlib import Path

import rerun as rr
import rerun.blueprint as rrb
from rerun.blueprint.encodings import ComponentSourceKind, VisualizerComponentMapping

from ..simulation.compared_signals import UNITS
from .palette import AFTER, BEFORE, MEASURED, Colour
from .recording_views import layout
from .rerun_view import live_blueprint
from .stream import APPLICATION, LIVE_APPLICATION

_STATE = "ema_twin_msgs.msg.EmaState:message"
_RESIDUAL = "ema_twin_msgs.msg.Residual:message"
_TIMELINE = "ros2_timestamp"  # time of the samples; the log time is that of their arrival
_SIGNALS = ("output_position", "current", "speed")
_MORE = ("voltage", "unexplained_torque", "motor_position")


def bag_blueprint() -> rrb.Blueprint:
    """The signals of an MCAP that ``import``, ``simulate`` or ``live --record`` wrote, by name and unit."""
    units = {**UNITS, "voltage": "V"}
    tabs = (
        rrb.Vertical(*(_signal(name, units[name]) for name in _SIGNALS), name="bench and twin"),
        rrb.Vertical(*(_residual(name, units[name]) for name in _SIGNALS), name="residuals"),
        rrb.Vertical(*(_signal(name, units[name]) for name in _MORE), name="more signals"),
    )
    return layout(tabs, _TIMELINE)


def _signal(name: str, unit: str) -> rrb.TimeSeriesView:
    return rrb.TimeSeriesView(
        origin="/",
        contents=["/bench/state", "/twin/state"],
        name=f"{name.replace('_', ' ')} [{unit}]",
        overrides={
            "/bench/state": [_field(_STATE, name, f"bench [{unit}]", MEASURED)],
            "/twin/state": [_field(_STATE, name, f"twin [{unit}]", BEFORE)],
        },
        plot_legend=rrb.PlotLegend(rrb.Corner2D.RightTop),
    )


def _residual(name: str, unit: str) -> rrb.TimeSeriesView:
    return rrb.TimeSeriesView(
        origin="/",
        contents=["/monitor/residual"],
        name=f"{name.replace('_', ' ')}: bench − twin [{unit}] (of what live --record wrote)",
        overrides={"/monitor/residual": [_field(_RESIDUAL, f"residual.{name}", f"bench − twin [{unit}]", AFTER)]},
    )


def _field(component: str, field: str, name: str, colour: Colour) -> rrb.Visualizer:
    """A curve of one field of a message."""
    mapping = VisualizerComponentMapping(
        "Scalars:scalars",
        source_kind=ComponentSourceKind.SourceComponent,
        source_component=component,
        selector=f".{field}",
    )
    return rr.SeriesLines(names=[name], colors=[colour], widths=[1.5]).visualizer(mappings=[mapping])


def save_blueprints(folder: Path) -> list[Path]:
    """Write all layouts; return their files."""
    folder.mkdir(parents=True, exist_ok=True)
    bench, live = folder / "bench.rbl", folder / "live.rbl"
    bag_blueprint().save(APPLICATION, bench)
    live_blueprint().save(LIVE_APPLICATION, live)
    return [bench, live]


if __name__ == "__main__":
    for written in save_blueprints(Path(sys.argv[1])):
        print(f"  {written}")
