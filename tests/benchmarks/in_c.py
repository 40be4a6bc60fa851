"""C loops beside the kernel: compiled as an engineer would, and given the package's own records."""

import ctypes
import shutil
import subprocess
from pathlib import Path

import numpy as np

from ema_twin_sim.plant.layout import PLANT, STATE
from ema_twin_sim.plant.planetary.layout import TRAIN, TRAIN_STATE
from ema_twin_sim.plant.switching.layout import WINDING, WINDING_STATE

FLAGS = ("-O3", "-march=native", "-fno-math-errno", "-fno-trapping-math", "-shared", "-fPIC")
RECORDS = {
    "plant_t": PLANT,
    "state_t": STATE,
    "winding_t": WINDING,
    "winding_state_t": WINDING_STATE,
    "train_t": TRAIN,
    "train_state_t": TRAIN_STATE,
}
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
