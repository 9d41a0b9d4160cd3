"""Runs: any number of workers, kills, full disks and damage give the same bytes; progress, failures, parts and commands."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from support import interruptible, wait_until

from scenelang.cli.main import main
from scenelang.datasets.running import (
    DatasetProgress,
    dataset,
    dataset_status,
    merge_datasets,
    verify_dataset,
)
from scenelang.grammar.diagnostics import SceneError


def contents(folder: Path) -> dict[str, bytes]:
    """The files of a dataset that must not depend on how it was made."""
    return {path.name: path.read_bytes() for path in folder.glob("t*-*.tar")}


def test_the_number_of_workers_changes_no_byte(made: Path, folder: Path, tmp_path: Path) -> None:
    seen: list[DatasetProgress] = []
    report = dataset(folder / "spec.toml", tmp_path / "two", jobs=2, progress=seen.append)
    assert contents(tmp_path / "two") == contents(made)
    assert report.digest == dataset_status(made).digest
    assert (report.samples, report.total, report.is_complete) == (10, 10, True)
    assert [progress.done for progress in seen] == list(range(1, 11))
    assert seen[-1].rate > 0
    assert 20e6 < seen[-1].memory < 2e9
    assert verify_dataset(tmp_path / "two") == []


def test_keys_are_unique_and_all_there(made: Path) -> None:
    keys = [key for record in _records(made) for key in _keys(made, record)]
    assert sorted(keys) == [f"{i:09d}" for i in range(10)]


def _records(folder: Path) -> list[dict[str, Any]]:
    return [json.loads(path.read_text()) for path in sorted((folder / "shards").glob("*.json"))]


def _keys(folder: Path, record: dict[str, Any]) -> set[str]:
    from scenelang.datasets.store import Store, items_of

    return {key for file in record["files"] for key, _ in items_of(Store(folder), file["name"])}


@pytest.mark.slow
def test_killed_workers_lose_and_repeat_nothing(made: Path, folder: Path, tmp_path: Path) -> None:
    killed: list[int] = []

    def kill(progress: DatasetProgress) -> None:
        if progress.done in (2, 6) and len(killed) < 4:
            own = os.getpid()
            children = Path(f"/proc/self/task/{own}/children").read_text().split()
            for child in map(int, children):
                killed.append(child)
                os.kill(child, signal.SIGKILL)

    report = dataset(folder / "spec.toml", tmp_path / "out", jobs=2, progress=kill)
    assert len(killed) >= 2
    assert report.failures == {}
    assert contents(tmp_path / "out") == contents(made)
    assert not list((tmp_path / "out").glob(".scenelang-*"))


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT, signal.SIGTERM])
@pytest.mark.sampled(3)
def test_a_killed_run_is_resumed(made: Path, folder: Path, tmp_path: Path, number: int) -> None:
    out = tmp_path / "out"
    words = [sys.executable, "-m", "scenelang", "dataset", str(folder / "spec.toml"), "-o", str(out), "--jobs", "2"]
    with interruptible(words, tmp_path) as running:
        wait_until(lambda: list(out.glob("shards/0*.json")))
        running.send_signal(number)
        _, told = running.communicate()
    assert number != signal.SIGINT or b"what is finished is kept; `--resume` goes on" in told
    wait_until(_no_worker_is_left)

    before = dataset_status(out)
    assert before.samples > 0
    report = dataset(folder / "spec.toml", out, jobs=1, resume=True)
    assert report.is_complete
    assert contents(out) == contents(made)
    assert not list(out.glob(".scenelang-*"))


def test_an_interrupted_evaluation_is_no_failed_sample(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from scenelang.grammar.diagnostics import LimitError
    from scenelang.interpreter.values.limits import Meter

    def interrupt(self: Meter, steps: int) -> None:
        raise LimitError("interrupted", "evaluation interrupted")

    monkeypatch.setattr(Meter, "spend", interrupt)
    spec = _failing(tmp_path, HOSTILE, "[params]\nn = 1")
    with pytest.raises(KeyboardInterrupt):
        dataset(spec, tmp_path / "out", jobs=0)


def _no_worker_is_left() -> bool:
    """Whether the workers have ended, as they do with their pool."""
    lines = subprocess.run(["ps", "ax", "-o", "args"], capture_output=True, text=True, check=True).stdout
    return "from scenelang.datasets.working import serve" not in lines


@pytest.mark.parametrize("damage", ["cut", "flip", "delete", "record"])
@pytest.mark.sampled(2)
def test_damage_is_found_and_made_again(copy: Path, made: Path, folder: Path, damage: str) -> None:
    target = sorted(copy.glob("train-*.tar"))[0]
    data = target.read_bytes()
    if damage == "cut":
        target.write_bytes(data[:-20_000])
    elif damage == "flip":
        target.write_bytes(data[:2000] + bytes([data[2000] ^ 1]) + data[2001:])
    elif damage == "delete":
        target.unlink()
    else:
        (copy / "shards" / "000001.json").write_text("{")
    found = verify_dataset(copy)
    assert len(found) >= 1
    assert found[0].hint == "`--resume` makes missing and damaged shards again"
    report = dataset(folder / "spec.toml", copy, jobs=0, resume=True)
    assert contents(copy) == contents(made)
    assert report.digest == dataset_status(made).digest
    assert verify_dataset(copy) == []


def test_labels_that_disagree_are_found(copy: Path) -> None:
    """A shard with a wrong label and a right digest."""
    import hashlib
    import io
    import tarfile

    import numpy as np

    from scenelang.datasets.making import decoded, png

    target = sorted(copy.glob("train-*.tar"))[0]
    changed = io.BytesIO()
    with tarfile.open(target) as old, tarfile.open(fileobj=changed, mode="w", format=tarfile.USTAR_FORMAT) as new:
        for member in old:
            content = old.extractfile(member)
            assert content is not None
            data = content.read()
            if member.name.endswith("semantic.png"):
                data = png(np.roll(decoded("semantic.png", data), 3, axis=1))
                member.size = len(data)
            new.addfile(member, io.BytesIO(data))
    target.write_bytes(changed.getvalue())
    record = copy / "shards" / f"{target.stem.split('-')[1]}.json"
    facts = json.loads(record.read_text())
    for file in facts["files"]:
        if file["name"] == target.name:
            file |= {"sha256": hashlib.sha256(changed.getvalue()).hexdigest(), "bytes": len(changed.getvalue())}
    record.write_text(json.dumps(facts))
    messages = [finding.message for finding in verify_dataset(copy)]
    assert messages
    assert all("classes and instances disagree" in message for message in messages)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs limits of processes")
def test_a_full_disk_leaves_a_state_that_resumes(made: Path, folder: Path, tmp_path: Path) -> None:
    import resource

    out = tmp_path / "out"
    words = [sys.executable, "-m", "scenelang", "dataset", str(folder / "spec.toml"), "-o", str(out)]
    full = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (30_000, 30_000))
    env = {**os.environ, "PYTHONDONTWRITEBYTECODE": "1"}  # Python keeps bytecode that a limit has cut short
    run = subprocess.run(words, capture_output=True, text=True, preexec_fn=full, env=env)
    assert run.returncode == 1
    assert "error[E701]" in run.stderr
    assert "Traceback" not in run.stderr
    assert dataset_status(out).samples == 0
    assert contents(out) == {}
    dataset(folder / "spec.toml", out, jobs=0, resume=True)
    assert contents(out) == contents(made)


def test_what_is_buffered_does_not_fail_again(made: Path, folder: Path, tmp_path: Path) -> None:
    import gc
    import warnings

    from scenelang.datasets.store import Store, _TarFile, read_plan

    plan = read_plan(Store(made))
    assert plan is not None
    written = _TarFile(tmp_path / "x.tar", plan)
    written.add("000000000", {"json": b"{}"})
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # a file that is left open warns when it is collected
        written.discard()
        assert (tmp_path / "x.tar").stat().st_size <= 16_384
        del written
        gc.collect()


def test_a_folder_that_cannot_be_replaced_stays(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from scenelang.backends.files import replaced_folder

    path = tmp_path / "coco"
    path.mkdir()
    (path / "old.json").write_text("{}")
    rename = Path.rename

    def fail(self: Path, target: Path) -> Path:
        if self.name == "made":
            raise OSError(28, "No space left on device", str(self))
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", fail)
    with pytest.raises(SceneError, match=r"cannot write `.*coco`: No space"), replaced_folder(path) as folder:
        (folder / "new.json").write_text("{}")
    assert [each.name for each in path.iterdir()] == ["old.json"]
    assert [each.name for each in tmp_path.iterdir()] == ["coco"]


def test_parts_are_merged(made: Path, folder: Path, tmp_path: Path) -> None:
    for k in range(2):
        report = dataset(folder / "spec.toml", tmp_path / str(k), jobs=0, part=(k, 2))
        assert not report.is_complete
    report = merge_datasets([tmp_path / "0", tmp_path / "1"], tmp_path / "all")
    assert report.is_complete
    assert contents(tmp_path / "all") == contents(made)
    assert (tmp_path / "all" / "README.md").read_text() == (made / "README.md").read_text()
    other = folder / "other.toml"
    other.write_text((folder / "spec.toml").read_text().replace("seed = 5", "seed = 6"))
    dataset(other, tmp_path / "other", jobs=0)
    with pytest.raises(SceneError, match="is a part of another dataset"):
        merge_datasets([tmp_path / "0", tmp_path / "other"], tmp_path / "mixed")


@pytest.mark.slow
def test_a_dataset_grows(made: Path, copy: Path, folder: Path, tmp_path: Path) -> None:
    report = dataset(folder / "spec.toml", copy, jobs=0, resume=True, count=14)
    assert (report.samples, report.total) == (14, 14)
    dataset(folder / "spec.toml", tmp_path / "fresh", jobs=0, count=14)
    assert contents(copy) == contents(tmp_path / "fresh")
    with pytest.raises(SceneError, match="has 14 samples, more than 10"):
        dataset(folder / "spec.toml", copy, jobs=0, resume=True)


def test_another_spec_does_not_resume(copy: Path, folder: Path, tmp_path: Path) -> None:
    other = folder / "again.toml"
    other.write_text((folder / "spec.toml").read_text().replace("seed = 5", "seed = 6"))
    with pytest.raises(SceneError, match="was made with another spec"):
        dataset(other, copy, jobs=0, resume=True)
    with pytest.raises(SceneError, match="has a dataset already"):
        dataset(folder / "spec.toml", copy, jobs=0)
    with pytest.raises(SceneError, match="is not a dataset"):
        dataset_status(tmp_path / "none")


def test_stores_of_fsspec(made: Path, folder: Path) -> None:
    import fsspec

    memory = fsspec.filesystem("memory")
    report = dataset(folder / "spec.toml", "memory://set", jobs=0)
    assert report.digest == dataset_status(made).digest
    assert {name: memory.cat(f"/set/{name}") for name in contents(made)} == contents(made)
    memory.pipe("/set/" + next(iter(contents(made))), b"")
    assert len(verify_dataset("memory://set")) == 1
    dataset(folder / "spec.toml", "memory://set", jobs=0, resume=True)
    assert verify_dataset("memory://set") == []


def test_any_error_of_a_store_is_told(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Packages of stores raise exceptions of their own, such as botocore's for a server that is not there."""
    import fsspec

    class LostError(Exception):
        pass

    def lose(*_: Any, **__: Any) -> None:
        raise LostError("Could not connect to the endpoint")

    kind = fsspec.get_filesystem_class("memory")
    for method in ("exists", "put_file", "_open", "ls"):
        with monkeypatch.context() as patch:
            patch.setattr(kind, method, lose)
            with pytest.raises(SceneError, match="in memory://lost: Could not connect to the endpoint") as caught:
                dataset(folder / "spec.toml", "memory://lost", jobs=0, count=1, resume=True)
            assert caught.value.name == "file"
            assert caught.value.hint == "check the address, and the endpoint and keys of its store"


