"""Where the weights of neural models are: a folder of the user's, the hub's cache here, or the hub itself."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from scenelang.grammar.diagnostics import SceneError

T = TypeVar("T")
VARIABLE = "SCENELANG_MODELS"
_NOT_FETCHED = ("LocalEntryNotFoundError", "OfflineModeIsEnabled")
INSTALL = '"scenelang[neural]"'


@dataclass(frozen=True, slots=True)
class Shelf:
    """``folder`` holds models in folders of their own, None where the user has none; ``fetch`` lets the hub be asked
    for what is not on this machine."""

    folder: Path | None = None
    fetch: bool = True

    def place(self, name: str) -> Path | None:
        """The folder of the model ``name``: ``name`` itself where it is one, else the shelf's ``org/name``,
        ``org--name`` or ``name``; None where there is none."""
        own = Path(name).expanduser()
        if own.is_dir():
            return own
        if self.folder is None:
            return None
        inside = (self.folder / part for part in (name, name.replace("/", "--"), name.rsplit("/", 1)[-1]))
        return next((place for place in inside if place.is_dir()), None)

    def load(self, name: str, local: Callable[[Path], T], hub: Callable[[str, bool], T]) -> T:
        """What ``local(folder)`` makes of the model's folder, else ``hub(name, offline)`` of its name.

        Raises SceneError("weights") where the weights are not to be had, or are no weights of that model.
        """
        place = self.place(name)
        try:
            return local(place) if place is not None else hub(name, not self.fetch)
        except SceneError:
            raise
        except Exception as error:  # what the libraries raise for files and networks has no common type
            raise _absent(name, place, error) from error


def shelf(folder: str | Path | None = None, fetch: bool = True) -> Shelf:
    """The shelf at ``folder``, else at the environment's SCENELANG_MODELS; raises SceneError("file") for no folder."""
    given = str(folder) if folder is not None else os.environ.get(VARIABLE)
    if not given:
        return Shelf(None, fetch)
    path = Path(given).expanduser()
    if not path.is_dir():
        raise SceneError("file", f"there is no folder {given} of models")
    return Shelf(path, fetch)


def _absent(name: str, place: Path | None, error: Exception) -> SceneError:
    said = " ".join(str(error).split())[:160] or type(error).__name__
    if type(error).__name__ in _NOT_FETCHED:  # the hub's own words tell of its settings, which nobody made
        said = "they have not been fetched"
    if place is not None:
        return SceneError("weights", f"{place} does not hold the model `{name}`: {said}")
    hint = f"connect to the network, or name the folder that holds it: --models-dir DIR, or {VARIABLE}"
    return SceneError("weights", f"the weights of `{name}` are not on this machine: {said}", hint=hint)
