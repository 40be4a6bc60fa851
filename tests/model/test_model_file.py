"""Model files: the shipped ones, and what is refused."""

from dataclasses import replace
from pathlib import Path

import pytest
import yaml

from ema_bench_replay.checked_yaml import parse_yaml
from ema_bench_replay.configuration import configuration_names, find_configuration
from ema_bench_replay.errors import InputError
from ema_twin_sim.model import load_model, save_model
from ema_twin_sim.model.constants import CONSTANTS
from ema_twin_sim.model.model_file import model_files


@pytest.fixture
def content(tmp_path):
    """A whole model as a dictionary to spoil."""
    return yaml.safe_load(save_model(load_model("polito_bench"), tmp_path / "whole.yaml").read_text())


def refused(tmp_path, content):
    path = tmp_path / "spoilt.yaml"
    path.write_text(content if isinstance(content, str) else yaml.safe_dump(content))
    with pytest.raises(InputError) as error:
        load_model(path)
    message = str(error.value)
    assert "spoilt.yaml" in message and "\n" not in message
    return message


@pytest.mark.parametrize("name", configuration_names("models"))
def test_shipped_models_load_and_name_the_source_of_every_constant(name):
    model = load_model(name)
    assert all(held.source for held in model.constants.values())


def test_the_stock_model_has_the_values_of_the_thesis():
    model = load_model("polito_bench")
    assert model.value("machine.gear_ratio") == pytest.approx((63 / 21 + 1) / (1 - 63 * 20 / (62 * 21)))
    assert model.value("drive.speed_limit") == pytest.approx(8000 * 3.141592653589793 / 30, rel=1e-5)
    assert model.value("machine.torque_constant") == 1.91
    assert model.effects["coulomb_friction_2"].parameters == {"torque": 0.045, "static_ratio": 2.0}
    assert model.kinds == {"drive": "averaged", "transmission": "rigid"}


def test_a_model_is_frozen():
    model = load_model("polito_bench")
    with pytest.raises(TypeError):
        model.effects["backlash"] = None
    with pytest.raises(AttributeError):
        model.name = "other"


def test_an_unknown_name_offers_the_nearest():
    with pytest.raises(InputError, match="polito_bench"):
        load_model("polito_bensh")


def test_a_missing_file_is_named():
    with pytest.raises(InputError, match=r"nowhere.yaml: cannot be read \(No such file.*config/models"):
        load_model(Path("nowhere.yaml"))


@pytest.mark.parametrize("name", ["gear_ratio", "torque_constant"])
def test_what_is_assumed_is_marked_until_it_is_measured_or_confirmed(tmp_path, name):
    path, stock = f"machine.{name}", load_model("polito_bench")

    def marked(model, file):
        text = save_model(model, tmp_path / f"{file}.yaml").read_text()
        assert load_model(tmp_path / f"{file}.yaml").constants[path] == model.constants[path]
        return [line.split(":")[0].strip() for line in text.splitlines() if "# CHECK: " in line]

    held = replace(stock.constants[path], source="assumed")
    assumed = replace(stock, constants={**stock.constants, path: held})
    assert marked(assumed, "assumed") == marked(assumed.with_effect("backlash"), "with") == [name]
    fitted = assumed.with_value(path, 1.1 * held.value).fitted_from(assumed)
    confirmed = replace(stock, constants={**stock.constants, path: replace(held, source="data sheet")})
    assert marked(fitted, "fitted") == marked(confirmed, "confirmed") == []


def test_a_wrong_unit_is_refused(tmp_path, content):
    content["machine"]["motor_inertia"]["unit"] = "g cm^2"
    assert "'g cm^2' but 'kg m^2'" in refused(tmp_path, content)


def test_an_unknown_key_offers_the_nearest(tmp_path, content):
    content["drive"]["speed_gian"] = content["drive"].pop("speed_gain")
    assert "did you mean 'speed_gain'?" in refused(tmp_path, content)


