"""Spec of a dataset: distributions, labels, filters and output, read from TOML (docs/datasets.md)."""

from __future__ import annotations

import hashlib
import json
import math
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from fnmatch import fnmatchcase
from functools import cached_property
from glob import glob
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from scenelang.backends.base import require
from scenelang.backends.files import program_files, read_regular, reason_of
from scenelang.backends.unreadable import unreadable
from scenelang.files.toml_places import TomlTable, parsed, shown
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import SceneError, suggest
from scenelang.grammar.reader import read
from scenelang.interpreter.loading import entry_points_of
from scenelang.interpreter.values.limits import Limits
from scenelang.session.declarations import declaration_problem
from scenelang.session.session import IMPORT_FORM

CODE = "dataset"
VERSION = 1
MAX_SAMPLES = 1_000_000_000  # of a dataset
MAX_VIEWS = 1_000  # of a sample
MAX_PROGRAMS = 100_000  # of a spec
MAX_SHARD = 100_000  # samples of a shard
_MAX_CHOICES = 100_000  # of a distribution
_MAX_SIDE_PX = 8_192  # pixels of an image along each axis
_MAX_IMPORTS = 1_000  # files that a program imports, for its digest
_BYTES_PER_PIXEL = 330  # of memory that a worker needs at least, measured with depth as the only label
MEMORY_SLACK = 1.25  # times the limit of memory, above which workers are ended
_MAX_SPLIT_NAME_LENGTH = 64  # letters, digits and underscores of a split's name
_MAX_BOUND = 1e300  # bound of a range, so that its width is finite
_PROGRAMS = (".scene", ".json", ".py", ".txt", ".ipynb")
_FIELD = re.compile(r"\{([^{}]*)\}")
_FIELDS = ("things", "seen", "word", "environment")

LABELS = (
    "instance", "semantic", "levels", "depth", "normals", "albedo", "flow", "tracks", "boxes", "visibility",
    "keypoints", "graph", "captions", "program",
)  # fmt: skip
DEFAULT_LABELS = ("instance", "semantic", "depth", "normals", "boxes", "captions")
FORMATS = ("webdataset", "parquet", "coco", "kitti", "bop", "nerfstudio", "colmap", "mot", "tap")
SHARD_FORMATS = ("webdataset", "parquet")
# Labels that a format needs, besides the images.
NEEDS: Mapping[str, tuple[str, ...]] = {
    "coco": ("instance", "boxes"), "kitti": ("boxes", "visibility"),
    "bop": ("instance", "depth", "boxes", "visibility"),
    "nerfstudio": ("depth",), "colmap": ("depth",), "mot": ("boxes",), "tap": ("tracks",),
}  # fmt: skip
# Files and folders next to those of the splits, which no split of that format may be named after.
TAKEN: Mapping[str, tuple[str, ...]] = {"coco": ("annotations",), "bop": ("models",), "mot": ("seqmaps",)}
PERSPECTIVE = ("nerfstudio", "colmap", "bop", "kitti")  # formats without orthographic cameras
LOOKS = ("color", "roughness", "metallic", "opacity", "emission", "ior")
CAMERAS = ("hemisphere", "orbit", "trajectory", "file")
PREDICATES = "scenelang.filters"  # group of entry points


# --- distributions ---------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Distribution:
    """Distribution of one quantity.

    ``kind`` is "choice" among ``values`` with ``weights`` (K,), or "uniform", "loguniform", "normal" or "integer" with
    the two parameters in ``values``; drawn numbers are clipped to ``low`` and ``high``.

    Examples
    --------
    >>> import numpy as np
    >>> Distribution("integer", (3, 3)).draw(np.random.default_rng(1))
    3
    """

    kind: str
    values: tuple[Any, ...]
    weights: tuple[float, ...] = ()
    low: float = -math.inf
    high: float = math.inf

    @property
    def is_fixed(self) -> bool:
        """Whether the quantity does not vary."""
        return self.kind == "choice" and len(self.values) == 1

    def draw(self, random: np.random.Generator) -> Any:
        """Return a plain value: a number, a boolean, a string or a list of numbers."""
        if self.kind == "choice":
            if len(self.values) == 1:
                return self.values[0]
            shares = np.array(self.weights or [1.0] * len(self.values))
            return self.values[int(np.searchsorted(np.cumsum(shares), random.random() * shares.sum(), side="right"))]
        first, second = self.values
        if self.kind == "integer":
            return int(random.integers(first, second, endpoint=True))
        if self.kind == "normal":
            value = float(random.normal(first, second))
        elif self.kind == "loguniform":
            value = math.exp(float(random.uniform(math.log(first), math.log(second))))
        else:
            value = float(random.uniform(first, second))
        return self.clipped(value)

    def clipped(self, value: float) -> float:
        """Return the number within the bounds that is nearest to a number."""
        return min(max(value, self.low), self.high)


def fixed(value: Any) -> Distribution:
    """Return the distribution of a quantity that does not vary."""
    return Distribution("choice", (value,))


def _distribution(table: TomlTable, key: str, default: Any = None) -> Distribution:
    """Read a distribution: a value, a list of choices, or a table such as ``{ uniform = [0, 1] }``."""
    value = table.take(key, default)
    if isinstance(value, list):
        return Distribution("choice", _choices(table, key, value))
    if isinstance(value, dict):
        return _described(table.table(key))
    if key in table and not _is_plain(value):
        table.fail(key, f"`{key}`: expected a number, boolean, string, list or table, got {shown(value)}")
    return fixed(value)


