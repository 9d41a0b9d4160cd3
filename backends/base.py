"""Backend interface, options and discovery by name.

The paper's formal view (section 5): a renderer has a parameter space ``Theta``, a space of poses ``T`` and a rendering
operation ``R: P(Theta x T) -> O`` from a set of posed primitives to an observation (a picture, a mesh). A backend
consists of the operation ``R`` and the reparameterisation ``g_reparam: (Word, Embedding) -> Theta``, which maps a
primitive entity to renderer parameters. The pose of a primitive is the product of the matrices on the path from the
root to it. Here ``interpreter/scene/flatten`` computes the poses, ``surfaces/solids`` and ``surfaces/appearance``
implement ``g_reparam`` for the geometric backends, and ``Backend.run`` is ``R``.

Backends are discovered through the entry-point group ``scenelang.backends``: any package may add one by naming a
``Backend`` object there. What must be known of our own before one is chosen (names, endings, options) is in
``descriptions.json``, which `make descriptions` writes from the backends, so that listing them imports none of them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from enum import Enum
from functools import cache
from typing import TYPE_CHECKING, Any

from scenelang.grammar.datum import dataclass, field
from scenelang.grammar.diagnostics import REINSTALL, Diagnostic, SceneError, suggest
from scenelang.grammar.settings import Setting, setting, whole
from scenelang.interpreter.loading import is_present
from scenelang.interpreter.loading import require as require  # backends import it with what else they need of here
from scenelang.interpreter.plugins import PluginRegistry
from scenelang.interpreter.scene.primitives import geometric_words

if TYPE_CHECKING:
    from pathlib import Path

    from scenelang.interpreter.scene.entity import Scene

GROUP = "scenelang.backends"
Progress = Callable[[float], None]
LOOKS = ("color", "roughness", "metallic", "opacity", "emission", "ior")


class Work(Enum):
    """Kind of output of a backend; the value is the command that runs it."""

    PICTURE = "render"
    EXPORT = "export"


@dataclass(frozen=True, slots=True)
class Option:
    """One option of a backend: the command line's flag ``--name``, its help, default and allowed values.

    ``default`` also determines the type (None: an optional integer; False: a flag). ``minimum`` and ``maximum`` are
    inclusive bounds of a number. ``choices`` lists the allowed strings; if it is empty, any string is allowed.
    ``check`` performs further validation and raises SceneError("value"). ``read`` converts what is given, of any type,
    in place of all this, and raises SceneError("value") too.
    """

    name: str
    doc: str
    default: int | float | str | bool | None
    choices: tuple[str, ...] = ()
    minimum: float | None = None
    maximum: float | None = None
    check: Callable[[Any], object] | None = None
    read: Callable[[Any], object] | None = None

    def setting(self, owners: Sequence[str]) -> Setting:
        """Return the command-line setting for this option; ``owners`` are the names of the backends that define it."""
        has_default = self.default not in (None, "") and type(self.default) is not bool
        text = f"{self.doc} ({', '.join(owners)}{f'; default {self.default}' if has_default else ''})"
        kind = int if self.default is None else type(self.default)
        metavar = "|".join(self.choices) or {int: "N", float: "X"}.get(kind, "TEXT")
        return Setting(self.default, text, (f"--{self.name}",), metavar, None if kind is str else kind)

    def validate(self, value: Any) -> Any:
        """Return ``value`` converted to the option's type; raises SceneError("value") if it is not allowed."""
        if self.read is not None:
            return self.read(value)
        expected = int if self.default is None else type(self.default)
        if expected is float and type(value) is int:
            value = float(value)
        if type(value) is not expected:
            raise SceneError("value", f"`--{self.name}` must be {_KINDS[expected]}, not {value!r}")
        if self.choices and value not in self.choices:
            hint = suggest(str(value), self.choices)
            raise SceneError("value", f"`--{self.name}` is one of {', '.join(self.choices)}, not `{value}`", hint=hint)
        self._check_range(value)
        if self.check is not None:
            self.check(value)
        return value

    def _check_range(self, value: Any) -> None:
        given = f"{value:,}" if type(value) is int else f"{value:,.12g}" if type(value) is float else ""
        if self.minimum is not None and not value >= self.minimum:
            raise SceneError("value", f"`--{self.name}` must be {self.minimum:,.12g} or more, not {given}")
        if self.maximum is not None and not value <= self.maximum:
            raise SceneError("value", f"`--{self.name}` must be {self.maximum:,.12g} or less, not {given}")


_KINDS: dict[type, str] = {int: "a whole number", float: "a number", str: "a string", bool: "true or false"}


@dataclass(frozen=True, slots=True)
class Accepts:
    """Scene content that a backend supports.

    ``words`` are the supported primitives (None: all visible primitives). With ``any_word``, every unbound word is
    supported too, as a box or by synthesis. ``attributes`` are read in addition to the geometry's own. ``animated``
    means that one file can contain all frames of a 4D scene.
    """

    words: tuple[str, ...] | None = None
    any_word: bool = True
    attributes: tuple[str, ...] = LOOKS
    animated: bool = False

    def primitives(self) -> tuple[str, ...]:
        """Return the words of the supported primitives."""
        return geometric_words() if self.words is None else self.words


