"""Configuration is found where the environment, the installation or the checkout has it, in this order."""

from pathlib import Path

import pytest

from ema_bench_replay.configuration import checkout, configuration_names, find_configuration
from ema_bench_replay.errors import InputError


def test_shipped_configuration_is_found():
    assert find_configuration("maps", "siemens").name == "siemens.yaml"
    assert find_configuration("maps", "siemens.yaml").is_file()
    assert "siemens" in configuration_names("maps")


def test_a_path_is_taken_as_it_is(tmp_path):
    path = tmp_path / "mine.yaml"
    path.touch()
    assert find_configuration("maps", path) == path
    assert find_configuration("maps", str(path)) == path


def test_a_file_here_does_not_hide_a_shipped_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("siemens").touch()
    assert find_configuration("maps", "siemens").name == "siemens.yaml"


def test_the_environment_goes_first(tmp_path, monkeypatch):
    for prefix in ("chosen", "prefix/share/ema_twin_config"):
        (tmp_path / prefix / "launch").mkdir(parents=True)
        (tmp_path / prefix / "launch" / "own.launch.py").touch()
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"{tmp_path / 'prefix'}")
    assert find_configuration("launch", "own").parent.parent == tmp_path / "prefix/share/ema_twin_config"
    monkeypatch.setenv("EMA_TWIN_CONFIG", str(tmp_path / "chosen"))
    assert find_configuration("launch", "own").parent.parent == tmp_path / "chosen"


def test_the_checkout_serves_what_is_not_installed(monkeypatch):
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    monkeypatch.delenv("EMA_TWIN_CONFIG", raising=False)
    monkeypatch.setattr("sys.prefix", "/nowhere")
    assert find_configuration("maps", "siemens") == checkout() / "config" / "maps" / "siemens.yaml"


def test_what_is_not_there_is_refused_with_help(tmp_path, monkeypatch):
    monkeypatch.setenv("EMA_TWIN_CONFIG", str(tmp_path))
    with pytest.raises(InputError) as caught:
        find_configuration("maps", "siemenz")
    message = str(caught.value)
    assert "did you mean 'siemens'" in message and str(tmp_path / "maps") in message and "\n" not in message
    with pytest.raises(InputError, match=r"there are: .*siemens"):
        find_configuration("maps", "quite_another")
    with pytest.raises(InputError, match=r"gone/siemens\.yaml: not found"):
        find_configuration("maps", "gone/siemens.yaml")


@pytest.mark.parametrize("name", [".", "..", "folder"])
def test_a_folder_is_said_to_be_one(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder").mkdir()
    with pytest.raises(InputError, match=r": is a folder; give a file in it, or one of the maps: .*siemens"):
        find_configuration("maps", name)
