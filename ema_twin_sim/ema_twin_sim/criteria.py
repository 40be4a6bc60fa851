"""Criteria: every number that decides, in one table. What is not here says how finely or for how long
something is computed.

None has a unit of a machine: what is in seconds, rad/s or rad/s² is in the machine's own units
(``model/own_units.py``), in which every machine is as large and as quick as the reference bench. One number stands for
one meaning, wherever that is asked for: to change a rule, change which meaning it asks for; to change a number, run
what guards it.

Each tells what it counts and why it is so large. Where one run set it, that is told; the runs that guard them all are
those of ``make accuracy``: ``--null`` (nothing hidden), ``--leave-out`` (the cause taken out of the catalogue), the
hidden effects of another bench, ``--other-machines`` (unkind ones, whose friction wanders) and ``--calibration``.
"""

from __future__ import annotations

# Differences, in standard errors, or in tolerances of a constant

LIKELY = 2.0
"""From which on a difference is told at all, as something that may be. Chance gets there once in twenty."""
CONTRADICTED = 3.0
"""From which on recordings contradict a model file, and an estimate is one. Chance gets there once in 400."""
SIGNIFICANT = 4.0
"""From which on an effect is there and a constant is not this machine's. Chance gets there once in 16,000: some 40
effects with several starts each are tried in a few rounds. ``--null``: none accused in 160 cases."""
APART = 6.0
"""From which on one recording is of another machine than the rest, and encoders part. Beyond chance, since rows are
correlated and models are not exact."""
FAR_OUT = 8.0
"""Of a single row: no chance reaches it in millions of rows."""
SPIKE = 12.0
"""Of a single sample that is a transmission error, in robust ones: an impact at the teeth takes several samples."""
STRAINED_TOGETHER = 18.0
"""Squared, summed over all constants, beyond which they are not those of the file: four that are off by two each are
not there yet. ``--leave-out`` against ``--null``."""
STRAINED_BESIDE = 12.0
"""The same beside an effect that only constants tell, which should have put them right."""
DECIDED = 5.0
"""By which rivals must come apart in a planned recording: one more than significant, since a simulation is not the
bench."""

# Prices, in twice a log-likelihood ratio of the correlated rows: what is not there gains a few by chance

COST_EFFECT = 7.0
"""Of an effect. Set with the next on benches with nothing hidden, so that none of these is accused."""
COST_PARAMETER = 4.0
"""Of each number that it brings: the square of two standard errors."""
COST_OF_BASIS_COLUMN = 6.0
"""Of a column of a generic basis, which fits anything. Effects that have a name must go before it."""
COST_OF_WANDER = 12.0
"""Of friction that wanders as part of the noise. ``--other-machines`` against steady ones."""
RIVAL_MARGIN = 8.0
"""By which a rival must lose: odds of 50 to 1."""
DEPENDS = 25.0
"""Gain from which on what is left depends on something. ``--null``: it stays below ten; beside right names below 17 in
19 cases of another bench, beside likenesses of the true effect from 26 to 546."""
SHAKY = 3.0
"""Times more that is gained by chance beside an output that bounces, whose impacts no contact law gets right."""

# Sizes of effects, in the noise of a recording's rows

LEAST_SIZE = 0.2
"""The smallest rms that is worth a name: less than a quarter of the sensors' noise, no twin is the better for it.
Half of it of a wave over the motor's angle: ``--limits`` against ``--null``."""
LEAST_SIZE_LIKE_FRICTION = 0.35
"""The same of friction in proportion to a load that never changes: it looks like all friction."""
LEAST_SIZE_BESIDE_IMPACTS = 0.7
"""The same beside an output that bounces, which is never known as well."""

# What may be left over, in the noise

UNEXPLAINED = 0.6
"""Rms beyond the noise of a recording that is explained. Known causes against unknown ones of another bench."""
MISFIT_DOUBTED = 1.1
"""Mean square from which on it is asked whether what is left depends on anything; beside added effects always."""
MISFIT_LEFT = 1.3
"""Mean square from which on something is left. ``--null``: it stays below."""
BRISTLED = 2.0
"""Times that where friction gives way before it slides: every law of that does so a little differently."""
CLEARLY_MORE = 1.2
"""Times, from which on one rms error is larger than another."""
NOISY = 1.5
"""Times the noise, below which an rms shows the sensors and not the model."""
TOO_MUCH = 3.0
"""Times what is expected, from which on something is wrong. Real machines with right models are left with up to 2.6
times their sensors' noise."""
INTERPOLATED = 10.0
"""Times an encoder's noise by which it may err between its lines."""

