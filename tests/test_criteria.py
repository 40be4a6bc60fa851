"""The numbers that decide: in one table, dimensionless, sixty at most, and none anywhere else."""

import ast
from collections import Counter
from pathlib import Path

import pytest

import ema_twin_sim
from ema_twin_sim import criteria

PACKAGE = Path(ema_twin_sim.__file__).resolve().parent
ROOMS = ("measured", "identification", "comparison", "fitting", "discovery", "health", "campaign", "live")
MOST = 60
PLAIN = {-1, 0, 0.5, 1, 2, 3, 4}  # no, all, half; a few: counts of things that are there
ROUNDING = 1e-4  # smaller ones, and the reciprocals of such, keep arithmetic from failing
METHOD = {
    "measured/balance_estimate.py": "FIRST_WIDTH LEAST_WIDTH WIDER PASSES KERNEL ROWS LOADS",
    "measured/bandwidth.py": "NARROWER",
    "measured/drive_regression.py": "PIECE",
    "measured/folds.py": "FEWEST_OF_BOTH BLOCKS",
    "measured/induced_voltage.py": "BUS",
    "measured/load_sensor.py": "_WIDTH _SHARE _ENDS _FEWEST_POINTS _SPEED _MOVING _MOTION",
    "measured/magnitude.py": "SMOOTHED _AT_ENDS",
    "measured/observe.py": "START JITTER LEAST_NOISE WIDER LARGEST",
    "measured/order_spectrum.py": "_ANGLE_BINS _LARGEST _LEAST _FINER",
    "measured/signal_factors.py": "DEGREES RPM TURN SETPOINT",
    "measured/adaptive_acceleration.py": "_TIMES _AGREE",
    "measured/ratio_of_positions.py": "ALIKE _FEWEST_TO_REFINE _SMOOTHED _AT_ENDS _ROUND _MOVING _FEWEST _WINDOWS",
    "measured/ratio_of_recordings.py": "_WINDOWS _SMOOTHED _AT_ENDS _FEWEST _MOST _BLOCKS _ROUND _BEND _DIRECTION",
    "measured/robust_regression.py": "_STEPS",
    "measured/smoothed_motion.py": "WIDTH COUNTER_WIDTH COUNTER_SPEED_WIDTH COUNTER_PULL LEAST_PERIODS FEWEST",
    "measured/smoothing.py": "REACH DERIVATIVE_REACH",
    "measured/spoilt_samples.py": "FEWEST TOLD ROUNDING NEIGHBOURS",
    "measured/switching_ripple.py": "_FINER",
    "measured/twist.py": "SMOOTHED FEWEST AT_ENDS",
    "measured/observability.py": "ENDLESS",
    "measured/speed_lag.py": "_BLOCKS _FEWEST",
    "measured/way_by_speed.py": "WINDOW FEWEST",
    "identification/chance.py": "NEIGHBOURS EXPLAINED",
    "identification/compliance.py": (
        "STIFFNESS DAMPING WIDTHS ABOUT HOLDING SIDES CONTACTS OUTPUT_SHARE SOFTER HARDLY HOPELESS RIVAL SPRINGY"
    ),
    "identification/cramer_rao.py": "LAGS MOST_LAGS NOTHING",
    "identification/equation.py": "KEPT",
    "identification/excerpt.py": "EXCERPT EXCERPTS MOST_TURNS",
    "identification/fit.py": "INITIAL_DAMPING NO_GAIN",
    "measured/quieter_motion.py": "MOST_PERIODS AS_QUIET PARTS STRETCHES STRETCH",
    "discovery/late_output.py": "SEARCHED_TO",
    "discovery/zeros_by_load.py": "SAME_ROWS",
    "discovery/zeros_by_model.py": "SAMPLES",
    "identification/generic_bases.py": (
        "KNOTS LEAST_KNOTS KNOT MOST_KNOTS LONGEST_WAVE SHORTEST_WAVE WAVES ORDERS BASIS_STEPS"
    ),
    "identification/hypothesis.py": "EXACT",
    "identification/null_hypothesis.py": "LAG_LIMIT LAG_STEP",
    "identification/local_minima.py": "FINALISTS STIFFER DAMPED HEAVIER HOPS",
    "identification/screening.py": "STEP AT_ONCE",
    "identification/search_limits.py": "LATEST LATEST_SAMPLES _POWERS",
    "identification/sensors.py": "GEARBOX_COLUMNS STEPS NEXT_TO_NOTHING",
    "identification/side_by_side.py": "LEAST",
    "identification/start_values.py": "WIDE SPREAD FEWEST MOST _TURNS DECADES",
    "identification/uncertainty.py": "STEP_SHARES RIDGE BLOCKS LEAST_ELSEWHERE",
    "identification/wandering.py": "SHARES HARDLY",
    "identification/weighting.py": "FAR INFLATED",
    "comparison/decisive_stretch.py": "_PARTS",
    "comparison/orders.py": "_STEP ORDERS _REFINED _MOST_REFINED _POLISHED FEWEST_CYCLES FEWEST_SAMPLES _ENOUGH",
    "comparison/setpoint_shift.py": "_MOST_SAMPLES",
    "comparison/torque_error.py": "BAND ENDS ORDER",
    "comparison/where.py": "_BINS FEWEST _SPEED_SHARES",
    "fitting/equation_misfit.py": "LAG_NUMBER",
    "fitting/fit.py": "MUCH",
    "fitting/free_parameters.py": "WEAK_ANGLE STEP STRUCTURAL_STEP SPAN OFF_BOUND",
    "fitting/simulation_misfit.py": "LINGER LEAP LEAPS MOST_ROWS FINE UNMEASURED",
    "fitting/solver.py": "ITERATIONS TRIES ENOUGH FINAL ROUGH STEEPEST PASSES",
    "fitting/starts.py": "FINALISTS STEPS TRIED",
    "fitting/uncertainty.py": "RIDGE",
    "fitting/unseen.py": "LAST",
    "discovery/criteria/own_shape.py": "TEETH_STEPS",
    "discovery/criteria/episodes.py": "SHORTEST HOLES",
    "discovery/criteria/worth.py": "STRAY_ROWS FEWEST_CYCLES",
    "discovery/diagnose.py": "BLOCK DRAWS RANKED SIMULATED",
    "discovery/differing_zeros.py": "LINES STEP FINER",
    "discovery/evidence.py": "BINS FEWEST BANDS LEAST_SHOWN SHOWN NEAR",
    "discovery/experiment/bench_limits.py": "_SLACK _SLACK_TRAVEL _LONG _NONE",
    "discovery/experiment/command_grid.py": (
        "LONGEST _SHORTEST _NICE _FEW_SPEEDS _SPEEDS _FEW_HALVES _HALVES _TIME_OF_SIZE"
    ),
    "discovery/experiment/doubts.py": "ALTERNATIVES",
    "discovery/experiment/next_command.py": "_TURNS _FINALISTS _FEW_FINALISTS _RUNNERS_UP _SIDE_BY_SIDE",
    "discovery/experiment/rival_field.py": "_STEP _AS_LONG STEPS",
    "discovery/experiment/suggestion.py": "SLOW FAST",
    "discovery/followed.py": "SECONDS STEPS ENOUGH TRIED FINER UNCOUNTED",
    "discovery/left_over.py": "_BINS _FEWEST",
    "discovery/search/adding.py": "ENTRANTS SECOND_LOOKS NEXT_TO_NOTHING",
    "discovery/search/found_orders.py": (
        "HIGHEST HIGHEST_UNGEARED HIGHEST_OF_MOTOR MOST FEWEST_TURNS MANY_CYCLES SLOW LEAST_DIGITS MOST_DIGITS SAME"
    ),
    "discovery/search/laws.py": "ITERATIONS",
    "discovery/search/rivals.py": "SWAPS",
    "discovery/search/search_order.py": "MORE",
    "discovery/search/unknown.py": "MOST_ROUNDS TRIED",
    "health/baseline.py": "FEWEST_TESTS _VANISHING",
    "health/block_limit.py": "_BEYOND _DRAWS _MOST",
    "health/change_point.py": "_FEWEST _BELIEVED _LARGEST",
    "health/false_alarms.py": "FALSE_ALARM FALSE_ALARM_OF_HISTORY",
    "health/disturbance.py": "_TAPS _TAPS_A_WAVE",
    "health/drift.py": "_FEWEST _ONSETS _POWERS _RATES _USUAL _STEPS _HARDLY _SECOND_DIFFERENCES _DIFFUSE",
    "health/encoders.py": "_REACHED",
    "health/families.py": "_AKAIKE",
    "health/features.py": "_FEW _PEAK _LOCAL _TINY",
    "health/motion_record.py": "_ROUNDING",
    "health/phases.py": "_SMOOTHED _FEWEST _TOP _STARTING _RESTING",
    "health/remaining_life.py": "_BEYOND",
    "health/wave.py": "FEWEST_CYCLES _FINER _NEIGHBOURS",
    "campaign/copies.py": "_SHOWN",
    "campaign/engine.py": "BATCH TASK AHEAD LARGEST DEATHS _CONNECTING _ENDING",
    "campaign/lost_workers.py": "LOOK PATIENCE _TOLD_AFTER _ANSWERED",
    "campaign/feature_courses.py": "_MOST",
    "campaign/healthy.py": "PART_OF_ALL",
    "campaign/histories.py": "FEWEST_HEALTHY _DAY _LEAST_OWN",
    "campaign/jobs.py": "_KEY_BYTES",
    "campaign/store.py": "_MANY_FILES _TRIES",
    "campaign/sweep.py": "MOST_POINTS",
    "campaign/work.py": "_LEAST_SAMPLES _HASH_BYTES",
    "live/diagnosing/judge.py": "_DIGITS",
    "live/diagnosing/worker.py": "_NICENESS",
    "live/diagnosing/worker_process.py": "_ENDING",
    "live/mixing.py": "FEW",
    "live/pace.py": "_WINDOW",
    "live/sample_stream.py": "REORDERED",
    "live/standalone.py": "_LOOKED_AT",
    "live/trend.py": "_LEAST _WINDOWS _TOLD",
    "live/waiting.py": "CAPACITY",
}
"""What says how finely or for how long something is computed: widths, grids, starts, steps, counts of tries and of what
is shown; and what holds where the user does not say otherwise (false alarms, which results are healthy). A number that
is none of these belongs into the table."""


