"""Conversion of program values to the arguments of entities: parts, poses, embeddings.

See docs/language.md, "Entities and embeddings".
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import isfinite
from typing import TYPE_CHECKING, Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.runtime.show import described, show
from scenelang.interpreter.runtime.types import matrix_or_none, type_name
from scenelang.interpreter.scene import pose
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.scene.part_columns import MIN_COLUMNS, GatheredParts, PartColumns
from scenelang.interpreter.scene.primitives.base import items_of
from scenelang.interpreter.scene.primitives.mesh_file import Asset
from scenelang.interpreter.scene.primitives.textures import is_image
from scenelang.interpreter.values.values import (
    ANONYMOUS,
    IDENTITY,
    NIL,
    Embedding,
    HandleList,
    Keyword,
    Matrix,
    MutableArray,
    MutableList,
    Pair,
    Set,
    Table,
    Vector,
    make_list,
    table_key,
)

if TYPE_CHECKING:
    from scenelang.interpreter.runtime.runtime import Runtime


_CHECK_INTERVAL = 256  # parts between two checks of the limits
_MAX_FREE_ATTRIBUTES = 32  # of an embedding: more cost steps


def plain_parts(values: Sequence[Any]) -> list[Pair] | None:
    """Return the parts of values that are entities or posed entities, or None if another one is among them."""
    pairs: list[Pair] = []
    for value in values:
        if type(value) is Entity:
            pairs.append(Pair(value, IDENTITY))
        elif type(value) is Pair and type(value.cdr) is Matrix and type(value.car) is Entity:
            pairs.append(value)
        else:
            return None
    return pairs


class PartCollector(list[Pair]):
    """Parts of a form in the order of its turns: pairs, of which many are put into columns.

    Generated code and closures append to it, and ``settle`` it now and then; ``value`` is that of the form.
    """

    _gathered: GatheredParts | None = None

    def settle(self) -> None:
        """Put the pairs into columns, if they are many."""
        if len(self) >= MIN_COLUMNS:
            self._gather(self)
            self.clear()

    def join(self, parts: Sequence[Pair]) -> None:
        """Add the parts of another form."""
        if type(parts) is PartColumns:
            self._gather(self)
            self.clear()
            self._gather(parts)
        else:
            self.extend(parts)
            self.settle()

    def take_plain(self, values: Sequence[Any]) -> bool:
        """Add values if none needs a conversion that could fail, else return False."""
        pairs = plain_parts(values)
        if pairs is None:
            return False
        self.extend(pairs)
        self.settle()
        return True

    def value(self) -> Any:
        """Return the list of the parts, or the columns of many; these may only become parts (``analyze``)."""
        if self._gathered is None:
            return make_list(self)
        self._gather(self)
        return self._gathered.columns()

    def _gather(self, parts: Sequence[Pair]) -> None:
        """Add parts to the columns."""
        if self._gathered is None:
            self._gathered = GatheredParts()
        self._gathered.extend(parts)


def listed(value: Any) -> Any:
    """Return a value as programs see it: columns as the list of their pairs."""
    return make_list(value) if type(value) is PartColumns else value


def parts_of(runtime: Runtime, value: Any, word: str | None = None) -> Sequence[Pair]:
    """Flatten a value to parts, that is, pairs ``(Entity . Matrix)``, in a tuple or in columns.

    Lists that share their tails can be exponentially larger than their memory, so the work is charged while it is done.
    The inner loop handles the usual case, a list of entities and pairs, without the stack.

    Parameters
    ----------
    value
        An entity, an ``(entity . pose)`` pair, or a list of parts, nested to any depth.
    word
        Word that the error message names.

    Raises
    ------
    SceneError
        "parts" if ``value`` contains anything else, "pose" if an entity is paired with an invalid pose.
    """
    if type(value) is Entity:
        return (Pair(value, IDENTITY),)
    if type(value) is PartColumns:
        _charge_walk(runtime, len(value))
        return value
    out: list[Pair] = []
    stack: list[Any] = [value]
    pending = 0
    while stack:
        item = stack.pop()
        kind = type(item)
        pending += 1
        if pending >= _CHECK_INTERVAL:
            pending = 0
            runtime.charge(_CHECK_INTERVAL)
            runtime.meter.check_growth(len(out), "a list of parts")
        while kind is Pair and pending < _CHECK_INTERVAL:
            pending += 1
            head = item.car
            if type(head) is Entity:
                tail = item.cdr
                if type(tail) is Matrix:
                    out.append(item)
                    item = NIL
                    kind = type(NIL)
                    break
                if type(tail) is Pair or tail is NIL or isinstance(tail, MutableList):
                    out.append(Pair(head, IDENTITY))
                else:
                    out.append(Pair(head, pose_from(runtime, tail)))
                    tail = NIL
                item = tail
            elif type(head) is Pair and type(head.cdr) is Matrix and type(head.car) is Entity:
                out.append(head)
                item = item.cdr
            else:
                stack.append(item.cdr)
                item = head
            kind = type(item)
        if kind is Entity:
            out.append(Pair(item, IDENTITY))
        elif kind is Pair:
            stack.append(item)
        elif isinstance(item, MutableList):
            runtime.read(item)
            runtime.charge(len(item.items) >> 8)
            stack.extend(reversed(item.items))
        elif item is not NIL:
            raise _not_a_part(item, word)
    runtime.charge(pending >> 1)
    return tuple(out)


def _charge_walk(runtime: Runtime, count: int) -> None:
    """Charge for ``count`` parts in columns as ``parts_of`` does for those of a list that it walks."""
    first = _CHECK_INTERVAL - 1  # its first step is the list itself
    blocks = range(first, count, _CHECK_INTERVAL)
    for passed in blocks:
        runtime.charge(_CHECK_INTERVAL)
        runtime.meter.check_growth(passed, "a list of parts")
    runtime.charge((count - blocks[-1] if blocks else count + 1) >> 1)


def primitives_of(runtime: Runtime, value: Any) -> list[Pair]:
    """Return the primitives below an entity, pair or list of parts in depth-first order, as pairs (entity . pose).

    The poses are relative to ``value``.
    """
    primitives: list[Pair] = []
    stack: list[tuple[Matrix, Iterator[Pair]]] = [(IDENTITY, iter(parts_of(runtime, value)))]
    while stack:
        around, pending = stack[-1]
        part = next(pending, None)
        if part is None:
            stack.pop()
            continue
        runtime.charge(1)
        entity = part.car
        inside = part.cdr if len(stack) == 1 else pose.compose(around, part.cdr)
        if entity.is_primitive:
            primitives.append(part if len(stack) == 1 else Pair(entity, inside))
            runtime.meter.check_growth(len(primitives), "a list of primitives")
        else:
            stack.append((inside, iter(entity.children)))
    return primitives


def _not_a_part(item: Any, word: str | None) -> SceneError:
    """Return the error for a value among parts, with a hint for the most frequent mistakes."""
    where = f' in "{word}"' if word is not None else ""
    message = f"expected entities or (entity . matrix) pairs{where}, got {type_name(item)}"
    if item is not None:
        message += f": {show(item, 60)}"
    hint = "to return no parts, write `(union)`" if item is None or isinstance(item, bool) else None
    if type(item) is Matrix:
        hint = "to apply a pose to an entity, write `(transform entity matrix)`"
    elif type(item) is str:
        hint = f"to create an entity from a word, write `(call {show(item, 40)})`"
    return SceneError("parts", message, hint=hint)


def pose_from(runtime: Runtime, value: Any) -> Matrix:
    """Convert a value to a finite pose; raise ``SceneError("pose")`` if it is not one."""
    matrix = matrix_or_none(runtime, value)
    if matrix is None:
        message = f"expected a 4x4 pose matrix with the last row 0 0 0 1, got {described(value, 60)}"
        raise SceneError("pose", message, hint="to turn a vector into a pose, write `(translate [x y z])`")
    if not pose.is_finite(matrix):
        raise not_finite()
    return matrix


def not_finite() -> SceneError:
    """Return the error of a pose with a number that is not finite."""
    return SceneError("pose", "a pose must be finite, but this one contains nan or inf")


def call_embeddings(
    runtime: Runtime, word: Any, arguments: list[Any]
) -> tuple[Embedding, list[Embedding], frozenset[str]]:
    """Return the embeddings and attribute names in the arguments of a ``call``.

    Parameters
    ----------
    arguments
        Embeddings or texts, and ``:name value`` attributes.

    Returns
    -------
    tuple of (Embedding, list of Embedding, frozenset of str)
        The embedding z with the attributes merged in, the rest gamma, and the names of the attributes.
    """
    if type(word) is not str:
        raise SceneError("word", f"`call` expects a string as the word, got {described(word, 40)}")
    embeddings: list[Embedding] = []
    attributes: dict[str, Any] = {}
    pending = iter(arguments)
    for argument in pending:
        kind = type(argument)
        if kind is Keyword:
            name = str(argument)
            if name in attributes:
                raise SceneError("keyword", f'`:{name}` appears twice in a call of "{word}"')
            try:
                attributes[name] = next(pending)
            except StopIteration:
                raise SceneError("keyword", f'`:{name}` has no value in a call of "{word}"') from None
        elif kind is Embedding:
            embeddings.append(argument)
        elif kind is str:
            embeddings.append(Embedding(text=argument))
        else:
            raise not_an_embedding(word, argument)
    z = embeddings[0] if embeddings else ANONYMOUS
    if attributes:
        z = with_attributes(runtime, z, attributes)
    return z, embeddings[1:], frozenset(attributes)


# Functions of entities: `call` with one of their names would create a semantic primitive.
OF_ENTITIES = frozenset((
    "cut-plane", "difference", "hull", "intersection", "minkowski", "offset-solid", "rounded", "shell", "split",
    "transform", "union", "solid-union",
))  # fmt: skip


def not_an_embedding(word: str, value: Any) -> SceneError:
    """Return the error for an argument of ``call`` that is neither an embedding nor an attribute."""
    message = f'`call` expects embeddings and `:name value` attributes, but "{word}" got {type_name(value)}'
    hint = f'to set an attribute, write its name: `(call "{word}" :name {show(value, 30)})`'
    if isinstance(value, Entity) and word in OF_ENTITIES:
        hint = f"`{word}` is a function: write `({word} ...)`"
    if isinstance(value, HandleList):
        hint = "to pass the first n embeddings of an infinite list, write `(list-head gamma n)`"
    return SceneError("embedding", message + f": {show(value, 60)}", hint=hint)


def with_attributes(runtime: Runtime, z: Embedding, attributes: Mapping[str, Any]) -> Embedding:
    """Return ``z`` with ``attributes`` merged in, overriding its own.

    Tables are copied, so that later mutation has no effect. Mutable lists and arrays are not, so a call that receives
    one is not shared.
    """
    copied = {name: copy_table(runtime, value) if type(value) is Table else value for name, value in attributes.items()}
    if len(z.attributes) + len(copied) > _MAX_FREE_ATTRIBUTES:
        runtime.charge((len(z.attributes) + len(copied)) >> 4)
    return Embedding(z.handle, z.text, {**z.attributes, **copied} if z.attributes else copied)


def copy_table(runtime: Runtime, table: Table) -> Table:
    """Return an immutable copy of a table."""
    if table.birth < 0:
        return table
    runtime.read(table)
    runtime.charge(len(table.entries) >> 5)
    return Table(dict(table.entries), -1)


_MIN_BYTE, _MAX_BYTE = 2, 255  # a brightened color has components just above 1


def color_of_bytes(z: Embedding) -> str | None:
    """Return a color with whole components up to 255 in place of 1 as text, or None for any other."""
    color = z.attributes.get("color")
    if type(color) is not Vector or len(color) != len("rgb") or not _MIN_BYTE <= max(color) <= _MAX_BYTE:
        return None
    return show(color) if all(number >= 0 and number == int(number) for number in color) else None


def geometric_attributes(runtime: Runtime, z: Embedding) -> dict[str, Any]:
    """Return the attributes of ``z`` for the geometry; mutable lists and arrays are recorded as read."""
    attributes = dict(z.attributes)
    if len(attributes) > _MAX_FREE_ATTRIBUTES:
        runtime.charge(len(attributes) >> 4)
    for value in attributes.values():
        if isinstance(value, (MutableList, MutableArray, Set)):
            runtime.read(value)
            if isinstance(value, MutableArray):
                runtime.charge(value.data.size >> 6)
    if attributes.get("texture") is not None:
        attributes["texture"] = _with_image(runtime, attributes["texture"])
    return attributes


def _with_image(runtime: Runtime, texture: Any) -> Any:
    """Return the value of ``:texture`` with the resolved path of its image, if it has one."""
    items = items_of(texture)
    name = texture if type(texture) is str else items[0] if items else None
    if type(name) is not str or not is_image(name):
        return texture
    path = image_path(runtime, name)
    return path if items is None else make_list([path, *items[1:]])


def image_path(runtime: Runtime, name: str) -> str:
    """Return the path of an image of the project's folder, a texture or a panorama; raises SceneError."""
    if runtime.image is None:
        raise SceneError("file", f"cannot read the image {name[:80]}: loading of images is disabled here")
    runtime.output += 1  # the file may change
    return runtime.image(name, runtime.charge)


