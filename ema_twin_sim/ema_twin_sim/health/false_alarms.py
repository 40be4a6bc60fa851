"""How often a healthy unit may be called off, unless who asks says otherwise. What decides follows from these."""

FALSE_ALARM = 0.01
"""Share of a healthy unit's recordings. One in fifty was asked of the ball screw of Cranfield; half of that leaves room
for what is not normally distributed."""
FALSE_ALARM_OF_HISTORY = 0.001
"""The same of a recording in a history: with some hundred recordings a unit, one alarm in ten healthy units."""
