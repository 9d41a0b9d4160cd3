"""Files of builds read, whatever made them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from scenelang.backends.minecraft.files import litematic, sponge, structure
from scenelang.backends.minecraft.files.damage import Damaged
from scenelang.backends.minecraft.files.loaded import Loaded
from scenelang.backends.minecraft.files.nbt_reader import LARGEST, read_nbt
from scenelang.grammar.diagnostics import SceneError

_READERS: Mapping[str, tuple[str, Callable[[Mapping[str, Any]], Loaded]]] = {
    ".schem": ("Sponge schematic", sponge.loaded),
    ".litematic": ("Litematica schematic", litematic.loaded),
    ".nbt": ("structure", structure.loaded),
}
ENDINGS = tuple(_READERS)


def read(path: Path, largest: int = LARGEST) -> Loaded:
    """The build in a file, by the ending of its name: ``.schem``, ``.litematic`` or ``.nbt``.

    Block states are taken as they stand: the version need not have them. Raises SceneError("file") for other endings,
    for a file that cannot be read, and where it is damaged or larger, or unpacks to more, than ``largest`` bytes.
    """
    if path.suffix.lower() not in _READERS:
        raise SceneError("file", f"`{path.name}` is no file of blocks that can be read; those are {', '.join(ENDINGS)}")
    name, loaded = _READERS[path.suffix.lower()]
    try:
        return loaded(read_nbt(path, largest))
    except OSError as error:
        raise SceneError("file", f"`{path}` cannot be read: {error.strerror or error}") from error
    except Damaged as problem:
        raise SceneError("file", f"`{path}` is no {name} that can be read: {problem}") from problem
