"""What a backend is, and how one is found by name.

The paper's formal view (section 5): a renderer has a parameter space ``Theta``, a space of poses ``T`` and a rendering
operation ``R: P(Theta x T) -> O`` from a set of posed primitives to an observation (a picture, a mesh). Two things make
a backend: the operation ``R`` itself, and the reparameterisation ``g_reparam: (Word, Embedding) -> Theta`` that says
what a primitive entity means to it. The pose of a primitive is the product of the matrices on the way from the root
to it. Here ``interpreter.flatten`` computes the poses, ``solids`` and ``meshes`` hold ``g_reparam`` of the geometric
backends, and ``Backend.run`` is ``R``.

Backends are discovered through the entry-point group ``scenelang.backends``: a package of anybody's may add one by
naming a ``Backend`` object there. Nothing heavy is imported before a backend runs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scenelang.grammar.diagnostics import SceneError, suggest

if TYPE_CHECKING:
    from scenelang.interpreter.entity import Scene

GROUP = "scenelang.backends"
Progress = Callable[[float], None]


class Work(Enum):
    """What a backend makes of a scene."""

    PICTURE = "picture"
    MESH = "mesh"


@dataclass(frozen=True, slots=True)
class Options:
    """What every backend understands. ``frame`` counts from 0, ``limit`` bounds the primitives that are expanded,
    ``progress`` is called with a fraction from 0 to 1."""

    frame: int = 0
    limit: int = 2_000_000
    progress: Progress | None = None


@dataclass(frozen=True, slots=True)
class Backend:
    """A rendering operation and what one must know to choose it.

    ``doc`` is one line, ``endings`` are the files it writes (``.png``), ``packages`` the modules it imports when it
    runs, ``install`` what ``pip install`` needs for these. ``run(scene, path, options)`` writes one file, whole or
    not at all; it raises SceneError.
    """

    name: str
    doc: str
    work: Work
    endings: tuple[str, ...]
    run: Callable[[Scene, Path, Options], None]
    packages: tuple[str, ...] = ()
    install: str = "scenelang"

    @property
    def is_installed(self) -> bool:
        """True when every package that the backend imports can be found; imports none of them."""
        from importlib.util import find_spec

        return all(find_spec(package) is not None for package in self.packages)


def need(package: str, install: str) -> Any:
    """The imported module ``package``; raises SceneError("backend") that names the command which installs it."""
    from importlib import import_module

    try:
        return import_module(package)
    except (ImportError, OSError) as error:  # OSError: one of its shared libraries does not load
        raise SceneError(
            "backend", f"the package `{package}` cannot be imported: {error}", hint=f"pip install {install}"
        ) from error


def names() -> list[str]:
    """The names of all registered backends, sorted; loads none of them."""
    return sorted({point.name for point in _entry_points()})


def find(name: str) -> Backend:
    """The backend called ``name``; raises SceneError("backend") when there is none or it cannot be loaded."""
    for point in _entry_points():
        if point.name == name:
            return _load(point)
    known = names()
    listed = ", ".join(known) if known else "none is installed: `pip install scenelang`"
    raise SceneError("backend", f"there is no backend `{name}` ({listed})", hint=suggest(name, known))


def every() -> list[Backend]:
    """All backends that load, by name. One that fails to load is left out: ``find`` says why."""
    loaded = []
    for name in names():
        try:
            loaded.append(find(name))
        except SceneError:
            continue
    return loaded


def for_file(path: Path | str, work: Work | None = None) -> Backend:
    """The first backend by name that writes files like ``path``; raises SceneError("backend") when none does."""
    ending = Path(path).suffix.lower()
    candidates = [backend for backend in every() if work is None or backend.work is work]
    for backend in candidates:
        if ending in backend.endings:
            return backend
    known = sorted({ending for backend in candidates for ending in backend.endings})
    shown = f"`{ending}` files" if ending else "a file without an ending"
    raise SceneError(
        "backend", f"no backend writes {shown}", hint=f"it can be one of {' '.join(known)}" if known else None
    )


def _entry_points() -> Iterable[Any]:
    from importlib.metadata import entry_points

    return entry_points(group=GROUP)


def _load(point: Any) -> Backend:
    try:
        backend = point.load()
    except (ImportError, AttributeError) as error:
        raise SceneError("backend", f"the backend `{point.name}` cannot be loaded: {error}") from error
    if not isinstance(backend, Backend):
        raise SceneError("backend", f"the entry point `{point.name}` names no Backend ({point.value})")
    return backend