def _described(table: TomlTable) -> Distribution:
    """Read the table of a distribution, with exactly one kind."""
    name = table.path[-1]
    kinds = ("uniform", "loguniform", "normal", "integer", "choice", "value")
    given_kinds = [kind for kind in kinds if kind in table]
    if len(given_kinds) != 1:
        stray = next((key for key in table if key not in (*kinds, "weights", "min", "max")), None)
        if stray is not None:
            table.check_choice(stray, stray, (*kinds, "weights", "min", "max"))
        table.fail(None, f"`{name}`: expected one of {', '.join(kinds)}, got {len(given_kinds) or 'none'} of them")
    kind = given_kinds[0]
    if kind == "value":
        distribution = fixed(_hashable(table, kind, table.take(kind)))
    elif kind == "choice":
        values = table.take(kind)
        if not isinstance(values, list):
            table.fail(kind, f"`choice`: expected a list, got {shown(values)}")
        distribution = Distribution("choice", _choices(table, kind, values), _weights(table, len(values)))
    else:
        distribution = _range(table, kind)
    table.finish()
    return distribution


def _choices(table: TomlTable, key: str, values: list[Any]) -> tuple[Any, ...]:
    """Return the validated choices of a distribution."""
    if not 1 <= len(values) <= _MAX_CHOICES:
        table.fail(key, f"`{key}`: expected 1 to {_MAX_CHOICES:,} choices, got {len(values):,}")
    return tuple(_hashable(table, key, value, str(i)) for i, value in enumerate(values))


def _hashable(table: TomlTable, key: str, value: Any, *place: str) -> Any:
    """Return a plain value, lists as tuples."""
    path = (*table.path, key, *place)
    if isinstance(value, list):
        if not value or not all(_is_plain(item) for item in value):
            message = f"`{key}`: expected numbers, booleans, strings or lists of them, got {shown(value)}"
            table.document.fail(path, message)
        return tuple(value)
    if not _is_plain(value):
        table.document.fail(path, f"`{key}`: expected a number, boolean, string or a list of them, got {shown(value)}")
    return value


def _is_plain(value: Any) -> bool:
    """Return whether a value is a finite number, a boolean or a string."""
    return isinstance(value, bool | int | str) or (isinstance(value, float) and math.isfinite(value))


def _is_number(value: Any) -> bool:
    """Return whether a value is a finite number, not a boolean."""
    return type(value) in (int, float) and math.isfinite(value)


def _weights(table: TomlTable, count: int) -> tuple[float, ...]:
    """Read the weights of choices, empty if they are equal."""
    weights = table.take("weights", [])
    if not isinstance(weights, list) or not all(_is_number(w) and 0 <= w <= _MAX_BOUND for w in weights):
        table.fail("weights", f"`weights`: expected finite numbers of at least 0, got {shown(weights)}")
    if weights and (len(weights) != count or not sum(weights) > 0):
        table.fail("weights", f"`weights`: expected {count} numbers with a positive sum, got {len(weights)}")
    return tuple(float(weight) for weight in weights)


def _range(table: TomlTable, kind: str) -> Distribution:
    """Read a distribution with two parameters, and its bounds."""
    pair = table.take(kind)
    allowed = (int,) if kind == "integer" else (int, float)
    if not isinstance(pair, list) or len(pair) != 2 or not all(type(x) in allowed and math.isfinite(x) for x in pair):
        expected = "two whole numbers" if kind == "integer" else "two numbers"
        table.fail(kind, f"`{kind}`: expected {expected}, got {shown(pair)}")
    first, second = pair
    if max(abs(first), abs(second)) > _MAX_BOUND:
        table.fail(kind, f"`{kind}`: expected numbers of at most {_MAX_BOUND:g}, got [{first:g}, {second:g}]")
    if kind == "normal":
        if second < 0:
            table.fail(kind, f"`normal`: expected a deviation of at least 0, got {second:g}")
    elif first > second:
        table.fail(kind, f"`{kind}`: the range [{first:g}, {second:g}] is empty", f"write [{second:g}, {first:g}]")
    elif kind == "loguniform" and first <= 0:
        table.fail(kind, f"`loguniform`: expected positive numbers, got {first:g}")
    low = table.number("min", -math.inf, -math.inf, math.inf)
    high = table.number("max", math.inf, -math.inf, math.inf)
    if low > high:
        table.fail("min", f"`min`: {low:g} is above `max`, {high:g}")
    return Distribution(kind, (first, second), (), low, high)


# --- the parts of a spec ---------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class WordChange:
    """Change of a word: distributions of its entities' looks, and of the expression that it is bound to."""

    looks: Mapping[str, Distribution]
    bind: Distribution | None = None


@dataclass(frozen=True, slots=True)
class CameraPlan:
    """Cameras of a sample: ``views`` of them, of one ``kind``.

    Angles are in degrees, ``distance`` and ``target`` in scene units (None: chosen to frame the scene); ``eyes`` (K, 3)
    and ``target`` are the trajectory; ``files`` are JSON cameras. ``sweep`` is the angle that an orbit covers.
    """

    kind: str = "hemisphere"
    views: int = 1
    azimuth: Distribution = Distribution("uniform", (-180.0, 180.0))
    elevation: Distribution = Distribution("uniform", (5.0, 65.0))
    fov: Distribution = Distribution("choice", (35.0,))
    distance: Distribution = Distribution("choice", (None,))
    sweep: float = 360.0
    target: tuple[float, float, float] | None = None
    orthographic: bool = False
    eyes: tuple[tuple[float, float, float], ...] = ()
    files: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class PicturePlan:
    """Images: size in pixels, quality, environment, ground, settings of the backend, and frames of a 4D scene."""

    width: int = 256
    height: int = 256
    quality: Distribution = Distribution("choice", ("draft",))
    environment: Distribution = Distribution("choice", ("studio",))
    ground: Distribution = Distribution("choice", (None,))
    settings: Mapping[str, Any] | None = None
    frames: tuple[int, int] | None = None


