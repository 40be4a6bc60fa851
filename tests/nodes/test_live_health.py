"""The running unit's health: the monitor judges a run as `units` judges its recording, and publishes the numbers."""

import re
from dataclasses import replace

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from ros_graph import figures

from ema_bench_replay.bags.bag_writer import write_mcap
from ema_bench_replay.errors import InputError
from ema_bench_replay.load import load
from ema_bench_replay.nodes import qos
from ema_bench_replay.nodes.played_run import PlayedRun
from ema_bench_replay.nodes.sample_codec import write_state
from ema_twin_msgs.msg import EmaState
from ema_twin_sim.campaign.healthy import Healthy
from ema_twin_sim.campaign.jobs import Grouping, Task, find_jobs
from ema_twin_sim.campaign.store import Store
from ema_twin_sim.campaign.unit_health import Learnt, healthy_runs, learnt_from, unit_health
from ema_twin_sim.campaign.units import units_of
from ema_twin_sim.campaign.work import judged
from ema_twin_sim.commands.live import run as run_command
from ema_twin_sim.live.unit_watch import UnitWatch
from ema_twin_sim.model import load_model
from ema_twin_sim.nodes.live import run_live
from ema_twin_sim.nodes.live_session import HealthAsked
from ema_twin_sim.nodes.monitor import PARAMETERS, MonitorNode
from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.virtual_bench import virtual_bench

TESTS = 6
COULOMB = "effects.coulomb_friction.torque"


@pytest.fixture(scope="module")
def unit(tmp_path_factory):
    """The results of a unit with six healthy tests and one with more friction, and its last recordings of each kind."""
    folder = tmp_path_factory.mktemp("unit")
    model, command = load_model("polito_bench"), parse_command("triangle:0.1:1")
    drawn = np.random.default_rng(4)
    for test in range(TESTS + 1):
        friction = 0.0676 * (1.0 + 0.02 * drawn.normal()) + (0.1 if test == TESTS else 0.0)
        for run in range(2):
            bench = virtual_bench(model.with_value(COULOMB, friction), command, 5.0, seed=10 * test + run)
            write_mcap(bench, folder / "runs" / "EMA" / f"test {test}" / f"{run}.mcap")
    task = Task("health", "polito_bench")
    store = Store.made(folder / "results")
    store.write(
        [row for job in find_jobs(Grouping.of(folder / "runs", None, "recording"), task) for row in judged(job, task)]
    )
    return folder


def test_a_run_is_judged_as_its_recording_is(unit):
    watch = UnitWatch.opened(unit / "results", "", "test [0-5]/")
    assert watch.unit == "EMA" and "no run judged yet" in watch.words and not watch.off
    worn = load(unit / "runs" / "EMA" / "test 6" / "1.mcap")
    watch.judge(lambda: worn)
    (held,) = units_of(Store.opened(unit / "results").rows())
    offline = unit_health(held, Healthy.of("test [0-5]/", 4)).tests[-1].runs[1]
    assert watch.off and offline.detected
    assert watch.last.distance == pytest.approx(offline.distance, rel=1e-6)
    assert watch.last.words == offline.words
    assert "A, healthy" in watch.figures["friction"]


def test_a_run_is_read_with_the_wavelength_of_the_nearest_motion(unit):
    """Beside healthy runs three times as far and fast, whose wave is half as long, nothing of its judgement changes."""
    (held,) = units_of(Store.opened(unit / "results").rows())
    runs, flags = healthy_runs(held, Healthy.of("test [0-5]/", 4))
    (learnt,) = learnt_from([run for run, flag in zip(runs, flags, strict=True) if flag]).kinds
    period, travel, speed = learnt.motion
    own = replace(learnt, wavelength=0.25 * travel)
    other = replace(own, motion=(period, 3.0 * travel, 3.0 * speed), wavelength=0.5 * own.wavelength)
    worn = load(unit / "runs" / "EMA" / "test 6" / "1.mcap")
    told = []
    for kinds in ((own,), (other, own), (own, other)):
        watch = UnitWatch("EMA", Learnt(kinds, ()))
        watch.judge(lambda: worn)
        told.append(watch.last)
    assert "wave_depth" in told[0].features
    assert all(one.features == told[0].features and one.words == told[0].words for one in told)


def test_a_run_whose_beginning_is_not_held_is_told(unit):
    watch = UnitWatch.opened(unit / "results", "EMA", "test [0-5]/")
    worn = load(unit / "runs" / "EMA" / "test 6" / "1.mcap")
    watch.judge(lambda: worn, 1.01 * worn.duration)
    assert watch.off and "are held" not in watch.words
    watch.judge(lambda: worn, 4.0 * worn.duration)
    needed = int(re.search(r"only its last 5 of 20 s are held and judged: .* (\d+) samples$", watch.words)[1])
    assert watch.off and 4 * len(worn) < needed < 5 * len(worn)
    watch.judge(lambda: worn)
    assert "are held" not in watch.words


