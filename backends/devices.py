"""What neural models compute on."""

from __future__ import annotations

from scenelang.backends.base import need
from scenelang.backends.weights import INSTALL
from scenelang.grammar.diagnostics import SceneError


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
        raise SceneError("value", f"there is no device `{name}` here", hint=f"there is {', '.join(here)}")
    return name