def numbers(node):
    """Every number within a piece of source."""
    for part in ast.walk(node):
        if isinstance(part, ast.Constant) and isinstance(part.value, int | float) and not isinstance(part.value, bool):
            yield part.value


def constants(file):
    """Names of the module's own numbers."""
    for node in ast.parse(file.read_text()).body:
        if isinstance(node, ast.Assign) and any(True for _ in numbers(node.value)):
            for target in node.targets:
                yield from (part.id for part in ast.walk(target) if isinstance(part, ast.Name))


def files():
    return [file for room in ROOMS for file in sorted((PACKAGE / room).rglob("*.py"))]


def table():
    """(name, value, text below it) of each criterion."""
    body = ast.parse(Path(criteria.__file__).read_text()).body
    for node, after in zip(body, [*body[1:], None], strict=True):
        if isinstance(node, ast.Assign):
            text = after.value.value if isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant) else ""
            yield node.targets[0].id, ast.literal_eval(node.value), text


def test_sixty_numbers_decide_each_with_its_reason():
    found = list(table())
    assert len(found) > 40
    assert len(found) <= MOST, (
        f"{len(found)} criteria, at most {MOST}: reuse one with that meaning, or remove one (docs/architecture.md, "
        f"'A new criterion'). One file alone asks for {', '.join(asked_for_once(name for name, *_ in found))}"
    )
    for name, value, text in found:
        assert value > 0.0 and len(text) > 30, f"criteria.py: {name} needs a value above 0, and its reason below it"