# --- failures --------------------------------------------------------------------------------------------------------

SOME_FAIL = '(param n 1)\n(bind "a" (lambda () (call "cube" :scale (if (> n 3) (/ 1 0) 1))))'
HOSTILE = '(param n 1)\n(bind "a" (lambda () (if (= n 1) (let loop ((i 0)) (loop (+ i 1)))) (call "cube")))'


def _failing(tmp_path: Path, text: str, spec: str) -> Path:
    (tmp_path / "a.scene").write_text(text)
    (tmp_path / "spec.toml").write_text(f"programs = 'a.scene'\ncount = 8\n[pictures]\nsize = 8\n{spec}")
    return tmp_path / "spec.toml"


@pytest.mark.slow
def test_failures_are_recorded_and_counted(tmp_path: Path) -> None:
    spec = _failing(tmp_path, SOME_FAIL, "[params]\nn = { integer = [1, 5] }\n[output]\nshard = 3")
    report = dataset(spec, tmp_path / "out", jobs=2)
    assert report.is_complete
    failed = sum(report.failures.values())
    assert 0 < failed < 8
    assert report.samples == 8 - failed
    assert all("a.scene:2" in each["text"] for each in report.failed)
    assert dataset(spec, tmp_path / "again", jobs=0).digest == report.digest
    assert "failures" in (tmp_path / "out" / "README.md").read_text()
    with pytest.raises(SceneError, match="samples have failed") as caught:
        dataset(spec, tmp_path / "strict", jobs=1, max_failures=0)
    assert caught.value.name == "sample"
    assert dataset(spec, tmp_path / "strict", jobs=1, resume=True).digest == report.digest


