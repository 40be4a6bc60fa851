"""Split a column's name into its words in plain letters and its unit.

People write units in brackets, after a slash, a comma, an underscore or the word "in", in English or German; symbols
come in Greek letters, with subscripts, or with a dot for a rate. Behind a name in letters that are neither Latin nor
Greek, as in Chinese, a unit needs no mark between. A single letter there is a unit only if the name says so, since it
may as well be a symbol: the n of a speed, the M of a torque, or the A of a motor A. Ticks of a time are a clock's, and
no counts of a position. Inches and feet are written ``in`` and ``ft`` in brackets only, as both are words as well.
"""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass, replace

from ema_bench_replay.units import units_of

COUNTS = "count"
"""The unit of a counter."""


def _products(forces: tuple[str, ...], lengths: tuple[str, ...]) -> tuple[str, ...]:
    """All spellings of a force times a length, in either order."""
    pairs = [(force, length) for force in forces for length in lengths]
    pairs += [(length, force) for force, length in pairs]
    return tuple(f"{one}{mark}{other}" for one, other in pairs for mark in (" ", "*", "·", ".", "-", ""))


_POUNDS = ("lbf", "lb", "lbs", "lbsf", "pound", "pounds")
_OUNCES = ("ozf", "oz", "ounce", "ounces")
_INCHES = ("in", "inch", "inches")
_FEET = ("ft", "foot", "feet")

