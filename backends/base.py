"""What a backend is, and how one is found by name.

The paper's formal view (section 5): a renderer has a parameter space ``Theta``, a space of poses ``T`` and a rendering
operation ``R: P(Theta x T) -> O`` from a set of posed primitives to an observation (a picture, a mesh). Two things make
a backend: the operation ``R`` itself, and the reparameterisation ``g_reparam: (Word, Embedding) -> Theta`` that says
what a primitive entity means to it. The pose of a primitive is the product of the matrices on the way from the root
to it. Here ``interpreter.flatten`` computes the poses, ``solids``, ``appearance`` and ``meshes`` hold ``g_reparam`` of
the geometric backends, and ``Backend.run`` is ``R``.

Backends are discovered through the entry-point group ``scenelang.backends``: a package of anybody's may add one by
naming a ``Backend`` object there. Nothing heavy is imported before a backend runs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from scenelang.grammar.diagnostics import Diagnostic, SceneError, suggest
from scenelang.grammar.settings import Setting, setting, whole
from scenelang.interpreter.plugins import entry_points_of
from scenelang.interpreter.scene.primitives import seen_words

if TYPE_CHECKING:
    from scenelang.interpreter.scene.entity import Scene

GROUP = "scenelang.backends"
Progress = Callable[[float], None]
Plugin = TypeVar("Plugin")
LOOKS = ("color", "roughness", "metallic", "opacity", "emission", "ior")


class Work(Enum):
    """What a backend makes of a scene, and so which command runs it."""

    PICTURE = "render"
    EXPORT = "export"


@dataclass(frozen=True, slots=True)
class Option:
    """One option of a backend, declared once: the command line's flag ``--name``, its help, and what is allowed.

    The type is that of ``default`` (None: a whole number that may be left out); a flag's default is False. ``least``
    and ``most`` bound numbers, ``choices`` are the texts that are allowed, all where there are none. ``check`` raises
    SceneError("value") for other values that make no sense.
    """

    name: str
    doc: str
    default: int | float | str | bool | None
    choices: tuple[str, ...] = ()
    least: float | None = None
    most: float | None = None
    check: Callable[[Any], object] | None = None

    def setting(self, owners: Sequence[str]) -> Setting:
        """The option as users give it; ``owners`` are the backends that have it."""
        has_default = self.default not in (None, "") and type(self.default) is not bool
        text = f"{self.doc} ({', '.join(owners)}{f'; default {self.default}' if has_default else ''})"
        kind = int if self.default is None else type(self.default)
        metavar = "|".join(self.choices) or {int: "N", float: "X"}.get(kind, "TEXT")
        return Setting(self.default, text, (f"--{self.name}",), metavar, None if kind is str else kind)

    def checked(self, value: Any) -> Any:
        """``value`` as the option's type; raises SceneError("value") where it is not allowed."""
        wanted = int if self.default is None else type(self.default)
        if wanted is float and type(value) is int:
            value = float(value)
        if type(value) is not wanted:
            raise SceneError("value", f"`--{self.name}` must be {_KINDS[wanted]}, not {value!r}")
        if self.choices and value not in self.choices:
            hint = suggest(str(value), self.choices)
            raise SceneError("value", f"`--{self.name}` is one of {', '.join(self.choices)}, not `{value}`", hint=hint)
        if self.least is not None and not float(value) >= self.least:
            raise SceneError("value", f"`--{self.name}` must be {self.least:,g} or more, not {value:,g}")
        if self.most is not None and not float(value) <= self.most:
            raise SceneError("value", f"`--{self.name}` must be {self.most:,g} or less, not {value:,g}")
        if self.check is not None:
            self.check(value)
        return value


_KINDS: dict[type, str] = {int: "a whole number", float: "a number", str: "a text", bool: "true or false"}


@dataclass(frozen=True, slots=True)
class Accepts:
    """What a backend can make something of: the words of primitives (``any_word``: every unbound word, as a box or by
    synthesis), the attributes that it looks at beside the geometry's own, and whether one file holds all frames of a
    4D scene. ``words`` None: of all primitives that can be seen."""

    words: tuple[str, ...] | None = None
    any_word: bool = True
    attributes: tuple[str, ...] = LOOKS
    animated: bool = False

    def primitives(self) -> tuple[str, ...]:
        """The words of the primitives."""
        return seen_words() if self.words is None else self.words


