"""Default false-alarm rates: how often a healthy unit may be called off. The limits follow from these."""

FALSE_ALARM = 0.01
"""Share of a healthy unit's recordings. For the ball screw of Cranfield one in fifty was required; half of that leaves
room for features that are not normally distributed."""
FALSE_ALARM_OF_HISTORY = 0.001
"""The same per recording of a history: with some hundred recordings per unit, one alarm in ten healthy units."""
