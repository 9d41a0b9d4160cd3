"""What a user meets at the edges: folders, pipes, closed streams, Ctrl-C at any moment, two commands at once."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import pytest
from safetensors.numpy import save_file
from support import interruptible, wait_until, worked_in_all

import scenelang as sl
from scenelang.backends.files import atomic_write, read_regular
from scenelang.cli.main import main
from scenelang.files.zfile import read_z, set_entry
from scenelang.grammar.diagnostics import SceneError

CUBE = '(bind "a" (lambda () (call "cube")))\n'
ESCAPES = '(bind "a\x1b[31mred" (lambda () (call "b\x07\x1b]0;title\x07")))\n'


def run(*words: str, cwd: Path, **options: Any) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-P", "-m", "scenelang", *words]
    return subprocess.run(command, cwd=cwd, capture_output=True, text=True, check=False, **options)


# --- files that are none -------------------------------------------------------------------------------------------


def test_folders_are_checked_program_by_program(tmp_path: Path, capsys: Any, monkeypatch: Any) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "deep").mkdir()
    (tmp_path / "a.scene").write_text(CUBE)
    (tmp_path / "deep" / "b.scene").write_text("(no-such-name)")
    assert main(["check", "--json", "."]) == 1
    assert [d["place"]["file"] for d in json.loads(capsys.readouterr().out)] == ["deep/b.scene"]
    for folder in (".", "..", "deep"):
        assert main(["run", folder]) == 1
        said = capsys.readouterr().err
        assert "E701" in said
        assert "internal error" not in said


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes here")
def test_pipes_and_devices_are_refused(tmp_path: Path, capsys: Any, monkeypatch: Any) -> None:
    monkeypatch.chdir(tmp_path)
    os.mkfifo(tmp_path / "pipe.scene")
    os.mkfifo(tmp_path.parent / f"{tmp_path.name}.scene")
    os.mkfifo(tmp_path / "a.z.safetensors")
    os.mkfifo(tmp_path / "camera.json")
    (tmp_path / "b.scene").write_text(CUBE)
    (tmp_path / "a.scene").write_text(CUBE)
    for words in (
        ["run", "pipe.scene"],
        ["check", "pipe.scene"],
        ["fmt", "pipe.scene"],
        ["diff", "pipe.scene", "b.scene"],
        ["run", "/dev/zero"],
        ["run", "a.scene"],
        ["render", "b.scene", "-o", "b.png", "--camera", "camera.json"],
    ):
        assert main(words) in (1, 2), words
        assert "E70" in capsys.readouterr().err, words
    assert main(["check", "b.scene"]) == 0  # the pipes beside it are not opened
    with pytest.raises(OSError, match="not a regular file"):
        read_regular(tmp_path / "pipe.scene")


def test_a_file_of_a_byte_order_mark_alone_is_empty(tmp_path: Path, capsys: Any) -> None:
    path = tmp_path / "a.scene"
    path.write_bytes(b"\xef\xbb\xbf")
    assert main(["check", str(path)]) == 0
    assert main(["fmt", "--check", str(path)]) == 0
    assert main(["run", str(path)]) == 1
    assert "E304" in capsys.readouterr().err


# --- streams and signals -------------------------------------------------------------------------------------------


@pytest.mark.skipif(sys.platform == "win32", reason="closes streams by number")
@pytest.mark.parametrize("closed", [(0,), (1,), (2,), (0, 1, 2)], ids=str)
@pytest.mark.sampled(2)
def test_closed_streams(closed: tuple[int, ...], tmp_path: Path) -> None:
    (tmp_path / "a.scene").write_text(CUBE)
    close = lambda: [os.close(number) for number in closed]
    command = [sys.executable, "-P", "-m", "scenelang", "tree", "a.scene"]
    with subprocess.Popen(command, cwd=tmp_path, stdout=-1, stderr=-1, preexec_fn=close) as running:
        out, err = running.communicate()
    assert running.returncode == 0
    assert b"Traceback" not in err
    assert (b"cube" in out) == (1 not in closed)


@pytest.mark.skipif(not Path("/proc/self/task").is_dir(), reason="nothing tells how far it is")
@pytest.mark.parametrize("moment", [0.12, 0.2, 0.3, 0.45, 0.7])
@pytest.mark.sampled(3)
def test_ctrl_c_in_the_first_second(moment: float, tmp_path: Path) -> None:
    (tmp_path / "a.scene").write_text("(define (f n) (f (+ n 1)))\n(f 0)\n")
    with interruptible(
        [sys.executable, "-P", "-m", "scenelang", "run", "a.scene", "--max-steps", "1000000000000"], tmp_path
    ) as running:
        wait_until(lambda: worked_in_all(running.pid) >= moment)
        if not _has_started(running.pid):
            pytest.skip("Python itself has not started yet")
        running.send_signal(signal.SIGINT)
        _, err = running.communicate()
    assert b"Traceback" not in err
    assert running.returncode == 130


def _has_started(pid: int) -> bool:
    """Whether our code runs: a handler of SIGINT that is ours, or SIGINT blocked."""
    try:
        status = Path(f"/proc/{pid}/maps").read_text()
    except OSError:
        return True
    return "scenelang" in status or "select.cpython" in status or "_datetime" in status


# --- control characters ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "words",
    [["tree"], ["count"], ["run"], ["embed", "--print"], ["graph", "-o", "g.svg"], ["export", "-o", "a.xml"]],
    ids=lambda words: words[0],
)
def test_control_characters_of_words_are_escaped(
    words: list[str], tmp_path: Path, capsys: Any, monkeypatch: Any
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.scene").write_text(ESCAPES)
    assert main([words[0], "a.scene", *words[1:]]) == 0
    texts = [
        capsys.readouterr().out,
        *(path.read_text() for path in tmp_path.iterdir() if path.suffix in (".svg", ".xml")),
    ]
    assert not any("\x1b" in text or "\x07" in text for text in texts)


def test_control_characters_in_lists_of_embeddings(tmp_path: Path, capsys: Any) -> None:
    (tmp_path / "a.scene").write_text(ESCAPES)
    assert main(["embeddings", str(tmp_path / "a.scene"), "set", "<z2>", "--text", "red\x1b[31m"]) == 0
    assert main(["embeddings", str(tmp_path / "a.scene"), "list"]) == 0
    out = capsys.readouterr().out
    assert "\x1b" not in out
    assert "red" in out


# --- files that are written -------------------------------------------------------------------------------------------


def test_no_change_of_embeddings_is_lost(tmp_path: Path) -> None:
    path = tmp_path / "a.z.safetensors"
    threads = [threading.Thread(target=set_entry, args=(path, f"z{n}", f"text {n}", {})) for n in range(1, 25)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert {name: entry.text for name, entry in read_z(path)[0].items()} == {f"z{n}": f"text {n}" for n in range(1, 25)}


def test_what_a_killed_process_left_is_swept(tmp_path: Path) -> None:
    code = "import os, signal, sys\nfrom scenelang.backends.files import atomic_write, atomic_write_all\n"
    code += "with atomic_write('a.txt') as path, atomic_write_all(__import__('pathlib').Path('.')) as folder:\n"
    code += "    path.write_text('half'); (folder / 'x').write_text('x'); os.kill(os.getpid(), signal.SIGKILL)\n"
    done = subprocess.run([sys.executable, "-P", "-c", code], cwd=tmp_path, check=False)
    assert done.returncode == -signal.SIGKILL
    assert len(list(tmp_path.iterdir())) == 2
    with atomic_write(tmp_path / "b.txt") as path:
        path.write_text("whole")
        assert len(list(tmp_path.iterdir())) == 1, "what another process is writing stays, what a dead one wrote goes"
    assert [path.name for path in tmp_path.iterdir()] == ["b.txt"]


BROKEN = {
    "not JSON": ({"scenelang": "{"}, "header entry `scenelang` is not valid JSON"),
    "a list": ({"scenelang": "[]"}, "header entry `scenelang` is not a JSON object"),
    "an entry": ({"scenelang": '{"z1": 3}'}, "entry <z1>: expected a JSON object"),
    "a text": ({"scenelang": '{"z7": {"text": 3}}'}, "entry <z7>: `text` must be a string"),
    "attributes": ({"scenelang": '{"z7": {"attributes": 3}}'}, "entry <z7>: `attributes` must be a JSON object"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_a_broken_file_of_embeddings_says_what_is_broken(name: str, tmp_path: Path) -> None:
    header, said = BROKEN[name]
    path = tmp_path / "a.z.safetensors"
    save_file({}, str(path), metadata=header)
    with pytest.raises(SceneError) as caught:
        read_z(path)
    assert caught.value.name == "z-file"
    assert said in caught.value.message


def test_numbers_that_no_float_holds_are_told() -> None:
    huge = "1" + "0" * 400
    with pytest.raises(sl.SceneError):
        sl.evaluate(f'(bind "a" (lambda () (call "cube" :scale {huge})))')
    scene = sl.evaluate('(bind "a" (lambda () (call "cube")))')
    with pytest.raises(sl.SceneError):
        scene.physics(metres_per_unit=10**400)
    with pytest.raises(sl.SceneError):
        scene.export("a\0.obj")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes with names")
def test_a_file_takes_the_place_of_no_pipe(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "a.obj")
    with pytest.raises(sl.SceneError, match="not a regular file"):
        sl.evaluate('(bind "a" (lambda () (call "cube")))').export(tmp_path / "a.obj")
    assert (tmp_path / "a.obj").is_fifo()
