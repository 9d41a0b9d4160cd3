"""Model hub: locate the weights of neural models in a local folder, the Hugging Face cache or the hub, and a device."""

from __future__ import annotations

import logging
import os
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from textwrap import shorten
from typing import TypeVar
from urllib.parse import urlsplit

from scenelang.backends.base import require
from scenelang.grammar.datum import dataclass
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.settings import setting

T = TypeVar("T")
VARIABLE = "SCENELANG_MODELS"
_HUB = "https://huggingface.co"
_PROXIES = ("HTTPS_PROXY", "https_proxy", "HTTP_PROXY", "http_proxy", "ALL_PROXY", "all_proxy")
_TIMEOUT = 3.0  # of the connection test, in seconds
_OFFLINE_ERRORS = ("LocalEntryNotFoundError", "OfflineModeIsEnabled")  # of huggingface_hub
INSTALL = "'scenelang[neural]'"


@dataclass(frozen=True, slots=True)
class ModelHub:
    """Source of model weights: a local ``folder`` with one subfolder per model (None: no such folder), then the hub's
    cache, then a download, which ``download`` permits."""

    folder: Path | None = None
    download: bool = True

    def find_folder(self, name: str) -> Path | None:
        """Return the local folder of the model ``name``, or None.

        ``name`` may be a path; otherwise the folder's ``org/name``, ``org--name`` and ``name`` are tried.
        """
        own = Path(name).expanduser()
        if own.is_dir():
            return own
        if self.folder is None:
            return None
        candidates = (self.folder / part for part in (name, name.replace("/", "--"), name.rsplit("/", 1)[-1]))
        return next((folder for folder in candidates if folder.is_dir()), None)

    def load(
        self,
        name: str,
        load_local: Callable[[Path], T],
        load_remote: Callable[[str, bool], T],
        address: str | None = None,
    ) -> T:
        """Load a model with ``load_local(folder)`` if it has a local folder, else with ``load_remote(name, offline)``.

        ``address`` is the server to download from; default: the Hugging Face hub. Raises SceneError("weights") if the
        weights are unavailable or belong to another model.
        """
        folder = self.find_folder(name)
        try:
            if folder is not None:
                return load_local(folder)
            with _silence_logging():
                online = self.download and is_reachable(address or os.environ.get("HF_ENDPOINT") or _HUB)
                return load_remote(name, not online)
        except SceneError:
            raise
        except Exception as error:  # the libraries' errors for files and networks have no common type
            raise _unavailable(name, folder, error) from error


def model_hub(folder: str | Path | None = None, download: bool = True) -> ModelHub:
    """Return the model hub with the local ``folder``; default: the environment variable SCENELANG_MODELS.

    Raises SceneError("file") if the folder does not exist.
    """
    given = str(folder) if folder is not None else os.environ.get(VARIABLE)
    if not given:
        return ModelHub(None, download)
    path = Path(given).expanduser()
    if not path.is_dir():
        raise SceneError("file", f"the model directory {given} does not exist")
    return ModelHub(path, download)


def is_reachable(url: str) -> bool:
    """Return whether a host accepts connections; the libraries themselves would retry for half a minute.

    Behind a proxy this cannot be tested, so the result is True.
    """
    if any(os.environ.get(name) for name in _PROXIES):
        return True
    address = urlsplit(url)
    try:
        port = address.port or (80 if address.scheme == "http" else 443)
        with socket.create_connection((address.hostname or "", port), timeout=_TIMEOUT):
            return True
    except (OSError, ValueError):
        return False


@contextmanager
def _silence_logging() -> Iterator[None]:
    """Disable logging in the block: the libraries log their retries, which the raised error summarises."""
    before = logging.root.manager.disable
    logging.disable(logging.ERROR)
    try:
        yield
    finally:
        logging.disable(before)


def _unavailable(name: str, folder: Path | None, error: Exception) -> SceneError:
    reason = shorten(str(error), 160, placeholder=" ...") or type(error).__name__
    if type(error).__name__ in _OFFLINE_ERRORS:  # the hub's message refers to its own settings
        reason = "they are not in the cache, and downloads are disabled"
    if folder is not None:
        return SceneError("weights", f"cannot load the model `{name}` from {folder}: {reason}")
    hint = f"connect to the network, or specify a local model directory with --models-dir DIR or {VARIABLE}"
    return SceneError("weights", f"the weights of `{name}` are not available: {reason}", hint=hint)


# Compute devices.


def resolve_device(name: str | None = None) -> str:
    """Return the torch device ``name``; default: the fastest available of cuda, mps and cpu.

    Raises SceneError("value") if the device is not available, "backend" without torch.
    """
    torch = require("torch", INSTALL)
    available = [
        *(["cuda"] if torch.cuda.is_available() else []),
        *(["mps"] if torch.backends.mps.is_available() else []),
        "cpu",
    ]
    if name is None:
        return available[0]
    if name.partition(":")[0] not in available:
        raise SceneError("value", f"unknown device `{name}`", hint=f"available: {', '.join(available)}")
    return name


@dataclass(frozen=True, slots=True)
class Models:
    """Source of model weights, and compute device.

    Parameters
    ----------
    folder : path, optional
        Local model directory with one subdirectory per model; default: the environment variable SCENELANG_MODELS.
    offline : bool
        Do not download weights.
    device : str, optional
        "cpu", "cuda" or "mps"; default: the fastest available.

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
    offline: bool = setting(False, "do not download weights")
    device: str | None = setting(None, "cpu, cuda or mps (default: the fastest available)", metavar="NAME")

    def hub(self) -> ModelHub:
        """Return the model hub; raises SceneError("file") if the folder does not exist."""
        return model_hub(self.folder, download=not self.offline)

    def resolve_device(self) -> str:
        """Return the name of the compute device.

        Raises SceneError: "value" if it is not available, "backend" without torch.
        """
        return resolve_device(self.device)