_SPELLINGS: dict[str, tuple[str, tuple[str, ...]]] = {
    # unit: (quantity, its spellings in lower case)
    "s": ("time", ("s", "sec", "secs", "second", "seconds", "sek", "sekunden", "secondes", "secondi",
                   "segundos")),
    "ms": ("time", ("ms", "msec", "millisec", "milliseconds", "millisekunden")),
    "us": ("time", ("us", "µs", "usec", "microseconds", "mikrosekunden")),
    "ns": ("time", ("ns", "nsec", "nanoseconds")),
    "rad": ("position", ("rad", "radian", "radians", "radiant")),
    "mrad": ("position", ("mrad",)),
    "mdeg": ("position", ("mdeg", "mgrad", "m°", "millidegree", "millidegrees")),
    "arcmin": ("position", ("arcmin",)),
    "arcsec": ("position", ("arcsec",)),
    "deg": ("position", ("deg", "°", "degree", "degrees", "grad", "degs", "degre", "degres", "gradi",
                          "grado", "grados")),
    "rev": ("position", ("rev", "revs", "revolution", "revolutions", "turn", "turns", "umdr", "umdrehung",
                         "umdrehungen", "u", "r", "tr", "tour", "tours", "giro", "giri", "vuelta", "vueltas")),
    COUNTS: ("position", ("count", "counts", "cnt", "cnts", "inc", "incs", "increments", "ink", "inkr", "inkremente",
                          "tick", "ticks", "pulses", "impulse", "impulses", "lsb")),
    "m": ("position", ("m", "meter", "metre", "metres", "meters")),
    "mm": ("position", ("mm",)),
    "cm": ("position", ("cm",)),
    "um": ("position", ("um", "µm")),
    "in": ("position", _INCHES[1:]),
    "ft": ("position", _FEET[1:]),
    "rad/s": ("speed", ("rad/s", "rad/sec", "rad s^-1", "rad s-1", "rads^-1", "rad*s^-1", "1/s", "s^-1", "radps",
                        "radians/s", "radian/second", "radians/second")),
    "rpm": ("speed", ("rpm", "1/min", "u/min", "min^-1", "min-1", "r/min", "rev/min", "upm", "umdr/min", "turns/min",
                      "revs/min", "rev/minute", "revolutions/minute", "tr/min", "tours/min", "giri/min",
                      "vueltas/min")),
    "krpm": ("speed", ("krpm", "1000/min", "1000 rpm")),
    "deg/s": ("speed", ("deg/s", "°/s", "grad/s", "deg/sec", "degree/s", "degrees/s", "deg s^-1", "° s^-1", "dps",
                        "degps", "deg/second", "degree/second", "degrees/second", "gradi/s", "grados/s", "degres/s")),
    "rev/s": ("speed", ("rev/s", "u/s", "rps", "r/s", "turns/s", "turn/s", "umdr/s", "revs/s", "hz", "1/sec",
                        "turns/second", "revolutions/second")),
    "mrad/s": ("speed", ("mrad/s",)),
    "mdeg/s": ("speed", ("mdeg/s", "mgrad/s", "m°/s")),
    "m/s": ("speed", ("m/s", "m/sec", "m s^-1")),
    "mm/s": ("speed", ("mm/s", "mm/sec", "mm s^-1")),
    "cm/s": ("speed", ("cm/s",)),
    "m/min": ("speed", ("m/min",)),
    "in/s": ("speed", ("in/s", "in/sec", "inch/s", "inch/sec", "inches/s", "inches/sec", "inches/second", "ips")),
    "in/min": ("speed", ("in/min", "inch/min", "inches/min", "inches/minute", "ipm")),
    "ft/s": ("speed", ("ft/s", "ft/sec", "foot/s", "feet/s", "feet/sec", "feet/second")),
    "ft/min": ("speed", ("ft/min", "feet/min", "feet/minute", "fpm")),
    "N m": ("torque", ("nm", "n m", "n*m", "n.m", "n·m", "newtonmeter", "newtonmetre", "n-m")),
    "mN m": ("torque", ("mnm", "mn m", "mn*m", "mn·m", "mn.m")),
    "uN m": ("torque", ("unm", "un m", "un*m", "un·m", "un.m", "µnm", "µn m", "µn*m", "µn·m", "µn.m")),
    "N cm": ("torque", ("ncm", "n cm", "n*cm", "n·cm", "n.cm", "n-cm")),
    "N mm": ("torque", ("nmm", "n mm", "n*mm", "n·mm", "n.mm", "n-mm")),
    "kN m": ("torque", ("knm", "kn m", "kn*m", "kn·m")),
    "lbf in": ("torque", _products(_POUNDS, _INCHES)),
    "lbf ft": ("torque", _products(_POUNDS, _FEET)),
    "ozf in": ("torque", _products(_OUNCES, _INCHES)),
    "kgf m": ("torque", ("kgf m", "kgfm", "kgf*m", "kgf·m", "kgf.m", "kgf-m", "kgm", "kg m", "kg*m", "kg·m",
                         "kg.m", "kg-m")),
    "kgf cm": ("torque", ("kgf cm", "kgfcm", "kgf*cm", "kgf·cm", "kgf.cm", "kgf-cm", "kgcm", "kg cm", "kg*cm", "kg·cm",
                          "kg.cm", "kg-cm")),
    "gf cm": ("torque", ("gf cm", "gfcm", "gf*cm", "gf·cm", "gf.cm", "gf-cm", "gcm", "g cm", "g*cm",
                         "g·cm", "g.cm", "g-cm")),
    "N": ("torque", ("n", "newton", "newtons")),
    "mN": ("torque", ("mn",)),
    "kN": ("torque", ("kn",)),
    "lbf": ("torque", _POUNDS),
    "ozf": ("torque", _OUNCES),
    "kip": ("torque", ("kip", "kips", "klbf")),
    "kgf": ("torque", ("kgf", "kgsf", "kilogram-force")),
    "gf": ("torque", ("gf", "gram-force")),
    "A": ("current", ("a", "amp", "amps", "ampere", "amperes", "arms", "aeff", "a rms", "a eff", "a peak", "apk")),
    "uA": ("current", ("ua", "µa")),
    "mA": ("current", ("ma", "milliamp", "milliamps", "marms")),
    "V": ("voltage", ("v", "volt", "volts", "vdc")),
    "mV": ("voltage", ("mv",)),
    "degC": ("temperature", ("°c", "degc", "deg c", "degrees c", "c", "celsius", "deg celsius", "gradc")),
}  # fmt: skip