@dataclass(frozen=True, slots=True)
class BackendOptions:
    """Options common to all backends.

    ``frame`` is zero-based (None: all frames if the backend writes 4D, else the first). ``limit`` is the maximum number
    of expanded primitives. ``progress`` is called with a fraction from 0 to 1. ``settings`` maps the backend's own
    options to values. ``warn`` receives a diagnostic for scene content that the backend cannot reproduce faithfully.
    """

    frame: int | None = setting(None, "only this frame of a 4D scene, from 0", metavar="N", read=whole)
    limit: int = 2_000_000
    progress: Progress | None = None
    settings: Mapping[str, Any] = field(default_factory=dict)
    warn: Callable[[Diagnostic], None] | None = None


@dataclass(frozen=True, slots=True, repr=False)
class Backend:
    """Rendering operation with the metadata needed to select it.

    ``doc`` is a one-line description, ``endings`` the file extensions it writes (``.png``), ``packages`` the modules it
    imports when it runs, ``install`` the argument of ``pip install`` that provides them. ``run(scene, path, options)``
    writes one file atomically, or several, in which case it returns their paths; it raises SceneError. ``module`` is
    the module that defines a backend which is listed from its description, and so may be missing.
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
    module: str = ""

    def __repr__(self) -> str:
        return f"<Backend {self.name}: {self.doc}>"

    @property
    def is_installed(self) -> bool:
        """Whether the backend itself and every package that it needs are installed; none of them is imported."""
        return self._is_present and all(map(is_present, self.packages))

    @property
    def _is_present(self) -> bool:
        """Return whether this installation has the module of the backend."""
        return not self.module or is_present(self.module)

    @property
    def remedy(self) -> str:
        """Command that installs what the backend needs."""
        return f"pip install {self.install if self._is_present else REINSTALL}"

    def metadata(self) -> dict[str, Any]:
        """Return the backend's metadata as JSON data: its description, with the state of the installation."""
        described = description_of(self)
        return {
            **{name: described[name] for name in ("name", "doc", "command", "endings")},
            "installed": self.is_installed,
            "install": self.remedy.removeprefix("pip install "),
            "accepts": described["accepts"] | {"words": list(self.accepts.primitives())},
            "options": [
                {name: option[name] for name in ("name", "doc", "default", "choices")}
                for option in described["options"]
            ],
        }

    @property
    def row(self) -> tuple[str, ...]:
        """Table row of the backend: name, command, file extensions, installation status, description."""
        installed = "yes" if self.is_installed else self.remedy
        return self.name, self.work.value, " ".join(self.endings), installed, self.doc

    def setting(self, options: BackendOptions, name: str) -> Any:
        """Return the validated value of the backend's own option ``name``; raises SceneError("value")."""
        option = next(option for option in self.options if option.name == name)
        return option.validate(options.settings[name]) if options.settings.get(name) is not None else option.default


def sub_progress(progress: Progress | None, start: float, end: float) -> Progress | None:
    """Return a callback that maps progress in [0, 1] to the range from ``start`` to ``end`` of ``progress``."""
    if progress is None:
        return None
    return lambda share: progress(start + (end - start) * share)


def frame_of(scene: Scene, frame: int | None) -> int:
    """Return the index of the requested frame, 0 for None.

    Raises SceneError("value") if the scene has no such frame.
    """
    number = frame or 0
    if not 0 <= number < len(scene.frames):
        have = f"{len(scene.frames)} frames, 0 to {len(scene.frames) - 1}" if len(scene.frames) > 1 else "one frame, 0"
        hint = f"frames are counted from 0: the last is {len(scene.frames) - 1}" if len(scene.frames) > 1 else None
        raise SceneError("value", f"the scene has {have}; frame {number} does not exist", hint)
    return number


def require_word(scene: Scene, word: str) -> None:
    """Raise SceneError("value") with the most similar word if no entity of the scene has ``word``.

    A path, such as ``chair/leg[2]``, is not checked.
    """
    from scenelang.interpreter.inspection.instance_paths import is_plain
    from scenelang.interpreter.scene.entity import descendants

    known = {entity.word for entity in descendants(*scene.frames)} if is_plain(word) else {word}
    if word not in known:
        same = [other for other in sorted(known) if other.lower() == word.lower()]
        hint = f'the word is "{same[0]}": upper and lower case differ' if same else suggest(word, sorted(known))
        raise SceneError("value", f'no entity has the word "{word}"', hint)


