"""Criteria: all decision thresholds, in one table. Other numbers only set how finely or how long something is computed.

No threshold has a unit of a particular machine. Those in seconds, rad/s or rad/s² are in the machine's own units
(``model/own_units.py``): every machine is scaled to the size and speed of the reference bench ("own s" and so on). One
number has one meaning wherever it is used. To change a rule, change which meaning it uses; to change a number, run what
guards it.

Each entry says what it counts and why it has this value, and names the run that set it if there was one. All are
guarded by the runs of ``make accuracy``: ``--null`` (nothing hidden), ``--leave-out`` (the true cause removed from the
catalogue), the hidden effects of another bench, ``--other-machines`` (difficult machines whose friction wanders) and
``--calibration``.
"""

from __future__ import annotations

# Differences, in standard errors, or in tolerances of a constant

LIKELY = 2.0
"""A difference from here on is mentioned as a possibility. Chance gets there once in 20."""
CONTRADICTED = 3.0
"""From here on recordings contradict a model file, and an estimate counts as one. Chance gets there once in 400."""
SIGNIFICANT = 4.0
"""From here on an effect exists, or a constant is not this machine's. Chance gets there once in 16,000: some 40 effects
with several starts each are tried in a few rounds. ``--null``: none accused in 160 cases."""
APART = 6.0
"""From here on one recording belongs to another machine than the rest, or the encoders disagree. Beyond chance, since
rows are correlated and models are not exact."""
FAR_OUT = 8.0
"""For a single row: chance does not reach it in millions of rows. A simulated loop whose error is as many times the
noise does not follow the machine any more: it hunts, or hits the teeth at other times."""
SPIKE = 12.0
"""For a single sample, in robust standard deviations: beyond it the sample is a transmission error. An impact of the
teeth takes several samples."""
STRAINED_TOGETHER = 18.0
"""Sum of squares over all constants beyond which they are not those of the file. Four constants that are off by two
each are still below. ``--leave-out`` against ``--null``."""
STRAINED_BESIDE = 12.0
"""The same, if an added effect shows only in constants: it should have corrected them."""
DECIDED = 5.0
"""By how much rivals must separate in a planned recording: one more than SIGNIFICANT, since a simulation is not the
bench."""

# Complexity penalties, in twice a log-likelihood ratio of the correlated rows: an absent effect gains a few by chance

COST_EFFECT = 7.0
"""Penalty of an effect. Set together with the next on benches with nothing hidden, so that no effect is accused."""
COST_PARAMETER = 4.0
"""Penalty of each of its parameters: the square of two standard errors."""
COST_OF_BASIS_COLUMN = 6.0
"""Penalty of a column of a generic basis, which fits anything. Named effects must take precedence over it."""
COST_OF_WANDER = 12.0
"""Penalty of friction that wanders as part of the noise. ``--other-machines`` against steady machines."""
RIVAL_MARGIN = 8.0
"""By how much a rival must lose: odds of 50 to 1."""
DEPENDS = 25.0
"""Gain from which on the residual depends on something. ``--null``: it stays below 10. With the right effects it is
below 17 in 19 cases of another bench, with look-alikes of the true effect from 26 to 546."""
SHAKY = 3.0
"""Factor on chance gains if the output bounces: no contact law gets its impacts right."""

# Sizes of effects, in units of the noise of a recording's rows

LEAST_SIZE = 0.2
"""Smallest rms worth naming: below a quarter of the sensors' noise an effect does not improve the twin. Half of it for
a wave over the motor angle. ``--limits`` against ``--null``."""
LEAST_SIZE_LIKE_FRICTION = 0.35
"""The same for friction proportional to a load that never changes: it looks like any friction."""
LEAST_SIZE_BESIDE_IMPACTS = 0.7
"""The same if the output bounces, where the residual is never known as well."""

# What may remain, in units of the noise

UNEXPLAINED = 0.6
"""Rms beyond the noise up to which a recording counts as explained. Known causes against unknown ones of another
bench."""
MISFIT_DOUBTED = 1.1
"""Mean square from which on the residual is tested for a dependence; with added effects it always is."""
MISFIT_LEFT = 1.3
"""Mean square from which on something is left. ``--null``: it stays below."""
BRISTLED = 2.0
"""Factor on these limits with presliding friction (a bristle): every law of it differs a little."""
CLEARLY_MORE = 1.2
"""Factor from which on one rms error is clearly larger than another."""
NOISY = 1.5
"""Factor on the noise below which an rms shows the sensors and not the model."""
TOO_MUCH = 3.0
"""Factor on the expected value from which on something is wrong. Real machines with right models leave up to 2.6 times
their sensors' noise."""
INTERPOLATED = 10.0
"""Factor on an encoder's noise that its interpolation error between lines may reach."""

