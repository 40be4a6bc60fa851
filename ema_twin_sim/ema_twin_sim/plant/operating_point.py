"""The signature with which the kernel calls an effect, and the call itself.

An effect's compiled function is ``act(at, p) -> float``: ``at`` is the operating point below, ``p`` four floats (its
parameters in the order of its table, then its numeric option). The kernel holds such functions as addresses in an
array and calls through them, so that a new effect, or a user's, compiles in milliseconds, can be switched in a running
twin, and never recompiles the kernel. Passing addresses costs 1 us a kernel call, where a tuple of Numba's first-class
functions costs 40 us per function to unbox.
"""

from __future__ import annotations

import math
from collections import namedtuple
from collections.abc import Callable
from functools import cache
from typing import Any

from numba import njit, types
from numba.extending import intrinsic

OperatingPoint = namedtuple(
    "OperatingPoint",
    [
        "time",  # s since the recording's first sample
        "motor_angle",  # rad, the motor counter's own angle, so that a phase is valid for all recordings
        "electrical_angle",  # rad, pole pairs times that angle; NaN if their number is unknown
        "motor_speed",  # rad/s
        "output_angle",  # rad of the slow shaft, the output encoder's own angle
        "output_travel",  # rad of the slow shaft since the recording's first sample
        "output_speed",  # rad/s of the slow shaft
        "acceleration",  # rad/s2 of the fast shaft, over the previous step
        "current",  # A, quadrature
        "motor_torque",  # N m, torque constant times current
        "transmitted_torque",  # N m at the fast shaft, transmitted to the output, over the previous step
        "dry_level",  # N m, of the motor's side (all, if the gearbox is rigid), summed so far, before it is scaled
        "viscous_coefficient",  # N m s/rad, the model's viscous friction
    ],
)
"""State of the machine in a step: everything an effect may depend on."""


@njit(error_model="numpy")
def changed(at, transmitted, dry):
    """The operating point ``at`` with another transmitted torque and dry level [N m]."""
    return OperatingPoint(
        at.time,
        at.motor_angle,
        at.electrical_angle,
        at.motor_speed,
        at.output_angle,
        at.output_travel,
        at.output_speed,
        at.acceleration,
        at.current,
        at.motor_torque,
        transmitted,
        dry,
        at.viscous_coefficient,
    )


PARAMETER_SLOTS = 4

_POINT = types.NamedUniTuple(types.float64, len(OperatingPoint._fields), OperatingPoint)
_PARAMETERS = types.UniTuple(types.float64, PARAMETER_SLOTS)
SIGNATURE = types.float64(_POINT, _PARAMETERS)


@cache
def compiled_effect(act: Callable[..., float], *, on_disk: bool) -> Any:
    """``act(at, p)`` compiled, callable from Python, too; kept for the life of the process.

    ``on_disk`` caches it for later processes: only for code that cannot change unnoticed.
    """
    return njit(SIGNATURE, cache=on_disk, error_model="numpy")(act)


def compile_effect(act: Callable[..., float], *, on_disk: bool) -> int:
    """The address of the compiled ``act(at, p)`` (valid for the life of the process)."""
    result = compiled_effect(act, on_disk=on_disk).overloads[SIGNATURE.args]
    return result.library.get_pointer_to_function(result.fndesc.llvm_func_name)


@intrinsic
def call_effect(typing_context, address, at, parameters):
    """Call the compiled effect at ``address`` with an operating point and four parameters.

    An effect that raises counts as NaN, which ends the run with an error message.
    """

    def generate(context, builder, signature, arguments):
        address, at, parameters = arguments
        function_type = context.call_conv.get_function_type(types.float64, SIGNATURE.args)
        pointer = builder.inttoptr(address, function_type.as_pointer())
        status, value = context.call_conv.call_function(
            builder, pointer, types.float64, SIGNATURE.args, (at, parameters)
        )
        called = builder.basic_block  # branched, not selected: a processor predicts it and does not wait for the status
        with builder.if_then(builder.not_(status.is_ok), likely=False):
            raised = builder.basic_block
        result = builder.phi(value.type)
        result.add_incoming(value, called)
        result.add_incoming(context.get_constant(types.float64, math.nan), raised)
        return result

    return types.float64(types.int64, _POINT, _PARAMETERS), generate
