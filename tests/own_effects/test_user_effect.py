"""A user's own effect, from one file: the same as the catalogue's in everything; one clear line where it is wrong."""

import json
import math
import multiprocessing
import os
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rclpy.parameter import Parameter
from ros_graph import start_process

from ema_bench_replay.errors import InputError
from ema_twin_sim.comparison.compare import compare
from ema_twin_sim.effects import catalogue
from ema_twin_sim.effects.catalogue import own_files
from ema_twin_sim.model import load_model, save_model
from ema_twin_sim.nodes.monitor import MonitorNode
from ema_twin_sim.nodes.twin import TwinNode
from ema_twin_sim.own_effects import load_effect, load_effects
from ema_twin_sim.own_effects.table import checked_table
from ema_twin_sim.own_effects.trial import try_out
from ema_twin_sim.plant.kernel import kernel
from ema_twin_sim.plant.operating_point import OperatingPoint
from ema_twin_sim.simulation.assembly import assemble
from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.simulate import simulate
from ema_twin_sim.simulation.virtual_bench import virtual_bench
from tests.command_line import ENDING, done, refused

EXAMPLE = Path(__file__).resolve().parents[2] / "docs" / "examples" / "position_friction.py"
HIDDEN = {"torque": 0.1, "count": 20.0, "phase": 0.5}

HEAD = "import math\nfrom ema_twin_sim.effects.effect import *\n"
ACT = "def act(at, p):\n    return {act}\n"
EFFECT = (
    'EFFECT = Effect(id="{id}", summary="s", equation="e", signature="s", source="s",'
    " parameters=({parameters}), {way}, {more})\n"
)
TABLE = 'Parameter("torque", "N m", 0.05, 0.0, 1.0, "size"),'
LAWS = 'options={"kind": ("a", "b")}, law="kind"'


def text(act="p[0]", parameters=TABLE, id="own_load", way="act=act", more=""):
    return HEAD + ACT.format(act=act) + EFFECT.format(id=id, parameters=parameters, way=way, more=more)


pytestmark = pytest.mark.usefixtures("catalogue_of_the_package")


@pytest.fixture
def own(tmp_path):
    """Writes an effect's file."""

    def write(content=None, name="own.py", **parts):
        path = tmp_path / name
        path.write_text(text(**parts) if content is None else content)
        return path

    return write


@pytest.fixture(scope="module")
def hiding(tmp_path_factory):
    """A model with the example in it, and what its virtual bench records."""
    folder = tmp_path_factory.mktemp("hiding")
    settings = [word for name, value in HIDDEN.items() for word in ("--set", f"{name}={value}")]
    done("add", EXAMPLE, *settings, "--model", "polito_bench", "-o", folder / "mine.yaml")
    command = ("--command", "triangle:0.04:2", "--seconds", "6", "--seed", "3")
    done("simulate", "--model", folder / "mine.yaml", "--with", EXAMPLE, *command, "-o", folder / "run.mcap")
    return folder / "mine.yaml", folder / "run.mcap"


def test_the_example_tells_what_an_effect_may_ask():
    for name in OperatingPoint._fields:
        assert f"at.{name}" in EXAMPLE.read_text()
    at = OperatingPoint(**{**dict.fromkeys(OperatingPoint._fields, 0.0), "output_angle": 0.3})
    expected = 0.05 * (1.0 + math.sin(20.0 * 0.3 + 0.5))
    assert load_effect(EXAMPLE).act(at, (0.1, 20.0, 0.5, 0.0)) == pytest.approx(expected)


@pytest.mark.slow
def test_it_is_listed_shown_and_added(tmp_path):
    done("effects", "--with", EXAMPLE, "--json", tmp_path / "all.json")
    listed = [effect["id"] for effect in json.loads((tmp_path / "all.json").read_text())]
    assert listed[-1] == "position_friction" and "backlash" in listed
    shown = done("effects", "--with", EXAMPLE, "position_friction").stdout
    assert "sin(count·θ_o + phase)" in shown and f"ema-twin add {EXAMPLE} --set torque=0.05" in shown
    added = done("add", EXAMPLE, "--model", "polito_bench", "-o", tmp_path / "one.yaml").stdout
    assert f"--with {EXAMPLE}" in added
    again = ("--with", EXAMPLE, "--with", EXAMPLE, "--model", tmp_path / "one.yaml")
    done("add", "position_friction", "--set", "count=7", *again, "-o", tmp_path / "two.yaml")
    info = done("info", tmp_path / "two.yaml", "--with", EXAMPLE).stdout
    assert "position_friction_2" in info and "count 7" in info
    done("remove", "position_friction", "--model", tmp_path / "two.yaml", "--with", EXAMPLE, "-o", tmp_path / "0.yaml")
    assert "position_friction" not in done("info", tmp_path / "0.yaml").stdout


