"""Fit: what is refused, and the command."""

import json
from dataclasses import replace

import pytest

import ema_twin_sim
from ema_bench_replay.errors import InputError
from ema_twin_sim.fitting.fit import METHODS, fit_model
from ema_twin_sim.model import load_model
from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.virtual_bench import virtual_bench
from tests.command_line import MODEL, done, refused
from tests.fitted_bench import SLOW, bench


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"method": "magic"}, ("magic", "equation or simulation")),
        ({"source": "voltage"}, ("voltage", "setpoint, current or command")),
        ({"free": ["machine.motor_inertai"]}, ("--free machine.motor_inertai", "machine.motor_inertia")),
        ({"fix": ["effects.backlash"]}, ("--fix effects.backlash", "no such number")),
        ({"fix": ["effects"]}, ("--fix effects",)),
        ({"free": ["machine.gear_ratio"]}, ("machine.gear_ratio", "exact")),
        ({"free": ["machine.motor_inertia"], "fix": ["machine.motor_inertia"]}, ("--free and by --fix",)),
    ],
)
def test_refused_options(stock, options, words):
    with pytest.raises(InputError) as refusal:
        fit_model(bench(stock, SLOW[1:2], 1.0), stock, **options)
    for word in words:
        assert word in str(refusal.value)


def test_refused_where_nothing_is_free(stock):
    fix = [f"effects.{name}" for name in stock.effects] + ["machine.motor_inertia", "machine.gearbox_inertia"]
    with pytest.raises(InputError, match="nothing is free"):
        fit_model(bench(stock, SLOW[1:2], 1.0), stock, fix=[*fix, "machine.output_inertia"])


def test_refused_recordings(stock):
    still = virtual_bench(stock, parse_command("ramp:0"), 3.0)
    moving = bench(stock, SLOW[:1], 2.0)[0]
    blind = replace(moving, signals={n: v for n, v in moving.signals.items() if n != "motor_position"})
    short = moving.between(0.0, 0.02)
    for recording, word in ((still, "motion"), (blind, "motor_position"), (short, "0.02 s")):
        for method in METHODS:
            with pytest.raises(InputError, match=word):
                fit_model([recording], stock, method=method)
    with pytest.raises(InputError, match="no recording"):
        fit_model([], stock)


@pytest.fixture(scope="module")
def fitted(tmp_path_factory, traces):
    """One run of the command: its folder, what it printed, and its errors."""
    folder = tmp_path_factory.mktemp("fit")
    done("add", "stribeck_friction", *MODEL, "-o", folder / "start.yaml")
    outputs = ("-o", folder / "new.yaml", "--json", folder / "fit.json")
    start = ("--model", folder / "start.yaml")
    result = done("fit", *traces, *start, "--method", "equation", "--to", 8, *outputs)
    return folder, result.stdout, result.stderr


def test_the_command_prints_numbers_with_units_and_standard_errors(fitted):
    folder, printed, errors = fitted
    for words in ("Parameters, with standard errors", " ± ", "rad/s", "noise floor", "held", str(folder / "new.yaml")):
        assert words in printed
    assert "nan" not in printed.lower() and "Traceback" not in errors


def test_the_command_writes_what_the_design_lists(fitted):
    content = json.loads((fitted[0] / "fit.json").read_text())
    assert content["method"] == "equation"
    assert (content["model"], content["machine"]) == ("start", "politecnico_ema") and len(content["recordings"]) > 0
    entry = content["parameters"]["stribeck_friction"]
    assert (entry["effect"], entry["options"]) == ("stribeck_friction", {"law": "exponential"})
    assert entry["speed"]["unit"] == "rad/s" and entry["speed"]["std"] > 0.0
    assert set(content["constants"]["machine"]["motor_inertia"]) == {"value", "std", "unit", "nominal"}
    for warning in content["warnings"]:
        assert set(warning) == {"kind", "instance", "parameter", "message"}
    assert len(content["correlations"]["matrix"]) == len(content["correlations"]["paths"])
    assert content["rmse"]["current"]["after"] < content["rmse"]["current"]["before"]
    written = load_model(fitted[0] / "new.yaml")
    assert written.effects["stribeck_friction"].parameters["speed"] == entry["speed"]["value"]
    inertia = written.constants["machine.motor_inertia"]
    assert inertia.value == content["constants"]["machine"]["motor_inertia"]["value"]
    assert inertia.source == "fitted; 0.00077 before"


def test_the_command_refuses(fitted, traces, tmp_path):
    folder = fitted[0]
    start = ("--model", folder / "start.yaml")
    refused("fit", traces[0], *start, "-o", folder / "new.yaml", naming=("exists already", "--force"))
    refused("fit", traces[0], *start, "-o", folder / "start.yaml", "--force", naming=("is an input",))
    refused("fit", traces[0], *start, "-o", tmp_path / "new.txt", naming=("named .yaml",))
    refused("fit", traces[0], *start, "-o", tmp_path / "n.yaml", "--fix", "effects.nothing", naming=("no such number",))
    line = refused(
        "fit", traces[0], *start, "-o", tmp_path / "n.yaml", "--free", "machine.zzz", naming=("of machine it has",)
    )
    assert "…" not in line and "motor_inertia" in line
    assert not list(tmp_path.iterdir())


def test_from_python():
    assert ema_twin_sim.fit is fit_model
