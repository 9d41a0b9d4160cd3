"""Samples: what is drawn, that nothing leaks, and that each is made again byte for byte."""

from __future__ import annotations

import json
import os
import threading
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from scenelang.datasets.making import Candidate, Maker, Predicate, SampleFailure, decoded
from scenelang.datasets.running import dataset, dataset_sample
from scenelang.datasets.sampler import draw_sample, key_of, views_of
from scenelang.datasets.spec import Spec, read_spec, spec_of
from scenelang.grammar.diagnostics import SceneError

Read = Callable[..., Spec]
HEAD = 'programs = "room.scene"\nseed = 5\n[pictures]\nsize = [32, 24]\n'


def test_a_sample_depends_on_the_seed_and_its_number_alone(read: Read, folder: Path) -> None:
    text = (folder / "spec.toml").read_text()
    spec = read(text)
    assert draw_sample(spec, 3) == draw_sample(read(text), 3)
    assert draw_sample(spec, 3) != draw_sample(spec, 4)
    assert draw_sample(spec, 3) != draw_sample(read(text.replace("seed = 5", "seed = 6")), 3)
    more = read(text.replace("[words.ball]", "[words.leg]\nmetallic = [0, 1]\n[words.ball]"))
    old, new = draw_sample(spec, 3), draw_sample(more, 3)
    assert old is not None
    assert new is not None
    assert (old.params, old.seed, old.looks["ball"]) == (new.params, new.seed, new.looks["ball"])


def test_splits_by_scene_hold_equal_scenes_together(read: Read) -> None:
    text = "seeds = [1, 2, 3]\n" + HEAD + "[params]\nballs = [1, 2, 3, 4]\n[splits]\ntrain = 0.5\ntest = 0.5\n"
    spec = read(text)
    where: dict[str, set[str]] = {}
    for index in range(300):
        draw = draw_sample(spec, index)
        assert draw is not None
        where.setdefault(draw.scene_key, set()).add(draw.split)
    assert len(where) == 12
    assert all(len(splits) == 1 for splits in where.values())
    assert {split for splits in where.values() for split in splits} == {"train", "test"}


@pytest.mark.slow
def test_splits_by_scene_ignore_what_changes_no_scene(tmp_path: Path) -> None:
    (tmp_path / "a.scene").write_text('(param n 1)\n(bind "a" (lambda () (call "cube" :scale n)))')
    (tmp_path / "b.scene").write_text('(param other 1)\n(bind "b" (lambda () (call "cube" :color [1 0 0])))')
    text = (
        "programs = ['a.scene', 'b.scene']\n[params]\nn = [1, 2]\nother = { uniform = [0, 1] }\n[pictures]\nsize = 8\n"
    )
    text += "[words.b]\nroughness = { uniform = [0, 1] }\n[splits]\ntrain = 0.5\ntest = 0.5\n"
    maker = Maker(spec_of(text, "s", tmp_path))
    where: dict[object, set[str]] = {}
    for index in range(30):
        draw = maker.make(index).draw
        scene = (draw.program, draw.params["n"]) if draw.program.endswith("a.scene") else index
        where.setdefault(scene, set()).add(draw.split)
    assert len(where) > 4
    assert all(len(splits) == 1 for splits in where.values())


def test_a_param_applies_to_the_programs_that_have_it(tmp_path: Path) -> None:
    (tmp_path / "a.scene").write_text('(param n 1)\n(bind "a" (lambda () (call "cube" :scale n)))')
    (tmp_path / "b.py").write_text('@register()\ndef box():\n    return primitive_call("cube")\n')
    maker = Maker(spec_of("programs = ['a.scene', 'b.py']\n[params]\nn = [1, 2]\n[pictures]\nsize = 8", "s", tmp_path))
    assert {Path(maker.make(index).draw.program).name for index in range(8)} == {"a.scene", "b.py"}


