"""Registry of the primitives, with one file per primitive.

Other packages can add a primitive with the entry-point group ``scenelang.primitives``: the name of the entry is the
word, its value is a subclass of ``Primitive``. Entry points are only loaded for words that the language itself does not
define, and only if some package on the path has any: ``importlib.metadata`` costs a tenth of a second, which every
program with a semantic primitive would pay.

``base`` defines the protocol, ``forms`` the canonical forms, ``mesh`` the fallback for every method. No module of this
package imports a backend; numpy is imported lazily.
"""

from __future__ import annotations

from collections.abc import Container, Mapping
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter import loading
from scenelang.interpreter.scene.primitives.base import (
    COLOR,
    MATERIALS,
    PHYSICS,
    SCALE,
    Attribute,
    Box,
    Placed,
    Point,
    Primitive,
    Support,
    items_of,
    material_of,
    texture_of,
)

if TYPE_CHECKING:
    from scenelang.interpreter.scene.primitives.forms import CanonicalForm

GROUP = "scenelang.primitives"

# Module and class of each built-in word, loaded on demand.
_BUILTIN: Mapping[str, tuple[str, str]] = {
    "cube": ("cube", "Cube"),
    "sphere": ("sphere", "Sphere"),
    "cylinder": ("cylinder", "Cylinder"),
    "cone": ("cone", "Cone"),
    "capsule": ("capsule", "Capsule"),
    "torus": ("torus", "Torus"),
    "rounded-cube": ("rounded_cube", "RoundedCube"),
    "mesh": ("mesh_file", "MeshFile"),
    "set-cuboid": ("blocks", "SetCuboid"),
    "delete-blocks": ("blocks", "DeleteBlocks"),
}
_SEMANTIC = ("cube", "Semantic")

# Words of primitives in earlier versions, with those of today and the attribute that tells them from a noun
# (docs/decisions.md, "Names of the field").
_FORMER: Mapping[str, tuple[str, str]] = {"asset": ("mesh", "file")}


MESH_ENDINGS = (".glb", ".gltf", ".obj", ".ply", ".stl", ".off")  # of the files that a "mesh" is read from


def words() -> tuple[str, ...]:
    """Return the words of all primitives, the built-in ones first."""
    return (*_BUILTIN, *_entry_points())


def is_word(word: str) -> bool:
    """Return whether ``word`` names a primitive, without loading it."""
    return word in _BUILTIN or word in _entry_points()


def word_of_today(word: str, attributes: Container[str]) -> str | None:
    """Return the word that replaces that of a primitive in earlier versions, or None for any other call.

    Parameters
    ----------
    word
        Word of a call that the program does not bind.
    attributes
        Names of the attributes of the call.

    Examples
    --------
    >>> word_of_today("asset", ["file"])
    'mesh'
    >>> word_of_today("asset", ["color"])  # a noun
    """
    today, attribute = _FORMER.get(word, (None, ""))
    return today if attribute in attributes else None


def former_word(word: str, today: str) -> str:
    """Return the message about a word of earlier versions."""
    return f'the primitive "{word}" is called "{today}"'


def find(word: str) -> type[Primitive] | None:
    """Return the class of the primitive ``word``, or None if there is none.

    Raises
    ------
    SceneError
        "backend" if the package that defines it cannot be loaded.
    """
    if word in _BUILTIN:
        return _loaded(*_BUILTIN[word])
    points = _entry_points()
    return _from_package(word) if points and word in points else None


def class_of(word: str) -> type[Primitive]:
    """Return the class of the primitive ``word``, or that of a semantic primitive if there is none."""
    return find(word) or _loaded(*_SEMANTIC)


def all_primitives() -> tuple[type[Primitive], ...]:
    """Return the classes of all primitives that can be loaded."""
    classes = []
    for word in words():
        try:
            cls = find(word)
        except SceneError:
            continue
        if cls is not None:
            classes.append(cls)
    return tuple(classes)


def solid_words() -> tuple[str, ...]:
    """Return the primitives whose attributes alone determine their appearance."""
    return tuple(cls.word for cls in all_primitives() if cls.is_solid)


def block_words() -> tuple[str, ...]:
    """Return the primitives made of Minecraft blocks."""
    return tuple(cls.word for cls in all_primitives() if cls.is_block)


def geometric_words() -> tuple[str, ...]:
    """Return the primitives that have a visible geometry."""
    return tuple(cls.word for cls in all_primitives() if cls.has_geometry)