@dataclass(frozen=True, slots=True)
class LabelPlan:
    """Labels: names of those to write, words that count as objects, keypoints by word, levels and tracked points."""

    write: tuple[str, ...] = DEFAULT_LABELS
    words: tuple[str, ...] = ()
    keypoints: tuple[str, ...] = ()
    levels: int = 4
    tracks: int = 64
    captions: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class SplitPlan:
    """Splits: ``by`` "program", "scene" or the name of a param, and a rule for each split.

    A rule is a share, patterns of programs, a range or values of the param, or "rest" for all others.
    """

    by: str
    rules: Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class FilterPlan:
    """Filters that a sample must pass.

    They are the least visible share of the image by word, no findings of the geometric check, stability under gravity,
    declarations, and predicates by name.
    """

    visible: Mapping[str, float]
    geometry: bool = False
    stable: bool = False
    that: tuple[str, ...] = ()
    predicates: tuple[str, ...] = ()
    attempts: int = 20


@dataclass(frozen=True, slots=True)
class OutputPlan:
    """Output: formats, and samples per shard."""

    formats: tuple[str, ...] = ("webdataset",)
    shard: int = 100
    licence: str = ""

    @property
    def shards(self) -> str:
        """Return the format of the shards, from which the other formats are made in one pass at the end.

        One sampler, one set of labels and one rule of commitment then serve all formats, at the cost of disk space.
        """
        return next((name for name in self.formats if name in SHARD_FORMATS), "webdataset")


@dataclass(frozen=True)
class Spec:
    """Spec of a dataset. ``text`` is its source; its paths are relative to ``folder``."""

    name: str
    text: str
    folder: str
    programs: tuple[str, ...]
    count: int
    seed: int
    seeds: Distribution | None
    root: str | None
    params: Mapping[str, Distribution]
    words: Mapping[str, WordChange]
    cameras: CameraPlan
    pictures: PicturePlan
    labels: LabelPlan
    splits: SplitPlan | None
    filters: FilterPlan
    output: OutputPlan
    limits: Limits

    @cached_property
    def texts(self) -> dict[str, str]:
        """Digest of every program with the files that it imports, by path."""
        return {path: _digest_of(Path(path)) for path in self.programs}

    @cached_property
    def matched_splits(self) -> dict[str, str]:
        """Split of every text whose program a pattern matches, by its digest.

        Programs of equal text are in one split, whatever their names: the first with a pattern that matches one.
        """
        split_of_text: dict[str, str] = {}
        for split, rule in self.splits.rules.items() if self.splits is not None else ():
            for path in self.programs if isinstance(rule, tuple) else ():
                if any(fnmatchcase(self.program_name(path), str(pattern)) for pattern in rule):
                    split_of_text.setdefault(self.texts[path], split)
        return split_of_text

    @cached_property
    def digest(self) -> str:
        """Digest of everything that can change a byte of a sample, without the number of samples."""
        plan = {
            "version": VERSION, "seed": self.seed, "seeds": self.seeds, "root": self.root, "params": self.params,
            "words": self.words, "cameras": replace(self.cameras, files=self._camera_digests),
            "pictures": self.pictures, "labels": self.labels,
            "splits": self.splits, "filters": self.filters,
            "programs": [(self.program_name(path), self.texts[path]) for path in self.programs],
        }  # fmt: skip
        data = json.dumps(plan, sort_keys=True, default=_plain)
        return hashlib.sha256(data.encode("utf-8", "surrogatepass")).hexdigest()

    @property
    def _camera_digests(self) -> tuple[str, ...]:
        """Return the digests of the camera files."""
        return tuple(_digest_of(Path(path)) for path in self.cameras.files)

    def program_name(self, path: str) -> str:
        """Return a program's path relative to the spec's folder, as samples record it."""
        try:
            return Path(os.path.relpath(path, Path(self.folder).resolve())).as_posix()
        except ValueError:  # another drive of Windows
            return Path(path).name


def _plain(value: Any) -> Any:
    """Return a part of a spec as plain data."""
    return asdict(value)


def _digest_of(path: Path) -> str:
    """Return the digest of a file and of the files that it imports, whatever they are called."""
    total, waiting, visited = hashlib.sha256(), [path.resolve()], set[Path]()
    while waiting:
        target = waiting.pop()
        if target in visited or len(visited) > _MAX_IMPORTS:
            continue
        visited.add(target)
        try:
            data = read_regular(target)
        except OSError as error:
            if target == path.resolve():
                raise SceneError("file", f"cannot read {path}: {error.strerror or error}") from None
            continue  # the evaluation reports it
        total.update(len(data).to_bytes(8, "little") + data)
        names = IMPORT_FORM.findall(data.decode("utf-8", "replace"))
        waiting += [(target.parent / name).resolve() for name in reversed(names)]
    return total.hexdigest()


# --- reading ---------------------------------------------------------------------------------------------------------


def read_spec(path: str | Path) -> Spec:
    """Read the spec of a dataset.

    Raises
    ------
    SceneError
        "dataset" with line and column for a mistake in the file, "file" if it or a program cannot be read.
    """
    try:
        text = read_regular(path, 2_000_000).decode("utf-8-sig")
    except OSError as error:
        raise unreadable(str(path), str(path), reason_of(error)) from None
    except UnicodeDecodeError:
        raise SceneError("encoding", f"{path} is not UTF-8 text", "save it as UTF-8") from None
    return spec_of(text, str(path), Path(path).resolve().parent)