def load_asset(runtime: Runtime, attributes: dict[str, Any]) -> tuple[Asset, dict[str, Any]]:
    """Load the mesh file of a mesh file.

    Returns
    -------
    tuple of (Asset, dict)
        Metadata of the mesh, and the attributes with the resolved path of the file.
    """
    file = attributes.get("file")
    if type(file) is not str:
        raise SceneError("attribute", 'the primitive "mesh" requires the attribute `:file`, a string')
    if runtime.asset is None:
        raise SceneError("file", f"cannot read the mesh file {file}: loading of mesh files is disabled here")
    asset = runtime.asset(file, runtime.charge)
    return asset, {**attributes, "file": asset.path}


def attribute_table(runtime: Runtime, pairs: Mapping[str, Any]) -> Table:
    """Create a table that maps names to values."""
    runtime.charge(len(pairs) >> 4)
    return runtime.table_of({table_key(name): (name, value) for name, value in pairs.items()})


def transformed(runtime: Runtime, part: Any, matrix: Any) -> Any:
    """Apply ``(transform part matrix)``: return a pair for an entity or pair, else a list, or columns."""
    moved = pose_from(runtime, matrix)
    if type(part) is Entity:
        return Pair(part, moved)
    parts = parts_of(runtime, part)
    if type(parts) is PartColumns:
        for start in range(0, len(parts), _CHECK_INTERVAL):
            runtime.charge(min(_CHECK_INTERVAL, len(parts) - start))
        columns = parts.moved(moved)
        if columns is None:
            raise not_finite()
        return columns
    composed: list[Pair] = []
    for start in range(0, len(parts), _CHECK_INTERVAL):
        block = parts[start : start + _CHECK_INTERVAL]
        runtime.charge(len(block))
        for p in block:
            inner = pose.compose(moved, p.cdr)
            if not isfinite(sum(inner)):
                pose_from(runtime, inner)  # the sum of finite numbers may overflow
            composed.append(Pair(p.car, inner))
    if type(part) is Pair and type(part.car) is Entity and part.cdr is not NIL and type(part.cdr) is not Pair:
        return composed[0]
    return make_list(composed)
