"""What entity functions give: parts, poses and embeddings out of the values that programs make (language.md, 2)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.runtime.show import show
from scenelang.interpreter.runtime.types import matrix_or_none, type_name
from scenelang.interpreter.runtime.values import (
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
    make_list,
    table_key,
)
from scenelang.interpreter.scene import pose
from scenelang.interpreter.scene.entity import Entity
from scenelang.interpreter.scene.primitives.asset import Asset

if TYPE_CHECKING:
    from scenelang.interpreter.runtime.runtime import Runtime


_BLOCK = 256  # parts between two checks
_FEW = 32  # attributes that are not charged


def parts_of(runtime: Runtime, value: Any, word: str | None = None) -> tuple[Pair, ...]:
    """The flat tuple of pairs ``(Entity . Matrix)`` that ``value`` is; raises SceneError naming ``word``.

    Lists that share their members can be far larger than they look, so the work is charged as it is done."""
    if type(value) is Entity:
        return (Pair(value, IDENTITY),)
    out: list[Pair] = []
    stack: list[Any] = [value]
    turns = 0
    while stack:
        item = stack.pop()
        kind = type(item)
        turns += 1
        if turns >= _BLOCK:
            turns = 0
            runtime.charge(_BLOCK)
            runtime.meter.check_growth(len(out), "a list of parts")
        while kind is Pair and turns < _BLOCK:
            turns += 1
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
            raise _no_part(item, word)
    runtime.charge(turns >> 1)
    return tuple(out)


def primitives_of(runtime: Runtime, value: Any) -> list[Pair]:
    """The primitives of an entity, pair or parts, depth first: pairs (entity . pose within ``value``)."""
    found: list[Pair] = []
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
            found.append(part if len(stack) == 1 else Pair(entity, inside))
            runtime.meter.check_growth(len(found), "a list of primitives")
        else:
            stack.append((inside, iter(entity.children)))
    return found


def _no_part(item: Any, word: str | None) -> SceneError:
    where = f' in "{word}"' if word is not None else ""
    message = f"expected entities or (entity . matrix) pairs{where}, got {type_name(item)}"
    if item is not None:
        message += f": {show(item, 60)}"
    hint = "nothing at all is `(union)`" if item is None or isinstance(item, bool) else None
    if type(item) is Matrix:
        hint = "a pose belongs to an entity: `(transform entity matrix)`"
    elif type(item) is str:
        hint = f"a word is called: `(call {show(item, 40)})`"
    return SceneError("parts", message, hint=hint)


def pose_from(runtime: Runtime, value: Any) -> Matrix:
    """The finite pose that ``value`` is, or an error."""
    matrix = matrix_or_none(runtime, value)
    if matrix is None:
        message = f"a pose must be a 4x4 matrix whose last row is 0 0 0 1, got {type_name(value)}: {show(value, 60)}"
        raise SceneError("pose", message, hint="a vector becomes a pose with `(translate [x y z])`")
    if not pose.is_finite(matrix):
        raise SceneError("pose", "a pose must be finite, but this one holds nan or inf")
    return matrix


def call_embeddings(
    runtime: Runtime, word: Any, arguments: list[Any]
) -> tuple[Embedding, list[Embedding], frozenset[str]]:
    """z, gamma and the attribute names written, from the arguments of a ``call``: embeddings and ``:name value``."""
    if type(word) is not str:
        raise SceneError("word", f"`call` wants a string for the word, got {type_name(word)}: {show(word, 40)}")
    embeddings: list[Embedding] = []
    attributes: dict[str, Any] = {}
    pending = iter(arguments)
    for argument in pending:
        kind = type(argument)
        if kind is Keyword:
            name = str(argument)
            if name in attributes:
                raise SceneError("keyword", f'`:{name}` is given twice in a call of "{word}"')
            try:
                attributes[name] = next(pending)
            except StopIteration:
                raise SceneError("keyword", f'`:{name}` is followed by no value in a call of "{word}"') from None
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


def not_an_embedding(word: str, value: Any) -> SceneError:
    message = f'`call` wants embeddings and `:name value` attributes, but "{word}" got {type_name(value)}'
    hint = f'name the attribute: `(call "{word}" :name {show(value, 30)})`'
    if isinstance(value, HandleList):
        hint = "take as many as you need: `(list-head gamma n)`"
    return SceneError("embedding", message + f": {show(value, 60)}", hint=hint)


def with_attributes(runtime: Runtime, z: Embedding, attributes: Mapping[str, Any]) -> Embedding:
    """``z`` with more attributes, which win over its own; tables are copied, so that later changes do not show."""
    copied = {name: copy_table(runtime, value) if type(value) is Table else value for name, value in attributes.items()}
    if len(z.attributes) + len(copied) > _FEW:
        runtime.charge((len(z.attributes) + len(copied)) >> 4)
    return Embedding(z.handle, z.text, {**z.attributes, **copied} if z.attributes else copied)


def copy_table(runtime: Runtime, table: Table) -> Table:
    """An unchangeable copy of a table."""
    if table.birth < 0:
        return table
    runtime.read(table)
    runtime.charge(len(table.entries) >> 5)
    return Table(dict(table.entries), -1)


def geometric_attributes(runtime: Runtime, z: Embedding) -> dict[str, Any]:
    """The attributes as geometry reads them; mutable lists and arrays count as read at this moment."""
    attributes = dict(z.attributes)
    if len(attributes) > _FEW:
        runtime.charge(len(attributes) >> 4)
    for value in attributes.values():
        if isinstance(value, (MutableList, MutableArray, Set)):
            runtime.read(value)
            if isinstance(value, MutableArray):
                runtime.charge(value.data.size >> 6)
    return attributes


def load_asset(runtime: Runtime, attributes: dict[str, Any]) -> tuple[Asset, dict[str, Any]]:
    """What is known of an asset's mesh file, and its attributes with the file's resolved path."""
    file = attributes.get("file")
    if type(file) is not str:
        raise SceneError("attribute", 'the primitive "asset" needs the attribute `:file`, a string')
    if runtime.asset is None:
        raise SceneError("file", f"the asset {file} cannot be read here")
    asset = runtime.asset(file, runtime.charge)
    return asset, {**attributes, "file": asset.path}


def attribute_table(runtime: Runtime, pairs: Mapping[str, Any]) -> Table:
    """A table from names to values."""
    runtime.charge(len(pairs) >> 4)
    return runtime.table_of({table_key(name): (name, value) for name, value in pairs.items()})


def transformed(runtime: Runtime, part: Any, matrix: Any) -> Any:
    """``(transform part matrix)``: an Entity gives the paper's pair, a pair a pair, a list a list."""
    moved = pose_from(runtime, matrix)
    if type(part) is Entity:
        return Pair(part, moved)
    parts = parts_of(runtime, part)
    composed: list[Pair] = []
    for start in range(0, len(parts), _BLOCK):
        block = parts[start : start + _BLOCK]
        runtime.charge(len(block))
        composed += [Pair(p.car, pose_from(runtime, pose.compose(moved, p.cdr))) for p in block]
    if type(part) is Pair and type(part.car) is Entity and part.cdr is not NIL and type(part.cdr) is not Pair:
        return composed[0]
    return make_list(composed)