def spec_of(text: str, name: str, folder: Path) -> Spec:
    """Return the spec in a TOML text whose paths are relative to ``folder``; raises SceneError as ``read_spec``."""
    table = parsed(Source(name, text), CODE)
    seeds = _distribution(table, "seeds") if "seeds" in table else None
    spec = Spec(
        name=name,
        text=text,
        folder=str(folder),
        programs=_programs(table, folder),
        count=table.number("count", 1, 1, MAX_SAMPLES),
        seed=table.number("seed", 0, 0, (1 << 63) - 1),
        seeds=_checked_seeds(table, seeds),
        root=table.text("root", None),
        params=_params(table.table("params")),
        words=_words(table.table("words")),
        cameras=_cameras(table.table("cameras"), folder),
        pictures=_pictures(table.table("pictures")),
        labels=_labels(table.table("labels"), table.table("captions")),
        splits=_splits(table),
        filters=_filters(table.table("filters")),
        output=_output(table.table("output")),
        limits=_limits(table.table("limits")),
    )
    table.finish()
    _check_together(table, spec)
    return spec


def _checked_seeds(table: TomlTable, seeds: Distribution | None) -> Distribution | None:
    """Return the distribution of seeds, which are 32-bit whole numbers."""
    if seeds is not None and not all(type(x) is int and 0 <= x < 1 << 32 for x in seeds.values):
        table.fail("seeds", f"`seeds`: expected whole numbers from 0 to {(1 << 32) - 1}")
    if seeds is not None and seeds.kind not in ("choice", "integer"):
        table.fail("seeds", f"`seeds`: expected whole numbers, not `{seeds.kind}`")
    return seeds


def _programs(table: TomlTable, folder: Path) -> tuple[str, ...]:
    """Return the paths of all programs, in the order of the patterns."""
    paths: dict[str, None] = {}
    patterns = table.texts("programs")
    if not patterns and "programs" in table:
        table.fail("programs", "`programs`: name at least one program")
    if not patterns:
        table.fail_missing("programs", "`programs`: name at least one program")
    for number, pattern in enumerate(patterns):
        matches = _matches(folder, pattern) if pattern else []
        if not matches and pattern and _exists(folder / pattern):
            message = f"`programs`: `{pattern[:80]}` {'has' if (folder / pattern).is_dir() else 'is'} no program"
            table.document.fail(("programs", str(number)), message, f"programs end in {', '.join(_PROGRAMS)}")
        if not matches:
            message = f"`programs`: no program matches `{pattern[:80]}`"
            table.document.fail(("programs", str(number)), message, f"paths are relative to {folder}")
        paths |= dict.fromkeys(matches)
        if len(paths) > MAX_PROGRAMS:
            table.fail("programs", f"`programs`: more than {MAX_PROGRAMS:,} files")
    return tuple(paths)


def _exists(path: Path) -> bool:
    """Return whether a path exists; a path that is too long does not."""
    try:
        return path.exists()
    except OSError:  # a name of thousands of letters
        return False


def _matches(folder: Path, pattern: str) -> list[str]:
    """Return the programs that a path or glob names, sorted; folders may be runs of a language model."""
    paths = [pattern] if _exists(folder / pattern) else sorted(glob(pattern, root_dir=folder, recursive=True))
    files: list[str] = []
    for path in paths:
        target = folder / path
        if target.is_dir():
            best = target / "best.scene"  # the result of a run
            files += [str(best)] if best.is_file() else sorted(program_files([str(target)]))
        else:
            files.append(str(target))
    return [str(Path(file).resolve()) for file in files if Path(file).is_file() and file.endswith(_PROGRAMS)]


def _params(table: TomlTable) -> Mapping[str, Distribution]:
    """Read the distributions of params."""
    return {name: _distribution(table, name) for name in table}


def _words(table: TomlTable) -> Mapping[str, WordChange]:
    """Read the changes of words."""
    changes = {}
    for word in table:
        word_table = table.table(word)
        looks = {name: _distribution(word_table, name) for name in LOOKS if name in word_table}
        for name, look in looks.items():
            _check_look(word_table, name, look)
        bind = _distribution(word_table, "bind") if "bind" in word_table else None
        if bind is not None and not all(isinstance(text, str) and text.strip() for text in bind.values):
            word_table.fail(
                "bind", "`bind`: expected the text of an expression", 'write bind = ["(lambda () (call \\"cube\\"))"]'
            )
        for text in bind.values if bind is not None else ():
            _check_expression(word_table, text)
        for name in (*LOOKS, "bind"):
            word_table.take(name)
        word_table.finish()
        if not looks and bind is None:
            table.fail(word, f"`{word}`: nothing varies", f"give {', '.join((*LOOKS, 'bind'))}")
        changes[word] = WordChange(looks, bind)
    return changes


def _check_look(table: TomlTable, name: str, look: Distribution) -> None:
    """Raise an error for a value that the attribute of a material cannot have."""
    from scenelang.stdlib.colors import color_of

    for value in look.values:
        is_vector = isinstance(value, tuple) and len(value) == 3 and all(map(_is_number, value))
        if name == "color" and isinstance(value, str):
            try:
                color_of(value)
            except SceneError as error:
                table.fail(name, f"`{name}`: {error.message}", error.hint)
        elif name == "color" and not is_vector:
            table.fail(name, f"`{name}`: expected colors, got {shown(value)}", 'write "red", "#3f5c45" or [r, g, b]')
        elif not (_is_number(value) or (is_vector and name in ("color", "emission"))):
            table.fail(name, f"`{name}`: expected numbers, got {shown(value)}")


