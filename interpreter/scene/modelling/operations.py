"""Solids as expressions: an operation, its parameters, and operands under poses.

An expression is immutable and is identified by its digest, so that equal solids are computed once, when they are drawn
or measured; ``check`` computes nothing. Its leaves are primitives of the language, or operations without operands such
as ``extrude``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

from scenelang.grammar.datum import Span, dataclass, field
from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.loading import np
from scenelang.interpreter.scene.primitives.base import Point, Primitive

if TYPE_CHECKING:
    import numpy.typing as npt

    FloatArray = npt.NDArray[np.float64]

PRIMITIVE = "primitive"  # the operation of a leaf that is a primitive of the language
MAX_OPERATIONS = 10_000  # of an expression, each counted once
SEGMENTS = 64  # sides of a full circle


@dataclass(frozen=True, eq=False)
class Expression:
    """Solid that is computed when it is needed.

    Attributes
    ----------
    operation
        A name of ``computing.OPERATIONS``, or ``PRIMITIVE``.
    parameters
        Numbers, strings, booleans, float64 arrays and tuples of arrays, by name.
    operands
        Solids that the operation takes, with their poses.
    shape
        Primitive of a leaf.
    word
        Word of the faces that this node creates, in masks.
    color
        Linear sRGB of these faces.
    site
        Source location of the call, which is not part of its identity.
    caller
        Builtin that it is part of, for error messages, if that has another name than the operation.
    """

    operation: str
    parameters: Mapping[str, Any] = field(default_factory=dict)
    operands: tuple[Operand, ...] = ()
    shape: Primitive | None = None
    word: str = ""
    color: Point = (1.0, 1.0, 1.0)
    site: Span | None = None
    caller: str = ""

    @cached_property
    def digest(self) -> str:
        """Hash of everything that the surface, its colors and its words depend on."""
        import hashlib  # 3 ms, which a check of a program does not need

        total = hashlib.sha256()
        for piece in (self.operation, self.word, repr(self.color), _shape_text(self.shape)):
            total.update(piece.encode("utf-8", "surrogatepass") + b"\0")
        for name, value in sorted(self.parameters.items()):
            total.update(name.encode() + b"=")
            for array in value if isinstance(value, tuple) else (value,):
                total.update(array.tobytes() + repr(array.shape).encode() if _is_array(array) else repr(array).encode())
            total.update(b"\0")
        for operand in self.operands:
            total.update(f"{operand.expression.digest} {operand.pose!r} {operand.color!r}\0".encode())
        return total.hexdigest()

    def __hash__(self) -> int:
        return hash(self.digest)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Expression) and self.digest == other.digest

    def __repr__(self) -> str:
        return f"<{self.operation} {self.digest[:12]}>"

    @cached_property
    def most_operations(self) -> int:
        """Number of operations if none were shared."""
        return 1 + sum(operand.expression.most_operations for operand in self.operands)

    @cached_property
    def colors(self) -> frozenset[Point]:
        """Colors that faces may have."""
        if not self.operands or self.operation in REPLACING:
            return frozenset([self.color])
        return frozenset[Point]().union(*(operand.colors for operand in self.operands))


# Operations whose faces are all new: they have the color and the word of the operation.
REPLACING = frozenset(("hull", "minkowski", "rounded", "shell", "offset-solid"))


@dataclass(frozen=True, slots=True)
class Operand:
    """Solid under a pose (12 floats, row by row); ``color`` replaces those of its faces."""

    expression: Expression
    pose: tuple[float, ...]
    color: Point | None = None

    @property
    def colors(self) -> frozenset[Point]:
        """Colors that faces may have."""
        return self.expression.colors if self.color is None else frozenset([self.color])


def nodes_of(expression: Expression) -> Iterator[Expression]:
    """Iterate over the distinct nodes of an expression, operands before the operations that take them."""
    visited: set[str] = set()
    stack = [(expression, iter(expression.operands))]
    while stack:
        node, operands = stack[-1]
        for operand in operands:
            if operand.expression.digest not in visited:
                visited.add(operand.expression.digest)
                stack.append((operand.expression, iter(operand.expression.operands)))
                break
        else:
            stack.pop()
            yield node


def _is_array(value: Any) -> bool:
    """Return whether a parameter is an array, without importing numpy."""
    return hasattr(value, "tobytes")


def _shape_text(shape: Primitive | None) -> str:
    """Return a text that is equal for primitives of equal geometry; of a mesh file, the digest of its triangles."""
    if shape is None:
        return ""
    if shape.is_file:
        mesh = shape.triangulate(0.0)
        import hashlib

        return hashlib.sha256(mesh.vertices.tobytes() + mesh.faces.tobytes()).hexdigest()
    return f"{type(shape).__qualname__} {sorted(shape.key.defining_attributes().items())}"


# --- plain data ------------------------------------------------------------------------------------------------------


def to_plain(expression: Expression, file_of: Any = str) -> list[dict[str, Any]]:
    """Return an expression as JSON data: its nodes, operands first, each with the indices of its operands.

    ``file_of(path)`` converts the paths of mesh files.
    """
    numbers: dict[str, int] = {}
    records = []
    for node in nodes_of(expression):
        numbers[node.digest] = len(numbers)
        record: dict[str, Any] = {"operation": node.operation, "word": node.word, "color": list(node.color)}
        if node.parameters:
            record["parameters"] = {name: _plain(value) for name, value in node.parameters.items()}
        if node.operands:
            record["operands"] = [
                [numbers[operand.expression.digest], list(operand.pose), operand.color and list(operand.color)]
                for operand in node.operands
            ]
        if node.shape is not None:
            record["shape"] = node.shape.word
            record["attributes"] = node.shape.key.defining_attributes()
            if node.shape.is_file:
                record["file"] = file_of(getattr(node.shape, "file", ""))
        records.append(record)
    return records


def _plain(value: Any) -> Any:
    """Return a parameter as JSON data, from which ``_from_plain`` makes it again."""
    if isinstance(value, tuple):
        return {"arrays": [array.tolist() for array in value]}
    return {"array": value.tolist()} if _is_array(value) else value


def from_plain(records: Any, shape_of: Any) -> Expression:
    """Return the expression of data made by ``to_plain``; raises ValueError for anything else.

    ``shape_of(word, attributes, file)`` returns the primitive of a leaf. The data may come from an untrusted file.
    """
    if not isinstance(records, list) or not 1 <= len(records) <= MAX_OPERATIONS:
        raise ValueError("a solid must be a list of operations")
    nodes: list[Expression] = []
    for record in records:
        if not isinstance(record, dict) or not isinstance(record.get("operation"), str):
            raise ValueError("an operation of a solid must be an object with a name")
        shape = None
        if record["operation"] == PRIMITIVE:
            shape = shape_of(str(record.get("shape")), record.get("attributes", {}), record.get("file"))
        operands = tuple(_operand(entry, nodes) for entry in record.get("operands", []))
        parameters = {str(name): _from_plain(value) for name, value in record.get("parameters", {}).items()}
        r, g, b = _numbers(record.get("color"), 3)
        word = str(record.get("word", ""))
        nodes.append(Expression(record["operation"], parameters, operands, shape, word, (r, g, b)))
        _ = nodes[-1].digest, nodes[-1].most_operations  # computed and cached from the leaves up, without recursion
    return nodes[-1]


def _operand(data: Any, nodes: Sequence[Expression]) -> Operand:
    """Return the operand with the number of an earlier node, a pose, and a color or None."""
    number, pose, color = data
    if type(number) is not int or not 0 <= number < len(nodes):
        raise ValueError("an operand must be an earlier operation")
    tint = None if color is None else _numbers(color, 3)
    return Operand(nodes[number], _numbers(pose, 12), None if tint is None else (tint[0], tint[1], tint[2]))


def _from_plain(value: Any) -> Any:
    """Return a parameter of JSON data; raises ValueError for any that ``_plain`` does not write."""
    if not isinstance(value, dict):
        if type(value) not in (int, float, str, bool):
            raise ValueError("a parameter of a solid must be plain")
        return value
    if "arrays" in value:
        return tuple(_array(rows) for rows in value["arrays"])
    return _array(value["array"])


def _array(value: Any) -> FloatArray:
    """Return nested lists of finite numbers as an array."""
    array = np.array(value, np.float64)
    if not np.isfinite(array).all():
        raise ValueError("a solid must have finite numbers")
    return array


def _numbers(value: Any, count: int) -> tuple[float, ...]:
    """Return a list of ``count`` finite numbers as a tuple."""
    if not isinstance(value, list) or len(value) != count or not all(type(x) in (int, float) for x in value):
        raise ValueError(f"expected {count} numbers")
    items = tuple(float(x) for x in value)
    if not all(map(math.isfinite, items)):
        raise ValueError("a solid must have finite numbers")
    return items


def check_size(expression: Expression) -> None:
    """Raise SceneError("size") if an expression has too many operations."""
    if expression.most_operations <= MAX_OPERATIONS:
        return
    count = sum(1 for _ in nodes_of(expression))
    if count > MAX_OPERATIONS:
        raise SceneError("size", f"a solid of {count:,} operations exceeds the limit of {MAX_OPERATIONS:,}")