# Shares

NEGLIGIBLE = 0.02
"""A share that is as good as nothing: calibration of sensors and of two right models of one thing differ by as much."""
SMALL = 0.1
"""A share that is not worth a name. Models of real machines, whose laws of friction are never exact, leave about as
much of the torque."""
PART = 0.25
"""A considerable share: what a cause must take away, or a leftover may be. Over 50 cases with play or a spring, these
took 0.32 or more of how the encoders part."""
MOSTLY = 0.75
"""The greater share. Eleven late encoders took 0.89 or more of how the encoders part, three likenesses of them 0.60 or
less."""
NEARLY_ALL = 0.95
"""All but what is rare or cannot be told from it: of rows that move, of a gain, of a correlation. Of what any shape
over the same quantity explains, 53 effects that were hidden took 0.97 or more, 14 likenesses but one 0.91 or less."""
ALL_BUT_SPIKES = 0.999
"""Of samples that count where a largest value is asked for: spoilt ones are fewer."""
SUREST = 0.98
"""No statement is surer. Of 152 unseen cases of other benches 149 were right (docs/accuracy.md)."""

# How far numbers may go

LARGEST_EFFECT = 2.0
"""Times the largest torque measured, and the fastest motion driven. Loads that cancel each other may be as large."""
SEARCHED_UP_TO = 10.0
"""Times what was reached, or given, up to which a number is searched for."""
SEARCHED_BEYOND_STARTS = 5.0
"""Times its outermost starts for a number that bends a curve."""
ANY_SIZE = 1e3
"""Times what was reached, for a number that nobody knows or that only shapes an effect."""
STIFFEST = 9.0
"""Times the contact that samples resolve: what a stiffer one gives way by, no encoder shows."""

# What is known before

TOLERANCE = 0.05
"""Relative, of a constant in a model file, where it gives none. Data sheets of motors and gearboxes are off by as
much."""
UNSEEN_SPREAD = 3.0
"""Times its typical size, of a number of which the recordings say nothing."""
LAG_TOLERANCE = 2e-4
"""Own s, of a current that lags or leads the position. A control cycle and a half of the drive."""
CALIBRATION = 0.005
"""Of a number: what two right formulations of the same physics differ by."""
SIDES_ERROR = 0.01
"""Of how friction is shared between two sides that part. Measured on the virtual bench, as is the next."""
DAMPING_ERROR = 0.4
"""Of a contact's damping, which a few impacts hardly tell."""

# What a row counts, in standard deviations of its noise

OUTLIER = 4.0
"""From which on it counts less and less. Where noise is normal, hardly a row is that far off."""
BESIDE_IMPACTS = 10.0
"""The same where an output bounces."""
MISSHAPEN = 20.0
"""The same at most where nothing bounces: what is left there is a model's error and no hit."""
FAR_OFF_ROW = 30.0
"""The same while starts are compared; where a row is cut off, and what it loses at most."""
CORRELATION = 2.0
"""Rows that count as one, as neighbours share half their smoothing."""

# The search

USUAL_EFFECTS = 4
"""That a machine may lack; where more seem missing, friction that wanders may be behind them. ``--other-machines``."""
MOST_EFFECTS = 7
"""That are added: what takes more is something else. ``--leave-out``."""

# Rows

STANDSTILL = 0.3
"""Own rad/s of the motor below which friction has no direction."""
HARD = 50.0
"""Own rad/s² beyond which a row counts less: there smoothing errs by more than the noise."""
CHAOTIC = 500.0
"""Own rad/s² after which an output with play rests anywhere."""
SHAKEN = 0.05
"""Own s after hard acceleration in which rows count less."""
THROWN = 2.0
"""Own s after such a throw in which the encoders' difference is not judged."""
COUNTED = 2.5
"""Counts of both encoders by which their readings may step where they are slow and coarse."""
FEWEST_ROWS = 20
"""Rows of a recording that tell anything. A mean square of fewer is off by a third."""
LEAST_ROWS = 100
"""Rows of motion in all recordings together: a second of the reference bench."""