_COUNTS_AS_UNITS = frozenset({"pulse", "increment", "step", "steps", "edges", "schritte", "qc"})
"""Words for counts where a unit stands, in brackets or in a row of units; elsewhere they are parts of names."""

_LENGTHS_IN_BRACKETS = frozenset({"in", "ft"})
"""Units of length where a unit stands; elsewhere ``in`` is a word, and ``ft`` may be a sensor of force and torque."""

_NO_LENGTH = re.compile(r"torque|moment|force|kraft|speed|veloc|drehzahl|curr|strom|volt|temp|power", re.IGNORECASE)
"""Names of what is given in no length: ``torque (in)`` is that of an input."""

_TORQUE = re.compile(r"torque|moment", re.IGNORECASE)
"""Names of what is no force: a torque ``in lb`` is one in inch-pounds."""

_OF_A_CLOCK = re.compile(r"time|zeit|clock|stamp", re.IGNORECASE)
"""Names of what counts time, as in ``Realtime Tick``."""

_OF_NO_SIGNAL = frozenset({"w", "kw", "va", "kva", "var", "kvar"})
"""Units of power behind a name in other letters."""

_NO_PART = _OF_NO_SIGNAL | {"g", "mg"}
"""Units of no signal that may stand in brackets within a name, where other words tell a part of the machine."""

_OF_A_NAME = frozenset(
    (
        *("act", "actual", "ist", "real", "meas", "measured", "feedback", "raw", "filt", "filtered", "smoothed"),
        *("est", "estimated", "set", "setpoint", "sp", "soll", "ref", "reference", "target", "desired", "demand"),
        *("cmd", "command", "commanded", "motor", "output", "load"),
    )
)
"""Words in brackets that tell which value of a signal it is, or of which part, and are no unit: ``speed (actual)``."""

_KINDS = rf"{'|'.join(_OF_A_NAME)}|des|tgt|goal|sollwert|istwert|fb|out|avg|mean|mittel|cmded"
"""Words behind a unit that tell which value of a signal it is, or of which part: ``torque_Nm_cmd``."""

_KIND_BEHIND = re.compile(rf"(.*?[^\s_])((?:[\s_]+(?:{_KINDS}))+)", re.IGNORECASE)
_NUMBER_BEHIND = re.compile(rf"(.*?[^\s_])((?:[\s_]+(?:{_KINDS}))*[\s_]+\d+(?:[\s_]+(?:{_KINDS}))*)", re.IGNORECASE)
_WORDS_TOO = frozenset({COUNTS, "rev", "s", "ms", "us", "ns"})
"""Units whose names are words too, so that a name that begins with one need not tell a unit: ``turn_ref``."""

_TURNS_A_MINUTE = re.compile(r"(?:set|ref|cmd|act|meas)?(k?rpm)")
"""A word that is nothing but a unit, wherever it stands in a name: ``rpm_left``, ``setrpm``."""
_OF_A_RATE = frozenset({"per", "ratio", "rate", "dot", "ddot", "dt", "s", "sec"})
"""Words beside a unit that tell a rate or a ratio of what is measured in it: ``rpm_dot``, ``delta_rpm_s_2``."""

_IN_OTHER_LETTERS = {
    "time": r"时间|時間|時刻|时刻|시간|время",
    "temperature": r"温度|溫度|온도|температур",
    "torque": r"力矩|转矩|轉矩|扭矩|トルク|토크|момент|(?<![压壓圧电電出入能])力|힘|сила|усили",
    "current": r"电流|電流|전류|(?<![^\W_])(ток|струм)",
    "voltage": r"电压|電壓|電圧|전압|напряжени",
    "speed": r"转速|轉速|(?<!加)速度|回転数|속도|скорост",
    "position": r"角度|位置|位移|変位|變位|行程|距离|距離|각도|위치|угол|положени|позици|перемещени",
}
"""By quantity, what names it in Chinese, Japanese, Korean and Russian."""

