"""Cameras, lights, environment and render settings of a program (docs/language.md, "Cameras and lights")."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.runtime.parts import image_path
from scenelang.interpreter.runtime.show import NotPlain, plain_value
from scenelang.interpreter.runtime.types import Registry
from scenelang.interpreter.scene.primitives.base import items_of
from scenelang.interpreter.scene.setup import (
    CAMERA,
    COLOR,
    ENVIRONMENT,
    LIGHT,
    PROPERTIES,
    SETTINGS,
    declared_setup,
    is_panorama,
)
from scenelang.interpreter.values.values import Array, MutableArray, MutableList
from scenelang.stdlib.colors import color_of

if TYPE_CHECKING:
    from scenelang.interpreter.runtime.runtime import Runtime

registry = Registry("setup")


def _keywords(form: str) -> str:
    """Return the keyword parameters of a declaration for its signature."""
    return " ".join(f"[:{key}]" for key in PROPERTIES[form])


def _doc(form: str, summary: str) -> str:
    """Return the documentation of a declaration: what it does, and what each keyword means."""
    return f"{summary} {'; '.join(f'`:{key}`: {prop.doc}' for key, prop in PROPERTIES[form].items())}."


def _declare(rt: Runtime, form: str, name: Any, options: dict[str, Any]) -> None:
    """Record a declaration with the values of a program."""
    values = {key.replace("_", "-"): value for key, value in options.items() if value is not None}
    for key, value in values.items():
        if not _is_plain(rt, value):
            raise _not_plain(form, key)
    rt.declare_setup(declared_setup(form, name, {k: plain_property(form, k, v) for k, v in values.items()}, rt.site))


_DEEPEST = 2  # lists: of values over the frames, each of which may be a point


def _is_plain(rt: Runtime, value: Any, depth: int = 0) -> bool:
    """Return whether a value is a number, a text or a list of such; meters its conversion, before it is done."""
    if value is None or isinstance(value, (bool, int, float, str)):
        return True
    if isinstance(value, (MutableArray, MutableList)):
        rt.read(value)
    if isinstance(value, (Array, MutableArray)):
        rt.charge(int(value.data.size))
        return True
    items = items_of(value) if depth < _DEEPEST else None
    if items is None:
        return False
    rt.charge(len(items))
    return all(_is_plain(rt, item, depth + 1) for item in items)


def _not_plain(form: str, key: str) -> SceneError:
    """Return the error for a value that is no plain data."""
    return SceneError("type", f"`:{key}` of `{form}` expects finite numbers or a text")


def plain_property(form: str, key: str, value: Any) -> Any:
    """Return the value of a keyword as plain Python data, with colors by name as numbers; raises SceneError."""
    prop = PROPERTIES[form].get(key)
    if prop is not None and prop.kind is COLOR and type(value) is str:
        return tuple(color_of(value))
    if value is None or type(value) in (bool, int, float, str):
        return value
    try:
        return plain_value(value)
    except NotPlain:
        raise _not_plain(form, key) from None


@registry.define(
    CAMERA, f"[name] {_keywords(CAMERA)}", "None",
    _doc(CAMERA, "At top level, declare a camera of the scene in world coordinates; the first one is the default, and a"
                 " list in place of one value is spread over the frames of a video."),
    ('(camera "main" :eye [3 2 5] :look-at [0 1 0] :fov 35)', "none"),
)  # fmt: skip
def camera(rt: Runtime, name: Any = None, **options: Any) -> None:
    _declare(rt, CAMERA, name, options)


@registry.define(
    LIGHT, f"[name] {_keywords(LIGHT)}", "None",
    _doc(LIGHT, "At top level, declare a light of the scene in world coordinates: a point, a sphere with `:radius`, a"
                " spot with `:angle`, a rectangle with `:size`, or with `:direction` alone a sun, in the"
                " units of Blender; a list in place of one value is spread over the frames of a video."),
    ("(light :position [2 3 2] :power 100)", "none"),
)  # fmt: skip
def light(rt: Runtime, name: Any = None, **options: Any) -> None:
    _declare(rt, LIGHT, name, options)


@registry.define(
    ENVIRONMENT, f"name {_keywords(ENVIRONMENT)}", "None",
    _doc(ENVIRONMENT, "At top level, declare the environment that lights the scene, as `--environment` names it:"
                      " by name, or a panorama (.hdr, .exr) of the project's folder."),
    ('(environment "sunset" :strength 1 :turn 30)', "none"),
)  # fmt: skip
def environment(rt: Runtime, name: Any, **options: Any) -> None:
    _declare(rt, ENVIRONMENT, image_path(rt, name) if is_panorama(name) else name, options)


@registry.define(
    SETTINGS, _keywords(SETTINGS), "None",
    _doc(SETTINGS, "At top level, declare the defaults of options of `render`."),
    ('(render-settings :size [1280 720] :quality "draft" :ground "none")', "none"),
)  # fmt: skip
def render_settings(rt: Runtime, **options: Any) -> None:
    _declare(rt, SETTINGS, None, options)