def test_unknown_sections_effects_parameters_options_and_kinds_are_refused(tmp_path, content):
    import copy

    def spoilt(change):
        other = copy.deepcopy(content)
        change(other)
        return refused(tmp_path, other)

    assert "did you mean 'sensors'?" in spoilt(lambda c: c.update(sensor=c.pop("sensors")))
    effects = "effects"
    bad = {"effect": "backlsh", "parameters": {}}
    assert "did you mean 'backlash'?" in spoilt(lambda c: c[effects].update(backlash=bad))
    bad = {"effect": "backlash", "parameters": {"widht": 0.1}}
    assert "did you mean 'width'?" in spoilt(lambda c: c[effects].update(backlash=bad))
    bad = {"effect": "backlash", "parameters": {}}
    assert "'width' [rad]" in spoilt(lambda c: c[effects].update(backlash=bad))
    bad = {"effect": "backlash", "parameters": {"width": 0.1}}
    assert "rename" in spoilt(lambda c: c[effects].update(play=bad))
    assert "motor, output" in spoilt(lambda c: c[effects]["viscous_friction"]["options"].update(side="left"))
    assert "rigid, two_inertia" in spoilt(lambda c: c["transmission"].update(kind="soft"))
    assert "version" in spoilt(lambda c: c.update(version=9))
    assert "is missing" in spoilt(lambda c: c["machine"].pop("gear_ratio"))
    assert "out of range" in spoilt(lambda c: c["machine"]["gear_ratio"].update(value=-3))
    assert "no number" in spoilt(lambda c: c["machine"]["gear_ratio"].update(value="much"))
    assert "out of range" in spoilt(lambda c: c["machine"]["gear_ratio"].update(value=float("nan")))


def test_text_that_is_no_model_is_refused(tmp_path):
    assert "is no YAML" in refused(tmp_path, "a: [1, 2")
    assert "no mapping" in refused(tmp_path, "just text")
    assert "leads back to itself" in refused(tmp_path, "base: spoilt.yaml")


def test_yaml_cannot_make_objects(tmp_path):
    made = tmp_path / "made"
    refused(tmp_path, f"version: !!python/object/apply:os.mkdir ['{made}']")
    assert not made.exists()


def test_yaml_is_read_alike_with_and_without_libyaml(monkeypatch):
    texts = [file.read_text() for file in sorted((Path(__file__).parents[2] / "config").rglob("*.yaml"))]
    texts += ["{a:\t1}", "a: {b? c}", "a: !", "a: |# b", "a: 1\n\ufeff", "a: &x {b: 1_0}\nc: *x\n<<: *x"]

    def read():
        return [_outcome(text) for text in texts]

    quick = read()
    monkeypatch.setattr("ema_bench_replay.checked_yaml.yaml.__with_libyaml__", False)
    assert quick == read()


def _outcome(text):
    try:
        return parse_yaml(text)
    except yaml.YAMLError as error:
        return str(error)


@pytest.mark.parametrize("libyaml", [True, False])
@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("x: !!int ''", "line 1: is no YAML: this is no int"),
        ("x: !!bool maybe", "line 1: is no YAML: this is no bool"),
        ("x: !!timestamp now", "line 1: is no YAML: this is no timestamp"),
        ("x: &x [*x]", "it contains itself"),
        (
            "a0: &a0 [x, x, x, x, x, x, x, x]\n"
            + "".join(f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 8)}]\n" for k in range(1, 9)),
            "its aliases make it too large",
        ),
        (
            "a0: &a0 {k: 1}\n"
            + "".join(f"a{k}: &a{k}\n  <<: [{', '.join([f'*a{k - 1}'] * 8)}]\n" for k in range(1, 9)),
            "its aliases make it too large",
        ),
        ("base: " + "long" * 2000, "is no file beside it"),
    ],
)
def test_yaml_that_would_grow_or_is_not_what_it_says(libyaml, text, told, tmp_path, monkeypatch):
    monkeypatch.setattr("ema_bench_replay.checked_yaml.yaml.__with_libyaml__", libyaml)
    assert told in refused(tmp_path, text)
    assert len(refused(tmp_path, text)) < 500 + len(str(tmp_path))