_UNIT_OF = {spelling: unit for unit, (_, spellings) in _SPELLINGS.items() for spelling in spellings}
_SUPERSCRIPTS = str.maketrans({"⁻": "-", "¹": "1", "²": "2", "μ": "µ", "º": "°", "⋅": "·", "∙": "·"})
_UMLAUTS = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue", "Ä": "Ae", "Ö": "Oe", "Ü": "Ue", "ß": "ss"})
_GREEK = str.maketrans(
    {
        **dict.fromkeys("φϕΦ", " phi "),
        **dict.fromkeys("θϑΘ", " theta "),
        **dict.fromkeys("ωΩ", " omega "),
        **dict.fromkeys("τΤ", " tau "),
        **dict.fromkeys("αΑ", " alpha "),
        **dict.fromkeys("βΒ", " beta "),
        **dict.fromkeys("γΓ", " gamma "),
    }
)
_ACCENTS = str.maketrans("éèê", "eee")
_BRACKETS = re.compile(r"\s*[\[({<]\s*([^\])}>]*?)\s*[\])}>]")
_SUBSCRIPTS = frozenset({"m", "r", "a", "c", "n", "v"})
"""Units of one letter that may also be a subscript: after an underscore they may mean the motor, an axis or a phase."""


_SIGNAL = {"position": "motor_position", "speed": "speed", "torque": "motor_torque"}
"""A signal that is given in the units of each quantity that differs between motions."""


@dataclass(frozen=True)
class HeaderWords:
    """A column's name: its words in lower case, and its unit; None if it has no known one."""

    name: str
    words: tuple[str, ...]
    unit: str | None
    in_doubt: bool = False  # whether the unit may be a subscript as well
    foreign: str = ""  # text in the place of a unit that is not a known unit

    @property
    def quantity(self) -> str | None:
        """What is measured in that unit: time, position, speed, torque, current, voltage or temperature."""
        return None if self.unit is None else _SPELLINGS[self.unit][0]

    def as_subscript(self) -> HeaderWords:
        """The name if the ambiguous unit is a subscript."""
        letter = re.split(r"_", self.name.strip())[-1].lower()
        return replace(self, words=(*self.words, letter), unit=None, in_doubt=False)

    @property
    def linear(self) -> bool | None:
        """Whether the unit is one of a linear machine; None if it does not show that."""
        if self.quantity not in ("position", "speed", "torque") or self.unit == COUNTS:
            return None
        return self.unit in units_of(_SIGNAL[self.quantity], "linear")


def is_unit(text: str) -> bool:
    """Whether a text in the place of a unit is a known one."""
    return _unit_in_its_place(unicodedata.normalize("NFC", text).translate(_SUPERSCRIPTS)) is not None


def header_words(name: str) -> HeaderWords:
    """Split a column's name into words and unit."""
    text = unicodedata.normalize("NFC", name.strip()).translate(_SUPERSCRIPTS)
    if len(text) > 1 and (unit := _unit(text)):  # a single letter is a symbol
        return HeaderWords(name, (), unit)
    rest, unit, in_doubt, foreign = _without_unit(text)
    told, letter = _symbol(rest) if unit is None else ((), "")
    words = (*told, letter.lower()) if told else () if letter else tuple(_words(rest))
    return HeaderWords(name, words, unit, in_doubt, foreign)


def _unit(text: str) -> str | None:
    plain = re.sub(r"\s*([/*·])\s*|\s+per\s+", lambda found: found[1] or "/", text.strip().rstrip(".").lower())
    plain = plain.translate(_ACCENTS)
    return _UNIT_OF.get(re.sub(r"\s+", " ", plain))


