"""The command completion: its scripts, in the shells themselves where these are installed."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from scenelang.cli.main import build_parser, main
from scenelang.cli.servers import SHELLS, script
from scenelang.shell_completion import Values, commands_of, subcommands

SCENE = '(bind "light house" (lambda () (call "cube")))\n(bind "boat" (lambda () (call "sphere")))\n'

# What stands on the line, the last word being completed, and what is among the completions and what is not.
LINES = {
    "commands": (["ren"], {"render"}, {"check"}),
    "all commands": ([""], {"render", "check", "completion", "doctor"}, set()),
    "options": (["render", "a.scene", "--q"], {"--quality", "--quiet"}, {"--root"}),
    "options of backends": (["render", "a.scene", "--sampl"], {"--samples"}, set()),
    "choices": (["render", "a.scene", "--quality", ""], {"draft", "final"}, {"a.scene"}),
    "values that are known": (["render", "--environment", "sun"], {"sunny", "sunset"}, {"night"}),
    "positional choices": (["completion", ""], set(SHELLS), {"a.scene"}),
    "commands of commands": (["embeddings", "a.scene", ""], {"list", "set"}, {"b.scene"}),
    "programs": (["check", ""], {"a.scene", "b.scene"}, {"notes.md"}),
    "several programs": (["check", "a.scene", "b"], {"b.scene"}, {"notes.md"}),
    "any file": (["render", "a.scene", "-o", "no"], {"notes.md"}, {"a.scene"}),
    "words": (["render", "a.scene", "--root", "bo"], {"boat"}, {"light house"}),
    "codes": (["explain", "E30"], {"E301", "E305"}, {"E401"}),
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "a.scene").write_text(SCENE, "utf-8")
    (tmp_path / "b.scene").write_text(SCENE, "utf-8")
    (tmp_path / "notes.md").write_text("", "utf-8")
    return tmp_path


def in_bash(words: list[str], folder: Path) -> set[str]:
    """What bash would offer, from the function that the script registers."""
    listed = " ".join(f"'{word}'" for word in ["scenelang", *words])
    code = (
        f"{script('bash')}\nCOMP_WORDS=({listed}); COMP_CWORD={len(words)}\n_scenelang\n"
        "printf '%s\\n' \"${COMPREPLY[@]}\""
    )
    return ran(["bash", "--norc", "-c", code], folder)


ZSH_SETUP = """
autoload -Uz compinit; compinit -u -D
zstyle ':completion:*' insert-tab false
compadd() {  # what is offered goes to a file, and is offered
  local -a hits
  if [[ " ${(j: :)@[1,(i)--]} " == *" -"[OAD]" "* ]]; then builtin compadd "$@"; return; fi
  builtin compadd -A hits "$@"
  print -rl -- $hits >> offered
  builtin compadd "$@"
}
finished() { print done > finished }
comppostfuncs=(finished)
bindkey '^I' complete-word
"""


def in_zsh(words: list[str], folder: Path) -> set[str]:
    """What zsh would offer: a shell in a terminal of its own, and a Tab."""
    (folder / "_scenelang").write_text(script("zsh"), "utf-8")
    (folder / "setup.zsh").write_text(ZSH_SETUP, "utf-8")
    code = f"""
zmodload zsh/zpty
zpty shell "zsh -f -i"
zpty -w shell "cd {folder}; fpath=({folder} \\$fpath); source ./setup.zsh"
zpty -w -n shell $'scenelang {" ".join(words)}\\t'
for i in {{1..300}}; do zpty -r -t shell piece; [[ -f finished ]] && break; sleep 0.05; done
zpty -d shell
"""
    ran(["zsh", "-f", "-c", code], folder)
    assert (folder / "finished").exists()
    offered = folder / "offered"
    return set(offered.read_text("utf-8").splitlines()) if offered.exists() else set()


def in_fish(words: list[str], folder: Path) -> set[str]:
    code = f"{script('fish')}\ncomplete -C 'scenelang {' '.join(words)}'"
    found = ran(["fish", "--no-config", "-c", code], folder)
    return {line.split("\t")[0] for line in found}


def ran(command: list[str], folder: Path) -> set[str]:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=60)
    assert done.stderr == ""
    return set(done.stdout.splitlines())


RUNS = {"bash": in_bash, "zsh": in_zsh, "fish": in_fish}


@pytest.mark.parametrize("shell", SHELLS)
@pytest.mark.parametrize("line", LINES)
def test_what_the_shell_offers(shell: str, line: str, folder: Path) -> None:
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed")
    words, wanted, unwanted = LINES[line]
    found = RUNS[shell](words, folder)
    assert wanted <= found
    assert not unwanted & found


def test_bash_quotes_words_and_knows_equals_signs(folder: Path) -> None:
    assert in_bash(["render", "a.scene", "--root", ""], folder) == {"boat", "light\\ house"}
    assert in_bash(["render", "a.scene", "--quality", "="], folder) == {"draft", "final"}
    assert in_bash(["render", "a.scene", "--quality", "=", "f"], folder) == {"final"}


@pytest.mark.parametrize("shell", SHELLS)
def test_the_scripts_parse(shell: str, tmp_path: Path) -> None:
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed")
    path = tmp_path / f"script.{shell}"
    path.write_text(script(shell), "utf-8")
    done = subprocess.run([shell, "-n", str(path)], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("shell", SHELLS)
def test_the_command_prints_every_command_and_option(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", shell]) == 0
    text = capsys.readouterr().out
    for command in commands_of(build_parser(), {}):
        assert command.name in text
        for option in command.options:
            assert all(flag.lstrip("-") in text for flag in option.flags)


def test_the_model_knows_what_values_are() -> None:
    commands = {command.name: command for command in commands_of(build_parser(), {})}
    assert set(commands) == set(subcommands(build_parser()))
    render = {flag: option for option in commands["render"].options for flag in option.flags}
    assert render["--root"].values is Values.WORDS
    assert render["--quiet"].values is Values.NONE
    assert render["--z"].endings == ("safetensors",)
    assert render["--seed"].values is Values.ANY
    assert commands["check"].positionals[0].repeats
    assert commands["maps"].options


def test_an_unknown_shell_is_wrong_usage(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(["completion", "cmd"])
    assert stopped.value.code == 2
    assert "fish" in capsys.readouterr().err
