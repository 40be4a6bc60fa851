"""What is said of a search is understood at the first reading, and no sentence contradicts the one beside it."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from ema_twin_sim.comparison.running_comparison import share_removed
from ema_twin_sim.criteria import SUREST
from ema_twin_sim.discovery.assumed_torque import of_assumed_torque
from ema_twin_sim.discovery.cautions import of_open_constants
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.simulation.command import parse_command
from ema_twin_sim.simulation.virtual_bench import virtual_bench
from ema_twin_sim.words.next_recording import recording_words
from ema_twin_sim.words.sentences import (
    change_words,
    larger_sentence,
    left_sentence,
    output_sentence,
    removed_words,
    surest_sentence,
)

FLOOR = 15e-3  # A


@pytest.mark.parametrize(
    ("after", "told"), [(33.0 * FLOOR, "over 99.9 %"), (FLOOR, "100.0 %"), (330.0 * FLOOR, "97.1 %")]
)
def test_all_of_an_error_is_gone_only_where_the_noise_alone_is_left(after, told):
    before = 1950.0 * FLOOR
    assert removed_words(share_removed(before, after, FLOOR), before, after) == told


def test_what_the_last_step_leaves_is_told_beside_the_noise():
    unseen = SimpleNamespace(
        signal="unexplained_torque",
        rmse=(3.0, 33.0 * FLOOR),
        settled=(3.0, 33.0 * FLOOR),
        noise_floor=FLOOR,
        unit="N m",
    )
    assert left_sentence(unseen).endswith("error of the unexplained torque is still 33 times the sensors' noise.")
    for settled, told in ((4.0, "in motion it is 4.0 times the noise"), (1.2, "in motion it is within the noise")):
        mostly_at_rest = SimpleNamespace(**{**vars(unseen), "settled": (3.0, settled * FLOOR)})
        assert f"still 33 times the sensors' noise; {told}. At standstill," in left_sentence(mostly_at_rest)
    for quiet in ({"rmse": (3.0, 1.2 * FLOOR)}, {"noise_floor": 0.0}):
        assert left_sentence(SimpleNamespace(**{**vars(unseen), **quiet})) == ""


def test_why_no_answer_is_surer_is_told_and_what_open_constants_cost():
    assert f"{100.0 * SUREST:.0f} %" in surest_sentence()
    told = of_open_constants()
    assert "less than 10 % of the drive's torque remains unexplained" in told
    assert all(len(sentence.split()) <= 25 for sentence in told.split(". "))


def test_what_rests_on_an_assumed_torque_constant_is_told_while_it_is_assumed(stock):
    ramp = virtual_bench(stock, parse_command("ramp:0.05"), 0.1)
    without_current = replace(ramp, signals={k: v for k, v in ramp.signals.items() if k != "current"})
    path = "machine.torque_constant"

    def said(source, recording=ramp):
        held = replace(stock.constants[path], source=source)
        return of_assumed_torque([recording], replace(stock, constants={**stock.constants, path: held}))

    assert "1.91 N m/A, is only assumed" in said("assumed")[0]
    assert said("data sheet") == said("fitted; 1 before") == said("assumed", without_current) == ()


@pytest.mark.slow
@pytest.mark.parametrize("reverses", [False, True])
def test_what_one_direction_cannot_tell_apart_is_said(stock, reverses):
    loaded = stock.with_effect("constant_load", {"torque": 0.01})
    commands = ("ramp:0.05", "sine:0.02:0.5" if reverses else "ramp:0.1")
    driven = [parse_command(command) for command in commands]
    runs = [virtual_bench(loaded, one, 5.0, name=f"run {k}", seed=k) for k, one in enumerate(driven)]
    said = [text for text in discover(runs, stock).warnings if "record a motion in both directions" in text]
    assert len(said) == (0 if reverses else 1)


@pytest.mark.parametrize(
    ("value", "nominal", "words"),
    [
        (1.004, 1.0, "+0.4 %"),
        (0.131, 1e-3, "× 131"),
        (1.0, 1e-3, "× 1000"),
        (41974.9, 1e-3, "× over 1000"),
        (4e-9, 1e-3, "× under 0.001"),
        (2e-5, 1e-3, "× 0.02"),
        (2.9, 1.0, "+190.0 %"),
        (1.0, 0.0, ""),
    ],
)
def test_a_constant_far_from_its_start_value_is_told_as_a_factor(value, nominal, words):
    assert change_words({"value": value, "nominal": nominal}) == words


def test_at_which_shaft_torques_of_the_output_are_given_is_told_where_there_is_one(stock):
    model = stock.with_effect("gravity_load").with_effect("encoder_eccentricity").with_effect("cogging")
    told = output_sentence(model, ["cogging", "gravity_load", "coulomb_friction_2", "machine"])
    assert "(gravity load and Coulomb friction 2) are given at the motor; a torque at the output is 124 times" in told
    for names in ((), ("machine",), ("cogging", "encoder_eccentricity", "coulomb_friction")):
        assert output_sentence(model, names) == ""
    assert output_sentence(model.with_value("machine.gear_ratio", 1.0), ["gravity_load"]) == ""


def test_why_a_step_is_kept_whose_simulated_error_grew_is_told_where_one_is():
    def step(before, after, action="add"):
        return SimpleNamespace(action=action, rmse_before=before, rmse_after=after)

    assert larger_sentence([step(29.7, 29.8), step(29.8, 5.6)]).startswith("Larger error: a step takes the effect that")
    for steps in ([], [step(29.7, 5.6)], [step(1.0, 1.0001)], [step(1.0, 2.0, "remove")]):
        assert larger_sentence(steps) == ""


@pytest.mark.parametrize(
    ("settled", "told"), [((0.036, 0.011), True), ((0.157, 0.255), False), ((0.036, 0.034), False)]
)
def test_where_an_error_grew_at_standstill_alone_that_is_told(settled, told):
    grown = [SimpleNamespace(action="add", rmse_before=0.157, rmse_after=0.255)]
    unseen = SimpleNamespace(rmse=(0.157, 0.255), settled=settled, unit="N m")
    said = larger_sentence(grown, unseen)
    assert ("In motion the steps together brought the error from 36.0 mN m to 11.0 mN m" in said) == told
    assert told or "a step takes the effect that best explains" in said


@pytest.mark.parametrize(
    ("suggested", "motion", "words"),
    [
        (
            "triangle:0.006:6 for 25 s: asymmetric_friction and a model without it would come apart by 6 standard "
            "deviations, over the whole recording",
            "linear",
            "triangle:0.006:6 for 25 s (position of the output: a triangle of ±0.006 m/s that turns every 6 s). "
            "Asymmetric friction and a model without it would come apart by 6 standard deviations of the noise, "
            "over the whole recording.",
        ),
        ("a motion, slow and fast, in both directions", "rotary", "a motion, slow and fast, in both directions"),
        ("", "rotary", ""),
    ],
)
def test_what_to_record_next_has_units_and_words_for_effects(suggested, motion, words):
    assert recording_words(suggested, motion) == words