@dataclass(frozen=True, slots=True)
class BackendOptions:
    """What every backend understands. ``frame`` counts from 0 (None: all frames where the backend writes 4D, else the
    first), ``limit`` bounds the primitives that are expanded, ``progress`` is called with a fraction from 0 to 1,
    ``settings`` are values of the backend's own options, ``warn`` is told what is not made as the program asks."""

    frame: int | None = setting(None, "only this frame of a 4D scene, from 0", metavar="N", read=whole)
    limit: int = 2_000_000
    progress: Progress | None = None
    settings: Mapping[str, Any] = field(default_factory=dict)
    warn: Callable[[Diagnostic], None] | None = None


@dataclass(frozen=True, slots=True, repr=False)
class Backend:
    """A rendering operation and what one must know to choose it.

    ``doc`` is one line, ``endings`` are the files it writes (``.png``), ``packages`` the modules it imports when it
    runs, ``install`` what ``pip install`` needs for these. ``run(scene, path, options)`` writes one file, whole or
    not at all, or several, and then gives their paths; it raises SceneError.
    """

    name: str
    doc: str
    work: Work
    endings: tuple[str, ...]
    run: Callable[[Scene, Path, Any], Sequence[Path] | None]
    options: tuple[Option, ...] = ()
    accepts: Accepts = Accepts()
    packages: tuple[str, ...] = ()
    install: str = "scenelang"

    def __repr__(self) -> str:
        return f"<Backend {self.name}: {self.doc}>"

    @property
    def is_installed(self) -> bool:
        """True when every package that the backend imports can be found; imports none of them."""
        from importlib.util import find_spec

        return all(find_spec(package) is not None for package in self.packages)

    def facts(self) -> dict[str, Any]:
        """What the backend is, as JSON data."""
        return {
            "name": self.name,
            "doc": self.doc,
            "command": self.work.value,
            "endings": list(self.endings),
            "installed": self.is_installed,
            "install": self.install,
            "accepts": {
                "words": list(self.accepts.primitives()),
                "any_word": self.accepts.any_word,
                "attributes": list(self.accepts.attributes),
                "animated": self.accepts.animated,
            },
            "options": [
                {"name": option.name, "doc": option.doc, "default": option.default, "choices": list(option.choices)}
                for option in self.options
            ],
        }

    @property
    def row(self) -> tuple[str, ...]:
        """What the backend is, in a row of a table: name, command, endings, whether it is installed, its line."""
        installed = "yes" if self.is_installed else f"pip install {self.install}"
        return self.name, self.work.value, " ".join(self.endings), installed, self.doc

    def setting(self, options: BackendOptions, name: str) -> Any:
        """The checked value of the backend's own option ``name``; raises SceneError("value")."""
        option = next(option for option in self.options if option.name == name)
        return option.checked(options.settings[name]) if options.settings.get(name) is not None else option.default


def need(package: str, install: str) -> Any:
    """The imported module ``package``; raises SceneError("backend") that names the command which installs it."""
    from importlib import import_module

    try:
        return import_module(package)
    except (ImportError, OSError) as error:  # OSError: one of its shared libraries does not load
        raise SceneError(
            "backend", f"the package `{package}` cannot be imported: {error}", hint=f"pip install {install}"
        ) from error


def part_of(progress: Progress | None, start: float, end: float) -> Progress | None:
    """``progress`` for a part of the work that takes it from ``start`` to ``end``."""
    if progress is None:
        return None
    return lambda share: progress(start + (end - start) * share)


def frame_of(scene: Scene, frame: int | None) -> int:
    """The frame that is meant, the first for None; raises SceneError("value") when the scene has no such frame."""
    number = frame or 0
    if not 0 <= number < len(scene.frames):
        have = f"{len(scene.frames)} frames, 0 to {len(scene.frames) - 1}" if len(scene.frames) > 1 else "one frame, 0"
        raise SceneError("value", f"the scene has {have}; there is no frame {number}")
    return number


