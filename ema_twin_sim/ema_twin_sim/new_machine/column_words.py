"""The words and units by which columns of a trace are known: of a quantity, a shaft, a setpoint, or of no signal.

Regular expressions look for parts of a word unless they are bound to its ends.
"""

from __future__ import annotations

STEMS: dict[str, str] = {
    "time": r"time|zeit|^temps$|^tempo$|^tiempo",
    "temperature": r"^temp",
    "torque": r"torque|moment(?!um)|force|kraft|^(set|ref|cmd|act|meas)?(trq|tor$)|^tau$|effort|^couple|^coppia|^par$"
    r"|^forza$|^fuerza$",
    "current": r"current|strom|^amps?$|^(set|ref|cmd|act|meas|mot)?curr?$|^strm$|^courant|^corr?iente|^corrente",
    "voltage": r"volt|spannung",
    "speed": r"speed|veloc|drehzahl|geschwind|omega|^(set|ref|cmd|act|meas)?(vel|rpm|spd)$|^vitesse|^vit$|^regime$"
    r"|^giri$",
    "position": r"posi|^pos|pos$|angle|winkel|^lage(?!r)|lage$|lageist|lagesoll|encoder|geber|^enc$|^weg$|travel|twist"
    r"|verdreh|^angol|^angul|^codeur|^recorrido$",
    "power": r"power|leistung|^watts?$|^puissance$|^potenza$|^potencia$",
}
"""Parts of words that determine a quantity, in the order in which they are looked for."""

PRESENT = r"^(current|curr?)$"
"""Words that before a position or a speed mean its present value, as in ``Current Position``, and no current."""

ENCODER = r"encoder|geber|^enc$|codeur"

SYMBOLS: dict[str, frozenset[str]] = {
    "time": frozenset({"t"}),
    "torque": frozenset({"m", "tq"}),
    "current": frozenset({"i", "iq", "im", "iist", "iact", "imot"}),
    "voltage": frozenset({"u", "uq"}),
    "speed": frozenset({"w", "n", "v", "qd", "dq", "dphi", "dtheta", "dx", "phip", "qp", "qdot", "nist", "nact"}),
    "position": frozenset({"q", "phi", "theta", "alpha", "beta", "gamma", "x", "s", "th"}),
}
"""Whole words that are symbols of a quantity."""