@pytest.mark.slow
def test_the_error_falls_when_it_is_added(tmp_path, hiding):
    model, recording = hiding
    models = ("--model", "polito_bench", "--model", model)
    done("compare", recording, *models, "--with", EXAMPLE, "--json", tmp_path / "c.json")
    before, after = (each["overall"]["current"] for each in json.loads((tmp_path / "c.json").read_text()))
    assert before["rmse"] > 8.0 * before["noise_floor"]
    assert after["rmse"] < 1.1 * after["noise_floor"]


@pytest.mark.slow
def test_live_gives_what_compare_gives(tmp_path, hiding):
    model, recording = hiding
    both = (recording, "--model", model, "--with", EXAMPLE, "--json")
    done("live", *both, tmp_path / "live.json", "--rate", "5", "--headless")
    done("compare", *both, tmp_path / "compare.json")
    live, offline = (json.loads((tmp_path / f"{name}.json").read_text())["overall"] for name in ("live", "compare"))
    for name, expected in offline.items():
        assert live[name]["rmse"] == pytest.approx(expected["rmse"], rel=1e-6)


@pytest.mark.slow
def test_no_model_runs_a_file_that_is_not_named(tmp_path, hiding):
    model, recording = hiding
    named = ("mine.yaml", "effects.position_friction", "--with FILE.py")
    for verb in (
        ("compare", recording, "--model", model),
        ("live", recording, "--model", model, "--headless"),
        ("simulate", "--model", model, "--command", "ramp:0.05", "-o", tmp_path / "x.mcap"),
        ("add", "backlash", "--model", model, "-o", tmp_path / "x.yaml"),
        ("remove", "position_friction", "--model", model, "-o", tmp_path / "x.yaml"),
        ("info", model),
    ):
        refused(*verb, naming=named)


def test_it_is_a_catalogue_effect_to_the_last_bit(own, stock):
    """The catalogue's Stribeck friction, written as a user's: the same signals, and none of it runs in Python."""
    act = "p[0] * math.exp(-abs(at.motor_speed) / p[1])"
    table = TABLE + 'Parameter("speed", "rad/s", 2.0, 0.01, 1000.0, "speed"),'
    file = own(act=act, parameters=table, id="own_stribeck", more="place=DRY_LEVEL")
    load_effect(file)
    recording = virtual_bench(stock, parse_command("sine:0.02:1"), 1.0, seed=None)
    theirs = simulate(stock.with_effect("stribeck_friction", {"torque": 0.08, "speed": 2.0}), recording)
    model = stock.with_effect("own_stribeck", {"torque": 0.08, "speed": 2.0})
    called = []
    sys.setprofile(lambda frame, event, _: called.append(frame.f_code.co_filename))
    try:
        mine = simulate(model, recording)
    finally:
        sys.setprofile(None)
    assert str(file) not in called and len(called) > 10
    assert len(kernel(False, False).signatures) == 1
    for name, signal in theirs.signals.items():
        assert np.array_equal(mine.signals[name], signal, equal_nan=True), name


def test_a_changed_file_never_runs_old_machine_code(own, stock):
    """Of the same size and the same time of change; read again by this process, and nothing is left beside it."""
    peaks = []
    for factor in ("1.0", "3.0"):
        file = own(act=f"{factor} * p[0]")
        os.utime(file, (1e9, 1e9))
        load_effect(file)
        bench = virtual_bench(stock.with_effect("own_load"), parse_command("ramp:0.05"), 0.5, seed=None)
        peaks.append(bench.signals["current"][-1])
    assert peaks[1] - peaks[0] == pytest.approx(0.1 / stock.value("machine.torque_constant"), rel=0.05)
    assert list(file.parent.iterdir()) == [file]


