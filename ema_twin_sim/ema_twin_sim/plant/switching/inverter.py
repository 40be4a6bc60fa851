"""The two-level three-phase bridge and the hysteresis comparators that switch it.

The thesis's blocks "PWM" and "H-bridge": every phase has its own comparator and its own leg, which ties it to one rail
of the DC link or to the other. Dead time is not modelled (the script gives none). Switches and diodes conduct through
``switch_resistance`` (inverter.Hbridge.Ron), which counts with the phase's own. The script's snubbers (1e5 ohm) would
draw 4 mA a leg and are left out.

With a floating star point a phase's voltage depends on all three legs, so that a current can leave its band: while all
legs lie on one rail, no leg can turn it back. Errors add up to zero, and so it stays within twice the band, less than
two others can each be off the other way (Brod and Novotny, IEEE Trans. Ind. Appl. 21, 1985, 562-570).
"""

from ..compiled import compiled


@compiled
def comparator(current, reference, hysteresis, leg):
    """The leg after a comparator: 1 (upper switch) below the band, -1 (lower switch) above it, unchanged within."""
    error = current - reference
    return 1.0 if error < -hysteresis else (-1.0 if error > hysteresis else leg)