def test_a_run_whose_every_sample_fails_exits_with_1(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    spec = _failing(tmp_path, SOME_FAIL, "[params]\nn = 5")
    assert main(["dataset", str(spec), "-o", str(tmp_path / "out"), "-q"]) == 1
    told = capsys.readouterr()
    assert "error[E" in told.err
    assert "a.scene:2" in told.err
    assert ", first of 000000000: " in told.out
    assert "`scenelang dataset sample SPEC 000000000 -o OUT` makes such a sample alone" in told.out


def test_a_huge_count_lists_no_shards(tmp_path: Path) -> None:
    spec = _failing(tmp_path, SOME_FAIL, "[params]\nn = 5\n[output]\nshard = 1")
    for jobs in (0, 1):
        with pytest.raises(SceneError, match="more than 2"):
            dataset(spec, tmp_path / f"out{jobs}", jobs=jobs, count=1_000_000_000, max_failures=2)


def test_wrong_numbers_of_the_api_are_usage_errors(folder: Path, tmp_path: Path) -> None:
    from scenelang.grammar.diagnostics import UsageError

    wrong: list[dict[str, Any]] = [{"gpus": -1.0}, {"part": "0/2"}, {"part": (0, 2, 3)}]
    for settings in wrong:
        with pytest.raises((UsageError, SceneError, TypeError)) as caught:
            dataset(folder / "spec.toml", tmp_path / "out", **settings)
        assert not isinstance(caught.value, TypeError)
    assert not (tmp_path / "out").exists()


def test_remote_stores_are_checked_before_anything_is_made(folder: Path, layouts: Path) -> None:
    with pytest.raises(SceneError, match="workers do not see memory://none"):
        dataset(folder / "spec.toml", "memory://none", jobs=1)
    with pytest.raises(SceneError, match=r"coco, kitti, .* written to local folders only"):
        dataset(folder / "everything.toml", "memory://none", jobs=0)
    with pytest.raises(SceneError, match=r"coco, kitti, .* written to local folders only"):
        merge_datasets([layouts], "memory://none")
    with pytest.raises(SceneError, match="is not a dataset"):
        dataset_status("memory://none")


def test_a_failed_start_leaves_nothing(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from scenelang.datasets import working

    monkeypatch.setattr(working, "_CODE", "import os; os._exit(9)")
    with pytest.raises(SceneError, match="workers end before they begin"):
        dataset(folder / "spec.toml", tmp_path / "out")
    assert not (tmp_path / "out" / "dataset.json").exists()


def test_stray_shards_missing_formats_and_leaks_are_found(copy: Path, layouts: Path, tmp_path: Path) -> None:
    first = sorted(copy.glob("t*.tar"))[0]
    shutil.copy(first, copy / "train-000099.tar")
    assert [each.message for each in verify_dataset(copy)] == ["`train-000099.tar` belongs to no shard"]
    shutil.copytree(layouts, tmp_path / "layouts")
    shutil.rmtree(tmp_path / "layouts" / "bop")
    assert [each.message for each in verify_dataset(tmp_path / "layouts")] == ["the folder `bop` is missing"]
    (tmp_path / "a.scene").write_text('(param n 1)\n(bind "a" (lambda () (call "cube")))')
    spec = tmp_path / "leak.toml"
    spec.write_text(
        "programs = 'a.scene'\ncount = 8\n[params]\nn = [1, 2]\n[pictures]\nsize = 8\n[splits]\nby = 'n'\ntrain = [1]\ntest = [2]"
    )
    dataset(spec, tmp_path / "leak", jobs=0)
    assert any("which leaks" in each.message for each in verify_dataset(tmp_path / "leak"))


def test_equal_pictures_of_other_seeds_are_duplicates(tmp_path: Path) -> None:
    """A scene without random draws, whose samples differ in the seed only."""
    spec = _failing(tmp_path, '(bind "a" (lambda () (call "cube")))', "[cameras]\nazimuth = 0\nelevation = 10")
    spec.write_text(spec.read_text().replace("count = 8", "count = 3"))
    dataset(spec, tmp_path / "out", jobs=0)
    assert [each.message for each in verify_dataset(tmp_path / "out")] == [
        f"00000000{n} repeats 000000000: equal pictures" for n in (1, 2)
    ]


def test_equal_frames_and_views_of_one_sample_are_no_duplicates(tmp_path: Path) -> None:
    text = '(bind "a" (lambda () (frames (list (call "sphere") (call "sphere")))))'
    spec = _failing(tmp_path, text, "[cameras]\nkind = 'orbit'\nazimuth = 0\nviews = 2\nsweep = 0")
    spec.write_text(spec.read_text().replace("count = 8", "count = 1"))
    dataset(spec, tmp_path / "out", jobs=0)
    assert [each.message for each in verify_dataset(tmp_path / "out") if "pictures" in each.message] == []


@pytest.mark.slow
def test_programs_that_never_end_are_ended(tmp_path: Path) -> None:
    spec = _failing(tmp_path, HOSTILE, "[params]\nn = [0, 1]\n[limits]\nseconds = 0.5\nsteps = 1000000000")
    report = dataset(spec, tmp_path / "out", jobs=2)
    assert report.is_complete
    assert 0 < sum(report.failures.values()) < 8
    assert set(report.failures) == {"E507"}


@pytest.mark.slow
def test_a_sample_that_kills_its_worker_is_given_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from scenelang.datasets import working

    code = (
        "import os, scenelang.datasets.making as m; old = m.Maker.make\n"
        "def make(self, index):\n    if index == 5: os._exit(9)\n    return old(self, index)\n"
        "m.Maker.make = make\nfrom scenelang.datasets.working import serve; serve()"
    )
    monkeypatch.setattr(working, "_CODE", code)
    spec = _failing(tmp_path, '(bind "a" (lambda () (call "cube")))', "[output]\nshard = 4")
    report = dataset(spec, tmp_path / "out", jobs=2)
    assert report.is_complete
    assert [each["key"] for each in report.failed] == ["000000005"]
    assert "ended 3 times at this sample (exit status 9)" in report.failed[0]["message"]


# --- commands --------------------------------------------------------------------------------------------------------


def test_the_commands(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    spec, out = str(folder / "spec.toml"), str(tmp_path / "out")
    assert main(["dataset", spec, "-o", out, "--count", "4"]) == 0
    told = capsys.readouterr()
    assert told.out.startswith("4 of 4 samples, 4 pictures (")
    assert told.err == ""
    assert main(["dataset", "status", out, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["is_complete"] is True
    assert main(["dataset", "verify", out]) == 0
    assert capsys.readouterr().out == f"{out} is complete and sound\n"
    assert main(["dataset", "sample", spec, "000000002", "-o", str(tmp_path / "one"), "-q"]) == 0
    assert (tmp_path / "one" / "000000002.color.png").is_file()
    shutil.rmtree(tmp_path / "out" / "shards")
    assert main(["dataset", "verify", out]) == 1
    assert "2 of 2 shards are missing: 0, 1" in capsys.readouterr().err
    assert main(["dataset", spec, "-o", out, "--count", "4", "--resume"]) == 0
    assert main(["dataset", "merge", out, "-o", str(tmp_path / "merged")]) == 0


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["{spec}"], "expected `dataset SPEC -o OUT`"),
        (["{spec}", "{spec}", "-o", "x"], "expected `dataset SPEC -o OUT`"),
        (["status"], "expected `dataset status DIR`"),
        (["merge", "x"], "expected `dataset merge DIR... -o OUT`"),
        (["sample", "{spec}", "-o", "x"], "expected `dataset sample SPEC KEY -o OUT`"),
        (["{spec}", "-o", "x", "--part", "2/2"], "expected K/N with K from 0 to N - 1"),
        (["{spec}", "-o", "x", "--jobs", "2000"], "`jobs`: expected 0 to 1,024"),
        (["{spec}", "--preview", "x.png", "--shown", "0"], "a preview shows 1 to 400 samples"),
        (["{spec}", "--preview", "x.png", "-o", "x"], "`--preview` writes a contact sheet only"),
        (["{spec}", "--preview", "x.txt"], "a preview cannot be written as `x.txt`"),
        (["{spec}", "--preview", "sheet"], "use .png .jpg .jpeg .webp"),
    ],
)
def test_wrong_usage_exits_with_2(
    folder: Path, words: list[str], told: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    spec = str(folder / "spec.toml")
    try:
        code = main(["dataset", *(word.replace("{spec}", spec) for word in words)])
    except SystemExit as stop:
        code = int(stop.code or 0)
    assert code == 2
    assert told in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_wrong_spec_exits_with_1(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "bad.toml").write_text("programs = 'x'\n")
    assert main(["dataset", str(tmp_path / "bad.toml"), "-o", str(tmp_path / "out")]) == 1
    assert f"{tmp_path}/bad.toml:1:1" in capsys.readouterr().err
    assert main(["dataset", str(tmp_path / "none.toml"), "-o", str(tmp_path / "out")]) == 1


@pytest.mark.parametrize(("package", "words"), [("ray", ["--ray", "auto"]), ("pyarrow", [])])
def test_a_missing_extra_names_its_installation(
    folder: Path, tmp_path: Path, package: str, words: list[str], monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    monkeypatch.setitem(sys.modules, package, None)
    text = (folder / "spec.toml").read_text()
    spec = folder / f"without-{package}.toml"
    spec.write_text(text + ('formats = "parquet"\n' if package == "pyarrow" else ""))
    assert main(["dataset", str(spec), "-o", str(tmp_path / "out"), *words]) == 1
    extra = {"ray": "cluster", "pyarrow": "datasets"}[package]
    assert f"install it with `pip install 'scenelang[{extra}]'`" in capsys.readouterr().err


def test_the_preview_shows_samples_and_what_varies(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from PIL import Image

    out = tmp_path / "sheet.png"
    assert main(["dataset", str(folder / "spec.toml"), "--preview", str(out), "--shown", "3", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["samples"] == 3
    assert set(told["varied"]) >= {"param.balls", "ball.roughness", "environment", "camera.azimuth", "split"}
    assert sum(told["varied"]["param.balls"].values()) == 10
    with Image.open(out) as sheet:
        assert (sheet.format, sheet.width > 700) == ("PNG", True)
    assert main(["dataset", str(folder / "spec.toml"), "--preview", str(tmp_path / "x.jpg"), "--shown", "1"]) == 0
    assert "  split (approximate): " in capsys.readouterr().out  # splits by scene are not those of the draws
    with Image.open(tmp_path / "x.jpg") as sheet:
        assert sheet.format == "JPEG"


def test_the_preview_explains_its_colors_and_shows_all_that_is_written(folder: Path, tmp_path: Path) -> None:
    from PIL import Image

    from scenelang.backends.labels.dataset import instance_color, word_color
    from scenelang.datasets.describing import _row, preview_dataset
    from scenelang.datasets.running import dataset_sample

    spec = tmp_path / "all.toml"
    text = (folder / "moving.toml").read_text().replace('"flow",', '"flow", "semantic", "captions",')
    spec.write_text(text.replace('"cart.scene"', f'"{folder}/cart.scene"'))
    found = dataset_sample(spec, "000000000-f0000")
    row = _row("x", {name.partition(".")[2]: data for name, data in found.items()})
    titles = [
        "x",
        "boxes",
        "depth",
        "flow",
        "flow_state, orange: hidden",
        "instance",
        "semantic",
        "tracks of all frames",
    ]
    assert [title for title, _ in row.tiles] == titles
    assert {picture.shape for _, picture in row.tiles} == {(96, 128, 3)}  # 48 x 64, enlarged by a whole number
    tiles = dict(row.tiles)
    assert row.words == {word: word_color(word) for word in ("cube", "wheel")}
    colors = {tuple(color) for color in tiles["semantic"].reshape(-1, 3).tolist()}
    assert colors == {(0, 0, 0), *row.words.values()}
    instances, caption = row.lines
    assert sorted(instances[1:]) == sorted(zip(("wheel", "cube", "cube"), map(instance_color, (1, 2, 3)), strict=True))
    assert {tuple(color) for color in tiles["instance"].reshape(-1, 3).tolist()} == {
        (0, 0, 0),
        *(c for _, c in instances[1:]),
    }
    assert caption == [("caption: 1 wheel and 2 cubes", None)]
    assert (tiles["tracks of all frames"] != tiles["x"]).any()
    preview_dataset(spec, tmp_path / "sheet.png", 1)
    with Image.open(tmp_path / "sheet.png") as sheet:
        shown = {color for _, color in sheet.getcolors(1 << 24)}
    assert shown >= {*row.words.values(), *(color for _, color in instances[1:])}


def test_a_list_of_words_tells_what_it_leaves_out() -> None:
    from scenelang.datasets.describing import _wrapped

    words = [(f"word{i}", (0, 0, 0)) for i in range(100)]
    lines = _wrapped(words, 300, 2)
    assert len(lines) == 2
    named = sum(len(line) for line in lines) - 1
    assert lines[-1][-1] == (f"and {100 - named} more", None)
    assert _wrapped(words[:3], 300, 2) == [words[:3]]
    assert _wrapped([("w" * 500, None)], 300, 2) == [[("w" * 500, None)]]


def test_a_key_above_the_count_is_told(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for key in ("000000010", "000000010-v001", "999999999999"):
        assert main(["dataset", "sample", str(folder / "spec.toml"), key, "-o", str(tmp_path / "one")]) == 1
        told = capsys.readouterr().err
        assert f"`{key}`: there are 10 samples, up to 000000009" in told
        assert "raise the count of the spec, or give `--count`: it changes no sample" in told
    assert not (tmp_path / "one").exists()


def test_progress_is_one_line() -> None:
    from io import StringIO

    from scenelang.datasets.running import progress_text

    stream = StringIO()
    show = progress_text(stream)
    show(DatasetProgress(1, 4, 0, {}, 2.0, 1.5, 0))
    show(DatasetProgress(4, 4, 0, {"E502": 1}, 2.0, 0.0, 3_000_000))
    lines = stream.getvalue().split("\r")
    assert lines[1] == "1 of 4 samples, 2.0 per second, 0:00:02 left"
    assert lines[2] == "4 of 4 samples, 2.0 per second, 1 failed (E502: 1), 3 MB per worker\n"
