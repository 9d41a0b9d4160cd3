"""Random programs in a subset of Python, as a hypothesis strategy: `programs()` draws program text.

Every program ends soon and runs: loops are bounded, indices wrap, divisors are not zero, lists are never empty, numbers
stay small, and a count of what the loops around a statement may produce keeps scenes below a few hundred primitives.
Text comes from a structured draw whose first choices are the simplest, so examples shrink to short programs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from hypothesis import strategies as st

Draw = Callable[[st.SearchStrategy[Any]], Any]

MAX_PRIMITIVES = 120  # of one call of one function
MOST_DEPTH = 3  # of nested blocks
HEADER = "from helper import *\n"
HELPER = """
def put(parts, shape):
    parts.append(shape)
    return len(parts)

"""


@dataclass
class Scope:
    """Names by type, all of them bound wherever a statement of this block runs."""

    ints: list[str] = field(default_factory=list)
    floats: list[str] = field(default_factory=list)
    lists: list[str] = field(default_factory=list)  # of whole numbers, never empty
    functions: list[str] = field(default_factory=list)  # from a number to a number
    makers: list[tuple[str, int]] = field(default_factory=list)  # from a number to a shape, with its weight
    fixed: set[str] = field(default_factory=set)  # loop variables and names of an outer function: not assigned to

    def inner(self) -> Scope:
        return Scope(
            list(self.ints),
            list(self.floats),
            list(self.lists),
            list(self.functions),
            list(self.makers),
            set(self.fixed),
        )

    def closure(self) -> Scope:
        """The same names as a nested function sees them: only to be read."""
        scope = self.inner()
        scope.fixed |= {*scope.ints, *scope.floats, *scope.lists}
        return scope


@dataclass
class Signature:
    """A registered function: its parameters and how many primitives one call makes at most."""

    name: str
    parameters: list[tuple[str, str]]
    weight: int


class Writer:
    """Draws one program and collects its lines."""

    def __init__(self, draw: Draw) -> None:
        self.draw = draw
        self.lines: list[str] = []
        self.level = 0
        self.counter = 0
        self.done: list[Signature] = []
        self.weight = 0
        self.turns = 1
        self.depth = 0
        self.in_loop = False

    # --- drawing and writing ---

    def pick(self, options: list[Any]) -> Any:
        return self.draw(st.sampled_from(options))

    def whole(self, low: int, high: int) -> int:
        return self.draw(st.integers(low, high))

    def flip(self) -> bool:
        return self.draw(st.booleans())

    def several(self, most: int) -> Iterator[int]:
        """One to `most` turns; each further one is a choice of its own, which shrinks to none."""
        for k in range(most):
            if k and not self.whole(0, 3):
                return
            yield k

    def line(self, text: str) -> None:
        self.lines.append("    " * self.level + text)

    def fresh(self, prefix: str) -> str:
        self.counter += 1
        return f"{prefix}{self.counter}"

    @contextmanager
    def block(self, head: str, turns: int = 1, *, loop: bool = False) -> Iterator[None]:
        self.line(head)
        saved = self.turns, self.in_loop
        self.level += 1
        self.depth += 1
        self.turns *= turns
        self.in_loop = self.in_loop or loop
        yield
        self.turns, self.in_loop = saved
        self.level -= 1
        self.depth -= 1

    # --- expressions ---

    def number(self, scope: Scope, depth: int = 2) -> str:
        return self.integer(scope, depth) if self.flip() else self.real(scope, depth)

    def integer(self, scope: Scope, depth: int = 2) -> str:
        kinds = ["literal"] + ["name"] * 2 * bool(scope.ints)
        if depth > 0:
            kinds += ["sum", "product", "floor", "modulo", "convert", "choose", "draw", "extreme", "table"]
            kinds += ["item", "measure"] * bool(scope.lists) + ["call"] * bool(scope.functions)
        match self.pick(kinds):
            case "literal":
                return str(self.whole(0, 5))
            case "name":
                return self.pick(scope.ints)
            case "sum":
                return f"({self.integer(scope, depth - 1)} {self.pick(['+', '-'])} {self.integer(scope, depth - 1)})"
            case "product":
                return f"({self.integer(scope, depth - 1)} * {self.integer(scope, depth - 1)} % {self.whole(2, 11)})"
            case "floor":
                return f"({self.integer(scope, depth - 1)} // {self.pick([2, 3, -2])})"
            case "modulo":
                return f"({self.integer(scope, depth - 1)} % {self.pick([2, 3, -3])})"
            case "convert":
                return f"{self.pick(['int', 'round'])}({self.number(scope, depth - 1)})"
            case "choose":
                return f"({self.integer(scope, depth - 1)} if {self.truth(scope, depth - 1)} else {self.integer(scope, 0)})"
            case "draw":
                return self.pick(
                    [
                        "random.randint(0, 3)",
                        "np.random.randint(4)",
                        "np.random.randint(1, 5)",
                        "random.choice([1, 2, 4])",
                    ]
                )
            case "extreme":
                return (
                    f"{self.pick(['min', 'max'])}({self.integer(scope, depth - 1)}, {self.integer(scope, depth - 1)})"
                )
            case "table":
                return f"{{0: 1, 1: {self.integer(scope, depth - 1)}}}.get({self.integer(scope, depth - 1)} % 3, 2)"
            case "item":
                name = self.pick(scope.lists)
                index = self.pick(["0", "-1", f"{self.integer(scope, depth - 1)} % len({name})"])
                return f"{name}[{index}]"
            case "measure":
                return f"({self.pick(['len', 'sum', 'min', 'max'])}({self.pick(scope.lists)}) % 9)"
            case _:
                return f"{self.pick(scope.functions)}({self.integer(scope, depth - 1)})"

    def real(self, scope: Scope, depth: int = 2) -> str:
        kinds = ["literal"] + ["name"] * 2 * bool(scope.floats)
        if depth > 0:
            kinds += ["sum", "scaled", "quotient", "wave", "choose", "draw", "absolute"]
        match self.pick(kinds):
            case "literal":
                return self.pick(["0.5", "1.0", "0.25", "2.5", "-0.75"])
            case "name":
                return self.pick(scope.floats)
            case "sum":
                return f"({self.real(scope, depth - 1)} {self.pick(['+', '-'])} {self.number(scope, depth - 1)})"
            case "scaled":
                return f"({self.pick(['0.5', '-0.25', '1.5'])} * {self.number(scope, depth - 1)})"
            case "quotient":
                return f"({self.number(scope, depth - 1)} / (abs({self.number(scope, depth - 1)}) + 1))"
            case "wave":
                return f"math.{self.pick(['sin', 'cos'])}({self.number(scope, depth - 1)})"
            case "choose":
                return f"({self.real(scope, depth - 1)} if {self.truth(scope, depth - 1)} else {self.real(scope, 0)})"
            case "draw":
                return self.pick(
                    ["random.random()", "np.random.rand()", "np.random.uniform(0, 2)", "random.uniform(-1, 1)"]
                )
            case _:
                return f"abs({self.number(scope, depth - 1)})"

    def truth(self, scope: Scope, depth: int = 1) -> str:
        kinds = ["compare", "parity"]
        if depth > 0:
            kinds += ["both", "either", "not", "between"] + ["within", "any"] * bool(scope.lists)
        match self.pick(kinds):
            case "compare":
                return f"{self.number(scope, max(depth, 0))} {self.pick(['<', '>=', '=='])} {self.number(scope, 0)}"
            case "parity":
                return f"{self.integer(scope, 0)} % 2 == 0"
            case "both":
                return f"({self.truth(scope, depth - 1)} and {self.truth(scope, depth - 1)})"
            case "either":
                return f"({self.truth(scope, depth - 1)} or {self.truth(scope, depth - 1)})"
            case "not":
                return f"(not {self.truth(scope, depth - 1)})"
            case "between":
                return f"(0 <= {self.integer(scope, depth - 1)} < 4)"
            case "within":
                return f"({self.integer(scope, depth - 1)} {self.pick(['in', 'not in'])} {self.pick(scope.lists)})"
            case _:
                return f"{self.pick(['any', 'all'])}(q > 1 for q in {self.pick(scope.lists)})"

    def sequence(self, scope: Scope) -> str:
        """A list of one to eight whole numbers."""
        kinds = ["literal", "comprehension", "range"]
        kinds += ["slice", "filtered", "sorted", "joined", "keyed"] * bool(scope.lists)
        match self.pick(kinds):
            case "literal":
                return "[" + ", ".join(self.integer(scope, 1) for _ in range(self.whole(1, 3))) + "]"
            case "comprehension":
                inner = scope.inner()
                inner.ints.append("k")
                inner.fixed.add("k")
                return f"[{self.integer(inner, 2)} for k in range({self.whole(1, 4)})]"
            case "range":
                return f"list(range({self.whole(1, 5)}))"
            case "slice":
                return f"{self.pick(scope.lists)}{self.pick(['[::-1]', '[:2]', '[-1:]', '[:]', '[::2]'])}"
            case "filtered":
                inner = scope.inner()
                inner.ints.append("q")
                source = self.pick(scope.lists)
                return f"([{self.integer(inner, 1)} for q in {source} if {self.truth(inner, 1)}] or [0])[:8]"
            case "sorted":
                return f"sorted({self.pick(scope.lists)}{self.pick(['', ', reverse=True'])})"
            case "joined":
                return f"({self.pick(scope.lists)} + {self.pick(scope.lists)})[:8]"
            case _:
                return f"sorted({self.pick(scope.lists)}, key=lambda q: -(q % 3))"

    # --- shapes ---

    def primitive(self, scope: Scope) -> str:
        self.weight += self.turns
        size = f"0.2 + abs({self.number(scope, 1)}) % 1.5"
        match self.pick(["cube", "sphere", "cylinder", "color"]):
            case "cube":
                return f"primitive_call('cube', shape_kwargs={{'scale': (1, {size}, 0.5)}})"
            case "sphere":
                return f"primitive_call('sphere', shape_kwargs={{'radius': {size}}}, color=(1, 0, 0))"
            case "cylinder":
                ends = f"'p0': (0, 0, 0), 'p1': (0, {size}, 1)"
                return f"primitive_call('cylinder', shape_kwargs={{'radius': 0.25, {ends}}}, color=(0, 0.5, 1))"
            case _:
                shade = f"abs({self.real(scope, 1)}) % 1.0"
                return f"primitive_call('cube', color=({shade}, 0.5, 0.5), shape_kwargs={{'scale': {size}}})"

    def library_call(self, scope: Scope) -> str:
        fitting = [s for s in self.done if self.weight + self.turns * s.weight <= MAX_PRIMITIVES]
        if not fitting:
            return self.primitive(scope)
        target = self.pick(fitting)
        self.weight += self.turns * target.weight
        given = [
            f", {name}={self.integer(scope, 1) if kind == 'int' else self.real(scope, 1)}"
            for name, kind in target.parameters
            if self.flip()
        ]
        return f"library_call('{target.name}'{''.join(given)})"

    def shape(self, scope: Scope, depth: int = 1) -> str:
        kinds = ["primitive", "moved"] + ["library"] * 2 * bool(self.done)
        if depth > 0:
            kinds += ["turned", "joined", "scaled"]
        match self.pick(kinds):
            case "primitive":
                return self.primitive(scope)
            case "library":
                return self.library_call(scope)
            case "moved":
                offset = f"({self.number(scope, 1)}, {self.number(scope, 1)}, {self.integer(scope, 0)})"
                return f"transform_shape({self.shape(scope, 0)}, translation_matrix({offset}))"
            case "turned":
                angle = self.real(scope, 1)
                return f"transform_shape({self.shape(scope, 0)}, rotation_matrix({angle}, (0, 1, 0), (0, 0, 0)))"
            case "joined":
                return f"concat_shapes({self.shape(scope, 0)}, {self.shape(scope, 0)})"
            case _:
                pose = f"translation_matrix((1, 0, {self.number(scope, 0)})) @ scale_matrix(0.5, (0, 0, 0))"
                return f"transform_shape({self.shape(scope, 0)}, {pose})"

    # --- statements ---

    def statement(self, scope: Scope) -> None:
        kinds = ["append", "int", "float", "list", "extend"]
        assignable = [n for n in scope.ints if n not in scope.fixed]
        changeable = [n for n in scope.lists if n not in scope.fixed]
        kinds += ["again", "swap"] * bool(assignable) + ["push", "store", "shuffle", "alias"] * bool(changeable)
        kinds += ["unpack"] * bool(scope.lists)
        if self.depth < MOST_DEPTH:
            kinds += ["if", "for", "while", "enumerate", "local", "lambda"]
        kinds += ["put"] + ["loop"] * bool(scope.makers) + ["return"]
        if self.in_loop:
            kinds += ["break", "continue"]
        match self.pick(kinds):
            case "append":
                self.line(f"shapes.append({self.shape(scope)})")
            case "extend":
                self.line(self.pick(["shapes += [{}]", "shapes.extend([{}])"]).format(self.shape(scope)))
            case "put":
                self.line(f"put(shapes, {self.shape(scope)})")
            case "loop":
                self.repeat(*self.pick(scope.makers))
            case "int":
                self.assign(scope, scope.ints, "n", self.integer(scope))
            case "float":
                self.assign(scope, scope.floats, "x", f"{self.real(scope)} % 7")
            case "list":
                self.assign(scope, scope.lists, "xs", self.sequence(scope))
            case "again":
                name = self.pick(assignable)
                self.line(f"{name} = ({name} {self.pick(['+', '-', '*'])} {self.integer(scope, 1)}) % 13")
            case "swap":
                first, second = self.pick(assignable), self.pick(assignable)
                self.line(f"{first}, {second} = {second}, {first}")
            case "push":
                self.line(f"{self.pick(changeable)}.append({self.integer(scope, 1)})")
            case "store":
                name = self.pick(changeable)
                self.line(f"{name}[{self.integer(scope, 1)} % len({name})] = {self.integer(scope, 1)}")
            case "shuffle":
                self.line(f"{self.pick(['random', 'np.random'])}.shuffle({self.pick(changeable)})")
            case "alias":
                self.assign(scope, scope.lists, "xs", self.pick(changeable))
            case "unpack":
                first, rest = self.fresh("n"), self.fresh("xs")
                self.line(f"{first}, *{rest} = {self.pick(scope.lists)} + [1]")
                scope.ints.append(first)
                scope.lists.append(rest)
            case "if":
                self.branches(scope)
            case "for":
                name, turns = self.fresh("i"), self.whole(1, 3)
                with self.block(f"for {name} in range({turns}):", turns, loop=True):
                    self.body(scope, ints=[name])
            case "enumerate":
                index, item, turns = self.fresh("i"), self.fresh("v"), self.whole(1, 3)
                values = ", ".join(self.integer(scope, 1) for _ in range(turns))
                with self.block(f"for {index}, {item} in enumerate([{values}]):", turns, loop=True):
                    self.body(scope, ints=[index, item])
            case "while":
                name, turns = self.fresh("w"), self.whole(1, 3)
                self.line(f"{name} = 0")
                with self.block(f"while {name} < {turns}:", turns, loop=True):
                    self.line(f"{name} += 1")
                    self.body(scope, ints=[name])
            case "local":
                self.local(scope)
            case "lambda":
                name = self.fresh("f")
                inner = scope.closure()
                inner.ints.append("q")
                self.line(f"{name} = lambda q: {self.integer(inner, 1)} % 7")
                scope.functions.append(name)
            case "return":
                with self.block(f"if {self.truth(scope)}:"):
                    self.line("return concat_shapes(*shapes)")
            case word:
                with self.block(f"if {self.truth(scope)}:"):
                    self.line(word)

    def assign(self, scope: Scope, names: list[str], prefix: str, value: str) -> None:
        """Bind a new name, or in a quarter of the cases an old one."""
        old = [n for n in names if n not in scope.fixed]
        if prefix == "x" and old and self.whole(0, 3) == 3:
            self.line(f"{self.pick(old)} = {value}")
            return
        name = self.fresh(prefix)
        self.line(f"{name} = {value}")
        names.append(name)

    def body(self, scope: Scope, ints: list[str] | None = None, most: int = 2) -> None:
        inner = scope.inner()
        inner.ints += ints or []
        inner.fixed |= set(ints or [])
        for _ in self.several(most):
            self.statement(inner)

    def branches(self, scope: Scope) -> None:
        with self.block(f"if {self.truth(scope)}:"):
            self.body(scope)
        if self.flip():
            with self.block(f"elif {self.truth(scope)}:"):
                self.body(scope)
        if self.flip():
            with self.block("else:"):
                self.body(scope)

    def local(self, scope: Scope) -> None:
        """A nested function that reads names of the outer one, for `loop` here and perhaps again later."""
        name = self.fresh("make")
        outside, self.weight = self.weight, 0
        turns, self.turns = self.turns, 1
        inner = scope.closure()
        inner.ints.append("i")
        with self.block(f"def {name}(i):"):
            self.in_loop = False
            if self.flip():
                local = self.fresh("n")
                self.line(f"{local} = {self.integer(inner)}")
                inner.ints.append(local)
            if self.flip():
                with self.block(f"if {self.truth(inner)}:"):
                    self.line(f"return {self.pick(['[]', self.shape(inner)])}")
            self.line(f"return {self.shape(inner)}")
        weight, self.weight, self.turns = self.weight, outside, turns
        scope.makers.append((name, weight))
        self.repeat(name, weight)

    def repeat(self, name: str, weight: int) -> None:
        """A nested function called in a loop, as often as the scene may grow."""
        room = (MAX_PRIMITIVES - self.weight) // max(1, self.turns * weight)
        times = min(self.whole(1, 3), max(0, room))
        self.weight += self.turns * weight * times
        self.line(f"shapes.append(loop({times}, {name}))")

    def function(self, name: str, *, root: bool) -> None:
        self.weight, self.turns, self.depth = 0, 1, 0
        scope = Scope()
        parameters: list[tuple[str, str]] = []
        for _ in range(0 if root else self.whole(0, 2)):
            kind = self.pick(["int", "float"])
            parameter = self.fresh("a")
            parameters.append((parameter, kind))
            (scope.ints if kind == "int" else scope.floats).append(parameter)
        defaults = ", ".join(f"{p}={'2' if kind == 'int' else '0.5'}" for p, kind in parameters)
        self.line("@register()")
        with self.block(f"def {name}({defaults}):"):
            self.depth = 0
            self.line(f"shapes = [{self.primitive(scope)}]")
            for _ in self.several(8):
                self.statement(scope)
            if root and self.done:
                self.line(f"shapes.append({self.library_call(scope)})")
            self.line("return concat_shapes(*shapes)")
        self.line("")
        self.done.append(Signature(name, parameters, self.weight))


@st.composite
def programs(draw: Draw) -> str:
    """The text of a program whose root is its last function."""
    writer = Writer(draw)
    for k in range(3):
        if k == 2 or not writer.whole(0, 2):
            break
        writer.function(f"part{k}", root=False)
    writer.function("scene", root=True)
    text = "\n".join(writer.lines)
    return HEADER + (HELPER if "put(" in text else "") + "\n" + text
