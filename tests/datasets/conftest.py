"""Small specs, and datasets of them that several tests read."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from scenelang.datasets.spec import Spec, spec_of

TABLE = """
(param balls 3 :min 1 :max 6)
(bind "ball" (lambda (:paint) (call "sphere" :radius .3 :color paint)))
(bind "leg" (lambda () (call "cube" :scale [.1 .6 .1])))
(bind "stool" (lambda ()
  (union (transform (call "cube" :scale [.6 .1 .6] :color [.5 .3 .1]) (translate [0 .6 0]))
         (transform (call "leg") (translate [.2 .3 .2]))
         (transform (call "leg") (translate [-.2 .3 -.2])))))
(bind "room" (lambda ()
  (union (transform (call "cube" :scale [4 .1 4] :color [.8 .8 .8]) (translate [0 -.05 0]))
         (transform (call "stool") (translate [(uniform -1 1) 0 (uniform -1 1)]))
         (for/union ((i (iota balls)))
           (transform (call "ball" :paint (if (= (% i 2) 0) [.8 .1 .1] [.1 .2 .8]))
                      (translate [(uniform -1.6 1.6) .3 (uniform -1.6 1.6)]))))))
"""
FILM = """
(bind "wheel" (lambda () (union (call "cylinder" :radius .4 :p1 [0 0 .2]) (transform (call "cube" :scale .2) (translate [.3 0 .2])))))
(bind "cart" (lambda ()
  (frames (for/list ((i (iota 4)))
    (union (transform (call "wheel") (@ (translate [(* .3 i) .4 0]) (rotate (* -.6 i) [0 0 1])))
           (transform (call "cube" :scale [3 .1 1]) (translate [0 -.05 0])))))))
"""
SPEC = """
programs = ["room.scene"]
count = 10
seed = 5
[params]
balls = { integer = [1, 4] }
[words.ball]
roughness = { uniform = [0.1, 0.9] }
[pictures]
size = [48, 36]
environment = ["studio", "sunny"]
[splits]
train = 0.7
test = 0.3
[output]
shard = 3
"""
EVERYTHING = """
programs = ["room.scene"]
count = 4
seed = 5
[params]
balls = { integer = [1, 4] }
[cameras]
kind = "orbit"
views = 3
[pictures]
size = [64, 48]
[labels]
write = ["instance", "semantic", "levels", "depth", "normals", "albedo", "boxes", "visibility", "keypoints", "graph",
         "captions", "program"]
keypoints = ["leg"]
[output]
shard = 2
formats = ["webdataset", "coco", "kitti", "bop", "nerfstudio", "colmap"]
"""
MOVING = """
programs = ["cart.scene"]
count = 2
[cameras]
azimuth = { uniform = [-20, 20] }
elevation = 20
[pictures]
size = [64, 48]
[labels]
write = ["instance", "depth", "boxes", "visibility", "flow", "tracks"]
words = ["wheel", "cube"]
tracks = 16
[output]
formats = ["webdataset", "mot", "tap"]
"""


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with programs and specs."""
    found = tmp_path_factory.mktemp("specs")
    for name, text in (
        ("room.scene", TABLE), ("cart.scene", FILM), ("spec.toml", SPEC), ("everything.toml", EVERYTHING),
        ("moving.toml", MOVING),
    ):  # fmt: skip
        (found / name).write_text(text)
    (found / "empty").mkdir()
    return found


@pytest.fixture
def read(folder: Path) -> Callable[..., Spec]:
    """Returns the spec of a text whose programs are those of `folder`."""
    return lambda text, name="spec.toml": spec_of(text, name, folder)


@pytest.fixture(scope="session")
def made(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished dataset of spec.toml."""
    from scenelang.datasets.running import dataset

    out = tmp_path_factory.mktemp("made") / "set"
    dataset(folder / "spec.toml", out, jobs=0)
    return out


@pytest.fixture(scope="session")
def layouts(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A dataset of everything.toml, with three views of each sample, in all formats for still scenes."""
    from scenelang.datasets.running import dataset

    out = tmp_path_factory.mktemp("layouts") / "set"
    dataset(folder / "everything.toml", out, jobs=0)
    return out


@pytest.fixture(scope="session")
def films(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A dataset of moving.toml, with four frames of each sample, in the formats for films."""
    from scenelang.datasets.running import dataset

    out = tmp_path_factory.mktemp("films") / "set"
    dataset(folder / "moving.toml", out, jobs=0)
    return out


@pytest.fixture
def copy(made: Path, tmp_path: Path) -> Path:
    """A copy of the finished dataset, to damage."""
    shutil.copytree(made, tmp_path / "copy")
    return tmp_path / "copy"
