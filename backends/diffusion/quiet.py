"""Libraries of models that say on the terminal what we say in errors."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager

from scenelang.backends.base import need
from scenelang.backends.weights import INSTALL


@contextmanager
def quiet_libraries(bars: bool) -> Iterator[None]:
    """diffusers and transformers report errors only in the block; ``bars``: they still show how far downloads are."""
    libraries = [need(f"{name}.utils.logging", INSTALL) for name in ("diffusers", "transformers")]
    levels = [library.get_verbosity() for library in libraries]
    shown = libraries[1].is_progress_bar_enabled()
    for library in libraries:
        library.set_verbosity_error()
    if not bars and shown:
        libraries[1].disable_progress_bar()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        for library, level in zip(libraries, levels, strict=True):
            library.set_verbosity(level)
        if not bars and shown:
            libraries[1].enable_progress_bar()