def test_of_one_id_there_is_one(own):
    one = load_effect(own(name="one.py"))
    load_effects([own(name="one.py"), own(name="one.py")])
    assert catalogue()["own_load"] is not one
    with pytest.raises(InputError, match=r"two\.py: EFFECT\.id: 'own_load' is there already, in .*one\.py"):
        load_effect(own(name="two.py"))
    with pytest.raises(InputError, match=r"'backlash' is there already, in the catalogue; choose another"):
        load_effect(own(name="three.py", id="backlash"))
    load_effect(own(name="one.py", id="renamed"))
    assert "own_load" not in catalogue() and "renamed" in catalogue()


def test_two_files_run_their_own_functions(own, stock):
    load_effects([own(name="one.py", id="one"), own(act="3.0 * p[0]", name="two.py", id="two")])
    addresses = assemble(stock.with_effect("one").with_effect("two")).effects[0]
    assert len(set(addresses.tolist())) == 2


def last_current(id):
    """For a process of its own, in which this module is imported."""
    bench = virtual_bench(load_model("polito_bench").with_effect(id), parse_command("ramp:0.05"), 0.5, seed=None)
    return float(bench.signals["current"][-1])


@pytest.mark.slow
def test_worker_processes_read_the_files_again(own):
    load_effect(own())
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, context, initializer=load_effects, initargs=(own_files(),)) as pool:
        assert pool.submit(last_current, "own_load").result(60) == last_current("own_load")


def test_whole_numbers_lists_and_options_will_do(own, stock, tmp_path):
    table = '[Parameter("torque", "N m", 1, 0, 2, "size", starts=[1]), Parameter("lag", "s", 1, 0, 2, "of no use")]'
    more = 'options={"order": ["1", "4"], "side": ("motor", "output")}, option_value=lambda o: float(o["order"]),'
    more += 'place=lambda o: TORQUE if o["side"] == "motor" else OUTPUT_TORQUE'
    effect = load_effect(own(act="p[0] * p[2]", parameters=table, more=more))
    assert [type(v) for p in effect.parameters for v in (p.default, p.lower, p.upper, *p.starts)] == [float] * 7
    model = stock.with_effect("own_load", options={"order": "4", "side": "output"})
    assert load_model(save_model(model, tmp_path / "m.yaml")).effects["own_load"] == model.effects["own_load"]
    assert assemble(model).effects[2].tolist() == [[1.0, 1.0, 4.0, 0.0]]


def test_settle_will_do(own, stock):
    content = HEAD + "def settle(plant, parameters, options):\n    plant['motor_dry'] += parameters['torque']\n"
    load_effect(own(content + EFFECT.format(id="more_dry", parameters=TABLE, way="settle=settle", more="")))
    model = stock.with_effect("more_dry", {"torque": 0.25})
    assert assemble(model).plant["motor_dry"][0] == pytest.approx(assemble(stock).plant["motor_dry"][0] + 0.25)


@pytest.mark.parametrize("id", sorted(catalogue()))
def test_the_catalogue_passes_the_same_trial(id):
    effect = catalogue()[id]
    checked = checked_table(Path("catalogue.py"), effect)
    assert replace(checked, options=effect.options).parameters == effect.parameters
    try_out(Path("catalogue.py"), checked)