def _check_expression(table: TomlTable, text: str) -> None:
    """Raise an error for a text of ``bind`` that is not one expression."""
    document = read(Source("bind", text))
    problem = next((diagnostic for diagnostic in document.diagnostics if diagnostic.is_error), None)
    if problem is not None:
        table.fail("bind", f"`bind`: {problem.message}", problem.hint)
    if len(document.forms) != 1:
        table.fail("bind", f"`bind`: expected one expression, got {len(document.forms)}")


def _cameras(table: TomlTable, folder: Path) -> CameraPlan:
    """Read the plan of cameras."""
    default = CameraPlan()
    kind = table.text("kind", default.kind, CAMERAS)
    plan = CameraPlan(
        kind=kind,
        views=table.number("views", 1, 1, MAX_VIEWS),
        azimuth=_angles(table, "azimuth", default.azimuth, -36_000.0, 36_000.0),
        elevation=_angles(table, "elevation", default.elevation, -90.0, 90.0),
        fov=_angles(table, "fov", default.fov, 0.1, 179.0),
        distance=_angles(table, "distance", default.distance, 1e-9, 1e12),
        sweep=table.number("sweep", 360.0, -36_000.0, 36_000.0),
        target=_point(table, "target") if "target" in table else None,
        orthographic=table.flag("orthographic", False),
        eyes=_points(table, "eyes"),
        files=_camera_files(table, folder),
    )
    table.finish()
    if kind == "trajectory" and (len(plan.eyes) < 2 or plan.target is None):
        table.fail("kind", "a trajectory needs `eyes`, two points or more, and the `target` that it looks at")
    if kind == "file" and not plan.files:
        table.fail("kind", "cameras from files need `files`")
    return plan


def _angles(table: TomlTable, key: str, default: Distribution, low: float, high: float) -> Distribution:
    """Read a distribution of numbers within bounds, to which its draws are clipped."""
    if key not in table:
        table.take(key)
        return default
    distribution = _distribution(table, key)
    bounds = distribution.values[:1] if distribution.kind == "normal" else distribution.values
    if not all(isinstance(x, int | float) and not isinstance(x, bool) and low <= x <= high for x in bounds):
        table.fail(key, f"`{key}`: expected numbers from {low:g} to {high:g}")
    return replace(distribution, low=max(low, distribution.low), high=min(high, distribution.high))


def _point(table: TomlTable, key: str) -> tuple[float, float, float]:
    """Read three finite numbers."""
    value = table.take(key)
    if not isinstance(value, list) or len(value) != 3 or not all(map(_is_number, value)):
        table.fail(key, f"`{key}`: expected three finite numbers, got {shown(value)}")
    x, y, z = (float(item) for item in value)
    return x, y, z


def _points(table: TomlTable, key: str) -> tuple[tuple[float, float, float], ...]:
    """Read a list of points."""
    value = table.take(key, [])
    if not isinstance(value, list) or len(value) > MAX_VIEWS:
        table.fail(key, f"`{key}`: expected at most {MAX_VIEWS:,} points, got {shown(value)}")
    inner = TomlTable({str(i): item for i, item in enumerate(value)}, (*table.path, key), table.document)
    return tuple(_point(inner, str(i)) for i in range(len(value)))


def _camera_files(table: TomlTable, folder: Path) -> tuple[str, ...]:
    """Return the paths of camera files, each of which is validated."""
    from scenelang.backends.pictures.camera import read_camera

    paths: list[str] = []
    for pattern in table.texts("files"):
        matches = sorted(glob(pattern, root_dir=folder, recursive=True))
        if not matches:
            table.fail("files", f"`files`: nothing matches `{pattern[:80]}`", f"paths are relative to {folder}")
        paths += [str((folder / path).resolve()) for path in matches]
    for path in paths:
        try:
            read_camera(path)
        except SceneError as error:
            table.fail("files", f"`files`: {Path(path).name}: {error.message}", error.hint)
    return tuple(paths)


def _pictures(table: TomlTable) -> PicturePlan:
    """Read the plan of images; checks the settings with the backends."""
    from scenelang.backends.pictures.film import PictureOptions, check, picture_backend
    from scenelang.backends.surfaces.environments import ENVIRONMENTS, GROUNDS

    width, height = _size(table)
    environment = _names(table, "environment", "studio", tuple(ENVIRONMENTS))
    ground = _names(table, "ground", None, tuple(GROUNDS))
    settings = dict(table.take("settings", {}) or {}) if isinstance(table.take("settings", {}), dict) else None
    if settings is None:
        table.fail("settings", "`settings`: expected a table of options of the backend")
    quality = _names(table, "quality", "draft")
    frames = _frames(table)
    table.finish()
    try:
        backends = [picture_backend(str(name)) for name in quality.values]
        check(PictureOptions(width=width, height=height, settings=settings), backends)
    except SceneError as error:
        table.fail("settings" if settings else "quality", error.message, error.hint)
    return PicturePlan(width, height, quality, environment, ground, settings, frames)


def _size(table: TomlTable) -> tuple[int, int]:
    """Read an image size in pixels: a number or a pair."""
    value = table.take("size", [256, 256])
    value = [value, value] if type(value) is int else value
    if (
        not isinstance(value, list)
        or len(value) != 2
        or not all(type(x) is int and 1 <= x <= _MAX_SIDE_PX for x in value)
    ):
        table.fail("size", f"`size`: expected [width, height] from 1 to {_MAX_SIDE_PX:,} pixels, got {shown(value)}")
    return value[0], value[1]


def _names(table: TomlTable, key: str, default: str | None, known: Sequence[str] = ()) -> Distribution:
    """Read a distribution of names."""
    distribution = _distribution(table, key, default)
    for value in distribution.values if key in table else ():
        if not isinstance(value, str):
            table.fail(key, f"`{key}`: expected names, got {shown(value)}")
        if known:
            table.check_choice(key, value, known)
    return distribution


