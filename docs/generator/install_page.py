"""The page Install: ways to install the package, and its extras as ``pyproject.toml`` declares them."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

from generator.markdown import NOTICE, table

PROJECT = Path(__file__).parents[2] / "pyproject.toml"
_OF_DEVELOPMENT = ("dev", "blender", "site", "view")

# Megabytes on disk with bytecode, of what the extra adds to the core: Linux x86-64, Python 3.11, versions of
# constraints.txt, November 2026. PyTorch brings CUDA's libraries there.
CORE_MEGABYTES = 136
_SECONDS = "60, 63 and 59"  # venv, pip install and the picture, at a load of 14, November 2026
MEGABYTES = {
    "final": 269, "text": 30, "repl": 18, "meshes": 4, "neural": 6_300, "cuda": 5_700, "lm": 48, "physics": 99,
    "minecraft": 143, "python-libraries": 175, "usd": 218, "draco": 19, "video": 107, "datasets": 178,
    "cluster": 431, "lsp": 3, "mcp": 39, "browser": 174, "notebook": 53, "all": 7_700,
}  # fmt: skip

_BEFORE = """
Python 3.11 or newer, and nothing else: on Linux every package of the core has wheels for 3.11, 3.12 and 3.13. The
**core** is the language, its checker and evaluation, solids, draft pictures, films as GIF and WebP, labels, the
viewer, and exports to JSON, glTF, OBJ, PLY, STL, 3MF and SVG. It takes {core} MB. What needs more packages is an
[extra](#extras), and says in one line what to install when it is asked for:

```text
$ scenelang render pawns.scene --quality final
error[E705]: the package `mitsuba` cannot be imported: No module named 'mitsuba'
  hint: install it with `pip install 'scenelang[final]'`
```

## From a checkout or a wheel

```sh
pip install .                      # in the folder of the repository, or the name of a wheel
scenelang doctor                   # what works here, what is missing and how to get it
scenelang render examples/chessboard.scene -o chessboard.png --quality draft
```

`-c constraints.txt` takes the versions that the tests ran with. `pipx install .` gives the command an environment of
its own, to which `pipx inject scenelang PACKAGE` adds packages. `make demo` in a fresh clone does all of this in
`.venv`.

From nothing to the first picture, with an environment, downloads from a mirror nearby, and a draft of the chess set
in 800x600 pixels, it takes {seconds} s with Python 3.11, 3.12 and 3.13 on two cores that were busy with seven times
their work; the picture is 8 s of it.

## Docker

The `Dockerfile` makes an image of the core and path tracing, whose command is `scenelang`, run as a user without
rights:

```text
docker build -t scenelang .
docker run --rm -v "$PWD:/scenes" --user "$(id -u)" scenelang render pawns.scene --quality final
```

## Editors

```sh
pip install '.[lsp]'
```

adds the language server, `scenelang lsp`, for [any editor](editors.md) that speaks the protocol. The extension for VS
Code is in `editors/vscode`; its README says how to build it.

## Extras

`pip install '.[final,text]'` in a checkout, or `pip install 'scenelang[final,text]'` where the package is installed,
adds extras to it. MB are what an extra adds to the core on Linux with Python 3.11; extras share packages. `neural` is
that large because PyTorch brings the libraries of CUDA.
""".strip()

_AFTER = """
## When something does not work

`scenelang doctor` tests every feature in a process of its own, and ends with the commands that install what is
missing. `scenelang doctor --json` is for reports of bugs.

| it says | so |
|---|---|
| `no` beside an extra or a format | it is not installed; the line ends with the command. Nothing else depends on it |
| `BROKEN` | a part that always has to work does not: `pip install --force-reinstall scenelang` |
| `mitsuba llvm`: LLVM not found | path tracing works, slower for large pictures; in Debian: `libllvm19` |
| `processes`: soft limits only | run no strangers' programs on this system ([security](security.md)) |
| `cache` is not writable | set `XDG_CACHE_HOME` to a folder of your own |

`scenelang: command not found` after an installation means that the folder of commands is not on the `PATH`: activate
the environment (`. .venv/bin/activate`), or run `python -m scenelang`.
""".strip()

_FIRST = re.compile(r"^(?P<name>[a-z-]+) = \[.*?(?:#\s*(?P<comment>.*))?$")


def extras() -> dict[str, tuple[str, tuple[str, ...]]]:
    """What each extra is for, the comment at its first line in ``pyproject.toml``, and the packages it names."""
    text = PROJECT.read_text("utf-8")
    named = tomllib.loads(text)["project"]["optional-dependencies"]
    lines = text.partition("[project.optional-dependencies]")[2].partition("\n[")[0].splitlines()
    found = [match for line in lines if (match := _FIRST.match(line))]
    return {each["name"]: (each["comment"] or "", tuple(named[each["name"]])) for each in found}


def install_page() -> str:
    """The page, Markdown."""
    before = _BEFORE.format(core=CORE_MEGABYTES, seconds=_SECONDS)
    return "\n".join(["# Install", "", NOTICE, "", before, "", *_rows(), _AFTER, ""])


def _rows() -> Iterator[str]:
    """The lines of the table of extras."""
    users = {name: row for name, row in extras().items() if name not in _OF_DEVELOPMENT}
    yield from table(
        ("extra", "for", "packages", "MB"),
        [(f"`{name}`", purpose, _packages(named), f"{MEGABYTES[name]:,}") for name, (purpose, named) in users.items()],
    )


def _packages(named: tuple[str, ...]) -> str:
    """Names of packages without versions; extras of ours in words."""
    if len(named) == 1 and named[0].startswith("scenelang["):
        return "those of the others"
    return ", ".join(re.split(r"[<>=;\[ ]", each)[0] for each in named if not each.startswith("scenelang["))
