"""Cameras, lights, environment and render settings that a program declares, as plain data.

This is the vocabulary, registered once for the builtins, the checker, the reference and the JSON of a scene. Names of
environments, grounds and qualities are stored as they are written: what they mean, and whether they exist, is known to
the renderers (``backends.pictures.declared``).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

from scenelang.grammar.datum import Span, dataclass
from scenelang.grammar.diagnostics import LimitError, SceneError, suggest

POINT, DIRECTION, TARGET, NUMBER, FLAG, COLOR, SIZE, PIXELS, COUNT, NAME = (
    "point", "direction", "point or word", "number", "boolean", "color", "size", "pixels", "whole number", "name"
)  # fmt: skip
CAMERA, LIGHT, ENVIRONMENT, SETTINGS = "camera", "light", "environment", "render-settings"
LONGEST_NAME = 100  # characters of a name, and of the words that a camera looks at
MAX_DECLARED = {CAMERA: 1_000, LIGHT: 64}  # the draft renderer casts up to six shadow maps for each light
MAX_KEYS = 10_000  # values of a list over the frames: as many as frames of a video
# What a program may name, so that a check knows without the renderers (``backends/surfaces/environments``,
# ``backends/pictures/camera``), whose tables have the same names by a test. Qualities come from plug-ins, too.
ENVIRONMENTS = ("studio", "softboxes", "overcast", "sunny", "sunset", "night", "flat", "sky")
GROUNDS = ("seamless", "none", "white", "dark", "meadow", "earth", "checker")
PRESETS = (
    "three-quarter", "hero", "catalogue", "isometric", "plan", "elevation", "front", "right", "back", "left", "top",
    "bottom", "turntable", "follow",
)  # fmt: skip
PANORAMAS = (".hdr", ".exr")
_LARGEST = 1e12  # coordinates and other numbers, whose squares and cubes are floats


@dataclass(frozen=True, slots=True)
class SetupProperty:
    """Keyword argument of a declaration.

    Attributes
    ----------
    kind
        POINT, NUMBER, ... : what its value is.
    doc
        For the reference.
    low, high
        Range of a number, or of each number of a value; ``low`` itself is excluded if ``is_above`` is set.
    may_vary
        Whether a list of values, spread over the frames of a video, may stand for one.
    names
        Strings that it takes; none for any string.
    """

    kind: str
    doc: str
    low: float = -_LARGEST
    high: float = _LARGEST
    is_above: bool = False
    may_vary: bool = False
    names: tuple[str, ...] = ()


def _positive(kind: str, doc: str, high: float = _LARGEST, *, may_vary: bool = False) -> SetupProperty:
    return SetupProperty(kind, doc, 0.0, high, is_above=True, may_vary=may_vary)


_CAMERA = {
    "eye": SetupProperty(POINT, "position, in place of `:azimuth`, `:elevation` and `:distance`", may_vary=True),
    "look-at": SetupProperty(TARGET, "what is in the middle: a point, or words such as \"vase\"", may_vary=True),
    "preset": SetupProperty(NAME, "view of `--camera` that the other values change, such as \"isometric\"",
                              names=PRESETS),
    "azimuth": SetupProperty(NUMBER, "degrees to the right, from +z towards +x", -1e6, 1e6, may_vary=True),
    "elevation": SetupProperty(NUMBER, "degrees above the horizon", -90.0, 90.0, may_vary=True),
    "distance": _positive(NUMBER, "from what it looks at, in scene units", may_vary=True),
    "fov": SetupProperty(NUMBER, "vertical field of view in degrees", 1.0, 150.0, may_vary=True),
    "lens": SetupProperty(NUMBER, "focal length in mm for an image 36 mm wide, in place of `:fov`", 4.0, 1200.0,
                          may_vary=True),
    "roll": SetupProperty(NUMBER, "degrees that it is turned clockwise about its view", -1e6, 1e6, may_vary=True),
    "orthographic": SetupProperty(FLAG, "parallel projection"),
    "aperture": SetupProperty(NUMBER, "radius of the lens in scene units; 0 is a pinhole", 0.0, may_vary=True),
    "focus": _positive(NUMBER, "distance of what is sharp, in scene units", may_vary=True),
    "orbit": SetupProperty(NUMBER, "degrees that the camera of a video travels around", -360_000.0, 360_000.0),
}  # fmt: skip
_LIGHT = {
    "position": SetupProperty(POINT, "where it is", may_vary=True),
    "direction": SetupProperty(
        DIRECTION, "where it shines; a light with a direction and no position is a sun", may_vary=True
    ),
    "look-at": SetupProperty(
        TARGET, 'what it shines at, in place of `:direction`: a point, or words such as "vase"', may_vary=True
    ),
    "color": SetupProperty(COLOR, "linear sRGB, or a name", 0.0),
    "power": SetupProperty(NUMBER, "radiant flux of a light with a position", 0.0, may_vary=True),
    "strength": SetupProperty(
        NUMBER, "irradiance of a sun: pi makes a white surface that faces it white", 0.0, may_vary=True
    ),
    "radius": SetupProperty(NUMBER, "of a sphere that shines, for soft shadows; 0 is a point", 0.0, may_vary=True),
    "angle": SetupProperty(
        NUMBER,
        "full angle in degrees: of the cone of a spot, or under which a sun is seen",
        0.0,
        179.0,
        may_vary=True,
    ),
    "blend": SetupProperty(NUMBER, "share of the cone's radius over which a spot fades", 0.0, 1.0),
    "size": _positive(SIZE, "width and height of a rectangle that shines to one side"),
}
_ENVIRONMENT = {
    "strength": SetupProperty(NUMBER, "factor of its light", 0.0, 1e6),
    "turn": SetupProperty(NUMBER, "degrees that it is turned about the vertical", -1e6, 1e6),
    "hour": SetupProperty(NUMBER, 'of the day, from 6 to 18, of the environment "sky"', 6.0, 18.0),
    "haze": SetupProperty(NUMBER, 'of the environment "sky", from 2, very clear, to 10', 2.0, 10.0),
}
_SETTINGS = {
    "size": SetupProperty(PIXELS, "width and height of images in pixels", 1.0, 8192.0),
    "quality": SetupProperty(NAME, 'such as "draft" and "final"'),
    "samples": SetupProperty(COUNT, "rays of a pixel of a final image", 1.0, 1e6),
    "ground": SetupProperty(NAME, 'such as "seamless", "none" and "checker"', names=GROUNDS),
    "exposure": SetupProperty(NUMBER, "stops: each doubles the light of an image", -30.0, 30.0),
}

PROPERTIES: Mapping[str, Mapping[str, SetupProperty]] = MappingProxyType({
    CAMERA: MappingProxyType(_CAMERA),
    LIGHT: MappingProxyType(_LIGHT),
    ENVIRONMENT: MappingProxyType(_ENVIRONMENT),
    SETTINGS: MappingProxyType(_SETTINGS),
})  # fmt: skip
_EXAMPLES = {
    CAMERA: '(camera "main" :eye [3 2 5] :look-at [0 1 0] :fov 35)',
    LIGHT: "(light :position [2 3 2] :power 100)",
    ENVIRONMENT: '(environment "sunset" :turn 30)',
    SETTINGS: '(render-settings :size [1280 720] :quality "draft")',
}


@dataclass(frozen=True, slots=True)
class Declared:
    """A camera, a light, the environment or the render settings of a program.

    Attributes
    ----------
    form
        CAMERA, LIGHT, ENVIRONMENT or SETTINGS.
    name
        Name of a camera or light, and of the environment, or the path of its image; empty without one.
    values
        Numbers, booleans, strings, tuples of numbers, and for values over the frames tuples of these, by keyword.
    span
        Where the program states it.
    """

    form: str
    name: str
    values: Mapping[str, Any]
    span: Span | None = None

    def to_plain(self) -> dict[str, Any]:
        """Return the declaration as JSON data; absent values are omitted."""
        record: dict[str, Any] = {"form": self.form}
        if self.name:
            record["name"] = self.name
        return record | {key: _listed(value) for key, value in self.values.items()}


Setup = tuple[Declared, ...]


def _listed(value: Any) -> Any:
    """Return a value with lists in place of tuples."""
    return [_listed(item) for item in value] if isinstance(value, tuple) else value


def setup_of_plain(data: Any) -> Setup:
    """Return the declarations of ``Declared.to_plain``; raises SceneError for anything else."""
    if not isinstance(data, list) or not all(isinstance(record, dict) for record in data):
        raise SceneError("value", "declarations must be a list of objects")
    setup: Setup = ()
    for record in data:
        form, name = record.get("form"), record.get("name", "")
        if form not in PROPERTIES:
            raise SceneError("value", f"unknown declaration {str(form)[:40]!r}")
        values = {key: value for key, value in record.items() if key not in ("form", "name")}
        setup = with_declared(setup, declared_setup(form, name, values, None))
    return setup


def misplaced_setup(form: str) -> tuple[str, str]:
    """Return the message and the hint about a declaration that is not at top level."""
    message = f"`{form}` declares something of the whole scene, in world coordinates: it is no part of an object"
    return message, f"write `({form} ...)` at the top level of the program, not in a function of `bind`"


def named(setup: Setup, form: str) -> tuple[Declared, ...]:
    """Return the declarations of one form, in the order of the program."""
    return tuple(item for item in setup if item.form == form)


def with_declared(setup: Setup, item: Declared) -> Setup:
    """Return declarations with one more; raises SceneError("duplicate") and LimitError("size")."""
    others = named(setup, item.form)
    most = MAX_DECLARED.get(item.form, 1)
    if item.form in (ENVIRONMENT, SETTINGS) and others:
        raise SceneError("duplicate", f"a program has one `{item.form}`", "remove one of the two", item.span)
    if item.form == CAMERA and item.name in (other.name for other in others):
        shown = f'the camera "{item.name}" is declared twice' if item.name else "two cameras have no name"
        raise SceneError("duplicate", shown, 'name them: `(camera "close" ...)`', item.span)
    if len(others) >= most:
        raise LimitError("size", f"a program may declare at most {most:,} {item.form}s", "declare fewer", item.span)
    return (*setup, item)


def declared_setup(form: str, name: Any, values: Mapping[str, Any], span: Span | None) -> Declared:
    """Return a checked declaration.

    Parameters
    ----------
    form
        A key of ``PROPERTIES``.
    name
        Name that it is given, None or empty without one.
    values
        Values by keyword: numbers, booleans, strings, and sequences of numbers or of sequences; None is left out.
    span
        Where the program states it.

    Raises
    ------
    SceneError
        "keyword" for an unknown keyword, "type" and "value" for a wrong value, "syntax" for one that is missing.
    """
    checked = {}
    for key, value in values.items():
        if value is not None:
            checked[key] = checked_property(form, key, value)
    check_together(form, frozenset(checked))
    return Declared(form, checked_name(form, name), MappingProxyType(checked), span)


def checked_name(form: str, name: Any) -> str:
    """Return the name of a declaration; raises SceneError."""
    if name is None:
        name = ""
    if type(name) is not str:
        raise SceneError("type", f"`{form}` expects a name as a string", f"write `{_EXAMPLES[form]}`")
    if form == ENVIRONMENT and not name:
        raise SceneError("arity", "`environment` expects the name of an environment", f"write `{_EXAMPLES[form]}`")
    if form == ENVIRONMENT and is_panorama(name):
        return name
    return _known(form, "environment", _short(form, name), ENVIRONMENTS if form == ENVIRONMENT else ())


def is_panorama(name: Any) -> bool:
    """Return whether the name of an environment is that of an image file."""
    return type(name) is str and name.lower().endswith(PANORAMAS)


def _known(form: str, what: str, name: str, known: Sequence[str]) -> str:
    """Return a name that is one of ``known``, any if there are none; raises SceneError."""
    if known and name not in known:
        hint = suggest(name, known) or f"expected one of {', '.join(known)}"
        raise SceneError("value", f'`{form}` names no {what}: "{name[:60]}"', hint)
    return name


def _short(form: str, text: str) -> str:
    """Return a name if it is not too long; raises SceneError."""
    if len(text) > LONGEST_NAME or not text.isprintable():
        raise SceneError("value", f"a name of `{form}` may have at most {LONGEST_NAME} printable characters")
    return text


def check_together(form: str, keys: frozenset[str]) -> None:
    """Raise SceneError("value") for keywords of a declaration that exclude or need each other."""
    for one, others in EXCLUSIVE.get(form, ()):
        other = next((key for key in others if key in keys), None)
        if one in keys and other is not None:
            raise SceneError("value", f"`{form}` takes `:{one}` or `:{other}`, not both")
    if form != LIGHT:
        return
    if not keys & {"position", "direction"}:
        hint = "`:position [x y z]` is a lamp, `:direction [x y z]` without one a sun"
        raise SceneError("value", "`light` expects a position or a direction", hint)
    for key, hint in _OF_LAMPS.items():
        if key in keys and "position" not in keys:
            raise SceneError("value", f"`:{key}` is of a light with a position", hint)
    if "blend" in keys and "angle" not in keys:
        raise SceneError("value", "`:blend` is of a spot", "add `:angle`, of the cone in degrees")


# Keywords of which a declaration takes the first, or some of the others.
EXCLUSIVE: Mapping[str, tuple[tuple[str, tuple[str, ...]], ...]] = {
    CAMERA: (("eye", ("azimuth", "elevation", "distance", "preset")), ("fov", ("lens",))),
    LIGHT: (("direction", ("look-at",)), ("strength", ("position",)), ("size", ("angle", "radius")),
            ("radius", ("angle",))),
}  # fmt: skip
_OF_LAMPS = {
    "power": "a sun has a `:strength`", "radius": "a sun has an `:angle`", "blend": "add `:position [x y z]`",
    "size": "add `:position [x y z]`", "look-at": "a sun shines along its `:direction [x y z]`",
}  # fmt: skip


def checked_property(form: str, key: str, value: Any) -> Any:
    """Return the value of a keyword as plain data; raises SceneError."""
    known = PROPERTIES[form]
    if key not in known:
        hint = suggest(key, known) or f"it takes {', '.join(f'`:{name}`' for name in known)}"
        raise SceneError("keyword", f"`{form}` has no parameter `:{key}`", hint)
    prop = known[key]
    return _Reader(form, key, prop).read(value)


_SHAPES = {
    POINT: "three numbers", DIRECTION: "three numbers that are not all 0", COLOR: "three numbers, or a color's name",
    SIZE: "a number or two", PIXELS: "two whole numbers", TARGET: "a point or a word", NUMBER: "a number",
    COUNT: "a whole number", FLAG: "#t or #f", NAME: "a string",
}  # fmt: skip


_VECTORS = (POINT, DIRECTION, TARGET, COLOR, SIZE, PIXELS)  # kinds of values that are several numbers


def is_keyed(form: str, key: str, value: Any) -> bool:
    """Return whether a value of a declaration is a sequence of values over the frames rather than one."""
    is_vector = PROPERTIES[form][key].kind in _VECTORS
    return isinstance(value, tuple) and not (is_vector and all(map(_is_number, value)))


@dataclass(frozen=True, slots=True)
class _Reader:
    """Reads the value of one keyword."""

    form: str
    key: str
    prop: SetupProperty

    def read(self, value: Any) -> Any:
        """Return the value, or the values over the frames, as plain data."""
        if self.prop.may_vary and _is_list(value) and not self._is_one(value):
            keys = list(value)
            if not 1 <= len(keys) <= MAX_KEYS:
                raise LimitError(
                    "size", f"`:{self.key}` of `{self.form}` takes 1 to {MAX_KEYS:,} values over the frames"
                )
            return tuple(self._one(key) for key in keys)
        return self._one(value)

    def _is_one(self, value: Any) -> bool:
        """Return whether a list is one value rather than several over the frames."""
        return self.prop.kind in _VECTORS and all(_is_number(item) for item in value)

    def _one(self, value: Any) -> Any:
        """Return a single value of the property as plain data; raises SceneError if it is of another kind."""
        kind = self.prop.kind
        if kind is FLAG:
            return value if type(value) is bool else self._fail(value)
        if kind is NAME or (kind is TARGET and type(value) is str):
            if type(value) is not str or not value:
                self._fail(value)
            return _known(self.form, self.key, _short(self.form, value), self.prop.names)
        if kind in (NUMBER, COUNT):
            if not _is_number(value):
                self._fail(value)
            number = self._number(value)
            if kind is COUNT and number != int(number):
                self._fail(value)
            return int(number) if kind is COUNT else number
        if kind is SIZE and _is_number(value):
            value = (value, value)
        count = 2 if kind in (SIZE, PIXELS) else 3
        if not _is_list(value) or len(value) != count or not all(_is_number(item) for item in value):
            self._fail(value)
        numbers = tuple(self._number(item) for item in value)
        if kind is DIRECTION and not any(numbers):
            self._fail(value)
        if kind is PIXELS:
            if any(number != int(number) for number in numbers):
                self._fail(value)
            return tuple(int(number) for number in numbers)
        return numbers

    def _number(self, value: Any) -> float:
        """Return a number within the range."""
        prop = self.prop
        is_low = value <= prop.low if prop.is_above else value < prop.low
        if math.isnan(value) or is_low or value > prop.high:
            span = (
                f"above {prop.low:g} and at most {prop.high:g}" if prop.is_above else f"{prop.low:g} to {prop.high:g}"
            )
            raise SceneError("value", f"`:{self.key}` of `{self.form}` must be {span}, got {_shown(value)}")
        return float(value)

    def _fail(self, value: Any) -> Any:
        """Raise the error for a value of another type."""
        several = ", or a list of these over the frames" if self.prop.may_vary else ""
        message = f"`:{self.key}` of `{self.form}` expects {_SHAPES[self.prop.kind]}{several}, got {_shown(value)}"
        raise SceneError("type", message, f"for example `{_EXAMPLES[self.form]}`")


def _is_number(value: Any) -> bool:
    return type(value) in (int, float)


def _is_list(value: Any) -> bool:
    return isinstance(value, Sequence) and not isinstance(value, str)


def _shown(value: Any) -> str:
    """Return a value for a message, shortened."""
    if isinstance(value, bool) or value is None:
        return {True: "#t", False: "#f", None: "none"}[value]
    if _is_number(value):
        try:
            return f"{value:.6g}"
        except OverflowError:
            return "a huge number"
    if isinstance(value, str):
        return f'"{value[:40]}"'
    if _is_list(value):
        is_short = len(value) <= 4 and all(map(_is_number, value))
        return f"[{' '.join(map(_shown, value))}]" if is_short else f"{len(value)} values"
    return "another value"