def _frames(table: TomlTable) -> tuple[int, int] | None:
    """Read the first and last frame, None for all."""
    if "frames" not in table:
        table.take("frames")
        return None
    value = table.take("frames")
    if not isinstance(value, list) or len(value) != 2 or not all(type(x) is int and 0 <= x < 10_000 for x in value):
        table.fail("frames", f"`frames`: expected [first, last], got {shown(value)}")
    if value[0] > value[1]:
        table.fail("frames", f"`frames`: the range [{value[0]}, {value[1]}] is empty")
    return value[0], value[1]


def _labels(table: TomlTable, captions: TomlTable) -> LabelPlan:
    """Read the plan of labels."""
    write = table.texts("write", DEFAULT_LABELS, LABELS)
    plan = LabelPlan(
        write=tuple(name for name in LABELS if name in write),
        words=table.texts("words"),
        keypoints=table.texts("keypoints"),
        levels=table.number("levels", 4, 1, 64),
        tracks=table.number("tracks", 64, 1, 100_000),
        captions=captions.texts("templates"),
    )
    table.finish()
    captions.finish()
    return plan


def _splits(table: TomlTable) -> SplitPlan | None:
    """Read the splits, None for a single one."""
    if "splits" not in table:
        table.take("splits")
        return None
    split_table = table.table("splits")
    by = split_table.text("by", "scene")
    rules = {name: _rule(split_table, name) for name in split_table if name != "by"}
    if len(rules) < 2:
        split_table.fail(None, "`splits`: name at least two splits", "such as train = 0.8 and test = 0.2")
    if by in ("scene", "program") and all(isinstance(rule, float) for rule in rules.values()):
        if not math.isclose(sum(rules.values()), 1.0, abs_tol=1e-6):
            split_table.fail(None, f"`splits`: the shares sum to {sum(rules.values()):g}, not to 1")
    elif by == "scene":
        split_table.fail("by", "splits by scene are shares, such as train = 0.8 and test = 0.2")
    elif any(isinstance(rule, float) for rule in rules.values()):
        expected = (
            "shares only, or patterns of programs" if by == "program" else "{ range = [low, high] } or a list of values"
        )
        name = next(name for name, rule in rules.items() if isinstance(rule, float))
        split_table.fail(name, f"`{name}`: expected {expected}")
    _check_disjoint(split_table, by, rules)
    return SplitPlan(by, rules)


def is_split_name(name: str) -> bool:
    """Return whether a split may have this name, which begins the names of its files."""
    return name.isidentifier() and len(name) <= _MAX_SPLIT_NAME_LENGTH


def _rule(table: TomlTable, name: str) -> Any:
    """Read the rule of a split."""
    value = table.take(name)
    if not is_split_name(name):
        hint = f"use at most {_MAX_SPLIT_NAME_LENGTH} letters, digits and underscores"
        table.fail(name, f"`{name[:60]}` is not a name for a split", hint)
    if type(value) in (int, float):
        if not 0 < value <= 1:
            table.fail(name, f"`{name}`: expected a share above 0 and at most 1, got {value:g}")
        return float(value)
    if isinstance(value, dict):
        rule_table = table.table(name)
        pair = rule_table.take("range")
        is_pair = isinstance(pair, list) and len(pair) == 2 and all(type(x) in (int, float) and x == x for x in pair)
        if not is_pair:
            rule_table.fail("range" if "range" in rule_table else None, f"`{name}`: expected {{ range = [low, high] }}")
        if pair[0] >= pair[1]:
            rule_table.fail("range", f"`range`: the range [{pair[0]:g}, {pair[1]:g}) is empty")
        rule_table.finish()
        return {"range": (float(pair[0]), float(pair[1]))}
    if value == "rest" or (isinstance(value, list) and value):
        return value if value == "rest" else tuple(_hashable(table, name, item) for item in value)
    table.fail(name, f'`{name}`: expected a share, a list, {{ range = [low, high] }} or "rest", got {shown(value)}')


def _check_disjoint(table: TomlTable, by: str, rules: Mapping[str, Any]) -> None:
    """Raise an error if a sample could be in two splits."""
    if sum(rule == "rest" for rule in rules.values()) > 1:
        table.fail(None, "`splits`: only one split can be the rest")
    splits_by_value: dict[Any, str] = {}
    ranges: list[tuple[float, float, str]] = []
    for name, rule in rules.items():
        if isinstance(rule, tuple):
            for value in rule if by != "program" else ():
                if value in splits_by_value:
                    table.fail(
                        name, f"`{name}`: {shown(value)} is also in `{splits_by_value[value]}`, which would leak"
                    )
                splits_by_value[value] = name
        elif isinstance(rule, dict):
            ranges.append((*rule["range"], name))
    ranges.sort()
    for (_, end, first), (start, _, second) in pairwise(ranges):
        if start < end:
            table.fail(second, f"`{second}`: the range overlaps that of `{first}`, which would leak")
    for low, high, other in ranges:
        for value, name in splits_by_value.items():
            if _is_number(value) and low <= value < high and name != other:
                table.fail(name, f"`{name}`: {shown(value)} is in the range of `{other}`, which would leak")