def check_settings(options: BackendOptions, backends: Sequence[Backend]) -> None:
    """Raises SceneError("value") where a setting is none of these backends', or is not allowed."""
    for name in (name for name, value in options.settings.items() if value is not None):
        owners = [backend for backend in backends if any(option.name == name for option in backend.options)]
        for backend in owners:
            backend.setting(options, name)
        if not owners:
            others = [backend.name for backend in every() if any(option.name == name for option in backend.options)]
            hint = f"it is an option of {', '.join(others)}" if others else None
            shown = ", ".join(f"`{backend.name}`" for backend in backends)
            raise SceneError("value", f"{shown} has no option `--{name}`", hint=hint)


@dataclass(frozen=True, slots=True)
class PluginRegistry(Generic[Plugin]):
    """Plug-ins of one kind by name: what packages name in the entry-point group ``group``. ``kind`` is what messages
    call one, ``cls`` what it must be an instance of."""

    group: str
    kind: str
    cls: type[Plugin]
    error: str = "backend"

    def names(self) -> list[str]:
        """The names of all, sorted; loads none of them."""
        return sorted(self._points())

    def get(self, name: str) -> Plugin | None:
        """The plug-in called ``name``, None where there is none; raises SceneError for one that cannot be loaded."""
        point = self._points().get(name)
        return None if point is None else self._load(point)

    def find(self, name: str) -> Plugin:
        """The plug-in called ``name``; raises SceneError when there is none or it cannot be loaded."""
        found = self.get(name)
        if found is not None:
            return found
        known = self.names()
        listed = ", ".join(known) if known else "none is installed: `pip install scenelang`"
        raise SceneError(self.error, f"there is no {self.kind} `{name}` ({listed})", hint=suggest(name, known))

    def every(self) -> list[Plugin]:
        """All that load, by name. One that fails to load is left out: ``find`` says why."""
        loaded = []
        for _, point in sorted(self._points().items()):
            try:
                loaded.append(self._load(point))
            except SceneError:
                continue
        return loaded

    def _points(self) -> Mapping[str, Any]:
        return entry_points_of(self.group)

    def _load(self, point: Any) -> Plugin:
        try:
            found = point.load()
        except Exception as error:  # foreign code may raise anything as it is imported
            raise SceneError("backend", f"the {self.kind} `{point.name}` cannot be loaded: {error}") from error
        if not isinstance(found, self.cls):
            said = f"the entry point `{point.name}` names no {self.cls.__name__} ({point.value})"
            raise SceneError("backend", said)
        return found


BACKENDS = PluginRegistry(GROUP, "backend", Backend)


def names() -> list[str]:
    """The names of all registered backends, sorted; loads none of them."""
    return BACKENDS.names()


def find(name: str) -> Backend:
    """The backend called ``name``; raises SceneError("backend") when there is none or it cannot be loaded."""
    return BACKENDS.find(name)


def every(work: Work | None = None) -> list[Backend]:
    """All backends that load, by name. One that fails to load is left out: ``find`` says why."""
    return [backend for backend in BACKENDS.every() if work is None or backend.work is work]


def settings_for(work: Work) -> dict[str, Setting]:
    """The options of the backends that do ``work``, by name; each tells whose it is."""
    owners: dict[str, list[str]] = {}
    options: dict[str, Option] = {}
    for backend in every(work):
        for option in backend.options:
            owners.setdefault(option.name, []).append(backend.name)
            options.setdefault(option.name, option)
    return {name: option.setting(owners[name]) for name, option in options.items()}


def for_file(path: Path | str, work: Work | None = None) -> Backend:
    """The first backend by name that writes files like ``path``; raises SceneError("backend") when none does."""
    ending = Path(path).suffix.lower()
    candidates = every(work)
    for backend in candidates:
        if ending in backend.endings:
            return backend
    known = sorted({ending for backend in candidates for ending in backend.endings})
    shown = f"`{ending}` files" if ending else "a file without an ending"
    raise SceneError(
        "backend", f"no backend writes {shown}", hint=f"it can be one of {' '.join(known)}" if known else None
    )
