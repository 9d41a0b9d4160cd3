"""Completion in the shell: what a shell is told that asks, as argcomplete's code asks, and the code itself in bash."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import copies
import pytest

from scenelang.cli.main import COMMANDS, main
from scenelang.cli.programs import SHELLS

SCENE = '(bind "light house" (lambda () (call "cube")))\n(bind "boat" (lambda () (call "sphere")))\n'
BREAKS = " \t\n\"'><=;|&(:"  # bash's COMP_WORDBREAKS

# What stands on the line, and what is among the completions of its last word and what is not.
LINES = {
    "commands": ("ren", {"render"}, {"check"}),
    "all commands": ("", set(COMMANDS), {"--help"}),
    "options": ("render a.scene --q", {"--quality", "--quiet"}, {"--root"}),
    "options of shared groups": ("check a.scene --max-s", {"--max-steps", "--max-seconds", "--max-size"}, {"--seed"}),
    "options of backends": ("render a.scene --sampl", {"--samples"}, set()),
    "choices": ("render a.scene --quality ", {"draft", "final"}, {"a.scene"}),
    "choices of backends": ("render a.scene --variant ", {"auto", "cuda"}, {"a.scene"}),
    "values that are known": ("render --environment sun", {"sunny", "sunset"}, {"night"}),
    "grounds": ("render --ground me", {"meadow"}, {"earth"}),
    "backends": ("export a.scene --backend gl", {"gltf"}, {"draft"}),
    "cameras": ("render --camera t", {"turntable", "top"}, {"follow"}),
    "positional choices": ("completion ", set(SHELLS), {"a.scene"}),
    "commands of commands": ("embeddings a.scene ", {"list", "set"}, {"b.scene"}),
    "options of commands of commands": ("embeddings a.scene set --t", {"--text"}, {"--root"}),
    "programs": ("check ", {"a.scene", "b.scene", "sub/"}, {"notes.md"}),
    "several programs": ("check a.scene b", {"b.scene"}, {"notes.md", "a.scene"}),
    "programs in folders": ("check sub/", {"sub/c.scene"}, {"sub/c.md"}),
    "any file": ("render a.scene -o no", {"notes.md"}, {"a.scene"}),
    "folders": ("labels a.scene -o ", {"sub/"}, {"a.scene", "notes.md"}),
    "embeddings": ("run a.scene --z ", {"a.z.safetensors"}, {"a.scene"}),
    "words": ("render a.scene --root bo", {"boat"}, {"light house"}),
    "words of no program": ("render --root bo", set(), {"boat"}),
    "codes": ("explain E30", {"E301", "E305"}, {"E401"}),
    "codes by name": ("explain unb", {"unbound"}, {"E401"}),
    "nothing of no command": ("sing a", set(), {"a.scene"}),
}  # fmt: skip


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "sub").mkdir()
    for name in ("a.scene", "b.scene", "sub/c.scene"):
        (tmp_path / name).write_text(SCENE, "utf-8")
    for name in ("notes.md", "a.z.safetensors", "sub/c.md"):
        (tmp_path / name).write_text("", "utf-8")
    return tmp_path


def asked(shell: str, line: str, folder: Path, behind: str = "") -> set[str]:
    """What a shell is told whose cursor stands between ``line`` and what is ``behind``."""
    line = f"scenelang {line}"
    separator = "\n" if shell == "fish" else "\013"
    told = folder / "told"
    variables = {
        "_ARGCOMPLETE": "1",
        "_ARGCOMPLETE_SHELL": shell,
        "_ARGCOMPLETE_SUPPRESS_SPACE": "1",
        "_ARGCOMPLETE_IFS": separator,
        "_ARGCOMPLETE_STDOUT_FILENAME": str(told),
        "COMP_LINE": line + behind,
        "COMP_POINT": str(len(line)),
        "COMP_TYPE": "9",
        **({"_ARGCOMPLETE_COMP_WORDBREAKS": BREAKS} if shell == "bash" else {}),
        **({"_ARGCOMPLETE_DFS": "\t"} if shell == "fish" else {}),
    }
    with pytest.MonkeyPatch.context() as patch:
        for name, text in variables.items():
            patch.setenv(name, text)
        answer = copies.command(folder=folder)
    assert (answer.returncode, answer.stdout, answer.stderr) == (0, "", "")
    offered = [each for each in told.read_text("utf-8").split(separator) if each]
    described = {"zsh": r"(?<!\\):.*", "fish": r"\t.*"}.get(shell)
    return {re.sub(described, "", each, flags=re.DOTALL) if described else each for each in offered}


@pytest.mark.parametrize("name", LINES)
@pytest.mark.sampled(2)
def test_what_bash_is_told(name: str, folder: Path) -> None:
    line, wanted, unwanted = LINES[name]
    found = asked("bash", line, folder)
    assert wanted <= found
    assert not unwanted & found


@pytest.mark.parametrize("shell", ["zsh", "fish"])
@pytest.mark.parametrize("name", ["commands", "options", "programs", "words", "codes"])
def test_what_other_shells_are_told(shell: str, name: str, folder: Path) -> None:
    line, wanted, unwanted = LINES[name]
    found = asked(shell, line, folder)
    assert wanted <= found
    assert not unwanted & found


@pytest.mark.slow
def test_words_are_quoted_and_equals_signs_known(folder: Path) -> None:
    assert asked("bash", "render a.scene --root ", folder) == {"boat", "light\\ house"}
    assert asked("bash", 'render a.scene --root "li', folder) == {"light house"}
    assert asked("bash", "render a.scene --quality=", folder) == {"draft", "final"}
    assert asked("bash", "render a.scene --quality=f", folder) == {"final"}
    assert asked("fish", "render a.scene --root l", folder) == {"light house"}


def test_programs_behind_the_cursor_count(folder: Path) -> None:
    assert asked("bash", "render --root b", folder, " a.scene") == {"boat"}


def test_commands_are_described(folder: Path) -> None:
    """zsh and fish show the line of help."""
    told = folder / "told"
    asked("fish", "ren", folder)
    assert told.read_text("utf-8") == f"render\t{COMMANDS['render'].help}"


def test_a_parser_imports_nothing_heavy() -> None:
    """A shell waits, and so does everybody who starts a command."""
    code = (
        "import sys, scenelang.console.shell_completion; from scenelang.cli.main import build_parser\n"
        "build_parser('check'); first = {'numpy', 'lark'} & set(sys.modules)\n"
        "build_parser(); print(sorted(first | {'torch', 'diffusers', 'open_clip', 'mitsuba', 'PIL'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def printed(shell: str) -> str:
    command = [sys.executable, "-P", "-m", "scenelang", "completion", shell]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


@pytest.mark.skipif(shutil.which("bash") is None, reason="bash is not installed")
def test_bash_completes_by_the_code_that_is_printed(folder: Path) -> None:
    command = folder / "bin" / "scenelang"
    command.parent.mkdir()
    command.write_text(f'#!/bin/sh\nexec {sys.executable} -P -m scenelang "$@"\n', "utf-8")
    command.chmod(0o755)
    line = "scenelang render a.scene --quality "
    code = (
        f"{printed('bash')}\nCOMP_LINE='{line}' COMP_POINT={len(line)} COMP_TYPE=9\n"
        "complete -p scenelang scene >&2; _python_argcomplete scenelang; printf '%s\\n' \"${COMPREPLY[@]}\""
    )
    path = f"{command.parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        ["bash", "--norc", "-c", code], cwd=folder, env=os.environ | {"PATH": path}, capture_output=True, text=True
    )
    assert set(done.stdout.split()) == {"draft", "final"}
    assert done.stderr.count("_python_argcomplete") == 2


@pytest.mark.parametrize("shell", SHELLS)
def test_the_code_parses(shell: str, tmp_path: Path) -> None:
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed")
    path = tmp_path / f"script.{shell}"
    path.write_text(printed(shell), "utf-8")
    done = subprocess.run([shell, "-n", str(path)], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("shell", SHELLS)
def test_the_code_is_for_both_names(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", shell]) == 0
    text = capsys.readouterr().out
    assert re.search(r"\bscenelang\b", text)
    assert re.search(r"\bscene\b", text)


def test_an_unknown_shell_is_wrong_usage(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(["completion", "cmd"])
    assert stopped.value.code == 2
    assert "fish" in capsys.readouterr().err