def test_visible_filters_judge_every_picture(tmp_path: Path) -> None:
    (tmp_path / "a.scene").write_text(
        '(bind "ball" (lambda () (call "sphere")))\n(bind "a" (lambda () (frames (list (call "ball") (call "cube")))))'
    )
    text = "programs = 'a.scene'\nroot = 'a'\n[pictures]\nsize = 16\n[filters]\nattempts = 2\n[filters.visible]\nball = 0.01"
    with pytest.raises(SampleFailure, match='2 with too little of "ball"'):
        Maker(spec_of(text, "s", tmp_path)).make(0)


def test_limits_are_named_as_the_spec_does(tmp_path: Path) -> None:
    (tmp_path / "a.scene").write_text('(bind "a" (lambda () (let loop ((i 0)) (loop (+ i 1)))))')
    with pytest.raises(SampleFailure) as caught:
        Maker(spec_of("programs = 'a.scene'\n[pictures]\nsize = 8\n[limits]\nsteps = 5000", "s", tmp_path)).make(0)
    assert str(caught.value.diagnostic.hint).endswith("raise the limit with `steps` in [limits]")


def test_splits_by_program_hold_equal_texts_together(tmp_path: Path) -> None:
    for i in range(10):
        (tmp_path / f"{i}.scene").write_text(f'(bind "a" (lambda () (call "cube" :scale {i % 5 + 1})))')
    spec = spec_of("programs = '*.scene'\n[splits]\nby = 'program'\ntrain = 0.6\ntest = 0.4", "s", tmp_path)
    found: dict[str, set[str]] = {"train": set(), "test": set()}
    for index in range(400):
        draw = draw_sample(spec, index)
        assert draw is not None
        found[draw.split].add(spec.texts[draw.program])
    assert len(found["train"]) == 3
    assert len(found["test"]) == 2
    assert not found["train"] & found["test"]


def test_splits_by_a_param_keep_ranges_apart(read: Read) -> None:
    text = (
        HEAD
        + "[params]\nballs = { integer = [1, 6] }\n[splits]\nby = 'balls'\ntrain = { range = [1, 4] }\ntest = { range = [5, 7] }"
    )
    spec = read(text)
    found: dict[str, set[int]] = {"train": set(), "test": set()}
    outside = 0
    for index in range(200):
        draw = draw_sample(spec, index)
        if draw is None:
            outside += 1
        else:
            found[draw.split].add(draw.params["balls"])
    assert found == {"train": {1, 2, 3}, "test": {5, 6}}
    assert outside > 10  # of 4 balls, which are in no split
    assert Maker(spec).make(next(i for i in range(200) if draw_sample(spec, i) is None)).draw.attempt > 0


def test_a_sample_alone_is_that_of_the_dataset(made: Path, folder: Path) -> None:
    import tarfile

    found = {}
    for path in sorted(made.glob("*.tar")):
        with tarfile.open(path) as tar:
            for member in tar:
                content = tar.extractfile(member)
                assert content is not None
                found[member.name] = content.read()
    for index in (0, 7):
        alone = dataset_sample(folder / "spec.toml", key_of(index))
        assert alone == {name: data for name, data in found.items() if name.startswith(key_of(index))}
        assert len(alone) == 7
    with pytest.raises(SceneError, match="is not the key of a sample"):
        dataset_sample(folder / "spec.toml", "x")
    with pytest.raises(SceneError, match="has no picture `000000001-v009`"):
        dataset_sample(folder / "spec.toml", "000000001-v009")


@pytest.mark.slow
def test_reused_scenes_change_no_byte(read: Read, folder: Path) -> None:
    spec = read("seeds = [1, 2]\n" + HEAD)
    warm = Maker(spec)
    for index in range(5):
        assert warm.make(index) == Maker(spec).make(index)


def test_programs_that_draw_nothing_are_evaluated_once(tmp_path: Path) -> None:
    (tmp_path / "still.scene").write_text('(bind "a" (lambda () (call "cube")))')
    (tmp_path / "top.scene").write_text('(define size (uniform 1 2))\n(bind "a" (lambda () (call "cube" :scale size)))')
    for name, evaluations in (("still", 1), ("top", 4)):
        spec = spec_of(f"programs = '{name}.scene'\n[pictures]\nsize = 8", "s", tmp_path)
        begun: list[bool] = []
        warm = Maker(spec, watch=begun.append)
        for index in range(4):
            assert warm.make(index) == Maker(spec).make(index)
        assert begun == [True, False] * evaluations