# Shares

NEGLIGIBLE = 0.02
"""A share that counts as nothing: sensor calibrations, and two right models of the same thing, differ by as much."""
SMALL = 0.1
"""A share not worth naming. Models of real machines, whose friction laws are never exact, leave about as much of the
torque."""
PART = 0.25
"""A considerable share: what a cause must remove, or what may be left. Over 50 cases with backlash or compliance, these
removed 0.32 or more of the encoder difference."""
MOSTLY = 0.75
"""The greater share. Eleven late encoders removed 0.89 or more of the encoder difference, three look-alikes 0.60 or
less."""
NEARLY_ALL = 0.95
"""All but what is rare or indistinguishable from it: of moving rows, of a gain, of a correlation. Of what a free shape
over the same quantity explains, 53 hidden effects removed 0.97 or more; all look-alikes but one of 14 removed 0.91 or
less."""
ALL_BUT_SPIKES = 0.999
"""Share of samples that counts in a search for a largest value: spoilt samples are fewer."""
SUREST = 0.98
"""Upper limit of any stated probability. Of 152 unseen cases of other benches 149 were right (docs/accuracy.md)."""

# Limits of parameters

LARGEST_EFFECT = 2.0
"""Factor on the largest measured torque, and on the fastest driven motion. Loads that cancel each other may be as
large."""
SEARCHED_UP_TO = 10.0
"""Factor on what was reached, or given, up to which a number is searched."""
SEARCHED_BEYOND_STARTS = 5.0
"""Factor on the outermost starts of a number that bends a curve."""
ANY_SIZE = 1e3
"""Factor on what was reached, for a number that nobody knows or that only shapes an effect."""
STIFFEST = 9.0
"""Factor on the contact stiffness that samples resolve: no encoder shows the deflection of a stiffer one."""

# Prior knowledge

TOLERANCE = 0.05
"""Relative tolerance of a constant in a model file that gives none. Data sheets of motors and gearboxes are off by as
much."""
UNSEEN_SPREAD = 3.0
"""Factor on the typical size, for a number of which the recordings say nothing."""
LAG_TOLERANCE = 2e-4
"""Own s, tolerance of the lag or lead of the current relative to the position: one and a half control cycles of the
drive."""
CALIBRATION = 0.005
"""Relative difference between two right formulations of the same physics."""
SIDES_ERROR = 0.01
"""Error of how friction is shared between two sides that can separate. Measured on the virtual bench, like the next."""
DAMPING_ERROR = 0.4
"""Relative error of a contact's damping, which a few impacts hardly determine."""

# Weight of a row, by its residual in standard deviations of its noise

OUTLIER = 4.0
"""From here on a row gets less and less weight. With normal noise hardly any row is that far off."""
BESIDE_IMPACTS = 10.0
"""The same if the output bounces."""
MISSHAPEN = 20.0
"""Largest such limit without bouncing: large residuals there are model errors, not impacts."""
FAR_OFF_ROW = 30.0
"""The same while starts are compared; the limit at which a row is cut off, and the most it can cost."""
CORRELATION = 2.0
"""Rows that count as one, because neighbours share half their smoothing window. Operating points share nothing."""

# The search

USUAL_EFFECTS = 4
"""Number of effects that a machine may usually lack; if more seem missing, wandering friction may be the cause.
``--other-machines``."""
MOST_EFFECTS = 7
"""Most effects that are added: what needs more has another cause. ``--leave-out``."""

# Rows

STANDSTILL = 0.3
"""Own rad/s of the motor below which friction has no direction."""
HARD = 50.0
"""Own rad/s² beyond which a row gets less weight: there smoothing errs by more than the noise."""
CHAOTIC = 500.0
"""Own rad/s² after which an output with backlash may come to rest anywhere in the gap."""
SHAKEN = 0.05
"""Own s after hard acceleration in which rows get less weight."""
THROWN = 2.0
"""Own s after such an impact in which the encoder difference is not judged."""
COUNTED = 2.5
"""Counts of both encoders by which their readings may step where they are slow and coarse."""
FEWEST_ROWS = 20
"""Rows that a recording needs to be informative. A mean square of fewer is uncertain by a third."""
LEAST_ROWS = 50
"""Rows of motion that all recordings together need. As CORRELATION rows count as one: five for each of three constants
and of an effect's two parameters. Logs of real joints at 30 Hz give right constants with 80 rows."""
