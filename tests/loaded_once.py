"""A fixture for modules whose tests run many commands with the same small models: these are loaded once."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest


@pytest.fixture(scope="module")
def loaded_once() -> Iterator[None]:
    """Diffusion models, which no command changes: by their folders, and as `imagine` loads them."""
    from scenelang.backends.neural import diffusion_loading
    from scenelang.backends.neural.imagine import sampling

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(diffusion_loading, "_from_folder", _once(diffusion_loading._from_folder))
        patch.setattr(sampling, "_load", _once(sampling._load))
        yield


def _once(load: Callable[..., Any]) -> Callable[..., Any]:
    found: dict[str, Any] = {}

    def loaded(*what: Any) -> Any:
        key = repr(what)
        if key not in found:
            found[key] = load(*what)
        return found[key]

    return loaded