def _filters(table: TomlTable) -> FilterPlan:
    """Read the filters; checks that predicates and the simulator are installed."""
    visible_table = table.table("visible")
    visible = {word: visible_table.number(word, None, 0.0, 1.0) for word in visible_table}
    predicates = table.texts("predicates")
    known = entry_points_of(PREDICATES)
    for name in predicates:
        if name not in known:
            listed = (
                f"installed: {', '.join(sorted(known))}" if known else f"no package has the entry point {PREDICATES}"
            )
            table.fail("predicates", f"`predicates`: unknown `{name[:60]}`", listed)
    geometry, stable = table.flag("geometry", False), table.flag("stable", False)
    that = table.texts("that")
    for number, text in enumerate(that):
        problem = declaration_problem(text)
        if problem is not None:
            table.fail("that", f"`that`: declaration {number + 1}: {problem.message}", problem.hint)
    if stable:
        require("mujoco", "'scenelang[physics]'")
    plan = FilterPlan(visible, geometry, stable, that, predicates, table.number("attempts", 20, 1, 10_000))
    table.finish()
    return plan


def _output(table: TomlTable) -> OutputPlan:
    """Read the formats and the size of shards."""
    formats = table.texts("formats", ("webdataset",), FORMATS)
    plan = OutputPlan(formats, table.number("shard", 100, 1, MAX_SHARD), table.text("licence", ""))
    table.finish()
    if sum(name in SHARD_FORMATS for name in formats) > 1:
        table.fail("formats", "`formats`: shards are webdataset or parquet, not both")
    return plan


def _limits(table: TomlTable) -> Limits:
    """Read the limits of an evaluation."""
    default = Limits()
    limits = Limits(
        steps=table.number("steps", default.steps, 1, 10**15),
        depth=table.number("depth", default.depth, 1, 10**9),
        entities=table.number("entities", default.entities, 1, 10**12),
        primitives=table.number("primitives", default.primitives, 1, 10**9),
        size=table.number("size", default.size, 1, 10**12),
        memory=table.number("memory", default.memory, 10**6, 10**15),
        seconds=table.number("seconds", default.seconds, 0.1, 86_400.0),
    )
    table.finish()
    return limits


def _check_together(table: TomlTable, spec: Spec) -> None:
    """Raise an error for parts that do not fit each other."""
    _check_needs(table, spec)
    _check_projection(table, spec)
    _check_captions(table, spec)
    _check_memory(table, spec)
    if "keypoints" in spec.labels.write and not spec.labels.keypoints:
        table.table("labels").fail("write", "`write`: keypoints of no words", 'name them: keypoints = ["eye"]')
    if spec.splits is not None and spec.splits.by not in ("scene", "program", *spec.params):
        hint = f"split by scene, program or one of {', '.join(spec.params) or 'the params that vary'}"
        table.table("splits").fail("by", f"`by`: `{spec.splits.by[:60]}` does not vary", hint)
    if spec.splits is not None:
        _check_split_names(table, spec, spec.splits.rules)
    if spec.splits is not None and spec.splits.by == "program":
        _check_patterns(table, spec, spec.splits.rules)
        _check_shares(table, spec, spec.splits.rules)
    elif spec.splits is not None and spec.splits.by in spec.params:
        _check_reached(table, spec.params[spec.splits.by], spec.splits)


def _check_reached(table: TomlTable, quantity: Distribution, splits: SplitPlan) -> None:
    """Raise an error if no value of the param is in a split."""
    ranges = sorted(rule["range"] for rule in splits.rules.values() if isinstance(rule, dict))
    listed = {value for rule in splits.rules.values() if isinstance(rule, tuple) for value in rule}
    for name, rule in splits.rules.items():
        if rule == "rest":
            reached = _reaches_rest(quantity, ranges, listed)
        elif isinstance(rule, dict):
            reached = _reaches_range(quantity, *rule["range"])
        else:
            reached = any(_may_be(quantity, value) for value in rule)
        if not reached:
            table.table("splits").fail(
                name, f"`{name}`: no value of `{splits.by}` is in this split, which would be empty"
            )


def _may_be(quantity: Distribution, value: Any) -> bool:
    """Return whether a value may be drawn; of continuous distributions only their bounds are drawn repeatedly."""
    if quantity.kind == "choice":
        return value in _chosen(quantity)
    first, second = quantity.values
    if quantity.kind == "integer":
        return _is_number(value) and value == int(value) and first <= value <= second
    return value in (quantity.low, quantity.high) or first == second == value


def _chosen(quantity: Distribution) -> list[Any]:
    """Return the choices with a positive weight."""
    shares = quantity.weights or (1.0,) * len(quantity.values)
    return [value for value, share in zip(quantity.values, shares, strict=True) if share > 0]


def _reaches_range(quantity: Distribution, low: float, high: float) -> bool:
    """Return whether a number from ``low`` to below ``high`` may be drawn."""
    if quantity.kind == "choice":
        return any(_is_number(value) and low <= value < high for value in _chosen(quantity))
    least, most = _span(quantity)
    if quantity.kind == "integer":
        return max(least, math.ceil(low)) <= min(most, math.ceil(high) - 1) if math.isfinite(low + high) else True
    return low <= most and least < high


def _span(quantity: Distribution) -> tuple[float, float]:
    """Return the least and the greatest number that may be drawn."""
    first, second = (-math.inf, math.inf) if quantity.kind == "normal" else quantity.values
    return (first, second) if quantity.kind == "integer" else (quantity.clipped(first), quantity.clipped(second))


def _reaches_rest(quantity: Distribution, ranges: Sequence[tuple[float, float]], listed: set[Any]) -> bool:
    """Return whether a value may be drawn that is in no range and not listed."""

    def is_rest(value: Any) -> bool:
        return value not in listed and not (_is_number(value) and any(low <= value < high for low, high in ranges))

    if quantity.kind == "choice":
        return any(map(is_rest, _chosen(quantity)))
    least, most = _span(quantity)
    if quantity.kind == "integer":
        return most - least >= _MAX_CHOICES or any(map(is_rest, range(int(least), int(most) + 1)))
    for low, high in ranges:
        least = high if low <= least < high else least
    return least <= most