def _unit_in_its_place(text: str) -> str | None:
    """The unit that a text between brackets, or in a row of units, tells."""
    plain = text.strip().lower()
    return _unit(text) or (COUNTS if plain in _COUNTS_AS_UNITS else plain if plain in _LENGTHS_IN_BRACKETS else None)


def _without_unit(text: str) -> tuple[str, str | None, bool, str]:
    """(name without its unit, unit, whether that may be a subscript, unknown text in the place of a unit)."""
    foreign = ""
    for found in reversed(list(_BRACKETS.finditer(text))):
        if unit := _unit_in_its_place(found[1]):
            name = text[: found.start()] + " " + text[found.end() :]
            if found[1].lower() in _LENGTHS_IN_BRACKETS and _NO_LENGTH.search(name):
                foreign = foreign or found[1]
                continue
            return (name, None, False, found[1]) if _ticks(name, unit) else (name, unit, False, "")
        foreign = foreign or ("" if _names_a_part(found) else found[1])
    plain = _BRACKETS.sub(lambda found: f" {found[1]} " if _names_a_part(found) else " ", text).strip() or text
    name, tail = _without_glued_unit(plain)
    if (unit := _unit_in_its_place(tail)) and (not _is_letter(tail) or _SPELLINGS[unit][0] in _told_quantities(name)):
        return name, unit, False, ""
    foreign = foreign or (tail if tail.lower() in _OF_NO_SIGNAL else "")
    for mark in re.finditer(r"\s+in\s+|\s*[,/]\s*|\s+|(?<=[^\s_])_+", plain):
        before, after = plain[: mark.start()].strip(" /,_"), plain[mark.end() :]
        unit = _unit(after) or _unit_in_underscores(after)
        told = _told_quantities(before) if _is_letter(after) else ()
        if unit and before and not _ticks(before, unit) and (not told or _SPELLINGS[unit][0] in told):
            if unit in ("lbf", "ozf") and _TORQUE.search(before) and (of_inches := _after_in(before, mark[0])):
                return of_inches, f"{unit} in", False, ""
            return before, unit, mark[0] == "_" and after.lower() in _SUBSCRIPTS, ""
    if not foreign and (read := _before_its_kind(plain) or _turns_a_minute(plain)):
        return *read, False, ""
    return plain, None, False, foreign


def _before_its_kind(name: str) -> tuple[str, str] | None:
    """A name without a unit behind which only words of a kind of value or a number stand, and that unit; else None.

    A number may also be a power: behind a length, or a unit in several words, as in ``acc_m_s_2``, it tells nothing.
    """
    by_kind = _KIND_BEHIND.fullmatch(name)
    if (found := by_kind or _NUMBER_BEHIND.fullmatch(name)) is None:
        return None
    before = found[1]
    rest, unit, in_doubt, _ = ("", _unit(before), False, "") if _unit(before) else _without_unit(before)
    written = before[len(rest) :].strip(" _,/")
    if unit is None or in_doubt or len(written) < 2 or (not rest and unit in _WORDS_TOO):
        return None
    if by_kind is None and (re.search(r"[\s_/]", written) or unit in units_of("motor_position", "linear")):
        return None
    return f"{rest} {found[2].strip(' _')}".strip(), unit


def _turns_a_minute(name: str) -> tuple[str, str] | None:
    """A name with a word that is turns per minute, and that unit; None without, or with a rate or ratio of it."""
    words = _words(name)
    found = next(filter(None, map(_TURNS_A_MINUTE.fullmatch, words)), None)
    return None if found is None or not _OF_A_RATE.isdisjoint(words) else (name, found[1])


def _after_in(before: str, mark: str) -> str:
    """The name before the word ``in`` that is before a unit; empty if there is no such word."""
    if mark.strip() == "in":
        return before
    found = re.search(r"[\s_]+in\Z", before)
    return before[: found.start()] if found else ""


