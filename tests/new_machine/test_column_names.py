"""What the names of columns tell without their numbers: one beside a time, and several that share a header."""

import pytest

from ema_twin_sim.new_machine.columns import guess_columns
from tests.taken_columns import signals

ALONE = {
    # abbreviations of loggers, with the number or the side of their part
    "CURR CURR_M1 currLeft MotCurr motor_curr AMPS_1 iq i_q iq1 Strm": "current",
    "VEL vel1 spdR SPD_left velLeft curr_vel CurrentSpeed": "speed",
    "POS pos1 posR POS_left curr_pos Current_Position cur_pos_1": "motor_position",
    "trq TRQ1 trqLeft tau1 tauR TQ_1 tq_left tor MotorFbTor ActTor tor_fb": "motor_torque",
    # a number that does not change what is measured; a command serves if nothing was measured
    "m1setvel": "speed_setpoint",
    "m1vel": "speed",
    "m1cur m1setcur i1~act": "current",
    "m1pos q1~raw": "motor_position",
    "m1trq M1 M1~ist": "motor_torque",
    # a letter that numbers a part, or stands among words of no quantity
    "m1foo m1state M2~xyz x1foo v3~open": None,
    "M_sequence_number M~sequence N_samples_lost S_message_counter m_index": None,
    # a letter alone or beside a unit, or beside a subscript
    "m M M_sequence~[Nm] M~(%~of~rated) M_ist M_Welle": "motor_torque",
    "I_rms _i": "current",
    "n n_mot w motor_w": "speed",
    "x q_meas": "motor_position",
    # what is named with a power may be a signal
    "power~current": "current",
    "power~stage~temperature motor_temp temp": "temperature",
    "AccX~(g) x~[m/s²] s~(g) Vibration~(g) alpha~[rad/s^2]": None,  # accelerations
    "current~program~number": None,
}
"""By names, whose blanks are ~, the signal that each is."""


@pytest.mark.parametrize(
    ("name", "signal"), [(name.replace("~", " "), signal) for names, signal in ALONE.items() for name in names.split()]
)
def test_a_name_alone(name, signal):
    assert signals("t", name) == ({name: signal} if signal else {})


@pytest.mark.parametrize(
    "told",
    [
        {"t": None, "φ̇": "speed", "φ": "motor_position", "i_q": "current", "i_d": None},
        {"t": None, "q_l": "output_position", "q_m": "motor_position", "tau": "motor_torque"},
        {"t": None, "x [mm]": "motor_position", "F [N]": "motor_torque", "v [mm/s]": "speed"},
        {"t": None, "angle [deg]": "motor_position", "acceleration [rad/s²]": None, "I [A]": "current"},
        {"t": None, "n*": "speed_setpoint", "n": "speed", "Strom": "current", "Fehler": None},
        {
            "Tiempo [ms]": None,
            "Posición del motor [rad]": "motor_position",
            "Velocidad [rad/s]": "speed",
            "Consigna de velocidad [rad/s]": "speed_setpoint",
            "Par [Nm]": "motor_torque",
        },
        # a column named in full goes before a letter
        {"t": None, "_i": None, "current": "current"},
        {"t": None, "n": None, "speed": "speed"},
        {"t": None, "m": None, "torque": "motor_torque"},
        {"t": None, "x": None, "position": "motor_position"},
        # a share of the torque is taken only if the whole is missing
        {"t": None, "angle [rad]": "motor_position", "Gravity Torque [Nm]": None, "Torque [Nm]": "motor_torque"},
        {"t": None, "angle [rad]": "motor_position", "friction torque [N m]": None, "Torque [Nm]": "motor_torque"},
        {"t": None, "angle [rad]": "motor_position", "tau_inertia [Nm]": None, "Torque [Nm]": "motor_torque"},
        {"t": None, "angle [rad]": "motor_position", "Gravity Torque [Nm]": "motor_torque"},
        {"t": None, "angle [rad]": "motor_position", "friction torque [N m]": "motor_torque"},
        {"t": None, "angle [rad]": "motor_position", "tau_inertia [Nm]": "motor_torque"},
        # a capital letter beside units is a unit: a tachometer's encoder_V was read as an angle in rad
        {"time_s": None, "current_A": "current", "encoder_V": "voltage"},
        # but not that of a part, as of an axis A, nor a small one, nor where no unit tells how the header is written
        {"time_s": None, "torque_Nm": "motor_torque", "position_A": "motor_position", "speed_A": "speed"},
        {"time_s": None, "torque_Nm": "motor_torque", "current_A": "current", "speed_A": "speed"},
        {"time_s": None, "torque_Nm": "motor_torque", "speed_A": "speed"},
        {"time_s": None, "torque_Nm": "motor_torque", "speed_rpm": "speed", "position_A": "motor_position"},
        {"time": None, "torque": "motor_torque", "speed_A": "speed"},
        {"time_s": None, "torque_Nm": "motor_torque", "speed_v": "speed"},
    ],
    ids=lambda told: ", ".join(told),
)
def test_names_beside_each_other(told):
    assert signals(*told) == {name: signal for name, signal in told.items() if signal}


@pytest.mark.parametrize(
    ("columns", "expected"),
    [
        (["time_s", "motorPosition_deg", "q_ref"], {"motor_position": "deg", "output_command": None}),
        (["t_s", "motor_speed_rad_s", "shaft_torque_N_m"], {"speed": "rad/s", "motor_torque": "N m"}),
        (["t_s", "motor_speed_rad_per_s"], {"speed": "rad/s"}),
        (["Zeit [ms]", "Strom [A]", "Drehzahl [1/min]", "Lage [rad]"],
         {"current": "A", "speed": "rpm", "motor_position": "rad"}),
        (["X [ms]", "iq set [A]", "iq [A]", "load torque [Nm]", "motor torque [Nm]"],
         {"current_setpoint": "A", "current": "A", "load_torque": "N m", "motor_torque": "N m"}),
        (["elapsed time [s]", "i_q [A]", "current limit [A]", "torque setpoint", "torque [Nm]", "speed error"],
         {"current": "A", "motor_torque": "N m"}),
        (["Zeit [ms]", "Weg Schlitten [mm]", "Geschwindigkeit [mm/s]", "Antriebskraft [N]", "Winkel"],
         {"motor_position": "mm", "speed": "mm/s", "motor_torque": "N"}),
        (["t", "position reference [mm]", "position [mm]", "force [kN]"],
         {"output_command": "mm", "motor_position": "mm", "motor_torque": "kN"}),
    ],
)  # fmt: skip
def test_units_are_told_too(columns, expected):
    guesses = guess_columns(columns)
    assert guesses.time is not None
    assert {guess.signal: guess.unit for guess in guesses.signals} == expected