def test_a_key_given_twice_is_refused_with_its_line(tmp_path):
    assert "line 2: is no YAML: the key 'version' is there twice" in refused(tmp_path, "version: 1\nversion: 1\n")
    text = "version: 1\neffects:\n  backlash: {}\n  'backlash': {}\n"
    assert "line 4" in refused(tmp_path, text)


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ({"enabled": "false"}, ["enabled", "'false' is neither true nor false"]),
        ({"enabled": None}, ["enabled", "None"]),
        ({"options": ["side"]}, ["viscous_friction.options", "no mapping"]),
        ({"options": "motor"}, ["viscous_friction.options", "no mapping"]),
        ({"parameters": 5}, ["viscous_friction.parameters", "no mapping"]),
        ({"parameters": []}, ["viscous_friction.parameters", "no mapping"]),
        ({"parameters": {"coefficient": "10^400"}}, ["viscous_friction.coefficient", "no number"]),
    ],
)
def test_what_an_effect_holds_is_checked(tmp_path, content, entry, words):
    content["effects"]["viscous_friction"].update(entry)
    message = refused(tmp_path, content)
    for word in words:
        assert word in message


@pytest.mark.parametrize("name", ["backlash_2", "backlash_\u00b2", "viscous_friction_\u00b2", "viscous_friction_1"])
def test_names_of_instances(tmp_path, content, name):
    effect, parameter = ("backlash", "width") if "backlash" in name else ("viscous_friction", "coefficient")
    content["effects"].setdefault("backlash", {"parameters": {"width": 0.001}})
    content["effects"][name] = {"effect": effect, "parameters": {parameter: 0.001}}
    assert f"effects.{name}: an instance of {effect}" in refused(tmp_path, content)


@pytest.mark.slow
def test_values_that_no_program_can_hold(tmp_path, content):
    content["machine"]["gear_ratio"]["value"] = 10**400
    assert "too large" in refused(tmp_path, content)
    assert "deeply" in refused(tmp_path, "version: " + "[" * 5000 + "]" * 5000)
    assert "version: True" in refused(tmp_path, "version: true")
    assert "cannot be read" in refused(tmp_path, "version: 2024-99-99")
    (tmp_path / "based.yaml").write_text('base: "spoilt\\0.yaml"')
    with pytest.raises(InputError, match=r"based\.yaml: base: 'spoilt\\x00\.yaml' is no file") as error:
        load_model(tmp_path / "based.yaml")
    assert "\n" not in str(error.value)


def test_the_files_of_a_model():
    own, base = model_files("polito_bench")
    assert (own.name, base.name) == ("polito_bench.yaml", "politecnico.yaml")


def test_an_existing_file_stays_unless_forced(tmp_path):
    model = load_model("polito_bench")
    path = save_model(model, tmp_path / "model.yaml")
    with pytest.raises(InputError, match="exists"):
        save_model(model, path)
    save_model(model, path, force=True)


def test_what_is_written_is_whole_and_stands_alone(tmp_path):
    path = save_model(load_model("polito_bench"), tmp_path / "alone.yaml")
    written = yaml.safe_load(path.read_text())
    assert "base" not in written
    parts = ["machine", "drive", "transmission", "sensors"]
    assert list(written) == ["version", *parts, "orders", "other_orders", "effects"]
    for constant in CONSTANTS.values():
        if not constant.optional and not constant.kind:
            assert written[constant.part][constant.name]["unit"] == constant.unit
    assert find_configuration("models", "polito_bench") != path


def test_a_base_may_be_a_shipped_model(tmp_path):
    (tmp_path / "mine.yaml").write_text("version: 1\nbase: polito_bench\nmachine: {name: mine}\n")
    mine = load_model(tmp_path / "mine.yaml")
    assert mine.machine == "mine" and mine.effects == load_model("polito_bench").effects
    (tmp_path / "none.yaml").write_text("version: 1\nbase: polito_bensh\n")
    with pytest.raises(InputError, match=r"none\.yaml: base: 'polito_bensh' is no file beside it"):
        load_model(tmp_path / "none.yaml")


