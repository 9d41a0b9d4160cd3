"""Where the game's looks are on this machine: what the user names, else the usual places."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from pathlib import Path

from scenelang.backends.deepslate.layers import Layer, layer_at, number_of
from scenelang.grammar.diagnostics import SceneError

VARIABLE = "SCENELANG_MINECRAFT"
_PACKAGE = Path("node_modules/minecraft-assets")
HINT = (
    "install the game and start it once, or give `--textures PATH`: its jar, a resource pack, or the folder of npm's "
    "minecraft-assets"
)


def layers_for(given: str) -> tuple[Layer, ...]:
    """The sets of looks to read from, the first that has something wins: what is ``given`` (empty: the environment's
    variable), then the usual places, for a resource pack may hold a part only. Raises SceneError("file")."""
    named = given or os.environ.get(VARIABLE, "")
    layers = [layer_at(Path(named).expanduser())] if named else []
    usual = next(_usual(), None)
    if usual is not None:
        layers.append(layer_at(usual))
    if not layers:
        raise SceneError("file", "the game's textures were not found on this machine", hint=HINT)
    return tuple(layers)


def _usual() -> Iterator[Path]:
    """What there is in the usual places, the newest version of the game first."""
    jars = [path for path in (_game() / "versions").glob("*/*.jar") if path.is_file()]
    yield from sorted(jars, key=lambda path: number_of(path.stem), reverse=True)
    for folder in (Path.cwd(), Path.home()):
        if (folder / _PACKAGE).is_dir():
            yield folder / _PACKAGE


def _game() -> Path:
    """The game's folder."""
    if sys.platform == "win32":
        return Path(os.environ.get("APPDATA", "~")).expanduser() / ".minecraft"
    if sys.platform == "darwin":
        return Path.home() / "Library/Application Support/minecraft"
    return Path.home() / ".minecraft"