WRONG = {
    "no effect": (HEAD, ["holds no EFFECT"]),
    "a syntax error": (HEAD + "def act(at, p)\n    return 1\n", ["line 3", "SyntaxError", "':'"]),
    "a name that is not there": (HEAD + "x = maths.pi\n", ["line 3", "NameError", "maths"]),
    "an exit": (HEAD + "raise SystemExit(0)\n", ["line 3", "SystemExit"]),
    "a catalogue's import": ("from .effect import Effect\n", ["line 1", "from ema_twin_sim.effects.effect import"]),
    "a forgotten comma": (text(parameters=TABLE.rstrip(",")), ["line 5", "a table of one parameter ends in a comma"]),
    "a missing argument": (text(way="place=TORQUE"), ["line 5", "give act or settle"]),
    "a size of one law": (
        text(parameters='Parameter("torque", "N m", 0.05, 0.0, 1.0, "size", choice="b"),', more=LAWS),
        ["parameters.torque.choice", "the first parameter is the effect's size"],
    ),
    "a choice that is none": (
        text(parameters=TABLE + 'Parameter("speed", "rad/s", 1.0, 0.1, 9.0, "s", choice="c"),', more=LAWS),
        ["parameters.speed.choice", "'c' is no choice of EFFECT.law"],
    ),
    "no parameter": (text(act="0.1", parameters=""), ["EFFECT.parameters", "at least one"]),
    "no Parameter": (text(parameters="'torque',"), ["EFFECT.parameters[0]", "'torque'", "Parameter("]),
    "an id that is none": (text(id="Own Load"), ["EFFECT.id", "small letters"]),
    "an id like an instance's": (text(id="load_2"), ["EFFECT.id", "second instance"]),
    "a parameter like the switch": (text(parameters=TABLE.replace("torque", "enabled")), ["enabled", "switch"]),
    "a name twice": (text(parameters=TABLE * 2), ["'torque' names two"]),
    "no unit": (text(parameters=TABLE.replace("N m", "")), ["EFFECT.parameters.torque.unit", "'1' for none"]),
    "a root in a unit": (
        text(parameters=TABLE.replace("N m", "N m s^(1/3)")), ["torque.unit", "'N m s^(1/3)'", "whole powers"]
    ),
    "a unit with a prefix": (text(parameters=TABLE.replace("N m", "mN m")), ["torque.unit", "'mN m'", "N m, kg m^2"]),
    "bounds the wrong way": (text(parameters=TABLE.replace("1.0", "-1.0")), ["torque", "lower 0", "in order"]),
    "a default out of bounds": (text(parameters=TABLE.replace("0.05", "5.0")), ["torque.default", "0 to 1"]),
    "a start out of bounds": (text(parameters=TABLE[:-2] + ", starts=(0.1, 7)),"), ["torque.starts[1]", "0 to 1"]),
    "a bound that is no number": (text(parameters=TABLE.replace("1.0", "math.nan")), ["torque.upper", "math.inf"]),
    "options of one text": (text(more="options={'side': 'motor'}"), ["EFFECT.options.side", "tuple of choices"]),
    "a place that is none": (text(more="place=7"), ["EFFECT.place", "DRY_LEVEL"]),
    "a place that fails": (text(more="options={'a': ('x', 'y')}, place=lambda o: {'x': 0}[o['a']]"), ["a y", "line 5"]),
    "act of one argument": (text().replace("act(at, p)", "act(at)"), ["line 3", "define act(at, p)"]),
    "a field that is not there": (text(act="p[0] * at.motor_sped"), ["line 4", "did you mean 'motor_speed'"]),
    "a parameter too many": (text(act="p[0] + p[1]"), ["line 4", "p[1]", "table has 1"]),
    "what does not compile": (text(act="helper(p[0])") + "def helper(x):\n    return x\n", ["line 4", "numba.njit"]),
    "a function math lacks": (text(act="math.sine(p[0])"), ["line 4", "sine", "does not compile"]),
    "an angle not asked for": (text(act="p[0] * math.sin(at.electrical_angle)"), ["line 3", "electrical=True"]),
    "a text": (text(act="'much'"), ["line 4", "no number"]),
    "nothing": (text(act="None"), ["line 4", "no number"]),
    "a division by zero at rest": (text(act="p[0] / at.motor_speed"), ["line 3", "gives inf", "motor_speed 0"]),
    "0 / 0 at a bound": (text(act="0.1 * at.dry_level * p[0] / (p[0] * at.dry_level)"), ["gives nan", "torque 0"]),
    "an exception": (
        HEAD + "def act(at, p):\n    if at.motor_speed < 0.0:\n        raise ValueError('no way')\n    return p[0]\n"
        + EFFECT.format(id="own", parameters=TABLE, way="act=act", more=""), ["act raises ValueError: no way", "-6.2"],
    ),
    "a setting of nothing": (
        HEAD + "def settle(plant, parameters, options):\n    plant['motor_dri'] += 1.0\n"
        + EFFECT.format(id="own", parameters=TABLE, way="settle=settle", more=""), ["line 4", "motor_dri", "layout.py"],
    ),
    "a setting without end": (
        HEAD + "def settle(plant, parameters, options):\n    plant['motor_dry'] = math.inf\n"
        + EFFECT.format(id="own", parameters=TABLE, way="settle=settle", more=""), ["settle makes motor_dry inf"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", WRONG)
def test_a_wrong_file_is_refused_with_place_and_remedy(own, what):
    content, expected = WRONG[what]
    with pytest.raises(InputError) as error:
        load_effect(own(content))
    said = str(error.value)
    assert said.startswith(str(own(content))) and "\n" not in said and ";" in said, said
    for part in expected:
        assert part in said, said
    assert not own_files()


def test_a_parameter_of_one_law_is_none_of_another(own, stock):
    """A function that settles the plant sees those of the law alone, in the trial as in a run."""
    speed = 'Parameter("speed", "rad/s", 1.0, 0.1, 9.0, "s", choice="b"),'
    settle = (
        "def settle(plant, parameters, options):\n"
        "    plant['motor_dry'] += parameters['torque'] * (parameters['speed'] if options['kind'] == 'b' else 1.0)\n"
    )
    effect = EFFECT.format(id="own_law", parameters=TABLE + speed, way="settle=settle", more=LAWS)
    load_effect(own(HEAD + settle + effect))
    dry = [
        assemble(stock.with_effect("own_law", parameters, {"kind": kind})).plant["motor_dry"][0]
        for kind, parameters in (("a", {}), ("b", {"speed": 3.0}))
    ]
    assert dry[1] - dry[0] == pytest.approx(2.0 * 0.05)


@pytest.mark.slow
def test_wrong_files_end_the_command_line_with_one_line_and_status_2(own, tmp_path):
    add = ("--model", "polito_bench", "-o", tmp_path / "x.yaml")
    refused("add", tmp_path / "none.py", *add, naming=("none.py", "no such file"))
    refused("effects", "--with", tmp_path, naming=("no Python file",))
    (tmp_path / "folder.py").mkdir()
    refused("effects", "--with", tmp_path / "folder.py", naming=("folder.py", "cannot be read"))
    for what in ("a syntax error", "a field that is not there", "0 / 0 at a bound"):
        refused("add", own(WRONG[what][0]), *add, naming=("own.py", *WRONG[what][1]))
    refused("add", own(), "--set", "torque=9", *add, naming=("torque", "0 to 1"))
    refused("effects", "--with", own(), "--with", own(name="two.py"), naming=("two.py", "there already"))
    assert not (tmp_path / "x.yaml").exists()


@pytest.mark.slow
def test_no_output_replaces_the_file(own, hiding):
    file = own()
    for verb in (("effects",), ("info", "polito_bench"), ("compare", hiding[1], "--model", "polito_bench")):
        refused(*verb, "--with", file, "--json", file, naming=("own.py", "no JSON file"))
    assert file.read_text() == text()


@pytest.mark.parametrize("place", ["TORQUE", "DRY_LEVEL", "OUTPUT_TORQUE", "VISCOUS_COEFFICIENT"])
def test_what_raises_far_from_the_trial_ends_the_run_with_words(own, stock, place):
    content = HEAD + (
        "def act(at, p):\n    if 0.2 < at.time < 0.3:\n        raise ValueError('here')\n    return 0.01 * p[0]\n"
    )
    load_effect(own(content + EFFECT.format(id="own", parameters=TABLE, way="act=act", more=f"place={place}")))
    recording = virtual_bench(stock, parse_command("ramp:0.05"), 0.5, seed=None)
    model = stock.with_effect("own")
    for run in (
        lambda: simulate(model, recording),
        lambda: compare([recording], model),
        lambda: virtual_bench(model, parse_command("ramp:0.05"), 0.5),
    ):
        with pytest.raises(InputError, match=r"diverges: .* no finite number 0\.20[0-9]+ s after.*of your own"):
            run()


def test_a_running_twin_has_its_parameters(graph, hiding):
    for node in (TwinNode, MonitorNode):
        with pytest.raises(InputError, match="effect_files"):
            graph.add(node, model=str(hiding[0]))
    files = {"effect_files": [str(EXAMPLE)]}
    graph.add(MonitorNode, model=str(hiding[0]), **files)
    twin = graph.add(TwinNode, **files, **{"effects.position_friction.count": 15})
    held = twin.mode.twin.effects
    assert held["position_friction"].parameters["count"] == 15.0 and not held["position_friction"].enabled
    (answer,) = twin.set_parameters([Parameter("effects.position_friction.enabled", value=True)])
    assert answer.successful and twin.mode.twin.effects["position_friction"].enabled
    (answer,) = twin.set_parameters([Parameter("effects.position_friction.torque", value=-1.0)])
    assert not answer.successful and "Max: 100.0" in answer.reason


@pytest.mark.slow
def test_a_node_refuses_a_wrong_file_in_one_line(own):
    process = start_process("ema_twin_sim.nodes.twin", f"effect_files:=[{own(WRONG['a text'][0])}]")
    error = process.communicate(timeout=ENDING)[1]
    assert process.returncode == 2 and len(error.splitlines()) == 1
    assert "own.py: line 4" in error
