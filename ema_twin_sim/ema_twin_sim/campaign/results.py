"""Results: one row of the store's table for each job, or for each run of a file that holds many."""

from __future__ import annotations

import pyarrow as pa

SCHEMA_VERSION = "7"
"""Changed with what would break readers of older files: the schema, or what the numbers of a column are."""

DONE, REFUSED, FAILED = "done", "refused", "failed"
"""Judged; input that cannot be judged; an error of this package, or a worker that died."""

LEFT_OUT = "; left out of its unit"
"""The end of a warning of a result: one of its recordings could not be read, and the others were judged without it."""

_ERROR = pa.struct(
    [
        ("signal", pa.string()),
        ("rmse", pa.float64()),  # in the signal's SI unit
        ("noise_floor", pa.float64()),
        ("unit", pa.string()),
    ]
)
_BEYOND = pa.struct([("signal", pa.string()), ("times", pa.float64())])
_PARAMETER = pa.struct(
    [
        ("owner", pa.string()),  # an effect's name in the model, or a part of the machine
        ("name", pa.string()),
        ("value", pa.float64()),
        ("std", pa.float64()),  # standard error; null if it was not fitted
        ("unit", pa.string()),
    ]
)
_CAUSE = pa.struct([("effect", pa.string()), ("probability", pa.float64())])

_FEATURE = pa.struct(
    [
        ("name", pa.string()),
        ("value", pa.float64()),  # in the unit; if a logarithm, of the size in that unit
        ("unit", pa.string()),
        ("logarithm", pa.bool_()),
        ("of_effort", pa.bool_()),  # whether it needs the effort
    ]
)
_HEALTH = pa.struct(
    [
        ("test", pa.string()),  # what was set up once: a day, a mounting, a series of repeats
        ("usable", pa.bool_()),  # whether it says anything about the unit
        ("effort_usable", pa.bool_()),
        ("unsigned", pa.bool_()),  # whether the effort is a magnitude
        ("findings", pa.list_(pa.string())),  # about its acquisition
        ("wavelength", pa.float64()),  # m or rad, of the wave that was looked for; null if there is none
        ("period", pa.float64()),  # s, of its samples
        ("travel", pa.float64()),  # m or rad
        ("top_speed", pa.float64()),  # m/s or rad/s
        ("strokes", pa.int64()),  # both ways
        ("forward", pa.float64()),  # mean effort against the motion each way, A or N m
        ("backward", pa.float64()),
        ("position_unit", pa.string()),
        ("effort_unit", pa.string()),
        ("features", pa.list_(_FEATURE)),
    ]
)

_SETTING = pa.struct([("path", pa.string()), ("value", pa.float64()), ("unit", pa.string())])

SCHEMA = pa.schema(
    [
        ("key", pa.string()),
        ("unit", pa.string()),
        ("name", pa.string()),
        ("task", pa.string()),
        ("model", pa.string()),
        ("status", pa.string()),  # done, refused or failed
        ("message", pa.string()),  # why it was refused, or failed
        ("time", pa.timestamp("us", "UTC")),  # of the recording, of several judged together the last; null if unknown
        ("duration", pa.float64()),  # s, of all its recordings together
        ("samples", pa.int64()),
        ("motion", pa.string()),  # rotary or linear
        ("signals", pa.list_(pa.string())),  # that all its recordings hold
        ("content", pa.list_(pa.string())),  # a hash of each recording's signals
        ("verdict", pa.string()),  # explained, none or unknown, if effects were looked for
        ("missing", pa.list_(pa.string())),  # effects that the model lacks
        ("depends_on", pa.list_(pa.string())),  # quantities that the error left depends on, if the verdict is unknown
        ("causes", pa.list_(_CAUSE)),
        ("errors", pa.list_(_ERROR)),
        ("beyond_noise", pa.list_(_BEYOND)),  # signals whose error exceeds the sensors' noise, the worst first
        ("parameters", pa.list_(_PARAMETER)),
        ("health", _HEALTH),  # of the verb health: the features by which a unit is judged
        ("settings", pa.list_(_SETTING)),  # of the verb sweep: numbers that were set in the simulated model
        ("lacked", pa.list_(pa.string())),  # of sweep: the effects that the simulated model has and the model lacks
        ("bounds", pa.list_(_PARAMETER)),  # of sweep: each number, and the least standard error that it can have
        ("warnings", pa.list_(pa.string())),
        ("seconds", pa.float64()),  # that the work took
        ("done_at", pa.timestamp("us", "UTC")),
        ("version", pa.string()),  # of ema-twin
    ],
    metadata={"ema_twin.schema": SCHEMA_VERSION},
)
