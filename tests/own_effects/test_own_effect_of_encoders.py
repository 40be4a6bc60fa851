"""A user's own effect beside two encoders and no torque: its numbers in SI, and what is said where it cannot show."""

import pytest

from ema_twin_sim.comparison.compare import compare
from ema_twin_sim.discovery.discover import discover
from ema_twin_sim.own_effects import load_effect
from tests.conftest import ROOT
from tests.discovery.test_two_encoders import drafted

LATE_BY_CYCLES = """
from ema_twin_sim.effects.effect import Effect, Parameter


def settle(plant, parameters, options):
    plant["encoder_delay"] += 1e-3 * parameters["cycles"]  # of a bus: 1 ms, whatever machine hangs on it


EFFECT = Effect(
    id="bus_cycles", summary="an encoder on a bus", equation="the encoder shows θ_o(t − cycles · 1 ms)",
    depends_on="encoders", signature="s", source="s", repeatable=False, settle=settle,
    parameters=(Parameter("cycles", "1", 1.0, 0.0, 100.0, "cycles by which it is late"),),
)
"""


pytestmark = pytest.mark.usefixtures("catalogue_of_the_package")


@pytest.mark.slow
@pytest.mark.parametrize("quicker", [1.0, 4.0])
def test_the_numbers_of_an_own_effect_are_those_of_si(quicker, tmp_path):
    recording, model = drafted(tmp_path, "late", quicker)
    file = tmp_path / "bus_cycles.py"
    file.write_text(LATE_BY_CYCLES)
    load_effect(file)
    own = model.with_effect("bus_cycles", {"cycles": 3.0 / quicker})
    before, after = (compare([recording], m).overall["output_position"]["rmse"] for m in (model, own))
    assert after < 0.05 * before
    found = discover([recording], model, without=["encoder_delay"])
    assert (found.verdict, found.added) == ("explained", ("bus_cycles",))
    assert found.parameters["bus_cycles"]["cycles"]["value"] == pytest.approx(3.0 / quicker, rel=0.02)


@pytest.mark.slow
def test_an_own_effect_on_the_torque_is_said_not_to_show(tmp_path):
    recording, model = drafted(tmp_path, "late", 1.0)
    load_effect(ROOT / "docs" / "examples" / "position_friction.py")
    found = discover([recording], model)
    assert found.added == ("encoder_delay",)
    said = [warning for warning in found.warnings if warning.startswith("position_friction: your own effects")]
    assert len(said) == 1
    assert not any("your own" in w for w in discover([recording], model, without=["position_friction"]).warnings)
