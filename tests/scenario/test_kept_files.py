"""A result holds the model files that it was computed from: its scenario is set up anywhere and opens no file."""

import base64
import json
import re
import shutil
import zlib

import pytest
from support.scenario_texts import CURVE

from wrsim import InputError, Scenario, load, load_vehicle
from wrsim.analysis.motion.record import numbers_digest
from wrsim.inputs.lookup import shipped_models
from wrsim.scenario.build import build
from wrsim.scenario.kept import scenario_of

SCENARIOS = shipped_models().parent / "scenarios"


def attributes_of(scenario: Scenario) -> dict[str, str | float | int]:
    """Attributes of a result of this scenario, and a digest of all numbers that it was computed from."""
    setup = build(scenario)
    return setup.attributes() | {"digest": numbers_digest(setup)}


@pytest.mark.parametrize("name", [
    "crossing", "bridge", "train_s_curve", "static_measured", "curve_r150_worn",
])  # fmt: skip
def test_a_result_holds_the_model_files_that_it_was_computed_from(name, tmp_path, monkeypatch):
    """No file is opened to set up its scenario."""
    about = attributes_of(load(SCENARIOS / f"{name}.toml"))
    monkeypatch.setattr("wrsim.inputs.toml_files._content", lambda path, kind: pytest.fail(f"opened {path}"))
    assert numbers_digest(build(scenario_of(about, tmp_path))) == about["digest"]
    assert len(about["model_files"]) < 40_000


def test_what_was_computed_counts_whatever_becomes_of_the_files(tmp_path, monkeypatch):
    """A wheel beside the vehicle, another in a folder of models, a rail that is named absolutely: changed, gone."""
    folder, models, elsewhere = tmp_path / "work", tmp_path / "models", tmp_path / "other"
    wheel, rail = (
        (SCENARIOS.parent / "models" / name).read_text() for name in ("wheels/S1002.toml", "rails/54E1.toml")
    )
    for place in (folder / "vehicles", models / "wheels", elsewhere):
        place.mkdir(parents=True)
    car = (SCENARIOS.parent / "models/vehicles/manchester_1.toml").read_text()
    (folder / "vehicles/car.toml").write_text(re.sub(r"(?m)^wheel = .*$", 'wheel = "../mine.toml"', car))
    worn = (SCENARIOS.parent / "models/wheels/S1002_worn.toml").read_text()
    (folder / "mine.toml").write_text(worn.replace('base = "S1002.toml"', 'base = "wheels/base.toml"'))
    (models / "wheels/base.toml").write_text(wheel)
    (elsewhere / "rail.toml").write_text(rail)
    monkeypatch.setenv("WRSIM_MODELS", str(models))
    changes = {"vehicle.model": "vehicles/car.toml", "track.rail": (elsewhere / "rail.toml").as_posix()}
    (folder / "run.toml").write_text(load(SCENARIOS / "manchester_r300.toml").with_values(changes).text)
    about = attributes_of(load(folder / "run.toml"))
    assert about["vehicle"] == load_vehicle(folder / "vehicles/car.toml").name != "car"
    assert str(folder) not in zlib.decompress(base64.b64decode(about["model_files"])).decode()
    (elsewhere / "rail.toml").write_text(rail.replace("54E1", "another"))
    shutil.rmtree(folder)
    shutil.rmtree(models)
    monkeypatch.delenv("WRSIM_MODELS")
    assert numbers_digest(build(scenario_of(about, tmp_path))) == about["digest"]


def packed(**changes: object) -> str:
    """Model files of a result as somebody else may have written them."""
    stored = {"folders": ["0"], "user_folders": [], "names": {}, "contents": []} | changes
    return base64.b64encode(zlib.compress(json.dumps(stored).encode())).decode()


@pytest.mark.parametrize("odd", [
    "", "abc", base64.b64encode(b"no zlib").decode(), packed(names={"0/a": 3}), packed(folders=["../.."]),
    packed(names=[]), packed(contents=[1], names={"0/a": 0}), packed(folders=3),
])  # fmt: skip
def test_model_files_of_a_result_that_are_damaged_are_one_clear_error(odd, tmp_path):
    with pytest.raises(InputError, match="its model_files are damaged; run the scenario again"):
        scenario_of({"scenario_text": CURVE, "model_files": odd}, tmp_path)


def test_model_files_of_a_result_open_no_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path.parent)
    (tmp_path / "secret.toml").write_text("root:x:0:0\n")
    for name in ((tmp_path / "secret.toml").as_posix(), "../secret.toml", f"{tmp_path.name}/secret.toml"):
        about = {"scenario_text": re.sub(r"(?m)^rail = .*$", f'rail = "{name}"', CURVE), "model_files": packed()}
        with pytest.raises(InputError, match=r"lies outside of|not found") as told:
            build(scenario_of(about, tmp_path))
        assert "root:" not in str(told.value)