def attributes_read(word: str) -> tuple[str, ...]:
    """Return the names of the attributes of the primitive ``word``, except those of the material.

    Returns an empty tuple if its package cannot be loaded; the error is reported where the word is called.
    """
    try:
        return class_of(word).attribute_names()
    except SceneError:
        return ()


def geometry_attributes(word: str) -> tuple[str, ...] | None:
    """Return the attributes of a primitive whose attributes alone determine its appearance, or None for other words."""
    try:
        cls = find(word)
    except SceneError:
        return None
    return cls.attribute_names() if cls is not None and cls.is_solid else None


def docs_of_words() -> dict[str, str]:
    """Return a one-line description of each primitive, by word."""
    return {cls.word: cls.doc for cls in all_primitives()}


def docs_of_attributes() -> dict[str, str]:
    """Return a one-line description of each attribute, by name.

    The first primitive that has the attribute defines it.
    """
    classes = all_primitives()
    solids = [attribute for cls in classes if cls.is_solid for attribute in cls.attributes]
    others = [attribute for cls in classes if not cls.is_solid for attribute in cls.attributes]
    docs: dict[str, str] = {}
    for attribute in (*solids, COLOR, *others):
        docs.setdefault(attribute.name, attribute.doc)
    return docs


def attribute_doc(word: str, name: str) -> str | None:
    """Return the description of an attribute of the primitive ``word``, or None if it has no attribute ``name``."""
    try:
        cls = class_of(word)
    except SceneError:
        return None
    readable: tuple[Attribute, ...] = (*cls.attributes, COLOR) if cls.has_color else cls.attributes
    return next((attribute.doc for attribute in readable if attribute.name == name), None)


def shape_of(word: str, attributes: Mapping[str, Any], asset: Any = None) -> Primitive:
    """Create the primitive ``word`` with ``attributes``.

    An attribute that is missing or ``none`` has its default (docs/language.md, "Geometry").

    Raises
    ------
    SceneError
        "attribute" if an attribute is invalid.
    """
    return class_of(word).from_attributes(word, attributes, asset)


@cache
def standard_forms() -> tuple[CanonicalForm, ...]:
    """Return the canonical forms that come first in every table of forms, in a fixed order.

    The order of the forms determines the drawing order, so it must not depend on which forms a scene contains.
    """
    from scenelang.interpreter.scene.primitives.cone import CONE
    from scenelang.interpreter.scene.primitives.cube import BLOCK
    from scenelang.interpreter.scene.primitives.cylinder import CYLINDER
    from scenelang.interpreter.scene.primitives.forms import TRIANGLE
    from scenelang.interpreter.scene.primitives.sphere import BALL

    return (BALL, BLOCK, CYLINDER, CONE, TRIANGLE)


# --- loading of classes ----------------------------------------------------------------------------------------------


@cache
def _loaded(module: str, name: str) -> type[Primitive]:
    """Import the class of a built-in primitive."""
    cls: type[Primitive] = getattr(import_module(f"{__name__}.{module}"), name)
    return cls


def _entry_points() -> Mapping[str, loading.EntryPoint]:
    """Return the entry points of other packages, by word."""
    return {word: point for word, point in loading.entry_points_of(GROUP).items() if word not in _BUILTIN}


@cache
def _from_package(word: str) -> type[Primitive]:
    """Load the class of another package; raises SceneError("backend") if it is not a primitive of that word."""
    point = _entry_points()[word]
    try:
        cls = point.load()
    except Exception as error:  # third-party code may raise anything on import
        raise SceneError("backend", f'cannot load the primitive "{word}" ({point.value}): {error}') from error
    if not isinstance(cls, type) or not issubclass(cls, Primitive) or cls.word != word:
        raise SceneError("backend", f'the entry point `{point.value}` is not a Primitive with the word "{word}"')
    return cls


def clear_package_cache() -> None:
    """Forget the primitives of other packages, so that their next use looks for installed packages again.

    This is for tests, and for a process in which a package was installed.
    """
    loading.forget()
    _from_package.cache_clear()


__all__ = [
    "COLOR",
    "GROUP",
    "MATERIALS",
    "PHYSICS",
    "SCALE",
    "Attribute",
    "Box",
    "Placed",
    "Point",
    "Primitive",
    "Support",
    "all_primitives",
    "attribute_doc",
    "attributes_read",
    "block_words",
    "class_of",
    "clear_package_cache",
    "docs_of_attributes",
    "docs_of_words",
    "find",
    "geometric_words",
    "geometry_attributes",
    "is_word",
    "items_of",
    "material_of",
    "shape_of",
    "solid_words",
    "standard_forms",
    "texture_of",
    "words",
]  # fmt: skip