def check_settings(options: BackendOptions, backends: Sequence[Backend], shown: Callable[[str], str] = str) -> None:
    """Validate ``options.settings``; raises SceneError("value") for an unknown option or a disallowed value.

    ``shown`` returns how a hint calls a backend of a name, such as by its quality.
    """
    for name in (name for name, value in options.settings.items() if value is not None):
        owners = [backend for backend in backends if any(option.name == name for option in backend.options)]
        for backend in owners:
            backend.setting(options, name)
        if not owners:
            having = [each.name for each in all_backends() if any(option.name == name for option in each.options)]
            others = [shown(other) for other in having]
            verb = "has" if len(others) == 1 else "have"
            hint = f"{' and '.join(others)} {verb} it: choose that, or leave it out" if others else None
            chosen = ", ".join(f"`{backend.name}`" for backend in backends)
            raise SceneError("value", f"{chosen} has no option `--{name}`", hint=hint)


@cache
def _descriptions() -> Mapping[str, Mapping[str, Any]]:
    """Return the data of ``descriptions.json`` by the value of the entry point."""

    import json
    from pathlib import Path

    text = Path(__file__).with_name("descriptions.json").read_text("utf-8")
    data: dict[str, Mapping[str, Any]] = json.loads(text)
    return data


def description_of(backend: Backend) -> dict[str, Any]:
    """Return what can be known of a backend without importing it, as JSON data; ``described`` reads it."""
    return {
        "name": backend.name,
        "doc": backend.doc,
        "command": backend.work.value,
        "endings": list(backend.endings),
        "packages": list(backend.packages),
        "install": backend.install,
        "accepts": {
            "words": None if backend.accepts.words is None else list(backend.accepts.words),
            "any_word": backend.accepts.any_word,
            "attributes": list(backend.accepts.attributes),
            "animated": backend.accepts.animated,
        },
        "options": [
            {"name": o.name, "doc": o.doc, "default": o.default, "choices": list(o.choices),
             "minimum": o.minimum, "maximum": o.maximum}
            for o in backend.options
        ],
    }  # fmt: skip


def described(data: Mapping[str, Any], module: str) -> Backend:
    """Return a backend for lists from ``description_of``; ``module`` is imported when it runs.

    Its options lack their own checks, which ``find`` and ``check_settings`` apply when it is chosen.
    """
    name, accepts = data["name"], data["accepts"]

    def run(scene: Scene, path: Path, options: Any) -> Sequence[Path] | None:
        """Import the backend, and run it."""
        return find(name).run(scene, path, options)

    return Backend(
        name=name,
        doc=data["doc"],
        work=Work(data["command"]),
        endings=tuple(data["endings"]),
        run=run,
        options=tuple(Option(**{**option, "choices": tuple(option["choices"])}) for option in data["options"]),
        accepts=Accepts(
            words=None if accepts["words"] is None else tuple(accepts["words"]),
            any_word=accepts["any_word"],
            attributes=tuple(accepts["attributes"]),
            animated=accepts["animated"],
        ),
        packages=tuple(data["packages"]),
        install=data["install"],
        module=module,
    )


@dataclass(frozen=True, slots=True)
class BackendRegistry(PluginRegistry[Backend]):
    """Backends; those with a description are listed without being imported."""

    def _listed(self, point: Any) -> Backend:
        data = _descriptions().get(point.value)
        return self._load(point) if data is None else described(data, point.value.partition(":")[0])


BACKENDS = BackendRegistry(GROUP, "backend", Backend)


def names() -> list[str]:
    """Return the sorted names of all registered backends without loading them."""
    return BACKENDS.names()


def find(name: str) -> Backend:
    """Return the backend ``name``; raises SceneError("backend") if it does not exist or cannot be loaded."""
    return BACKENDS.find(name)


def all_backends(work: Work | None = None) -> list[Backend]:
    """Return all backends for a list, sorted by name, without importing those that ``descriptions.json`` describes.

    ``find`` and ``for_file`` return one that can run, with the checks of its options.
    """
    return [backend for backend in BACKENDS.all() if work is None or backend.work is work]


def settings_for(work: Work) -> dict[str, Setting]:
    """Return the options of all backends for ``work``, by name; the help of each lists its backends."""
    owners: dict[str, list[str]] = {}
    options: dict[str, Option] = {}
    for backend in all_backends(work):
        for option in backend.options:
            owners.setdefault(option.name, []).append(backend.name)
            options.setdefault(option.name, option)
    return {name: option.setting(owners[name]) for name, option in options.items()}


def for_file(path: Path | str, work: Work | None = None) -> Backend:
    """Return the first backend by name that writes files of ``path``'s type, of those that are installed if any is.

    Raises
    ------
    SceneError
        "backend" if no backend writes such files.
    """
    from pathlib import Path

    ending = Path(path).suffix.lower()
    candidates = all_backends(work)
    for longest in ("".join(Path(path).suffixes[-2:]).lower(), ending):  # .mjcf.xml before .xml
        writers = [backend for backend in candidates if longest in backend.endings]
        if writers:
            return find(next((backend for backend in writers if backend.is_installed), writers[0]).name)
    known = sorted({ending for backend in candidates for ending in backend.endings})
    shown = f"`{ending}` files" if ending else "files without an extension"
    verb = f"`{work.value}` does not write" if work is not None else "no backend writes"
    raise SceneError("backend", f"{verb} {shown}", hint=f"it writes {' '.join(known)}" if known else None)
