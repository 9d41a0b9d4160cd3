"""Commands that are ended or cannot write: what they were to make is absent, as it was, or whole; the next run leaves no
temporary files; nobody sees a traceback."""

from __future__ import annotations

import ctypes
import json
import os
import random
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import copies
import pytest
from hostile.measuring import children
from PIL import Image
from safetensors import safe_open
from support import is_running, wait_until

from scenelang.sandbox.supervision import is_supported

pytestmark = pytest.mark.skipif(not is_supported(), reason="needs Linux")
SCENE = """(bind "ball" (lambda (:n) (call "sphere" :radius (+ .2 (/ n 100)) :color [1 0 0])))
(bind "top" (lambda () (union-loop 150 (lambda (i) (transform (call "ball" :n i) (translate [(% i 12) (// i 12) 0]))))))
"""


@dataclass(frozen=True)
class Job:
    """A command, what it makes, and whether that is whole."""

    words: tuple[str, ...]
    made: str
    is_whole: Callable[[Path], bool]


def picture(path: Path) -> bool:
    with Image.open(path) as image:
        image.load()
        return image.size == (96, 96)


def glb(path: Path) -> bool:
    data = path.read_bytes()
    return data[:4] == b"glTF" and int.from_bytes(data[8:12], "little") == len(data)


def maps(path: Path) -> bool:
    for file in path.rglob("*"):
        if any(part.startswith(".") for part in file.relative_to(path).parts):  # temporary: the next run removes it
            continue
        if file.suffix == ".png":
            with Image.open(file) as image:
                image.load()
        elif file.suffix == ".json":
            json.loads(file.read_text())
    return True


def z(path: Path) -> bool:
    with safe_open(str(path), framework="numpy") as file:
        return "scenelang" in file.metadata()


JOBS = {
    "render": Job(("render", "a.scene", "-o", "out.png", "--quality", "draft", "--size", "96x96"), "out.png", picture),
    "export": Job(("export", "a.scene", "-o", "out.glb"), "out.glb", glb),
    "labels": Job(("labels", "a.scene", "-o", "out", "--size", "64x64"), "out", maps),
    "embeddings": Job(("embeddings", "a.scene", "set", "z1", "--text", "an old oak"), "a.z.safetensors", z),
}


# Python keeps bytecode that a limit has cut short, and fails whenever it reads it.
NO_BYTECODE = {**os.environ, "PYTHONDONTWRITEBYTECODE": "1"}


