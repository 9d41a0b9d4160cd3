"""Where the weights of neural models are: a folder of the user's, the hub's cache here, or the hub itself."""

from __future__ import annotations

import logging
import os
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from textwrap import shorten
from typing import TypeVar
from urllib.parse import urlsplit

from scenelang.backends.base import need
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.settings import setting

T = TypeVar("T")
VARIABLE = "SCENELANG_MODELS"
_HUB = "https://huggingface.co"
_PROXIES = ("HTTPS_PROXY", "https_proxy", "HTTP_PROXY", "http_proxy", "ALL_PROXY", "all_proxy")
_PATIENCE = 3.0  # seconds
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

    def load(
        self, name: str, local: Callable[[Path], T], hub: Callable[[str, bool], T], address: str | None = None
    ) -> T:
        """What ``local(folder)`` makes of the model's folder, else ``hub(name, offline)`` of its name. ``address``:
        where the weights are fetched from, by default the hub of Hugging Face.

        Raises SceneError("weights") where the weights are not to be had, or are no weights of that model.
        """
        place = self.place(name)
        try:
            if place is not None:
                return local(place)
            with _silent_hub():
                return hub(name, not (self.fetch and is_reachable(address or os.environ.get("HF_ENDPOINT") or _HUB)))
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
        raise SceneError("file", f"no model directory {given}")
    return Shelf(path, fetch)


def is_reachable(url: str) -> bool:
    """Whether a host answers: libraries would try for half a minute. Behind a proxy nobody knows, so it is True."""
    if any(os.environ.get(name) for name in _PROXIES):
        return True
    address = urlsplit(url)
    try:
        port = address.port or (80 if address.scheme == "http" else 443)
        with socket.create_connection((address.hostname or "", port), timeout=_PATIENCE):
            return True
    except (OSError, ValueError):
        return False


@contextmanager
def _silent_hub() -> Iterator[None]:
    """What libraries log of their tries is not for users, who get one line."""
    before = logging.root.manager.disable
    logging.disable(logging.ERROR)
    try:
        yield
    finally:
        logging.disable(before)


def _absent(name: str, place: Path | None, error: Exception) -> SceneError:
    said = shorten(str(error), 160, placeholder=" ...") or type(error).__name__
    if type(error).__name__ in _NOT_FETCHED:  # the hub's own words tell of its settings, which nobody made
        said = "they are not in the cache, and downloads are disabled"
    if place is not None:
        return SceneError("weights", f"{place} does not hold the model `{name}`: {said}")
    hint = f"connect to the network, or name the folder that holds it: --models-dir DIR, or {VARIABLE}"
    return SceneError("weights", f"the weights of `{name}` are not on this machine: {said}", hint=hint)


# What neural models compute on.


def device(name: str | None = None) -> str:
    """The device called ``name``, else the fastest that torch finds here: cuda, mps or cpu.

    Raises SceneError("value") for a device that is not here.
    """
    torch = need("torch", INSTALL)
    here = [
        *(["cuda"] if torch.cuda.is_available() else []),
        *(["mps"] if torch.backends.mps.is_available() else []),
        "cpu",
    ]
    if name is None:
        return here[0]
    if name.partition(":")[0] not in here:
        raise SceneError("value", f"unknown device `{name}`", hint=f"available: {', '.join(here)}")
    return name


@dataclass(frozen=True, slots=True)
class Models:
    """Where the weights of neural models are, and what computes.

    Parameters
    ----------
    folder : path, optional
        A folder that holds models, each in a folder of its own; default: the environment's SCENELANG_MODELS.
    offline : bool
        Ask no hub for weights that are not on this machine.
    device : str, optional
        "cpu", "cuda", "mps"; default: the fastest that torch finds.

    Examples
    --------
    >>> Models(offline=True, device="cpu")
    Models(folder=None, offline=True, device='cpu')
    """

    folder: str | Path | None = setting(
        None,
        "local model directory, one subdirectory per model (SCENELANG_MODELS)",
        "--models-dir",
        metavar="DIR",
    )
    offline: bool = setting(False, "ask no hub for weights that are not on this machine")
    device: str | None = setting(None, "cpu, cuda, mps (default: the fastest there is)", metavar="NAME")

    def shelf(self) -> Shelf:
        """Where the weights are looked for; raises SceneError("file") where the folder is none."""
        return shelf(self.folder, fetch=not self.offline)

    def computes_on(self) -> str:
        """The name of the device; raises SceneError("value") for one that is not here, "backend" without torch."""
        return device(self.device)
