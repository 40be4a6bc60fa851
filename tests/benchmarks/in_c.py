"""C loops beside the kernel: compiled as an engineer would, given the package's own records, and run as the kernel."""

import ctypes
import shutil
import subprocess
from pathlib import Path

import numpy as np

from ema_twin_sim.model import Model
from ema_twin_sim.plant.kernel import kernel
from ema_twin_sim.plant.layout import BENCH, PLANT, SETPOINT, STATE, TWIN
from ema_twin_sim.plant.planetary.layout import LANE, ROW, TRAIN, TRAIN_STATE
from ema_twin_sim.plant.switching.layout import WINDING, WINDING_STATE
from ema_twin_sim.simulation.assembly import assemble
from ema_twin_sim.simulation.fidelity import is_fine, resting_state, set_in_motion

FLAGS = ("-O3", "-march=native", "-fno-math-errno", "-fno-trapping-math", "-shared", "-fPIC")
RECORDS = {
    "plant_t": PLANT,
    "state_t": STATE,
    "winding_t": WINDING,
    "winding_state_t": WINDING_STATE,
    "train_t": TRAIN,
    "train_state_t": TRAIN_STATE,
}
PERIOD = 2_000_000  # ns, of the drive's trace
MOTION = ("motor_angle", "motor_speed", "integral", "current", "smoothed_speed", "output_angle", "output_speed")
_C_TYPES = {"f": "double", "i": "long"}


def c_loop(name: str, folder: Path) -> ctypes._CFuncPtr:
    """The function ``advance`` of a C file beside this one, compiled in ``folder``; ``records.h`` is there for it."""
    compiler = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
    assert compiler, "no C compiler: install the package build-essential"
    (folder / "records.h").write_text("\n".join(map(_struct, RECORDS, RECORDS.values())))
    library = folder / f"{name}.so"
    source = Path(__file__).with_name(f"{name}.c")
    subprocess.run([compiler, *FLAGS, f"-I{folder}", str(source), "-o", str(library), "-lm"], check=True)
    return ctypes.CDLL(str(library)).advance


def _struct(name: str, record: np.dtype) -> str:
    lines = []
    for field in record.names or ():
        kind = record[field]
        size = "".join(f"[{length}]" for length in kind.shape)
        lines.append(f"    {_C_TYPES[kind.base.kind]} {field}{size};")
    return "\n".join(["typedef struct {", *lines, f"}} {name};", ""])


def pointer(array: np.ndarray) -> ctypes.c_void_p:
    """Where an array's values stand; the array must outlive the call."""
    return ctypes.c_void_p(array.ctypes.data)


class Run:
    """A model that follows a speed ``setpoint`` (n,) [rad/s], by the kernel or by a C loop, from the same state."""

    def __init__(self, model: Model, setpoint: np.ndarray, step: float) -> None:
        self.assembly, self.fine_model = assemble(model), is_fine(model)
        self.setpoint, self.step = np.ascontiguousarray(setpoint), step
        self.stamps = np.arange(len(setpoint), dtype=np.int64) * PERIOD
        self.seconds = self.stamps[-1] * 1e-9
        self.rows = np.zeros((len(setpoint), len(TWIN)))
        self.state, self.fine = np.zeros(1, STATE), resting_state(self.assembly.fine)
        self._first = np.zeros(1, STATE)
        for speed in ("motor_speed", "output_speed", "smoothed_speed", "speed_setpoint"):
            self._first[speed] = self.setpoint[0]
        self._first["control_phase"] = self.assembly.plant["control_cycle"]
        self._bench = np.full((len(setpoint), len(BENCH)), np.nan)
        self._bench[:, BENCH.index("load_torque")] = 0.0
        self._bench[:, BENCH.index("speed_setpoint")] = self.setpoint
        self._advance = kernel(self.assembly.fine.switching, self.assembly.fine.planetary)

    def begin(self) -> None:
        """Let the run start at the setpoint's first speed."""
        self.state.view(np.uint8)[:] = self._first.view(np.uint8)  # field by field takes 7 us
        if self.fine_model:
            self.fine = resting_state(self.assembly.fine)
            set_in_motion(self.fine, self.assembly.fine, self.setpoint[0], 0.0, 0.0)

    def by_kernel(self, record: bool = False) -> None:
        """Run the kernel over the whole setpoint."""
        self.begin()
        self._advance(
            self.assembly.plant, self.state, self.assembly.acting, self.assembly.effects, (*self.fine,), SETPOINT,
            self.stamps, self._bench, self.rows, self.step, record,
        )  # fmt: skip

    def by_c(self, function: ctypes._CFuncPtr) -> None:
        """Run a C loop over the whole setpoint."""
        self.begin()
        parts: list[object] = []
        if self.assembly.fine.planetary:
            winding, winding_state, train, train_state, lanes, table = self.fine[:6]
            parts = [pointer(part) for part in (winding, winding_state, train, train_state, table)]
            parts += [ctypes.c_long(table.shape[1] - 1), pointer(lanes[ROW["SPIN"] : ROW["SPIN_SPEED"] + LANE])]
        function(
            pointer(self.assembly.plant), pointer(self.state), *parts, pointer(self.setpoint),
            ctypes.c_long(len(self.setpoint)), ctypes.c_double(PERIOD * 1e-9), ctypes.c_double(self.step),
        )  # fmt: skip

    def assert_same_in_c(self, function: ctypes._CFuncPtr, names: tuple[str, ...] = MOTION) -> None:
        """Whether the kernel and a C loop end in the same motion, by the ``names`` of states that both have."""
        self.by_c(function)
        in_c = [float(self.state[name][0]) for name in names]
        self.by_kernel()
        np.testing.assert_allclose([float(self.state[name][0]) for name in names], in_c, rtol=1e-9, atol=1e-9)