def test_a_run_of_another_motion_is_not_judged(unit):
    watch = UnitWatch.opened(unit / "results", "EMA", "test [0-5]/")
    watch.judge(lambda: virtual_bench(load_model("polito_bench"), parse_command("triangle:0.03:1"), 5.0))
    assert watch.last.detected is None and not watch.off
    assert "repeat their test" in watch.words


@pytest.mark.parametrize("fault", [InputError("too few samples were compared"), ZeroDivisionError("0 rows")])
def test_what_cannot_be_judged_is_told_and_nothing_of_the_run_before(unit, fault):
    watch = UnitWatch.opened(unit / "results", "EMA", "test [0-5]/")
    worn = load(unit / "runs" / "EMA" / "test 6" / "1.mcap")
    watch.judge(lambda: worn)
    assert watch.off and watch.figures

    def fails():
        raise fault

    watch.judge(fails)
    assert str(fault) in watch.words and not watch.off and not watch.figures
    watch.judge(lambda: worn)
    assert watch.off and not watch.refused


@pytest.mark.parametrize(("name", "healthy", "reason"), [
    ("other", "test", "holds no unit 'other'; give the unit: one of EMA"),
    ("EMA", "nothing", "no healthy recording is selected"),
    ("EMA", "test 0", "too few to estimate how tests differ"),
    ("EMA", "(", "no regular expression"),
])  # fmt: skip
def test_results_that_tell_nothing_of_it_are_refused(unit, name, healthy, reason):
    with pytest.raises(InputError, match=reason):
        UnitWatch.opened(unit / "results", name, healthy)


def test_the_monitor_publishes_the_units_health(graph, unit):
    monitor = graph.add(MonitorNode, services=False, results=str(unit / "results"), unit="EMA", healthy="test [0-5]/")
    node = graph.plain_node()
    publishers = [node.create_publisher(EmaState, f"{side}/state", qos.STATE) for side in ("bench", "twin")]
    told = []
    node.create_subscription(DiagnosticArray, "/diagnostics", lambda array: told.extend(array.status), 10)
    graph.spin_until(lambda: all(p.get_subscription_count() for p in publishers))
    for run, test in ((1, 6), (2, 0)):
        played = PlayedRun(load(unit / "runs" / "EMA" / f"test {test}" / "0.mcap"), 0, run)
        for k in range(len(played.part)):
            stamp, sequence, signals = played.sample(k)
            for publisher in publishers:
                publisher.publish(write_state(stamp, run, sequence, signals))
            if k % 50 == 0:
                graph.spin_for(0.002)
        if run == 1:
            graph.spin_until(lambda sent=k + 1: monitor.pairing.compared == sent)

    def off():
        return [s for s in told if "health of the unit" in s.name and s.level == DiagnosticStatus.WARN]

    graph.spin_until(off)
    status = off()[0]
    assert status.hardware_id == "EMA" and "effort in steady motion" in status.message
    assert float(figures(status)["distance, in times of the limit's"]) > 1.0


def test_live_hands_its_options_to_the_monitor(tmp_path):
    asked = HealthAsked(tmp_path, "EMA", "test [0-5]/", 30.0)
    given = {parameter.name: parameter.value for parameter in asked.parameters}
    assert given == {"results": str(tmp_path), "unit": "EMA", "healthy": "test [0-5]/", "judged_after": 30.0}
    assert given.keys() <= {declared.name for declared in PARAMETERS}
    assert "judged_after" not in {p.name for p in asked._replace(judged_after=None).parameters}


@pytest.mark.parametrize("given", [{"unit": "EMA"}, {"healthy": "4"}, {"judged_after": 10.0}])
def test_live_refuses_choices_without_results(given):
    with pytest.raises(InputError, match="give --results"):
        run_command(model="polito_bench", headless=True, **given)


def test_live_refuses_a_folder_without_results(unit):
    with pytest.raises(InputError, match="holds no results; give the folder"):
        run_live(None, load_model("polito_bench"), health=HealthAsked(unit / "runs", "", "", None))


@pytest.mark.slow
def test_live_ends_with_the_units_health(unit):
    worn = load(unit / "runs" / "EMA" / "test 6" / "1.mcap")
    asked = HealthAsked(unit / "results", "EMA", "test [0-5]/", None)
    live = run_live(worn, load_model("polito_bench"), rate=0.0, health=asked)
    assert live.complete and live.health["unit"] == "EMA" and live.health["off"]
    assert "effort in steady motion" in live.health["words"] and "friction" in live.health["figures"]
    assert run_live(worn, load_model("polito_bench"), rate=0.0).health is None
