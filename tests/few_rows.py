"""Observations of a few rows that tests make by hand: nothing is recorded, and nothing simulated."""

import numpy as np

from ema_twin_sim.measured.observation import Observation

RATIO = 26.0  # about the stock machine's: the encoders' difference is told beside it


def few_rows(torque, noise=0.01, encoder=(), encoder_noise=1e-5, name="by_hand"):
    """Rows of ``torque`` (m,) [N m], at speeds that go from fast backward to fast forward, and of the encoders'
    difference [rad] at the first of them.
    """
    count, seen = len(torque), len(encoder)
    speed = np.linspace(-5.0, 5.0, count)
    time = 0.01 * np.arange(count)
    angle = np.cumsum(speed) * 0.01
    motion = np.stack([time, angle, speed, np.zeros(count), np.zeros(count), angle / RATIO, np.zeros(count)], 1)
    every = np.arange(count)
    return Observation(
        name=name,
        period=0.01,
        geared=True,
        motion=motion,
        motor_origin=0.0,
        output_origin=0.0,
        kernel=np.ones(1),
        rows=every,
        torque=np.asarray(torque, float),
        torque_rate=np.zeros(count),
        acceleration=np.zeros(count),
        torque_noise=np.full(count, noise),
        torque_step=0.0,
        coarse=False,
        hit=np.zeros(count),
        after_impact=np.zeros(count, bool),
        encoder_rows=every[:seen],
        encoder=np.asarray(encoder, float),
        encoder_noise=np.full(seen, encoder_noise),
        encoder_piece=np.zeros(seen, int),
    )
