"""Tensors of a file put into a network, where they are those of that network."""

from __future__ import annotations

import json
import pickle
import warnings
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from scenelang.backends.base import need
from scenelang.backends.weights import INSTALL
from scenelang.grammar.diagnostics import SceneError

_LARGEST_CONFIG = 1_000_000


def fitted(source: str, network: Any, tensors: Mapping[str, Any], called: Mapping[str, str] | None = None) -> Any:
    """``network``, which may be on torch's device "meta", with ``tensors`` for its weights.

    ``called`` are other names of the keys, for messages. Raises SceneError("weights") that names the first key which
    is missing, foreign, or has another shape.
    """
    names = called or {}
    wanted = network.state_dict()
    for key, like in wanted.items():
        if key not in tensors:
            raise other_model(source, f"`{names.get(key, key)}` is missing")
        if tensors[key].shape != like.shape:
            found, meant = (" x ".join(map(str, shape)) for shape in (tensors[key].shape, like.shape))
            raise other_model(source, f"`{names.get(key, key)}` has the shape {found}, not {meant}")
    for key in tensors:
        if key not in wanted:
            raise other_model(source, f"`{key}` does not belong there")
    network.load_state_dict(dict(tensors), assign=True)
    return network.eval().requires_grad_(False)


def other_model(source: str, why: str) -> SceneError:
    """The error for weights of another model than that which ``source`` should hold."""
    return SceneError("weights", f"{source} holds no weights of that model: {why}")


def read_tensors(path: Path) -> dict[str, Any]:
    """The tensors of a ``.safetensors``, ``.pt`` or ``.ckpt`` file, by name; those of the last two under
    ``state_dict`` where that is there. Nothing in the file is run, and torch maps it rather than reads it where it can.

    Raises SceneError("weights") for what holds anything else.
    """
    torch = need("torch", INSTALL)
    try:
        if path.suffix.lower() == ".safetensors":
            return dict(need("safetensors.torch", INSTALL).load_file(path))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about files that are refused anyway
            held = torch.load(path, map_location="cpu", weights_only=True, mmap=zipfile.is_zipfile(path))
    except pickle.UnpicklingError:  # torch's own message advises to trust the file
        raise other_model(path.name, "it has more than tensors in it, or is broken") from None
    except Exception as error:  # what the libraries raise for broken files has no common type
        raise other_model(path.name, " ".join(str(error).split())[:160] or type(error).__name__) from error
    inner = held.get("state_dict", held) if isinstance(held, dict) else None
    if not isinstance(inner, dict) or not all(
        isinstance(key, str) and isinstance(value, torch.Tensor) for key, value in inner.items()
    ):
        raise other_model(path.name, "it is no table of tensors by name")
    return inner


def read_config(path: Path) -> dict[str, Any]:
    """A JSON object of settings; raises SceneError("weights") for anything else."""
    try:
        if path.stat().st_size > _LARGEST_CONFIG:
            raise other_model(str(path), "it is too large for settings")
        data = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise other_model(str(path), str(error)[:160]) from error
    if not isinstance(data, dict):
        raise other_model(str(path), "it is no JSON object")
    return data
