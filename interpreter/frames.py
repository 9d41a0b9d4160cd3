"""Where variables live at run time: the slots of a frame, and the steps that read and write them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.source import Span
from scenelang.interpreter.procedures import UNDEFINED, Frame, Node
from scenelang.interpreter.scope import Variable

if TYPE_CHECKING:
    from scenelang.interpreter.runtime import Runtime


class Layout:
    """The slots of one frame."""

    __slots__ = ("parent", "size", "slots")

    def __init__(self, parent: Layout | None) -> None:
        self.parent = parent
        self.slots: dict[Variable, int] = {}
        self.size = 1

    def add(self, variable: Variable | None) -> int:
        """A slot for ``variable``, or an unnamed one."""
        index = self.size
        self.size += 1
        if variable is not None:
            self.slots[variable] = index
        return index


def undefined(rt: Runtime, name: str, span: Span) -> SceneError:
    """The error for a variable that is read too early. Its later definition must undo what saw this."""
    rt.drew = True
    return SceneError("undefined-yet", f"`{name}` is used before its definition has run", None, span)


def slot_reader(depth: int, slot: int) -> Node:
    if depth == 0:
        return lambda f: f[slot]
    if depth == 1:
        return lambda f: f[0][slot]
    if depth == 2:
        return lambda f: f[0][0][slot]

    def read(f: Frame) -> Any:
        for _ in range(depth):
            f = f[0]
        return f[slot]

    return read


def slot_writer(depth: int, slot: int) -> Any:
    if depth == 0:

        def write_here(f: Frame, value: Any) -> None:
            f[slot] = value

        return write_here

    def write(f: Frame, value: Any) -> None:
        for _ in range(depth):
            f = f[0]
        f[slot] = value

    return write


def cell_reader(rt: Runtime, find: Node, name: str, span: Span) -> Node:
    def read(f: Frame) -> Any:
        cell = find(f)
        if cell.birth < rt.serial:
            rt.read(cell)
        value = cell.value
        if value is UNDEFINED:
            raise undefined(rt, name, span)
        return value

    return read


def checked_reader(rt: Runtime, find: Node, name: str, span: Span) -> Node:
    def read(f: Frame) -> Any:
        value = find(f)
        if value is UNDEFINED:
            raise undefined(rt, name, span)
        return value

    return read
