"""Datasets and other people's files: nothing foreign is replaced, and damaged or hostile records do no harm."""

from __future__ import annotations

import json
import os
import shutil
import signal
import tarfile
from collections.abc import Callable
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest
from support import worked

from scenelang.cli.main import main
from scenelang.datasets.running import dataset, dataset_status, merge_datasets, verify_dataset
from scenelang.grammar.diagnostics import SceneError, UsageError


def contents(folder: Path) -> dict[str, bytes]:
    """All files of a folder by path."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def changed(path: Path, change: Callable[[Any], Any]) -> None:
    """Change the data of a JSON file; ``change`` returns the new data, or None after changing them in place."""
    data = json.loads(path.read_text())
    found = change(data)
    path.write_text(json.dumps(data if found is None else found))


def _one(tmp_path: Path, program: str, spec: str = "") -> Path:
    (tmp_path / "a.scene").write_text(program)
    (tmp_path / "spec.toml").write_text(f"programs = 'a.scene'\ncount = 4\n[pictures]\nsize = 8\n{spec}")
    return tmp_path / "spec.toml"


CUBE = '(bind "a" (lambda () (call "cube")))'


# --- foreign files ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("resume", [False, True])
@pytest.mark.parametrize("name", ["README.md", "coco/mine.json", "train-000000.tar", "shards/000000.json", ".hidden"])
@pytest.mark.sampled(3)
def test_a_folder_that_is_no_dataset_is_refused(folder: Path, tmp_path: Path, name: str, resume: bool) -> None:
    out = tmp_path / "out"
    (out / name).parent.mkdir(parents=True)
    (out / name).write_text("mine")
    with pytest.raises(SceneError, match="is not empty, and no dataset") as caught:
        dataset(folder / "everything.toml", out, jobs=0, resume=resume)
    assert (caught.value.name, caught.value.hint) == ("file", "choose a new folder")
    assert contents(out) == {name: b"mine"}
    with pytest.raises(SceneError, match="is not empty, and no dataset"):
        merge_datasets([_made(tmp_path)], out)
    assert contents(out) == {name: b"mine"}


def _made(tmp_path: Path) -> Path:
    out = tmp_path / "source"
    if not out.exists():
        dataset(_one(tmp_path, CUBE), out, jobs=0)
    return out


@pytest.mark.parametrize("name", ["coco/mine.json", "nerfstudio/000000000/mine.txt"])
def test_files_within_formats_are_not_replaced(layouts: Path, folder: Path, tmp_path: Path, name: str) -> None:
    out = tmp_path / "copy"
    shutil.copytree(layouts, out)
    (out / name).write_text("mine")
    before = contents(out)
    with pytest.raises(SceneError, match=rf"`{name}` in .* was not written by this dataset"):
        dataset(folder / "everything.toml", out, jobs=0, resume=True)
    assert contents(out) == before
    assert [each.message for each in verify_dataset(out)] == [f"`{name}` belongs to no dataset"]


def test_a_folder_with_the_name_of_a_new_format_is_not_replaced(tmp_path: Path) -> None:
    spec, out = _one(tmp_path, CUBE), tmp_path / "out"
    dataset(spec, out, jobs=0)
    (out / "coco").mkdir()
    (out / "coco" / "mine").write_text("x")
    spec.write_text(spec.read_text() + "[output]\nformats = ['webdataset', 'coco']\n")
    with pytest.raises(SceneError, match=r"`coco` in .* was not written by this dataset"):
        dataset(spec, out, jobs=0, resume=True)
    shutil.rmtree(out / "coco")
    dataset(spec, out, jobs=0, resume=True)
    assert (out / "coco" / "annotations").is_dir()
    assert verify_dataset(out) == []


@pytest.mark.parametrize("name", ["README.md", "coco/annotations/instances_train.json", "derived.json"])
@pytest.mark.parametrize("damage", ["delete", "change"])
@pytest.mark.sampled(2)
def test_damaged_formats_and_cards_are_found_and_written_again(
    layouts: Path, folder: Path, tmp_path: Path, name: str, damage: str
) -> None:
    out = tmp_path / "copy"
    shutil.copytree(layouts, out)
    if damage == "delete":
        (out / name).unlink()
    else:
        (out / name).write_text("{")
    (found,) = verify_dataset(out)
    assert f"`{name}`" in found.message
    if name == "derived.json":  # then nobody knows whose the folders are
        with pytest.raises(SceneError, match="was not written by this dataset"):
            dataset(folder / "everything.toml", out, jobs=0, resume=True)
        return
    dataset(folder / "everything.toml", out, jobs=0, resume=True)
    assert contents(out) == contents(layouts)


# --- records ---------------------------------------------------------------------------------------------------------

DAMAGES: dict[str, Callable[[Any], Any]] = {
    "no JSON": lambda _: "{",
    "a list": lambda _: [],
    "nothing": lambda _: {},
    "deep": lambda data: data | {"values": [json.loads("[" * 400 + "]" * 400)]},
    "no run": lambda data: data.pop("run") and None,
    "no failures": lambda data: data.pop("failures") and None,
    "a text as a number": lambda data: data | {"samples": "3"},
    "a number as a list": lambda data: data | {"failures": 3},
    "a failure without a code": lambda data: data | {"failures": [{"key": "000000000"}]},
    "files of texts": lambda data: data | {"files": ["train-000000.tar"]},
    "a name outside": lambda data: data["files"][0].update(name="../../evil.tar"),
    "an absolute name": lambda data: data["files"][0].update(name="/tmp/evil.tar"),
    "a split outside": lambda data: data["files"][0].update(split="../x", name="../x-000000.tar"),
    "the name of another shard": lambda data: data["files"][0].update(name="train-000001.tar"),
    "the name of the plan": lambda data: data["files"][0].update(name="dataset.json"),
    "too few samples": lambda data: data | {"samples": 1},
}  # fmt: skip


@pytest.mark.parametrize("damage", DAMAGES)
@pytest.mark.sampled(3)
def test_damaged_records_are_told_found_and_made_again(
    copy: Path, made: Path, folder: Path, tmp_path: Path, damage: str, capsys: pytest.CaptureFixture[str]
) -> None:
    changed(copy / "shards" / "000000.json", DAMAGES[damage])
    assert "1 shard with damaged records" in str(dataset_status(copy))
    assert dataset_status(copy).damaged == 1
    assert main(["dataset", "verify", str(copy)]) == 1
    assert "1 of 4 shards have damaged records: 0" in capsys.readouterr().err
    merged = merge_datasets([copy], tmp_path / "merged")
    assert not merged.is_complete
    assert sorted(path.name for path in (tmp_path / "merged" / "shards").iterdir()) == [
        f"00000{n}.json" for n in (1, 2, 3)
    ]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["copy", "merged"]
    assert dataset(folder / "spec.toml", copy, jobs=0, resume=True).digest == dataset_status(made).digest
    assert verify_dataset(copy) == []


@pytest.mark.parametrize(
    "damage",
    [
        lambda _: [],
        lambda data: data.pop("classes") and None,
        lambda data: data | {"count": "10"},
        lambda data: data | {"count": 0},
        lambda data: data | {"shard": 0},
        lambda data: data | {"formats": ["../x"]},
        lambda data: data | {"formats": [1]},
        lambda data: data | {"columns": 3},
        lambda data: data | {"shards": "zip"},
        lambda data: data | {"version": True},
    ],
)
def test_a_damaged_plan_is_told(copy: Path, damage: Callable[[Any], Any], capsys: pytest.CaptureFixture[str]) -> None:
    changed(copy / "dataset.json", damage)
    for words in (["status", str(copy)], ["verify", str(copy)], ["merge", str(copy), "-o", str(copy / "x")]):
        assert main(["dataset", *words]) == 1
        told = capsys.readouterr().err
        assert "is not the plan of a dataset" in told
        assert "make the dataset again in a new folder" in told


def test_a_nested_plan_is_told(copy: Path) -> None:
    (copy / "dataset.json").write_text("[" * 100_000)
    with pytest.raises(SceneError, match="is not the plan of a dataset"):
        dataset_status(copy)


def test_keys_of_pictures_do_not_leave_the_folder(tmp_path: Path) -> None:
    """A shard with a right digest whose keys are paths."""
    import hashlib

    out = tmp_path / "out"
    dataset(_one(tmp_path, CUBE, "[output]\nformats = ['coco']\nshard = 4"), out, jobs=0)
    target = tmp_path / "evil"
    data = BytesIO()
    with tarfile.open(out / "train-000000.tar") as old, tarfile.open(fileobj=data, mode="w") as new:
        for member in old:
            content = old.extractfile(member)
            assert content is not None
            member.name = member.name.replace("000000000", str(target))
            new.addfile(member, content)
    (out / "train-000000.tar").write_bytes(data.getvalue())
    facts = {"sha256": hashlib.sha256(data.getvalue()).hexdigest(), "bytes": len(data.getvalue())}
    changed(out / "shards" / "000000.json", lambda record: record["files"][0].update(facts))
    assert any("is not the key of a picture" in each.message for each in verify_dataset(out))
    with pytest.raises(SceneError, match="is not the key of a picture"):
        merge_datasets([out], tmp_path / "merged")
    assert not list(tmp_path.glob("evil*"))


# --- reasons of the machine ------------------------------------------------------------------------------------------

SLOW = '(param n 1)\n(bind "a" (lambda () (if (= n 1) (let loop ((i 0)) (loop (+ i 1)))) (call "cube")))'
SLOW_SPEC = "[params]\nn = [0, 1]\n[limits]\nseconds = 0.3\nsteps = 1000000000\n[output]\nshard = 1"


def test_what_fails_for_reasons_of_the_machine_is_tried_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from scenelang.datasets import working
    from scenelang.datasets.making import Maker, SampleFailure
    from scenelang.interpreter.values.limits import memory_error

    spec = _one(tmp_path, CUBE, "[output]\nshard = 2")
    make = Maker.make

    def fail(self: Maker, index: int) -> Any:
        if index == 1:
            raise SampleFailure(memory_error(1).diagnostic)
        return make(self, index)

    monkeypatch.setattr(working.Maker, "make", fail)
    report = dataset(spec, tmp_path / "out", jobs=0)
    told = "1 sample failed for reasons of the machine; `--resume` tries it again"
    assert (report.failures, report.of_machine, report.samples) == ({"E506": 1}, 1, 3)
    assert told in str(report).splitlines()
    assert [each.message for each in verify_dataset(tmp_path / "out")] == [told]
    monkeypatch.setattr(working.Maker, "make", make)
    seen: list[int] = []
    again = dataset(spec, tmp_path / "out", jobs=0, resume=True, progress=lambda each: seen.append(each.kept))
    assert seen[0] == 2  # of the other shard
    assert (again.failures, again.of_machine, again.samples) == ({}, 0, 4)
    assert again.digest == dataset(spec, tmp_path / "fresh", jobs=0).digest
    assert verify_dataset(tmp_path / "out") == []


@pytest.mark.slow
def test_a_part_without_failures_of_the_machine_is_merged(tmp_path: Path) -> None:
    spec = _one(tmp_path, SLOW, SLOW_SPEC)
    for name in ("one", "two"):
        dataset(spec, tmp_path / name, jobs=0)
    record = next(p for p in sorted((tmp_path / "one/shards").iterdir()) if json.loads(p.read_text())["failures"])
    failed = json.loads(record.read_text())
    assert failed["failures"][0]["code"] == "E507"
    assert failed["failures"][0]["machine"] is True
    whole = next(p for p in sorted((tmp_path / "one/shards").iterdir()) if not json.loads(p.read_text())["failures"])
    changed(tmp_path / "two/shards" / whole.name, lambda data: data.update(
        files=[], samples=0, pictures=0, failures=[failed["failures"][0]]))  # fmt: skip
    for order in (("one", "two"), ("two", "one")):
        out = tmp_path / "-".join(order)
        merged = merge_datasets([tmp_path / name for name in order], out)
        assert merged.digest == dataset_status(tmp_path / "one").digest


@pytest.mark.slow
def test_a_worker_that_is_killed_again_and_again_fails_for_this_run(tmp_path: Path) -> None:
    spec, killed = _one(tmp_path, SLOW, "[params]\nn = 1\n[limits]\nsteps = 1000000000\n"), list[int]()
    from threading import Thread
    from time import sleep

    def kill() -> None:
        while len(killed) < 12:
            for child in Path(f"/proc/self/task/{os.getpid()}/children").read_text().split():
                is_worker = "datasets.working" in Path(f"/proc/{child}/cmdline").read_text()
                if is_worker and worked(int(child)) > 3.0:  # seconds, of which it starts in less than two
                    os.kill(int(child), signal.SIGKILL)
                    killed.append(int(child))
            sleep(0.1)

    Thread(target=kill, daemon=True).start()
    report = dataset(spec, tmp_path / "out", count=1)
    killed += [0] * 12
    assert report.failures == {"E922": 1}
    assert report.of_machine == 1


# --- usage -----------------------------------------------------------------------------------------------------------


def test_a_share_of_gpus_is_whole_or_less_than_one(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"`gpus`: expected a whole number, or less than 1, got 1\.5"):
        dataset(folder / "spec.toml", tmp_path / "out", gpus=1.5)
    assert main(["dataset", str(folder / "spec.toml"), "-o", str(tmp_path / "out"), "--gpus", "1.5"]) == 2


def test_one_folder_is_merged(made: Path, tmp_path: Path) -> None:
    assert merge_datasets(str(made), tmp_path / "out").digest == dataset_status(made).digest


def test_a_finished_part_says_so(folder: Path, tmp_path: Path) -> None:
    report = dataset(folder / "spec.toml", tmp_path / "out", jobs=0, part=(1, 2))
    assert "part 1/2 is complete; `dataset merge` joins the parts" in str(report)
    assert "resume" not in str(report)