# --- cameras ---------------------------------------------------------------------------------------------------------


def _cameras(spec: Spec, index: int = 0) -> list[np.ndarray]:
    sample = Maker(spec).make(index)
    return [np.array(json.loads(item.files["json"])["camera"]["eye"]) for item in sample.items]


def test_orbits_go_around(read: Read) -> None:
    eyes = np.array(_cameras(read(HEAD + "[cameras]\nkind = 'orbit'\nviews = 4\nelevation = 30\ndistance = 9")))
    assert np.ptp(eyes[:, 1]) < 1e-9
    assert np.allclose(eyes[0, [0, 2]] - eyes[2, [0, 2]], -(eyes[1, [0, 2]] - eyes[3, [0, 2]])[::-1] * [1, -1])


def test_trajectories_look_at_their_target(read: Read) -> None:
    text = HEAD + "[cameras]\nkind = 'trajectory'\nviews = 3\neyes = [[0, 1, 8], [8, 1, 0]]\ntarget = [0, 0.5, 0]"
    assert np.allclose(_cameras(read(text)), [[0, 1, 8], [4, 1, 4], [8, 1, 0]])
    sample = Maker(read(text)).make(0)
    for item in sample.items:
        camera = json.loads(item.files["json"])["camera"]
        point = np.array(camera["world_to_camera"]) @ [0, 0.5, 0, 1]
        assert np.allclose((np.array(camera["K"]) @ point[:3])[:2] / point[2], [16, 12])


def test_cameras_come_from_files(read: Read, folder: Path) -> None:
    from scenelang.backends.pictures.camera import camera_to_json

    draw = draw_sample(read(HEAD), 0)
    assert draw is not None
    import scenelang as sl

    camera = sl.load(folder / "room.scene").placed(sl.Camera(azimuth=70, elevation=5), size=(32, 24))
    (folder / "camera.json").write_text(json.dumps(camera_to_json(camera)))
    spec = read(HEAD + "[cameras]\nkind = 'file'\nfiles = 'camera.json'")
    assert np.allclose(_cameras(spec)[0], camera.eye)
    assert len(views_of(spec, draw)) == 1


def test_hemispheres_are_those_of_maps(read: Read) -> None:
    sample = Maker(read(HEAD + "[cameras]\nviews = 8")).make(0)
    assert len({item.key for item in sample.items}) == 8
    assert 5.0 <= sample.camera["camera.elevation"] <= 65.0


# --- words, captions, filters ----------------------------------------------------------------------------------------


def test_words_are_recolored_and_bound_again(read: Read) -> None:
    text = "seeds = 1\n" + HEAD + "[labels]\nwrite = ['semantic', 'albedo', 'instance', 'program']\n"
    red = Maker(read(text + "[words.ball]\ncolor = ['lime']")).make(0).items[0].files
    record = json.loads(red["json"])
    ball = next(thing["class"] for thing in record["things"] if thing["word"] == "ball")
    albedo = decoded("albedo.png", red["albedo.png"])
    shown = albedo[decoded("semantic.png", red["semantic.png"]) == ball]
    assert len(shown)
    assert (shown == [0, 255, 0]).all()
    bound = "[words.ball]\nbind = ['(lambda () (call \"cone\" :radius .2))']"
    files = Maker(read(text + bound)).make(0).items[0].files
    assert b'(bind "ball"\n(lambda () (call "cone" :radius .2)))' in files["program.scene"]
    assert json.loads(files["json"])["counts"].get("ball") == 3


def test_captions_are_made_of_words(read: Read) -> None:
    text = "seeds = 1\n" + HEAD + "[params]\nballs = 2\n[captions]\ntemplates = "
    caption = lambda template: Maker(read(text + template)).make(0).items[0].files["txt"].decode()
    assert caption("'{count:ball} in a {word}'") == "2 in a room"
    assert sorted(caption("'{things}'").replace(" and ", ", ").split(", ")) == ["1 stool", "2 balls", "2 legs"]
    assert caption("'{count:leg} legs, {param:balls}'") == "2 legs, 2"
    with pytest.raises(SceneError, match=r"unknown field `\{thing\}`"):
        caption("'{thing}'")