SETPOINT = (
    r"setp|soll|command|demand|desire|target|refer|rifer|consign|vorgabe|fuehrung"
    r"|^(set|ref|cmd)(vel|rpm|spd|speed|pos|cur|torque|trq)"
    r"|^(set|ref|cmd|sp|des|star|goal|wanted|tgt|actions?)$"
)
ACTUAL = r"^(ist|act|actual|meas|measured|fb|feedback|mesuree?|misurat[ao]|medid[ao]|reale?)$|istwert|^ist"
ESTIMATED = r"^est$|^estimate[ds]?$|^estimation$|^geschaetzt"
"""Words for what the drive estimates, mostly from its currents."""
COMPUTED = r"^calc$|^calculated$|^computed$|^berechnet"
"""Words for what a controller computed: taken only if nothing that the drive reports is there."""
SHARE = r"^k[pid]$|^gravit|^friction|^damping$|^viscous$|^coulomb$|^inertial?$|^coriolis$|^centri|^reibung|^schwer"
"""Words for one share of a torque, which a model or a controller computes: taken only if the whole is not there."""
OUTPUT = (
    r"output|abtrieb|^load|^last(?!_)|^link|^joint|^arm(?!a)|^slow$|second|^out$|^(l|o|2)$|brake|bremse|dyno"
    r"|^sortie|^charge$|^uscita|^carico|^salida|^carga$"
)
MOVED = r"^steer|^lenk|^pedal|^rudder|^aileron|^elevator$|^flaps?$|^valve"
"""What motors move: without a word for the motor beside it, an angle of such a part is not the motor's."""
MOTOR = r"motor|rotor|antrieb|^moteur|^motore|^(mot|m|1|fast|primary|drive|input)$"
MOTOR_ITSELF = r"motor|rotor|antrieb|^moteur|^mot$"
NUMBERED = r"^(axis|achse|odrive|moteus)$"
"""Words before a number that tells which of several drives it is, and neither its motor nor its output."""
NO_SIGNAL = (
    r"error|err$|fehler|deviat|abweich|limit|grenz|ripple|accel|^acc[xyz]?$|beschleun|vibration|status"
    r"|^(mode|flags?|ddot|max|min|dc|udc|idc)$"
    r"|zwischenkreis|^bus$|supply|^(id|isd)$|offset"
)
DUTY = r"^pwm|^duty|^tastgrad|^tastverh"
"""A share of the supply's voltage that a drive gives to its motor."""
DUTY_SETTING = r"^freq|^enable|^mode|^stat(e|us)|^period|^frequenz|^freigabe"
"""What is set or told beside a duty cycle."""
FEEDFORWARD = r"^ff$|^feedforward$|^vorsteuer"
"""A share of a command, which the drive adds to its controller's: neither a measurement nor what the drive follows."""
SUPPLY = r"supply|^(dc|bus|battery|batt)$|zwischenkreis|versorg"
"""Names of a drive's supply, whose current has not the sign of the motor's."""
TRANSDUCER = r"^sensor|transducer|^cell$|loadcell|messwelle|dehn|strain|^tr[sd]$|^futek$|^kistler$|^hbm$"
"""Names of transducers, with those of usual series (TRS605, TRD605) and makers, that measure the torque behind a
machine whose current or own torque is measured too."""
SENSOR_SERIES = r"^tr[sd]$"
"""Names of series of such transducers, whose type is a number behind them, and no joint's: ``trs605-5``."""
INERTIAL = r"^imus?$|^gyro|^ahrs$"
"""Names of inertial sensors, whose turning is that of what they are fixed to: taken only if no shaft's is there."""
TOOL = r"^(tcp|tool|flange|cartesian|cart|eef|wrench)$"
"""Names of what a robot holds at its end: its pose and the force on it are of all joints together."""
FILTERED = r"^filt|smooth|geglaett"
"""A smoothed copy of a signal: taken only if the signal itself is missing."""
UNPROCESSED = r"^(raw|values?|states?|signals?|data|dot)$"
"""Words that come with any quantity and tell neither a part of the machine nor a side of it."""
OF_A_SYMBOL = (
    r"^(..?|rms|eff|avg|mean|mittel|sum|total|ges|gesamt|anker|armature|stator|phase|welle|shaft|spindle|spindel)$"
)
"""Words beside which a single letter is still the symbol of a quantity: subscripts, kinds, parts of all motors."""
NUMBER_OF_SOMETHING = r"^(number|nummer|sequence|index)$"
"""The last word of a name without a unit that is no measurement, as of ``current program number``."""
OF_NO_PART = "|".join(
    (
        *STEMS.values(),
        *(ACTUAL, COMPUTED, ENCODER, ESTIMATED, FEEDFORWARD, FILTERED),
        *(MOTOR, OUTPUT, SETPOINT, TRANSDUCER, UNPROCESSED),
    )
)
"""All words that tell what is measured, how, and on which side, and so no part of the machine."""
SLIDES = r"^pos|^x$|^s$|weg$|travel|stroke|hub$"
"""Words for positions that may be lengths."""
TIME_WORDS = (
    r"^(t|time|zeit|timestamp|zeitstempel|elapsed|mess|messzeit|laufzeit|uhrzeit|stamp|rel|abs|relative|since|start|unix"
    r"|temps|tempo|tiempo|tid|tijd|czas|aika)$"
)
NO_CLOCK = (
    r"slip|schlupf|gliss|scorrim|desliz|poslizg|delay|verzoeger|lag$|latenc|jitter|period|durat|dauer|cycle|zyklus"
    r"|dead|totzeit"
)
"""Names of what is given in a unit of time but is no clock: an induction motor's slip, a delay, a duration."""
NO_CLOCK_IN_OTHER_LETTERS = r"轉差|转差|滑差|すべり|滑り|скольжени|周期|延迟|延遲"
"""The same in Chinese, Japanese and Russian."""
TIME_IN_OTHER_LETTERS = r"時間|时间|時刻|时刻|시간|время"
"""The same in Chinese, Japanese, Korean and Russian."""
POWER_UNIT = r"[umk\u00b5]?W|k?VA[rR]?|k?var"
"""Units of power, which no signal has."""
ACCELERATION_UNIT = r"m?g|g_?n|G|k?(m|rad|deg|\u00b0)\s*/\s*s(\^?2|\u00b2)|(m|rad|deg)\s*s\^?-2"
"""Units of acceleration, which no signal has either."""
FLOW_UNIT = (
    r"(?i)([cdm]?l|ltr|liters?|litres?|[cd]?m(\^?3|\u00b3)|ccm|gal)\s*/\s*(s|sec|min|h|hr|std)|[lg]pm|[cm]?m(\^?3|\u00b3)_?h"
    r"|k?g\s*/\s*(s|min|h)"
)
"""Units of a flow, such as a coolant's, which no signal has either."""
REACTIVE_OR_APPARENT = r"[kM]?(VA[rR]?|var)"
"""Units of powers that only an electric circuit has."""
BETWEEN_VOLTAGE_AND_CURRENT = r"^cos(phi)?$|^cosinus|^phasenwinkel|^phasenverschieb|^phaseangle$|^lambda$"
"""Names of the angle between voltage and current, and of its cosine."""
DIRECT_OR_PHASE = frozenset({"d", "u", "v", "w", "a", "b", "c", "alpha", "beta"})
"""Subscripts of currents and voltages that are not of the quadrature axis."""