def asked_for(file):
    """Names whose value a file uses."""
    nodes = ast.walk(ast.parse(file.read_text()))
    return {node.id for node in nodes if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load)}


def asked_for_once(names):
    """Those of the names that one file alone asks for."""
    count = Counter(name for file in files() for name in asked_for(file))
    return [name for name in names if count[name] == 1]


def test_every_criterion_is_asked_for_somewhere():
    asked = set().union(*(asked_for(file) for file in files()))
    assert [name for name, *_ in table() if name not in asked] == [], "nothing asks for these: remove them"


@pytest.mark.parametrize("file", files(), ids=lambda file: str(file.relative_to(PACKAGE)))
def test_no_number_decides_elsewhere(file):
    compared = {
        value
        for node in ast.walk(ast.parse(file.read_text()))
        if isinstance(node, ast.Compare)
        for value in numbers(node)
        if value not in PLAIN and ROUNDING < abs(value) < 1.0 / ROUNDING
    }
    name = str(file.relative_to(PACKAGE))
    assert compared == set(), f"{name} compares with plain numbers: give each a name and its reason in criteria.py"
    found, listed = [*constants(file)], METHOD.get(name, "").split()
    new = " ".join(constant for constant in found if constant not in listed)
    assert not new, (
        f"{name}: {new} decides something? Move it to criteria.py. Only how finely it is computed? Add it to METHOD"
    )
    assert found == listed, f"METHOD lists for {name}: {' '.join(listed)}; there are: {' '.join(found)}"


def test_methods_are_listed_for_files_that_are_there():
    assert {*METHOD} - {str(file.relative_to(PACKAGE)) for file in files()} == set()