def _ticks(name: str, unit: str) -> bool:
    """Whether counts are the ticks of a clock that a name tells."""
    return unit == COUNTS and _OF_A_CLOCK.search(name) is not None


def _names_a_part(bracket: re.Match[str]) -> bool:
    """Whether a bracket is part of a name, as in ``knee[left].torque`` or ``speed (actual)``, and no unit."""
    words = re.findall(r"[^\s,._-]+", bracket[1].lower())
    if words and _OF_A_NAME.issuperset(words):
        return True
    goes_on = re.search(r"\w", _BRACKETS.sub("", bracket.string[bracket.end() :]))
    known = bracket[1].lower() in _NO_PART
    return goes_on is not None and not known and re.fullmatch(r"\w[\w .-]*", bracket[1]) is not None


def in_other_letters(text: str) -> bool:
    """Whether a text has letters that are neither Latin nor Greek, nor marks of units, such as Chinese ones."""
    return any(map(_is_other_letter, unicodedata.normalize("NFC", text)))


def _is_other_letter(letter: str) -> bool:
    known = ("LATIN ", "GREEK ", "MICRO ", "DEGREE ", "OHM ", "MASCULINE ", "FEMININE ")
    return letter.isalpha() and not unicodedata.name(letter, "LATIN ").startswith(known)


def _without_glued_unit(text: str) -> tuple[str, str]:
    """A name in other letters, and the Latin letters or degree sign directly behind it; the latter empty without."""
    begins = [
        place
        for place in range(1, len(text))
        if _is_other_letter(text[place - 1]) and re.match(r"[A-Za-zµ°]", text[place])
    ]
    return (text[: begins[-1]], text[begins[-1] :]) if begins else (text, "")


def _is_letter(text: str) -> bool:
    return len(text) == 1 and text.isalpha()


def _told_quantities(name: str) -> tuple[str, ...]:
    """The quantities that the characters of a name in other letters give."""
    plain = name.lower()
    return tuple(quantity for quantity, pattern in _IN_OTHER_LETTERS.items() if re.search(pattern, plain))


def _symbol(name: str) -> tuple[tuple[str, ...], str]:
    """The quantities that a name in other letters gives, and a symbol of one letter directly behind it; else empty.

    The letter alone gives none: behind a motor or an axis it only tells which one.
    """
    before, letter = _without_glued_unit(name)
    if not _is_letter(letter) or _words(before):
        return (), ""
    return _told_quantities(before), letter


def _unit_in_underscores(text: str) -> str | None:
    """The unit of ``rad_s``, ``rad_per_s``, ``N_m`` or ``kgf_cm``; the word ``in`` may be at its beginning."""
    if "_" not in text or re.match(r"in_(?!per_)", text, re.IGNORECASE):
        return None
    of_torque = re.fullmatch(r"[mkuµ]?N_[cm]?m|k?gf?_c?m|lb[fs]?_(in|ft)|ozf?_in|ft_lb[fs]?", text, re.IGNORECASE)
    as_torque = _unit(text.replace("_", " ")) if of_torque else None
    return as_torque or _unit(text.replace("_per_", "/").replace("_", "/"))


def _words(name: str) -> list[str]:
    """The words of a name in lower case: ``motorPosition`` as motor, position; a dotted q as q, dot."""
    text = unicodedata.normalize("NFD", name.translate(_UMLAUTS))
    text = text.replace("\u0307", " dot ").replace("\u0308", " ddot ")
    text = unicodedata.normalize("NFKD", text).translate(_GREEK)
    text = "".join(letter for letter in text if not unicodedata.combining(letter))
    text = text.replace("*", " star ")
    text = re.sub(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Za-z])(?=\d)|(?<=\d)(?=[A-Za-z])", " ", text)
    return [word for word in re.split(r"[^A-Za-z0-9]+", text.lower()) if word]
