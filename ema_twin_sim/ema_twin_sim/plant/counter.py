"""Motion by a counter alone, for the unexplained torque: its coarse speed passes a lag, and all torques pass it too.

``state`` (``layout.STATE``) carries the lag; the fields ``balance_*`` belong to ``balance.py``.
"""

from numba import njit

from .drive import lag_gain

COUNTER_LAG = 0.020  # s, each of the two lags: a counter's difference is coarse
TURNED = 2.0
"""Times its dither by which a counter must come back before its shaft has turned round."""


@njit(error_model="numpy")
def counter_speed(state, speed, interval):
    """Speed [rad/s] after the first lag, from the counter's difference over an interval."""
    if state.balance_ready == 0.0:
        state.balance_speed_1 = speed
    else:
        state.balance_speed_1 += lag_gain(interval, COUNTER_LAG) * (speed - state.balance_speed_1)
    return state.balance_speed_1


@njit(error_model="numpy")
def _moves(state, direction, position):
    """Let the counter move in a ``direction`` (-1 or 1) from a ``position`` [rad] on."""
    state.balance_direction = direction
    state.balance_farthest = position
    state.balance_since = 0.0


@njit(error_model="numpy")
def counter_direction(state, position, dither, interval):
    """Direction of motion, -1 to 1, after the first lag, by a counter's ``position``, which noise moves by ``dither``.

    Both are in rad. The shaft turned round when the counter was farthest, which shows only once it has come back.
    """
    if state.balance_ready == 0.0:
        _moves(state, 1.0 if state.balance_speed_1 > 0.0 else -1.0, position)
        state.balance_sense = state.balance_direction
        return state.balance_sense
    direction = state.balance_direction
    state.balance_sense += lag_gain(interval, COUNTER_LAG) * (direction - state.balance_sense)
    state.balance_since += interval
    ahead = (position - state.balance_farthest) * direction
    if ahead >= 0.0:
        _moves(state, direction, position)
    elif -ahead > TURNED * dither:
        state.balance_sense -= 2.0 * direction * lag_gain(state.balance_since, COUNTER_LAG)
        _moves(state, -direction, position)
    return state.balance_sense


@njit(error_model="numpy")
def counter_at_rest(state, position, torque, dry):
    """Let a shaft be held against a ``torque`` [N m] by friction of the level ``dry``: in its sense it would start."""
    if dry > 0.0:
        state.balance_sense = min(max(torque / dry, -1.0), 1.0)
    _moves(state, 1.0 if torque > 0.0 else -1.0, position)


@njit(error_model="numpy")
def counter_torque(state, torque, interval):
    """Torque [N m] after the same lag: its mean over the interval, as the counter's difference is the mean speed."""
    if state.balance_ready == 0.0:
        state.balance_torque_1 = torque
    else:
        mean = 0.5 * (torque + state.balance_torque_in)
        state.balance_torque_1 += lag_gain(interval, COUNTER_LAG) * (mean - state.balance_torque_1)
    state.balance_torque_in = torque
    return state.balance_torque_1


@njit(error_model="numpy")
def late(short, change, interval):
    """By how much [N m] a torque, after the first lag, still falls short of what it is.

    ``short`` is its value of the last sample, ``change`` [N m] the torque's over the interval, during which
    ``counter_torque`` uses its mean.
    """
    gain = lag_gain(interval, COUNTER_LAG)
    return (1.0 - gain) * short - (1.0 - 0.5 * gain) * change
