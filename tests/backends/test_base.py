"""The registry, lazy imports, and writing files whole."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from scenelang.backends import base
from scenelang.backends.exports.gltf import GLTF
from scenelang.backends.files import atomic_write
from scenelang.backends.pictures.draft_painter import DRAFT
from scenelang.backends.pictures.film import save_picture
from scenelang.backends.pictures.mitsuba import MITSUBA
from scenelang.grammar.diagnostics import MissingPart, SceneError
from scenelang.interpreter.loading import EntryPoint
from scenelang.interpreter.plugins import PluginRegistry


def modules_after(statement: str) -> set[str]:
    code = f"import sys; {statement}; print(' '.join(sys.modules))"
    return set(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split())


def test_base_imports_nothing_heavy() -> None:
    loaded = modules_after("import scenelang.backends.base")
    assert not loaded & {"numpy", "mitsuba", "trimesh", "PIL", "importlib.metadata", "drjit"}


LIGHT = (
    "exports.gltf",
    "exports.usd",
    "mitsuba_export.mitsuba_xml",
    "pictures.mitsuba",
    "pictures.draft_painter",
    "pictures.camera",
    "pictures.film",
)


def test_backends_import_no_package_until_they_run() -> None:
    loaded = modules_after(f"import {', '.join(f'scenelang.backends.{module}' for module in LIGHT)}")
    assert {f"scenelang.backends.{module}" for module in LIGHT} <= loaded
    assert not loaded & {"mitsuba", "mitsuba_oidn", "drjit", "trimesh", "PIL", "scipy", "pxr"}


def points(*backends: base.Backend) -> dict[str, SimpleNamespace]:
    return {b.name: SimpleNamespace(name=b.name, value="somewhere", load=lambda b=b: b) for b in backends}


def test_backends_are_found_by_name_and_by_file(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(PluginRegistry, "_points", lambda self: points(MITSUBA, DRAFT, GLTF))
    assert base.names() == ["draft", "gltf", "mitsuba"]
    assert base.find("gltf") is GLTF
    assert base.for_file("a.PNG") is DRAFT
    assert base.for_file("a.glb", base.Work.EXPORT) is GLTF
    assert all(backend.is_installed for backend in base.all_backends())
    with pytest.raises(SceneError, match="unknown backend `drft`") as caught:
        base.find("drft")
    assert caught.value.hint == "did you mean `draft`?"
    with pytest.raises(SceneError, match=r"no backend writes `\.obj` files"):
        base.for_file("a.obj")


def test_a_backend_whose_module_is_missing_is_not_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is listed from its description; another one that writes the suffix is chosen."""
    gone = "scenelang.backends.exports.nothing:GLTF"
    monkeypatch.setattr(base, "_descriptions", lambda: {gone: base.description_of(GLTF) | {"name": "a-gltf"}})
    missing = SimpleNamespace(name="a-gltf", value=gone)
    monkeypatch.setattr(PluginRegistry, "_points", lambda self: {"a-gltf": missing, **points(GLTF)})
    listed = base.all_backends()[0]
    assert (listed.name, listed.is_installed, listed.metadata()["installed"]) == ("a-gltf", False, False)
    assert listed.row[3] == "pip install --force-reinstall scenelang"
    assert base.for_file("a.glb") is GLTF


def test_a_broken_backend_does_not_hide_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail() -> None:
        raise ImportError("no module named `nothing`")

    broken = SimpleNamespace(name="broken", value="x", load=fail)
    wrong = SimpleNamespace(name="wrong", value="x:y", load=lambda: 3)
    monkeypatch.setattr(PluginRegistry, "_points", lambda self: {"broken": broken, "wrong": wrong, **points(DRAFT)})
    assert base.all_backends() == [DRAFT]
    with pytest.raises(SceneError, match="cannot be loaded"):
        base.find("broken")
    with pytest.raises(SceneError, match="is not a Backend"):
        base.find("wrong")


def test_a_missing_package_of_others_is_no_missing_part(monkeypatch: pytest.MonkeyPatch) -> None:
    """A part of ours that is missing is named; an error of a module that exists keeps its text."""
    gone = EntryPoint("a", "scenelang.backends.physics.nothing:A")
    broken = EntryPoint("b", "no_such_package_here:B")
    monkeypatch.setattr(PluginRegistry, "_points", lambda self: {"a": gone, "b": broken})
    with pytest.raises(MissingPart, match=r"this installation lacks the part physics, .*physics\.nothing`\)"):
        base.find("a")
    with pytest.raises(SceneError, match="the backend `b` cannot be loaded: No module named") as caught:
        base.find("b")
    assert type(caught.value) is SceneError


def test_a_missing_package_names_its_command() -> None:
    with pytest.raises(SceneError, match="no_such_package_here") as caught:
        base.require("no_such_package_here", "such-a-package")
    assert caught.value.name == "backend"
    assert caught.value.hint == "install it with `pip install such-a-package`"


PICTURE = np.full((4, 5, 3), 200, np.uint8)


def test_pictures_are_saved_whole(tmp_path: Path) -> None:
    from PIL import Image

    path = tmp_path / "a.png"
    save_picture(PICTURE, path)
    assert (np.asarray(Image.open(path)) == PICTURE).all()
    assert os.listdir(tmp_path) == ["a.png"]


@pytest.mark.parametrize("error", [KeyboardInterrupt, ValueError])
def test_an_interrupted_write_changes_nothing(tmp_path: Path, error: type[BaseException]) -> None:
    path = tmp_path / "a.txt"
    path.write_text("before")

    def interrupted() -> None:
        with atomic_write(path) as temporary:
            temporary.write_text("half")
            raise error

    with pytest.raises(error):
        interrupted()
    assert path.read_text() == "before"
    assert os.listdir(tmp_path) == ["a.txt"]


def test_unwritable_files_and_unknown_endings_are_diagnosed(tmp_path: Path) -> None:
    with pytest.raises(SceneError) as caught:
        save_picture(PICTURE, tmp_path / "no" / "a.png")
    assert caught.value.name == "file"
    (tmp_path / "folder.png").mkdir()
    with pytest.raises(SceneError) as caught:
        save_picture(PICTURE, tmp_path / "folder.png")
    assert caught.value.name == "file"
    with pytest.raises(SceneError) as caught:
        save_picture(PICTURE, tmp_path / "a.gif")
    assert caught.value.name == "backend"