def test_a_torque_constant_may_be_told_at_the_output(tmp_path, content):
    ratio, held = content["machine"]["gear_ratio"]["value"], content["machine"]["torque_constant"]
    content["machine"]["torque_constant"] = {**held, "value": held["value"] * ratio, "shaft": "output"}
    path = tmp_path / "joint.yaml"
    path.write_text(yaml.safe_dump(content))
    model = load_model(path)
    assert model.value("machine.torque_constant") == pytest.approx(held["value"])
    assert load_model(save_model(model, tmp_path / "again.yaml")).constants == model.constants
    content["machine"]["gear_ratio"]["shaft"] = "output"
    assert "shaft" in refused(tmp_path, content)
    del content["machine"]["gear_ratio"]["shaft"]
    content["machine"]["torque_constant"]["shaft"] = "load"
    assert "motor, output" in refused(tmp_path, content)


@pytest.mark.parametrize(
    ("written", "meant"),
    [("{value: 0,052, unit: kg m^2}", "0.052"), ("{value: -12,5, unit: kg m^2}", "-12.5"), ("{value: 3,4}", "3.4")],
)
def test_a_decimal_comma_in_braces_is_named_as_such(tmp_path, content, written, meant):
    """The comma ends the value there, and the rest was an unknown key, of which YAML reads 052 as 42."""
    content["machine"]["motor_inertia"] = "HERE"
    message = refused(tmp_path, yaml.safe_dump(content).replace("HERE", written))
    assert f"has a decimal comma; write {meant}, with a point" in message and ": line " in message


@pytest.mark.parametrize("quoted", ["0,052", "'0,052'", "1,5e-3"])
def test_so_is_one_outside_of_braces(tmp_path, content, quoted):
    content["machine"]["motor_inertia"] = {"unit": "kg m^2", "value": "HERE"}
    message = refused(tmp_path, yaml.safe_dump(content).replace("HERE", quoted))
    written = quoted.strip("'")
    assert f"{written} has a decimal comma; write {written.replace(',', '.')}, with a point" in message


@pytest.mark.parametrize(
    ("part", "key", "place"),
    [
        ("machine", "orders", "the top level of the file, beside `machine:`"),
        ("machine", "current_limit", "under `drive:`"),
        ("drive", "gear_ratio", "under `machine:`"),
    ],
)
def test_a_key_in_another_part_is_told_where_it_belongs(tmp_path, content, part, key, place):
    content[part][key] = {"slots": 18}
    message = refused(tmp_path, content)
    assert f"{part}: unknown key '{key}'" in message and message.endswith(place)


def test_other_keys_of_digits_are_what_they_were(tmp_path, content):
    assert parse_yaml("{1: 2, 3: 4}") == {1: 2, 3: 4} and parse_yaml("[0,052]") == [0, 42]
    content["machine"]["motor_inertia"] = "HERE"
    message = refused(tmp_path, yaml.safe_dump(content).replace("HERE", "{value: about 1, 52: }"))
    assert "comma" not in message and "unknown key 52" in message


def test_a_ratio_that_is_missing_is_a_plain_number(tmp_path, content):
    """Its unit, 1, read as if the value were to be given in ones."""
    del content["machine"]["gear_ratio"]
    assert refused(tmp_path, content).endswith("machine.gear_ratio: is missing; give its value, a plain number")


@pytest.mark.parametrize("name", [".", "..", "folder", "folder.yaml"])
def test_a_folder_is_no_model(tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder.yaml").mkdir()
    with pytest.raises(InputError) as error:
        load_model(name)
    assert "older" in str(error.value).partition(name)[2] or "directory" in str(error.value)


def test_a_folder_does_not_hide_a_shipped_model(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "polito_bench").mkdir()
    assert load_model("polito_bench").name
