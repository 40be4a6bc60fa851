"""The two-level three-phase bridge and the hysteresis comparators that switch it.

The thesis's blocks "PWM" and "H-bridge": every phase has its own comparator and its own leg, which connects it to one
rail of the DC link or the other. Dead time is not modelled (the script gives none). Switches and diodes conduct through
``switch_resistance`` (inverter.Hbridge.Ron), which is added to the phase resistance. The script's snubbers (1e5 ohm)
would draw 4 mA a leg and are omitted.

With a floating star point a phase's voltage depends on all three legs, so a current can leave its band: while all legs
are on one rail, no leg can turn it back. The three errors add up to zero, so it stays within twice the band: the other
two can each be off by at most one band in the opposite direction (Brod and Novotny, IEEE Trans. Ind. Appl. 21, 1985,
562-570).
"""

from ..compiled import compiled


@compiled
def comparator(current, reference, hysteresis, leg):
    """New state of the leg: 1 (upper switch) below the band, -1 (lower switch) above it, unchanged within."""
    error = current - reference
    return 1.0 if error < -hysteresis else (-1.0 if error > hysteresis else leg)
