"""The primitives, one file each, and the registry that everything else asks: which words there are, what they are.

Packages of anybody's add one through the entry-point group ``scenelang.primitives``: the entry's name is the word, its
value a subclass of ``Primitive``. They are looked for when a word is asked for that is none of the language's own.
``base`` is the protocol, ``forms`` what canonical forms share, ``mesh`` the fallback of every method. Nothing here
knows a backend; numpy is imported at first use (``lazy``).
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter import plugins
from scenelang.interpreter.scene.primitives.base import (
    COLOR,
    MATERIALS,
    SCALE,
    Attribute,
    Box,
    Placed,
    Point,
    Primitive,
    Support,
    items_of,
)

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

    from scenelang.interpreter.scene.primitives.forms import CanonicalForm

GROUP = "scenelang.primitives"

# Every word of the language's own with its module and class, which are loaded when they are needed.
_OWN: Mapping[str, tuple[str, str]] = {
    "cube": ("cube", "Cube"),
    "sphere": ("sphere", "Sphere"),
    "cylinder": ("cylinder", "Cylinder"),
    "cone": ("cone", "Cone"),
    "capsule": ("capsule", "Capsule"),
    "torus": ("torus", "Torus"),
    "rounded-cube": ("rounded_cube", "RoundedCube"),
    "asset": ("asset", "MeshFile"),
    "set-cuboid": ("blocks", "SetCuboid"),
    "delete-blocks": ("blocks", "DeleteBlocks"),
}
_SEMANTIC = ("semantic", "Semantic")


def words() -> tuple[str, ...]:
    """The words of all primitives, the language's own first."""
    return (*_OWN, *_entry_points())


def is_word(word: str) -> bool:
    """Whether ``word`` is that of a primitive; loads none."""
    return word in _OWN or word in _entry_points()


def find(word: str) -> type[Primitive] | None:
    """The class of the primitive ``word``, None for a word that has none. Raises SceneError("backend") where a package
    that brings it does not load."""
    if word in _OWN:
        return _loaded(*_OWN[word])
    points = _entry_points()
    return _from_package(word) if points and word in points else None


def class_of(word: str) -> type[Primitive]:
    """The class that makes ``word``: that of a semantic primitive where it has none."""
    return find(word) or _loaded(*_SEMANTIC)


def every() -> tuple[type[Primitive], ...]:
    """The classes of all primitives that load."""
    found = []
    for word in words():
        try:
            cls = find(word)
        except SceneError:
            continue
        if cls is not None:
            found.append(cls)
    return tuple(found)


def solid_words() -> tuple[str, ...]:
    """The primitives whose attributes alone say what is seen."""
    return tuple(cls.word for cls in every() if cls.is_solid)


def block_words() -> tuple[str, ...]:
    """The primitives that make builds of Minecraft."""
    return tuple(cls.word for cls in every() if cls.is_block)


def seen_words() -> tuple[str, ...]:
    """The primitives that have a geometry to be seen."""
    return tuple(cls.word for cls in every() if cls.has_geometry)


def attributes_read(word: str) -> tuple[str, ...]:
    """The names of the attributes that the primitive ``word`` reads, material aside. A package that does not load
    brings none: what is asked is told where it is called."""
    try:
        return class_of(word).attribute_names()
    except SceneError:
        return ()


def geometry_read(word: str) -> tuple[str, ...] | None:
    """The attributes of a primitive whose attributes alone say what is seen; None for all other words."""
    try:
        cls = find(word)
    except SceneError:
        return None
    return cls.attribute_names() if cls is not None and cls.is_solid else None


def docs_of_words() -> dict[str, str]:
    """What each primitive is, in a line, by word."""
    return {cls.word: cls.doc for cls in every()}


def docs_of_attributes() -> dict[str, str]:
    """What each attribute of some primitive means, in a line, by name; the first primitive that has it says so."""
    classes = every()
    solids = [attribute for cls in classes if cls.is_solid for attribute in cls.attributes]
    others = [attribute for cls in classes if not cls.is_solid for attribute in cls.attributes]
    found: dict[str, str] = {}
    for attribute in (*solids, COLOR, *others):
        found.setdefault(attribute.name, attribute.doc)
    return found


def attribute_doc(word: str, name: str) -> str | None:
    """What the attribute ``name`` means to the primitive ``word``; None where it reads none of that name."""
    try:
        cls = class_of(word)
    except SceneError:
        return None
    own: tuple[Attribute, ...] = (*cls.attributes, COLOR) if cls.has_color else cls.attributes
    return next((attribute.doc for attribute in own if attribute.name == name), None)


def shape_of(word: str, attributes: Mapping[str, Any], asset: Any = None) -> Primitive:
    """The primitive ``word`` with its parameters; raises SceneError where an attribute does not fit it.

    A missing attribute, or one that is ``none``, has the default of language.md, section 6.
    """
    return class_of(word).made(word, attributes, asset)


@cache
def standard_forms() -> tuple[CanonicalForm, ...]:
    """The canonical forms of the oldest primitives and the piece of a mesh, which stand first in every table of forms,
    so that what is drawn keeps its order."""
    from scenelang.interpreter.scene.primitives.cone import CONE
    from scenelang.interpreter.scene.primitives.cube import BLOCK
    from scenelang.interpreter.scene.primitives.cylinder import CYLINDER
    from scenelang.interpreter.scene.primitives.forms import TRIANGLE
    from scenelang.interpreter.scene.primitives.sphere import BALL

    return (BALL, BLOCK, CYLINDER, CONE, TRIANGLE)


# --- where classes come from -----------------------------------------------------------------------------------------


@cache
def _loaded(module: str, name: str) -> type[Primitive]:
    found: type[Primitive] = getattr(import_module(f"{__name__}.{module}"), name)
    return found


def _entry_points() -> Mapping[str, EntryPoint]:
    """The entry points of other packages by word."""
    return {word: point for word, point in plugins.entry_points_of(GROUP).items() if word not in _OWN}


@cache
def _from_package(word: str) -> type[Primitive]:
    point = _entry_points()[word]
    try:
        cls = point.load()
    except Exception as error:  # foreign code may raise anything as it is imported
        raise SceneError("backend", f'the primitive "{word}" ({point.value}) cannot be loaded: {error}') from error
    if not isinstance(cls, type) or not issubclass(cls, Primitive) or cls.word != word:
        raise SceneError("backend", f'the entry point `{point.value}` names no Primitive with the word "{word}"')
    return cls


def forget_packages() -> None:
    """Look for packages again: for tests, and for a process in which one was installed."""
    plugins.forget()
    _from_package.cache_clear()


__all__ = [
    "COLOR", "GROUP", "MATERIALS", "SCALE", "Attribute", "Box", "Placed", "Point", "Primitive", "Support", "attribute_doc", "attributes_read",
    "block_words", "class_of", "docs_of_attributes", "docs_of_words", "every", "find", "forget_packages",
    "geometry_read", "is_word", "items_of", "seen_words", "shape_of", "solid_words", "standard_forms", "words",
]  # fmt: skip
