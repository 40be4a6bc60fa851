"""What the shell completes: names of the configuration, files, the effects of a model, and the inputs of a twin."""

import pytest

from ema_twin_sim.commands.main import application


@pytest.mark.parametrize(
    ("line", "offered"),
    [
        ("ema-twin compare run.mcap --map sie", ["siemens"]),
        ("ema-twin compare run.mcap --map my", ["my_map.yaml"]),
        ("ema-twin init run.csv --map maps/o", ["maps/own.yaml"]),
        ("ema-twin compare run.mcap --model polito_b", ["polito_bench"]),
        ("ema-twin compare run.mcap --model my", ["my_map.yaml"]),
        ("ema-twin compare run.mcap --input s", ["setpoint"]),
        ("ema-twin remove --model emps vis", ["viscous_friction"]),
        ("ema-twin remove back", ["backlash"]),
        ("ema-twin remove c| --model emps -o new.yaml", ["coulomb_friction", "constant_load"]),
        ("ema-twin remove c| --model=emps", ["coulomb_friction", "constant_load"]),
        ("ema-twin remove back| --model", ["backlash"]),
    ],
)
def test_the_shell_completes(tmp_path, monkeypatch, capsys, line, offered):
    """A bar is where the cursor stands, if not at the end."""
    (tmp_path / "my_map.yaml").touch()
    (tmp_path / "my_trace.csv").touch()
    (tmp_path / "maps").mkdir()
    (tmp_path / "maps" / "own.yaml").touch()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("_EMA_TWIN_COMPLETE", "complete_bash")
    begin, *_ = line.split("|")
    line = line.replace("|", "")
    monkeypatch.setenv("COMP_WORDS", line)
    monkeypatch.setenv("COMP_CWORD", str(len(begin.split(" ")) - 1))
    with pytest.raises(SystemExit):
        application(line.split(" ")[1:2])([], prog_name="ema-twin")
    assert capsys.readouterr().out.split() == offered