def test_filters_draw_again(read: Read) -> None:
    strict = read(HEAD + "[filters.visible]\nball = 0.035")
    attempts: Counter[int] = Counter()
    for index in range(8):
        sample = Maker(strict).make(index)
        attempts[sample.draw.attempt] += 1
        files = sample.items[0].files
        record = json.loads(files["json"])
        ids = decoded("instance.png", files["instance.png"])
        balls = [thing["id"] for thing in record["things"] if thing["word"] == "ball"]
        assert np.isin(ids, balls).mean() >= 0.035
    assert sum(count for attempt, count in attempts.items() if attempt) > 0
    with pytest.raises(SampleFailure, match='no draw passes the filters: 20 with too little of "ball"'):
        Maker(read(HEAD + "[filters.visible]\nball = 0.9")).make(0)


def test_geometry_is_a_filter(tmp_path: Path) -> None:
    (tmp_path / "a.scene").write_text(
        '(param apart 2)\n(bind "a" (lambda () (union (call "cube" :color [1 0 0]) (transform (call "cube" :color [0 1 0]) (translate [apart 0 0])))))'
    )
    text = "programs = 'a.scene'\n[params]\napart = [0, 1]\n[pictures]\nsize = 8\n[filters]\ngeometry = true"
    spec = spec_of(text, "s", tmp_path)
    assert {Maker(spec).make(index).draw.params["apart"] for index in range(12)} == {1}


PILE = """
(param apart 0)
(bind "box" (lambda () (call "cube" :color [1 0 0])))
(bind "ball" (lambda () (call "sphere" :radius .2 :color [0 1 0])))
(bind "pile" (lambda () (union (transform (call "box") (translate [0 .5 0])) (transform (call "ball") (translate [apart 1.2 0])))))
(scene "pile")
"""


@pytest.mark.parametrize("rule", ['that = [\'(on "ball" "box")\']', "stable = true"])
def test_declarations_and_stability_are_filters(tmp_path: Path, rule: str) -> None:
    if rule.startswith("stable"):
        pytest.importorskip("mujoco")
    (tmp_path / "a.scene").write_text(PILE)
    text = (
        "programs = 'a.scene'\n[params]\napart = [0, 2]\n[pictures]\nsize = 8\n[labels]\nwrite = ['graph']\n[filters]\n"
    )
    spec = spec_of(text + rule, "s", tmp_path)
    samples = [Maker(spec).make(index) for index in range(6)]
    assert {sample.draw.params["apart"] for sample in samples} == {0}
    graph = json.loads(samples[0].items[0].files["graph.json"])
    words = [node["word"] for node in graph["nodes"]]
    assert [(words[r["subject"]], r["relation"], words[r["other"]]) for r in graph["relations"]] == [
        ("ball", "on", "box")
    ]
    with pytest.raises(SceneError, match="declaration 1"):
        spec_of(text + 'that = [\'(onn "ball" "box")\']', "s", tmp_path)


def test_predicates_of_packages_filter(read: Read, monkeypatch: pytest.MonkeyPatch) -> None:
    from scenelang.datasets import making
    from scenelang.datasets import spec as spec_module

    def has_many(candidate: Candidate) -> bool:
        return candidate.values["param.balls"] > 2 and candidate.scene.count()["ball"] > 2

    class Installed:
        @staticmethod
        def find(name: str) -> Predicate:
            return Predicate(name, "more than two balls", has_many)

    real = spec_module.entry_points_of
    known = lambda group: {"many": None} if group == spec_module.PREDICATES else real(group)
    monkeypatch.setattr(spec_module, "entry_points_of", known)
    monkeypatch.setattr(making, "FILTERS", Installed)
    spec = read(HEAD + "[params]\nballs = [1, 2, 3, 4]\n[filters]\npredicates = 'many'")
    assert {Maker(spec).make(index).draw.params["balls"] for index in range(10)} == {3, 4}