def heed() -> None:
    """Take SIGINT, which is ignored in what a script runs in the background, as tests may be."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


def limit_files() -> None:
    """Let no file grow past 20 bytes."""
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (20, 20))


def start(job: Job, folder: Path, **options: object) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-P", "-m", "scenelang", *job.words]
    pipe = subprocess.PIPE
    settings = {"stdout": pipe, "stderr": pipe, "preexec_fn": heed, **options}
    return subprocess.Popen(command, cwd=folder, **settings)  # type: ignore[call-overload, no-any-return]


def prepared(folder: Path) -> Path:
    folder.mkdir(exist_ok=True)
    (folder / "a.scene").write_text(SCENE)
    return folder


def check(job: Job, folder: Path, said: bytes) -> None:
    """After a fault: nothing half-written, and the next run works and leaves nothing else."""
    assert b"Traceback" not in said, said
    assert b"internal error" not in said, said
    made = folder / job.made
    assert not made.exists() or job.is_whole(made)
    done = copies.command(*job.words, folder=folder)
    assert done.returncode == 0, done.stderr
    assert job.is_whole(made)
    left = {path.name for path in folder.iterdir()} - {"a.scene", job.made}
    assert not {name for name in left if not name.endswith(".lock")}, left


def ended(job: Job, folder: Path, whom: str, number: int, delay: float) -> None:
    running = start(job, folder)
    time.sleep(delay)
    below = children(running.pid)
    pids = {"parent": [running.pid], "child": below[:1], "both": [running.pid, *below[:1]]}[whom]
    for pid in pids:
        try:
            os.kill(pid, number)
        except ProcessLookupError:
            pass
    _, err = running.communicate()
    wait_until(lambda: not any(map(is_running, below)))  # what the parent leaves ends with it
    check(job, folder, err)


@pytest.fixture(scope="module")
def usual(tmp_path_factory: pytest.TempPathFactory) -> float:
    """Seconds that a command takes without a fault."""
    folder = prepared(tmp_path_factory.mktemp("usual"))
    begin = time.monotonic()
    start(JOBS["export"], folder).communicate()
    return time.monotonic() - begin


FEW = [("render", "Ctrl-C"), ("embeddings", "kill both")]
FAULTS = {
    "Ctrl-C": ("parent", signal.SIGINT), "kill parent": ("parent", signal.SIGKILL), "kill child": ("child", signal.SIGKILL),
    "kill both": ("both", signal.SIGKILL), "SIGTERM": ("parent", signal.SIGTERM),
}  # fmt: skip


@pytest.mark.parametrize(("name", "fault"), FEW)
@pytest.mark.sampled(2)
def test_an_ending_leaves_nothing_half_done(name: str, fault: str, tmp_path: Path, usual: float) -> None:
    whom, number = FAULTS[fault]
    ended(JOBS[name], prepared(tmp_path), whom, number, usual * 0.8)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("name", JOBS)
def test_an_ending_at_any_moment(name: str, fault: str, seed: int, tmp_path: Path, usual: float) -> None:
    whom, number = FAULTS[fault]
    delay = random.Random(f"{name} {fault} {seed}").uniform(0.1, 1.3) * usual
    ended(JOBS[name], prepared(tmp_path), whom, number, delay)


@pytest.mark.parametrize(
    "name", ["export", *(pytest.param(name, marks=pytest.mark.slow) for name in JOBS if name != "export")]
)
def test_a_full_disk(name: str, tmp_path: Path) -> None:
    """No file may grow past 20 bytes."""
    prepared(tmp_path)
    running = start(JOBS[name], tmp_path, preexec_fn=limit_files, env=NO_BYTECODE)
    _, err = running.communicate()
    assert running.returncode == 1, err
    assert err
    assert not (tmp_path / JOBS[name].made).is_file()
    check(JOBS[name], tmp_path, err)


def read_only(folder: Path) -> None:
    """Let this process see ``folder`` without writing to it; rights of files do not hold back the superuser."""
    libc = ctypes.CDLL(None, use_errno=True)
    name = str(folder).encode()
    new_names, private, bind, again = 0x20000, 1 << 18 | 1 << 14, 1 << 12, 1 << 12 | 1 << 5 | 1
    steps = (
        lambda: libc.unshare(new_names), lambda: libc.mount(b"none", b"/", None, private, None),
        lambda: libc.mount(name, name, None, bind, None), lambda: libc.mount(b"none", name, None, again, None),
    )  # fmt: skip
    if any(step() for step in steps):
        os._exit(99)
    os.chdir(folder)  # the folder that it was in is not the one that was put over it


@pytest.mark.parametrize("name", JOBS)
@pytest.mark.sampled(4)
def test_a_folder_that_may_only_be_read(name: str, tmp_path: Path) -> None:
    prepared(tmp_path)
    as_root = os.getuid() == 0
    tmp_path.chmod(0o555)
    try:
        running = start(JOBS[name], tmp_path, preexec_fn=(lambda: read_only(tmp_path)) if as_root else None)
        _, err = running.communicate()
    finally:
        tmp_path.chmod(0o755)
    if running.returncode == 99:
        pytest.skip("this process may not make folders read-only")
    assert running.returncode == 1, err
    assert b"error[E" in err
    check(JOBS[name], tmp_path, err)


@pytest.mark.parametrize("kind", ["closed pipe", "full"])
def test_output_that_nobody_takes(kind: str, tmp_path: Path) -> None:
    prepared(tmp_path)
    reading, writing = os.pipe()
    os.close(reading)
    if kind == "full":
        os.close(writing)
        writing = os.open("/dev/full", os.O_WRONLY)
    running = start(Job(("flatten", "a.scene", "--json"), "", bool), tmp_path, stdout=writing)
    os.close(writing)
    _, err = running.communicate()
    assert running.returncode in (0, 1, 141)
    assert b"Traceback" not in err
    assert b"internal error" not in err
    assert b"Exception ignored" not in err
    assert [path.name for path in tmp_path.iterdir()] == ["a.scene"]