def _check_split_names(table: TomlTable, spec: Spec, rules: Mapping[str, Any]) -> None:
    """Raise an error for splits whose folders would be those of a format, or of each other where case is ignored."""
    taken = {name: format_ for format_ in spec.output.formats for name in TAKEN.get(format_, ())}
    names_by_folded: dict[str, str] = {}
    for name in rules:
        folded = name.casefold()
        if folded in taken:
            message = f"`{name}`: {taken[folded]} has a folder of this name beside its splits"
            table.table("splits").fail(name, message, "choose another name for the split")
        if names_by_folded.setdefault(folded, name) != name:
            message = f"`{name}` and `{names_by_folded[folded]}` are one name where case is ignored"
            table.table("splits").fail(name, message, "choose another name for one of the splits")


def _check_shares(table: TomlTable, spec: Spec, rules: Mapping[str, Any]) -> None:
    """Raise an error if there are fewer programs than splits."""
    different = len(set(spec.texts.values()))
    if all(isinstance(rule, float) for rule in rules.values()) and different < len(rules):
        count = "one program" if different == 1 else f"{different:,} different programs"
        message = f"`by`: {count} cannot be dealt to {len(rules)} splits, of which some would be empty"
        table.table("splits").fail("by", message, 'write by = "scene", which decides by the evaluated scene')


def _check_patterns(table: TomlTable, spec: Spec, rules: Mapping[str, Any]) -> None:
    """Raise an error if a program is in no split, or a split has no program."""
    if not any(isinstance(rule, tuple) for rule in rules.values()):
        return
    names = [spec.program_name(path) for path in spec.programs]
    patterns = {split: tuple(map(str, rule)) for split, rule in rules.items() if isinstance(rule, tuple)}
    for split, split_patterns in patterns.items():
        if not any(fnmatchcase(name, pattern) for name in names for pattern in split_patterns):
            table.table("splits").fail(split, f"`{split}`: no program matches {', '.join(split_patterns)}"[:300])
    for split in patterns:
        if split not in spec.matched_splits.values():
            message = f"`{split}`: its programs, or programs of equal text, are in another split, so it would be empty"
            table.table("splits").fail(split, message)
    rest = next((split for split, rule in rules.items() if rule == "rest"), None)
    matched = spec.matched_splits
    unmatched = [name for path, name in zip(spec.programs, names, strict=True) if spec.texts[path] not in matched]
    if rest is not None and not unmatched:
        table.table("splits").fail(rest, f"`{rest}`: every program is in another split, so this one would be empty")
    if rest is None and unmatched:
        table.table("splits").fail(None, f"`splits`: `{unmatched[0]}` is in no split", 'name one split "rest"')


def _check_projection(table: TomlTable, spec: Spec) -> None:
    """Raise an error for a format that cannot describe orthographic cameras."""
    from scenelang.backends.pictures.camera import read_camera

    cameras = spec.cameras
    camera_files = map(read_camera, cameras.files if cameras.kind == "file" else ())
    perspective_formats = [name for name in spec.output.formats if name in PERSPECTIVE]
    if perspective_formats and (
        (cameras.orthographic and cameras.kind not in ("file", "trajectory"))
        or any(c.is_parallel for c in camera_files)
    ):
        message = f"`formats`: {perspective_formats[0]} has no orthographic cameras"
        table.table("output").fail(
            "formats", message, f"leave out {', '.join(perspective_formats)}, or use perspective cameras"
        )


def _check_memory(table: TomlTable, spec: Spec) -> None:
    """Raise an error for images that cannot be made within the limit of memory."""
    width, height, limit = spec.pictures.width, spec.pictures.height, spec.limits.memory
    needed = width * height * _BYTES_PER_PIXEL
    if needed > MEMORY_SLACK * limit:
        path = ("limits", "memory") if "memory" in table.table("limits") else ("pictures", "size")
        message = f"`{path[1]}`: {width:,} x {height:,} pixels need at least {needed / 1e9:.2g} GB of memory"
        hint = "reduce `size` in [pictures], or raise `memory` in [limits]"
        table.document.fail(path, f"{message}, more than the limit of {limit / 1e9:.2g} GB", hint)


def _check_captions(table: TomlTable, spec: Spec) -> None:
    """Raise an error for an unknown field of a template."""
    known = [*_FIELDS, *(f"param:{name}" for name in spec.params)]
    for number, template in enumerate(spec.labels.captions):
        for name in _FIELD.findall(template):
            if name not in known and not (name.startswith("count:") and name[6:]):
                hint = suggest(name, known) or (
                    "known are {things}, {seen}, {word}, {environment}, {count:WORD} and {param:NAME}"
                )
                path = ("captions", "templates", str(number))
                table.document.fail(path, f"a caption has the unknown field `{{{name[:60]}}}`", hint)


def _check_needs(table: TomlTable, spec: Spec) -> None:
    """Raise an error for a format whose labels are not written."""
    for name in spec.output.formats:
        missing = [label for label in NEEDS.get(name, ()) if label not in spec.labels.write]
        if missing:
            hint = f"add {', '.join(missing)} to `write` in [labels]"
            table.table("output").fail("formats", f"`formats`: {name} is made from {', '.join(missing)}", hint)


def varied(spec: Spec) -> Iterable[str]:
    """Yield the names of the quantities that vary from sample to sample."""
    if len(spec.programs) > 1:
        yield "program"
    for name, param in spec.params.items():
        if not param.is_fixed:
            yield f"param.{name}"
    for word, change in spec.words.items():
        quantities = {**change.looks} | ({"bind": change.bind} if change.bind is not None else {})
        for name, quantity in quantities.items():
            if not quantity.is_fixed:
                yield f"{word}.{name}"