FILTER = """
from scenelang.datasets.making import Candidate, Predicate


def is_on(candidate: Candidate) -> bool:
    scene = candidate.scene
    assert scene.render(size=(16, 16)).size == (16, 16)
    related = [each.relation for each in scene.relations()]
    return related == ["on"] and not scene.violations('(on "ball" "box")')


ON = Predicate("on", "the ball is on the box", is_on)
"""


@pytest.mark.parametrize("jobs", [0, 1])
def test_a_filter_of_a_package_has_the_scene_of_the_api(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, jobs: int
) -> None:
    """In this process, and in a worker."""
    import scenelang as sl

    info = tmp_path / "site/filters-1.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: filters\nVersion: 1\n")
    (info / "entry_points.txt").write_text("[scenelang.filters]\non = filter_of_a_package:ON\n")
    (tmp_path / "site/filter_of_a_package.py").write_text(FILTER)
    monkeypatch.syspath_prepend(tmp_path / "site")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path / "site"), os.environ.get("PYTHONPATH", "")]))
    (tmp_path / "a.scene").write_text(PILE)
    (tmp_path / "spec.toml").write_text(
        "programs = 'a.scene'\ncount = 3\n[params]\napart = [0, 2]\n[pictures]\nsize = 8\n[filters]\npredicates = 'on'"
    )
    report = sl.dataset(tmp_path / "spec.toml", tmp_path / "out", jobs=jobs)
    assert (report.samples, list(report.failed)) == (3, [])
    assert {Maker(read_spec(tmp_path / "spec.toml")).make(index).draw.params["apart"] for index in range(3)} == {0}


def test_a_program_that_fails_says_why(tmp_path: Path) -> None:
    (tmp_path / "a.scene").write_text('(param n 1)\n(bind "a" (lambda () (call "cube" :scale (/ 1 n))))')
    spec = spec_of("programs = 'a.scene'\n[params]\nn = 0\n[pictures]\nsize = 8", "s", tmp_path)
    with pytest.raises(SampleFailure) as caught:
        Maker(spec).make(0)
    assert caught.value.diagnostic.is_error
    assert caught.value.diagnostic.span is not None


def test_the_quality_varies(read: Read) -> None:
    spec = read(HEAD + 'quality = ["draft", "final"]\nsettings = { samples = 2 }\n')
    made = [Maker(spec).make(index).items[0] for index in range(6)]
    drawn = [draw_sample(spec, index, 0) for index in range(6)]
    assert {each.quality for each in drawn if each is not None} == {"draft", "final"}
    assert len({item.files["color.png"] for item in made}) == 6


def test_each_frame_of_a_film_is_cast_once(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from scenelang.backends.labels import views

    text = (
        'programs = "cart.scene"\ncount = 1\n[pictures]\nsize = 24\n'
        '[labels]\nwrite = ["instance", "boxes", "flow", "tracks"]\n[filters]\nvisible = { cart = 0.01 }\n'
    )
    cast: list[int] = []
    truth_in = views.truth_in
    monkeypatch.setattr(views, "truth_in", lambda frame, shot: cast.append(shot.frame) or truth_in(frame, shot))
    everything = [dict(item.files) for item in Maker(spec_of(text, "spec", folder)).make(0).items]
    assert sorted(cast) == [0, 1, 2, 3]
    monkeypatch.setattr(views, "_MAX_CACHE_BYTES", 0)  # two at a time, as for large pictures
    assert [dict(item.files) for item in Maker(spec_of(text, "spec", folder)).make(0).items] == everything
    assert len(cast) > 8


def test_pictures_are_encoded_while_the_next_is_made(
    read: Read, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from scenelang.datasets import making

    threads = set()
    png = making.png

    def encoded(values: Any) -> bytes:
        threads.add(threading.current_thread().name.partition("_")[0])
        return png(values)

    monkeypatch.setattr(making, "png", encoded)
    dataset(folder / "spec.toml", tmp_path / "out", jobs=0, count=3)
    assert threads == {"encoder"}
