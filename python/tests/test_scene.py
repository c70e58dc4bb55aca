"""Scenes: values, files, dicts, errors."""

import json
import pickle
import subprocess
from pathlib import Path

import numpy as np
import pytest

import comminute
from comminute import errors

BALL = {
    "kind": "assembly",
    "steps": 20,
    "contact.law": "hertz",
    "grain": [{"position_m": [0.0, 0.0, 0.03], "radius_m": 0.01}],
    "wall": [{"kind": "plane", "point_m": (0, 0, 0), "normal": np.array([0.0, 0.0, 1.0])}],
    "stepping": {"inertia_scaling": True},
    "material": {
        "name": "rubber",
        "grain": {"density_kg_m3": 1100.0},
        "elastic": {"E_GPa": np.float32(0.5), "nu": 0.45},
        "contact.friction": 0.5,
    },
}


def test_values_are_read_and_replaced(coke):
    assert coke.kind == "oedometer" and coke["loading.max_stress_kPa"] == 600
    coke["loading.max_stress_kPa"] = 2000
    assert coke["loading.max_stress_kPa"] == 2000.0
    coke.update({"seed.packing": np.int64(3), "name": "other"})
    assert (coke["seed.packing"], coke.name) == (3, "other")
    assert "loading.max_stress_kPa" in coke and "loading.nothing" not in coke and 3 not in coke
    assert coke.get("loading.nothing", 7) == 7
    with pytest.raises(KeyError, match="loading.nothing"):
        coke["loading.nothing"]


def test_a_wrong_value_changes_nothing(coke):
    with pytest.raises(errors.InputError) as wrong:
        coke["specimen.porosity"] = -1
    assert str(wrong.value).startswith("override specimen.porosity=-1: must be")
    assert wrong.value.key == "specimen.porosity" and wrong.value.exit_code == 2
    assert isinstance(wrong.value, ValueError)
    assert coke["specimen.porosity"] == 0.46
    coke["loading.max_stress_kPa"] = 500


def test_mistakes_have_the_texts_of_the_command(root, command, tmp_path):
    file = tmp_path / "bad.toml"
    file.write_text('kind = "oedometer"\nporosity = 3\nsorts = 2\n')
    with pytest.raises(errors.InputErrors) as wrong:
        comminute.Scene.load(file)
    said = subprocess.run([command, "check", str(file)], capture_output=True, text=True, check=False)
    assert said.returncode == wrong.value.exit_code == 2
    assert [f"error: {line}" for line in str(wrong.value).splitlines()] == said.stderr.splitlines()
    assert "\n".join(str(error) for error in wrong.value.errors) == str(wrong.value)


def test_a_missing_file_is_missed():
    with pytest.raises(errors.Error, match="no such file"):
        comminute.Scene.load("no/scene.toml")


def test_a_dict_is_a_scene(tmp_path):
    scene = comminute.Scene(BALL)
    assert scene["wall[0].normal"] == [0.0, 0.0, 1.0]
    assert scene["material.elastic.E_GPa"] == 0.5
    # what it is written as is the same scene
    again = comminute.Scene.from_text(scene.to_toml())
    assert again.to_dict() == scene.to_dict()
    assert pickle.loads(pickle.dumps(scene)).to_toml() == scene.to_toml()
    assert scene.copy({"steps": 30})["steps"] == 30 and scene["steps"] == 20


@pytest.mark.parametrize("value", [None, {1: 2}, object()])
def test_what_no_scene_can_hold_is_refused(value):
    with pytest.raises(TypeError):
        comminute.Scene({**BALL, "name": value})


def test_a_key_given_twice_is_refused():
    with pytest.raises(ValueError, match="stepping.inertia_scaling is there twice"):
        comminute.Scene({**BALL, "stepping.inertia_scaling": False})


def test_check_says_what_the_command_says(root, command, coke):
    path = root / "experiments/petroleum_coke/h-c-2.toml"
    sets = [f"{key}={value}" for key, value in __import__("conftest").SMALL.items()]
    args = [command, "check", str(path), "--json", *(word for text in sets for word in ("--set", text))]
    said = json.loads(subprocess.run(args, capture_output=True, text=True, check=True).stdout)
    assert coke.check() == said
    assert said["estimate"]["grains"] == 240


def test_the_keys_are_told():
    assert "loading.max_stress_kPa" in comminute.key_reference() or "max_stress_kPa" in comminute.key_reference()


def test_a_path_is_a_value(coke, tmp_path):
    coke["specimen.file"] = Path("specimen.csv")
    assert coke["specimen.file"] == "specimen.csv"
