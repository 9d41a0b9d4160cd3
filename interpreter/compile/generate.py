"""Generator of Python functions for hot code: one function per ``lambda`` or loop of the core AST.

Closures remain the tier for cold code: compiling a function to Python costs about 20 microseconds per line, as much as
a hundred or more calls of it as closures, and most functions of a published program are called less often. Both tiers
share frames, helpers and error messages; ``tests/differential.py`` compares them.

Variables are Python's local variables; those that closures capture are also stored in the frame, with the addresses
that the closures of ``compile`` use, so that code of both tiers shares frames. Statements are written one per line: the
line number of a call in a traceback is the key of its *site* (see ``generated``), so that no call needs a ``try``. No
text of a program enters the source: variables are numbered, and values are constants of the function's namespace.

Forms without a translation here (``guard``, ``let/ec``, patterns, loops whose variables closures capture) are compiled
to closures and called with the frame (``_embed``). Code that is too deep or too long for CPython stays with the
closures.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from operator import itemgetter
from types import CodeType
from typing import TYPE_CHECKING, Any

from scenelang.grammar import ast
from scenelang.grammar.datum import Keyword
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.lazy_patterns import lazy_pattern
from scenelang.interpreter.compile import calls, generated, intrinsics
from scenelang.interpreter.compile.analyze import (
    FrameLayout,
    Loop,
    LoopKinds,
    children,
    enters_library,
    pattern_variables,
    tail_nodes,
    walk,
)
from scenelang.interpreter.compile.generated import (
    BLOCK,
    COMPARISONS,
    OPERATORS,
    CallSite,
    CodeText,
    Local,
    Text,
    Unsupported,
)
from scenelang.interpreter.compile.kinds import (
    ANY,
    BOOLEAN,
    CONS,
    EMBEDDING,
    FUNCTION,
    LIST,
    MATRIX,
    NEVER,
    PART,
    VECTOR,
    Kind,
    join,
    kind_of_operand,
)
from scenelang.interpreter.expand.scope import Variable
from scenelang.interpreter.runtime.procedures import UNDEFINED, ClosureCode, Frame, Node
from scenelang.interpreter.runtime.show import array_literal
from scenelang.interpreter.runtime.types import Builtin, Mismatch
from scenelang.interpreter.values.values import Matrix

if TYPE_CHECKING:
    from scenelang.interpreter.compile.compile import Compiler

_MAX_NODES = 3_000  # of a function; longer code stays with the closures
_MAX_LOOPS = 50  # of a function: the inner loops of a nest are analyzed once for every loop around them
_MAX_ARITY = 8  # parameters of a function; ``_ADAPTERS`` of ``compile`` has one adapter for each number of them
_MAX_UNCHARGED = 32  # arguments of a builtin; ``call_builtin`` charges for more (``_MIN_CHARGED`` of ``procedures``)
_MAX_INLINE_LIST = 4  # items of ``(list ...)`` that are written as nested pairs
_FRAME = lazy_pattern(r"\bF\b")  # the frame of a generated function, in its text


@dataclass(eq=False, slots=True)
class LoopCode:
    """Loop that is being written: its function, and the local variable that counts its turns.

    ``number`` identifies the loop in the text: ``q = number`` before a ``break`` selects the outer loop that continues.
    """

    variable: Variable
    function: ast.Lambda
    counter: str | None
    number: int
    is_left: bool = False  # whether an inner loop continues an outer one


@dataclass(frozen=True, slots=True)
class Dest:
    """Destination of a value.

    Attributes
    ----------
    name
        Local variable to which it is assigned; None if it is not used.
    returns
        Whether it is the result of the function.
    loops
        Loops that the value ends, the innermost last.
    """

    name: str | None = None
    returns: bool = False
    loops: tuple[LoopCode, ...] = ()

    @property
    def exits(self) -> bool:
        """Whether control leaves the current statements with the value."""
        return self.returns or bool(self.loops)


NOWHERE = Dest()
_EMBEDDED = (ast.Guard, ast.LetEscape)
_COLLECTING = ("list", "append")
_FOR_KINDS = frozenset({*_COLLECTING, "union", "each", "sum", "and", "or", "first", "fold"})


class FunctionWriter(Text):
    """Writer of one generated function.

    Expressions are written as statements that assign temporaries, plus a Python expression of the value (``value``);
    statements send their value to a destination (``into``).
    """

    def __init__(self, compiler: Compiler, layout: FrameLayout, root: Any) -> None:
        super().__init__(compiler, layout)
        self.survey(root)

    # --- preparation ---------------------------------------------------------------------------------------------

    def survey(self, root: Any) -> None:
        """Find the variables that embedded code uses; refuse code that is too long or has too many loops."""
        stack, count, loops = [root], 0, 0
        while stack:
            node = stack.pop()
            count += 1
            if count > _MAX_NODES:
                raise Unsupported
            if type(node) is ast.Lambda:
                continue  # its variables are captured
            loop = self.compiler.analysis.loops.get(id(node))
            if loop is not None:
                loops += 1
                if loops > _MAX_LOOPS:
                    raise Unsupported
                stack += [loop.function.body, *loop.start.arguments]
                continue
            if self.is_embedded(node):
                self._survey_embedded(node)
            else:
                stack.extend(children(node))

    def is_embedded(self, node: Any) -> bool:
        """Return whether a form has no translation to Python, so that the generated code calls it as a closure.

        Destructuring patterns and loops whose turns have frames of their own, because closures capture their variables,
        have none.
        """
        if type(node) is ast.Define:
            return isinstance(node.target, tuple)  # a pattern
        if type(node) is ast.For:
            targets = [accumulator.target for accumulator in node.accumulators]
            targets += [target for clause in node.clauses for target in clause.targets]
            has_pattern = any(isinstance(target, tuple) for target in targets)
            return self.compiler.region(node).has_frame or node.kind not in _FOR_KINDS or has_pattern
        if type(node) is ast.While:
            return self.compiler.region(node).has_frame
        return isinstance(node, _EMBEDDED)

    def _survey_embedded(self, root: Any) -> None:
        """Record the variables that a closure for an embedded form reads, assigns or defines."""
        for node in walk(root):
            if type(node) is ast.Reference and isinstance(node.target, Variable):
                self.embedded.add(node.target)
                if node.target.assigned:
                    self.unshared.add(node.target)
            elif type(node) is ast.Assignment:
                self.unshared.add(node.target)
            elif type(node) is ast.Define:
                self.unshared.update(pattern_variables(node.target))

    # --- whole functions -----------------------------------------------------------------------------------------

    def function(self, node: ast.Lambda, code: ClosureCode) -> Callable[..., Any]:
        """Write and compile a function.

        Parameters
        ----------
        node
            The function.
        code
            Its compiled closure.

        Returns
        -------
        callable
            ``g(env, *arguments)``, or ``g(frame)`` if its parameters are not all plain.

        Raises
        ------
        Unsupported
            If no code can be generated.
        """
        is_plain = code.arity >= 0  # arguments are parameters of the generated function, not slots of a frame
        if code.arity > _MAX_ARITY:
            raise Unsupported
        names = [self.fresh("v") for _ in node.parameters]
        self._find_itself(code)
        self.line(f"def g({', '.join(['e', *names]) if is_plain else 'f'}):")
        self.indent = 1
        self.line("try:")
        self.indent = 2
        if is_plain and self.direct is not None and self._has_self_tail(node.body):
            self.open("while True:")
            self.self_tail = tuple(names)
        frame_line = self.prologue(is_plain=is_plain)
        for parameter, name, slot in zip(node.parameters, names, range(1, len(names) + 1)):
            target = parameter.target
            if not is_plain:
                self.line(f"{name} = f[{slot}]")
            if target is not None and not self.in_frame_only(target):
                self.names[target] = name
                if target.assigned:
                    self.mutable.add(name)
        self.into(node.body, Dest(returns=True))
        self._finish_frame(frame_line, names, is_plain=is_plain)
        if not self.returns_tail:
            for number in self.own_checks:
                text = self.lines[number]
                self.lines[number] = text[: len(text) - len(text.lstrip())] + "pass"
        return self._compiled()

    def prologue(self, *, is_plain: bool) -> int:
        """Write a line for the creation of the frame, and return its index; ``_finish_frame`` completes it."""
        self.frames[self.base] = "F" if is_plain else "f"
        self.line("pass")
        return len(self.lines) - 1

    def _finish_frame(self, index: int, names: Sequence[str], *, is_plain: bool) -> None:
        """Write the creation of the frame, whose size is known after the body, in line ``index``, if it is needed."""
        text = self.lines[index]
        assert text.strip() == "pass"
        indent = text[: text.index("pass")]
        missing = self.base.size - 1 - len(names)
        if not is_plain:
            if missing:
                self.lines[index] = f"{indent}f.extend({self.constant((None,) * missing)})"
        elif self.uses_frame:
            self.lines[index] = f"{indent}F = [{', '.join(['e', *names, *['None'] * missing])}]"

    @property
    def uses_frame(self) -> bool:
        """Whether a line mentions the frame; most functions keep all variables in local ones and create none."""
        return any(_FRAME.search(line) for line in self.lines)

    def loop(self, loop: Loop, tail: bool) -> Callable[[Frame, int], Any]:
        """Write and compile a loop that the closures began; return ``g(frame, done)``.

        ``done`` is the number of turns that are not charged yet. In tail position of its function (``tail``) the loop
        may return a tail call.
        """
        self.line("def g(f, done):")
        self.indent = 1
        self.line("try:")
        self.indent = 2
        self.frames[self.base] = "f"
        self.preload(loop.function.body)
        parameters = [p.target for p in loop.function.parameters]
        for target in parameters:
            if target is None:
                raise Unsupported
            if not self.in_frame_only(target):
                self.line(f"{self.name_of(target)} = f[{self.base.slots[target]}]")
        dest = Dest(returns=True) if tail else Dest(self.fresh("t"))
        inference = LoopKinds(self.kind_of_variable)
        self.write_loop(loop, dest, [inference.kind(start) for start in loop.start.arguments], resumed=True)
        if not tail:
            self.line(f"return {dest.name}")
        return self._compiled()

    def expression(self, node: Any) -> Callable[[Frame], Any]:
        """Write and compile an expression whose variables are in a frame; return ``g(frame)``."""
        self.line("def g(f):")
        self.indent = 1
        self.line("try:")
        self.indent = 2
        self.frames[self.base] = "f"
        self.preload(node)
        result = self.fresh("t")
        self.into(node, Dest(result))
        self.line(f"return {result}")
        return self._compiled()

    def preload(self, root: Any) -> None:
        """Copy variables of the enclosing code, which the loop ``root`` refers to and nothing changes, to local ones.

        Reading a local variable of Python is faster than a slot of the frame in every turn.
        """
        bound = {v for node in walk(root) if type(node) is ast.Define for v in pattern_variables(node.target)}
        for node in walk(root):
            target = node.target if type(node) is ast.Reference else None
            if not isinstance(target, Variable) or target.is_global or target in bound or target in self.names:
                continue
            if target.assigned or target.recursive or target not in self.base.slots:
                continue
            self.line(f"{self.name_of(target)} = f[{self.base.slots[target]}]")

    def _compiled(self) -> Callable[..., Any]:
        """Compile the lines to a function, whose handler locates errors by the line in the traceback.

        One handler per function and a table from lines to calls keep the text shorter to compile than a ``try`` per
        call.
        """
        self.indent = 1
        self.line("except CAUGHT as error:")
        self.indent = 2
        self.line("located = placed(error, SITES)")
        self.line("if located is error:")
        self.line(" raise")
        self.line("raise located from None")
        source = "\n".join(self.lines) + "\n"
        exec(_code_of(source), self.constants)  # noqa: S102  # nosec B102: of our own templates; no text of a program
        self.rt.units.append(self.constants)
        entry: Callable[..., Any] = self.constants["g"]
        return entry

    def _find_itself(self, code: ClosureCode) -> None:
        """Record the global variable whose value is this function, if there is one, for direct calls of itself."""
        for cell in self.compiler.global_cells_of(code):
            self.direct = (cell.value, self.constant(cell))

    def _has_self_tail(self, body: Any) -> bool:
        """Return whether the function calls itself in tail position, outside of loops."""
        assert self.direct is not None
        itself = self.direct[0]
        for node in tail_nodes(body, self.compiler.analysis.loops):
            if type(node) is ast.Application and isinstance(node.function, ast.Reference):
                target = node.function.target
                if isinstance(target, Variable) and self.known_global(target) is itself:
                    return True
        return False

    # --- variables -----------------------------------------------------------------------------------------------

    def reference(self, node: ast.Reference) -> CodeText:
        """Return the value of a variable, checked for a definition where it may have none yet."""
        target = node.target
        if not isinstance(target, Variable):
            return CodeText(self.constant(target), FUNCTION)
        if target.is_global:
            return self._global_reference(target, node)
        name = self.names.get(target)
        if name is None:
            text = self.slot_text(target)
            if self.in_cell(target):
                return self.read_cell(text, target, node)
            if target.recursive:
                value = self.temporary(CodeText(text))
                self.check_defined(value.text, target, node)
                return value
            return self.temporary(CodeText(text)) if target.assigned else CodeText(text, ANY, True, False)
        if target.recursive and name not in self.kinds:
            self.check_defined(name, target, node)
        if target.assigned:
            return self.temporary(CodeText(name))
        return CodeText(name, self.kinds.get(name, ANY))

    def _global_reference(self, target: Variable, node: ast.Reference) -> CodeText:
        cell = self.compiler.global_cell(target)
        name = self.constant(cell)
        if target.assigned:
            return self.read_cell(name, target, node)
        value = self.temporary(CodeText(f"{name}.value"))
        if cell.value is UNDEFINED:
            self.check_defined(value.text, target, node)
        return value

    # --- expressions ---------------------------------------------------------------------------------------------

    def value(self, node: Any) -> CodeText:
        """Write the statements that a node needs, and return the Python expression of its value."""
        kind = type(node)
        if kind is ast.Constant:
            return self.literal(node.value)
        if kind is ast.Reference:
            return self.reference(node)
        if kind is ast.Application and type(node.function) is ast.Reference:
            target = node.function.target
            if isinstance(target, Builtin):
                return self.builtin(target, node)
        write = _VALUES.get(kind)
        if write is not None:
            code: CodeText = write(self, node)
            return code
        if self.is_embedded(node):
            return self._embed(node)
        if kind is ast.Application:
            return self.call(node)
        if kind is ast.For:
            return self._for(node)
        if kind is ast.While:
            return self._while(node)
        name = self.fresh("t")
        result = self.into(node, Dest(name))
        self.kinds[name] = ANY if result is NEVER else result
        return CodeText(name, self.kinds[name])

    def operands(self, nodes: Sequence[Any], *, atomic: bool = True) -> list[CodeText]:
        """Return the values of several nodes, evaluated in order, as names or constants.

        Unless ``atomic`` is set, the values may also be pure expressions.
        """
        values = []
        for node in nodes:
            code = self.value(node)
            values.append(code if code.atomic or (code.pure and not atomic) else self.temporary(code))
        return values

    def _embed(self, node: Any) -> CodeText:
        """Write a call of a closure for a form without a translation."""
        run = self.compiler.embedded(node, self.layout)
        return self.temporary(CodeText(f"{self.constant(run)}({self.frames[self.layout]})"))

    def by_values(self, make: Callable[[list[Node]], Node], nodes: Sequence[Any]) -> CodeText:
        """Evaluate nodes, and call the closure that ``make`` compiles for them.

        The closure gets the tuple of values as its frame, and its operands read their items.
        """
        run = make([itemgetter(i) for i in range(len(nodes))])
        values = self.operands(nodes)
        return self.temporary(CodeText(f"{self.constant(run)}(({''.join(f'{v.text}, ' for v in values)}))"))

    def _lambda(self, node: ast.Lambda) -> CodeText:
        code = self.compiler.codes.get(id(node))
        if code is None:
            raise Unsupported
        return self.temporary(CodeText(f"Closure({self.constant(code)}, {self.frames[self.layout]})", FUNCTION))

    def _assignment(self, node: ast.Assignment) -> CodeText:
        """Write ``set!`` of a variable in a cell, a local variable or a slot."""
        value = self.atom(self.value(node.value))
        target = node.target
        if target.is_global or self.in_cell(target):
            store = self.constant(generated.cell_storer(self.rt, target.name, node.span))
            cell = self.constant(self.compiler.global_cell(target)) if target.is_global else self.slot_text(target)
            self.line(f"{store}({cell}, {value.text})")
        elif target in self.names:
            self.line(f"{self.names[target]} = {value.text}")
        else:
            self.line(f"{self.slot_text(target)} = {value.text}")
        return CodeText("None")

    def _array(self, node: ast.ArrayLiteral) -> CodeText:
        """Write an array literal; three numbers of one type become a Vector without a call."""
        if all(type(item) is ast.Constant for item in node.items):
            try:
                value = array_literal([item.value for item in node.items])  # type: ignore[union-attr]
                return CodeText(self.constant(value), kind_of_operand(value))
            except SceneError:
                pass  # reported at run time
        if len(node.items) != 3:
            return self.by_values(lambda nodes: calls.array_node(self.rt, nodes, node.span), node.items)
        values = self.operands(node.items)
        texts = [v.text for v in values]
        kinds = [self.kind_of(v) for v in values]
        if all(kind.tag == "Float" for kind in kinds) or all(kind.tag == "Integer" for kind in kinds):
            return self.temporary(CodeText(f"Vector(({', '.join(texts)}))", VECTOR))
        run = self.constant(calls.vector_maker(self.rt, node.span))
        return self.temporary(CodeText(f"{run}({', '.join(texts)})"))

    def _first(self, node: ast.First) -> CodeText:
        first = self.temporary(self.value(node.items[0]))
        for item in node.items[1:]:
            self.effect(item)
        return first

    def _transform(self, node: ast.Transform) -> CodeText:
        part, matrix = self.operands((node.part, node.matrix))
        result = calls.part_result(self.compiler, node)
        slow = self.constant(calls.transform_node(self.rt, itemgetter(0), itemgetter(1), node.span, result))
        test = f"type({part.text}) is Entity"
        if matrix.text not in self.poses:
            test += f" and type({matrix.text}) is Matrix and isfinite(sum({matrix.text}))"
        text = f"Pair({part.text}, {matrix.text}) if {test} else {slow}(({part.text}, {matrix.text}))"
        return self.temporary(CodeText(text, ANY if id(node) in self.compiler.analysis.parts else PART))

    def _union(self, node: ast.Union) -> CodeText:
        result = calls.part_result(self.compiler, node)
        return self.by_values(lambda nodes: calls.union_node(self.rt, nodes, node, result), node.members)

    def _union_loop(self, node: ast.UnionLoop) -> CodeText:
        result = calls.part_result(self.compiler, node)

        def compiled(nodes: list[Node]) -> Node:
            return calls.union_loop_node(self.rt, nodes[0], nodes[1], node.span, result)

        return self.by_values(compiled, (node.count, node.function))

    def _bind(self, node: ast.Bind) -> CodeText:
        def compiled(nodes: list[Node]) -> Node:
            return calls.bind_node(self.rt, nodes[0], nodes[1], node.span)

        return self.by_values(compiled, (node.word, node.function))

    def _entity(self, node: ast.Call) -> CodeText:
        def compiled(nodes: list[Node]) -> Node:
            return calls.call_node(self.rt, nodes[0], nodes[1:], node)

        return self.by_values(compiled, (node.word, *calls.call_operands(node)))

    def _handle(self, node: ast.HandleLiteral) -> CodeText:
        return CodeText(self.constant(self.rt.handle(node.name)), EMBEDDING)

    # --- tests ---------------------------------------------------------------------------------------------------

    def test(self, node: Any) -> str:
        """Write the statements that a test needs, and return its Python condition."""
        kind = type(node)
        if kind is ast.Application and type(node.function) is ast.Reference:
            target = node.function.target
            if isinstance(target, Builtin) and target.intrinsic == "not" and len(node.arguments) == 1:
                return f"(not {self.test(node.arguments[0])})"
        if kind in (ast.And, ast.Or) and node.items:
            text = self._joined_test(node)
            if text is not None:
                return text
        return self.truth(self.value(node))

    def _joined_test(self, node: Any) -> str | None:
        """Return the condition of ``and`` or ``or``, if the tests after the first need no statements; else None."""
        lines, kinds, names = len(self.lines), dict(self.kinds), dict(self.names)
        first = self.test(node.items[0])
        start = len(self.lines)
        texts = [first]
        for item in node.items[1:]:
            texts.append(self.test(item))
            if len(self.lines) != start:
                self.roll_back(lines, kinds, names)
                return None
            self.kinds = dict(kinds)
        return "(" + (" and " if type(node) is ast.And else " or ").join(texts) + ")"

    # --- statements ----------------------------------------------------------------------------------------------

    def effect(self, node: Any) -> None:
        """Write a node whose value is not used."""
        self.into(node, NOWHERE)

    def into(self, node: Any, dest: Dest) -> Kind:
        """Write a node and send its value to ``dest``; return the kind of the value, NEVER if there is none."""
        kind = type(node)
        if kind is ast.If:
            return self._if(node, dest)
        if kind is ast.Body:
            return self._body(node, dest)
        if kind is ast.And or kind is ast.Or:
            return self._and_or(node, dest)
        if kind is ast.Application and not (
            type(node.function) is ast.Reference and isinstance(node.function.target, Builtin)
        ):
            return self._application(node, dest)
        if kind is ast.Application and dest.returns and node.function.target.name == "apply":
            run = calls.tail_apply(
                self.rt, node.function.target, [itemgetter(i) for i in range(len(node.arguments))], node.span
            )
            values = self.operands(node.arguments)
            self.returns_tail = True
            code = self.temporary(CodeText(f"{self.constant(run)}(({''.join(f'{v.text}, ' for v in values)}))"))
            return self.finish(dest, code)
        return self.finish(dest, self.value(node))

    def finish(self, dest: Dest, code: CodeText) -> Kind:
        """Write the end of an expression: send its value ``code`` to ``dest``, and leave the loops that end with it.

        Returns the kind of the value.
        """
        kind = self.kind_of(code)
        if dest.loops and not (code.atomic and code.pure):
            code = self.temporary(code)
        if dest.returns:
            self._leave(dest.loops)
            self.line(f"return {code.text}")
            return kind
        if dest.name is not None:
            self.line(f"{dest.name} = {code.text}")
        elif not code.atomic:
            self.line(code.text)
        if dest.loops:
            self._leave(dest.loops)
            if len(dest.loops) > 1:
                self.line("q = 0")
            self.line("break")
        return kind

    def _leave(self, loops: Sequence[LoopCode]) -> None:
        """Charge for the turns of loops that are left."""
        for loop in reversed(loops):
            if loop.counter is not None:
                self.line(f"charge({loop.counter})")

    def _if(self, node: ast.If, dest: Dest) -> Kind:
        """Write an ``if`` statement; return the join of the kinds of its branches."""
        test = self.test(node.test)
        kinds = dict(self.kinds)
        self.line(f"if {test}:")
        self.indent += 1
        then = self.into(node.then, dest)
        self.line("pass")
        self.indent -= 1
        self.kinds = dict(kinds)
        if not dest.exits:
            if node.otherwise is None and dest.name is None:
                return ANY
            self.line("else:")
            self.indent += 1
        if node.otherwise is None:
            other = self.finish(dest, CodeText("None"))
        else:
            other = self.into(node.otherwise, dest)
        if not dest.exits:
            self.line("pass")
            self.indent -= 1
        self.kinds = kinds
        return join(then, other)

    def _and_or(self, node: Any, dest: Dest) -> Kind:
        """Write ``and`` or ``or`` as nested ``if`` statements, whose values all go to ``dest``."""
        is_and = type(node) is ast.And
        if not node.items:
            return self.finish(dest, CodeText(repr(is_and), BOOLEAN))
        *tests, last = node.items
        kinds, indent = None, self.indent
        result = NEVER
        for item in tests:
            code = self.value(item)
            if self.kind_of(code).tag == "Boolean":
                truth, code = code.text, CodeText(repr(not is_and), BOOLEAN)
            else:
                code, result = self.atom(code), ANY
                truth = self.truth(code)
            kinds = dict(self.kinds) if kinds is None else kinds
            self.line(f"if not {truth}:" if is_and else f"if {truth}:")
            self.indent += 1
            self.finish(dest, code)
            self.line("pass")
            self.indent -= 1
            if not dest.exits:
                self.line("else:")
                self.indent += 1
        last_kind = self.into(last, dest)
        if self.indent != indent:
            self.line("pass")
        self.indent = indent
        if kinds is not None:
            self.kinds = kinds
        return join(BOOLEAN if tests and result is NEVER else result, last_kind)

    def _body(self, node: ast.Body, dest: Dest) -> Kind:
        """Write a body: its definitions and effects, then its value."""
        loop = self.compiler.analysis.loops.get(id(node))
        if loop is not None:
            return self._loop_body(loop, dest)
        self._prepare(node)
        for item in node.items[:-1]:
            self._define(item) if type(item) is ast.Define else self.effect(item)
        last = node.items[-1]
        if type(last) is ast.Define:
            self._define(last)
            return self.finish(dest, CodeText("None"))
        return self.into(last, dest)

    def _prepare(self, node: ast.Body) -> None:
        """Write the undefined state of variables that code may read or capture before their definition."""
        for item in node.items:
            if type(item) is not ast.Define:
                continue
            for variable in pattern_variables(item.target):
                if variable.is_global:
                    raise Unsupported
                self.layout.add(variable)
                if self.in_cell(variable):
                    self.line(f"{self.slot_text(variable)} = Cell(U, rt.clock)")
                elif variable.recursive:
                    if variable in self.unshared:
                        self.line(f"{self.slot_text(variable)} = U")
                        continue
                    name = self.name_of(variable)
                    self.kinds.pop(name, None)
                    self.line(f"{name} = U")
                    if self.is_stored(variable):
                        self.line(f"{self.slot_text(variable)} = U")

    def _define(self, node: ast.Define) -> None:
        """Write a definition of a body."""
        if self.is_embedded(node):
            self._embed(node)
            return
        if node.target is None:
            self.effect(node.value)
            return
        code = self.value(node.value)
        self.bind(node.target, code.text, self.kind_of(code))

    # --- loops ---------------------------------------------------------------------------------------------------

    def _loop_body(self, loop: Loop, dest: Dest) -> Kind:
        """Write a loop from its start."""
        function = loop.function
        region = self.compiler.analysis.regions[id(function)]
        starts = self.operands(loop.start.arguments)
        parameters = [p.target for p in function.parameters]
        if any(p is None for p in parameters):
            raise Unsupported
        kinds = [self.kind_of(code) for code in starts]
        if region.has_frame:
            return self._framed_loop(loop, dest, starts)
        for variable, code in zip(parameters, starts):
            self.layout.add(variable)
            self._set_parameter(variable, code.text)
        return self.write_loop(loop, dest, kinds)

    def _set_parameter(self, variable: Variable, text: str) -> None:
        """Write the first value of a loop's parameter."""
        if self.in_frame_only(variable):
            if self.in_cell(variable):
                raise Unsupported
            self.line(f"{self.slot_text(variable)} = {text}")
            return
        name = self.name_of(variable)
        self.line(f"{name} = {text}")
        if self.is_stored(variable):
            self.line(f"{self.slot_text(variable)} = {name}")

    def write_loop(self, loop: Loop, dest: Dest, kinds: Sequence[Kind], *, resumed: bool = False) -> Kind:
        """Write a loop whose parameters have their first values.

        Turns are charged in blocks: an inner ``for`` counts them without a call for each.

        Parameters
        ----------
        loop
            The loop.
        dest
            Destination of its value.
        kinds
            Kinds of the first values.
        resumed
            Whether the closures ran the first ``done`` turns of the first block.
        """
        parameters = [p.target for p in loop.function.parameters]
        parameter_kinds = LoopKinds(self.kind_of_variable).loop(loop, kinds)
        counter = self.fresh("n")
        record = LoopCode(loop.variable, loop.function, counter, self.fresh_number())
        before = dict(self.kinds)
        if resumed:
            self.line(f"turns = range(done + 1, {BLOCK + 1})")
        self.open("while True:")
        self.open(f"for {counter} in turns:" if resumed else f"for {counter} in BLOCK:")
        for variable, kind in zip(parameters, parameter_kinds):
            name = self.names.get(variable)
            if name is not None and not variable.assigned:
                self.kinds[name] = kind
        inner = Dest(dest.name, dest.returns, (*dest.loops, record))
        result = self.into(loop.function.body, inner)
        self.close()
        self.line("else:")
        self.indent += 1
        self.line(f"spend({BLOCK})")
        if resumed:
            self.line("turns = BLOCK")
        self.line("continue")
        self.indent -= 1
        self.line("break")
        self.close()
        self.kinds = before
        self._after_loop(record, dest)
        return result

    def fresh_number(self) -> int:
        """Return a new number of a loop."""
        self.count += 1
        return self.count

    def _after_loop(self, record: LoopCode, dest: Dest) -> None:
        """Write the lines after an inner loop in tail position of an outer loop, which continues or is left."""
        if not dest.loops:
            return
        parent = dest.loops[-1]
        if record.is_left:
            self.line(f"if q == {parent.number}: continue")
        self.line("break")

    def _framed_loop(self, loop: Loop, dest: Dest, starts: Sequence[CodeText]) -> Kind:
        """Write a loop with a frame for each turn, because closures capture its variables."""
        function = loop.function
        layout = self.compiler.layouts.get(id(function))
        if layout is None or layout.parent is not self.layout:
            raise Unsupported
        parameters = [p.target for p in function.parameters]
        names = [self.fresh("p") for _ in parameters]
        for name, code in zip(names, starts):
            self.line(f"{name} = {code.text}")
        record = LoopCode(loop.variable, function, None, self.fresh_number())
        self.loop_names[record.number] = names
        before, outer = dict(self.kinds), self.layout
        self.open("while True:")
        self.line("next(ticks)")
        frame = self.frames[layout] = self.fresh("F")
        self.line("pass")
        frame_line = len(self.lines) - 1  # completed when the size of the frame is known
        self.layout = layout
        for variable, name in zip(parameters, names):
            self.bind(variable, name, ANY)
        result = self.into(function.body, Dest(dest.name, dest.returns, (*dest.loops, record)))
        self.layout = outer
        self.lines[frame_line] = self.lines[frame_line].replace(
            "pass", f"{frame} = [{self.frames[outer]}{', None' * (layout.size - 1)}]"
        )
        self.close()
        self.kinds = before
        self._after_loop(record, dest)
        return result

    def _next_turn(self, node: ast.Application, dest: Dest, index: int) -> None:
        """Write the continuation of the loop ``dest.loops[index]``; the loops inside it are left."""
        record = dest.loops[index]
        values = self.operands(node.arguments, atomic=False)
        if record.counter is None:
            targets = self.loop_names[record.number]
            self.line(f"{', '.join(targets)} = {', '.join(v.text for v in values)}" if targets else "pass")
        else:
            self._assign_parameters(record, values)
        inner = dest.loops[index + 1 :]
        self._leave(inner)
        if not inner:
            self.line("continue")
            return
        for loop in inner:
            loop.is_left = True
        self.line(f"q = {record.number}")
        self.line("break")

    def _assign_parameters(self, record: LoopCode, values: Sequence[CodeText]) -> None:
        """Write the simultaneous assignment of a loop's parameters.

        The frame gets copies of those that closures or embedded code read.
        """
        targets, texts, slots = [], [], []
        for parameter, value in zip(record.function.parameters, values):
            variable = parameter.target
            if self.in_frame_only(variable):
                targets.append(self.slot_text(variable))
                texts.append(value.text)
                continue
            name = self.names[variable]
            if name != value.text:
                targets.append(name)
                texts.append(value.text)
                if self.is_stored(variable):
                    slots.append(f"{self.slot_text(variable)} = {name}")
        if targets:
            self.line(f"{', '.join(targets)} = {', '.join(texts)}")
        for text in slots:
            self.line(text)

    def _while(self, node: ast.While) -> CodeText:
        """Write a ``while`` loop, which gives its span to errors inside that have none."""
        before, around = dict(self.kinds), self.around
        self.around = node.span
        self.open("while True:")
        self.line("next(ticks)")
        self.line(f"if not {self.test(node.test)}: break")
        self.effect(node.body)
        self.close()
        self.kinds, self.around = before, around
        return CodeText("None")

    def _for(self, node: ast.For) -> CodeText:
        """Write a ``for`` form as nested loops of Python around the update of its result."""
        out, leaves = self.fresh("t"), self.fresh("t")
        starts = [self.temporary(self.value(a.value)) for a in node.accumulators]
        before = dict(self.kinds)
        results = [self.fresh("t") for _ in starts]
        for accumulator, result, start in zip(node.accumulators, results, starts):
            self.line(f"{result} = {start.text}")
            self._bind_item(accumulator.target, result)
        indent, blocks = self.indent, self.blocks
        self.line(f"{out} = {_STARTS.get(node.kind, '[]')}")
        self.line(f"{leaves} = False")
        loops = []  # indentation of each loop
        for clause in node.clauses:
            if clause.kind == "each":
                loops.append(self.indent)
                self._each(clause)
                continue
            test = self.test(clause.values[0])
            if clause.kind == "break":
                self.line(f"if {test}:")
                self.leave_all(leaves, loops)
            else:
                self.line(f"if {test}:" if clause.kind == "when" else f"if not {test}:")
                self.indent += 1
        if node.kind == "fold":
            self._fold_step(node, results)
        else:
            self._step(node, out, leaves, loops)
        for loop_indent in reversed(loops[1:]):
            self.indent = loop_indent
            self.line(f"if {leaves}: break")
        self.indent, self.blocks, self.kinds = indent, blocks, before
        if node.kind == "fold":
            return CodeText(results[0]) if len(results) == 1 else self.list_of([CodeText(result) for result in results])
        if node.kind == "union":
            result = self.constant(calls.part_result(self.compiler, node))
            is_list = id(node) not in self.compiler.analysis.parts
            return self.temporary(CodeText(f"{result}({out}.value())", LIST if is_list else ANY))
        if node.kind in _COLLECTING:
            return self.temporary(CodeText(f"make_list({out})", LIST))
        return CodeText("None" if node.kind == "each" else out)

    def _each(self, clause: ast.Clause) -> None:
        """Write the head of a Python loop over the sequences of a clause."""
        items = []
        for value in clause.values:
            code = self.value(value)
            iterate = self.constant(generated.iterator(self.rt, value.span))
            items.append(self.temporary(CodeText(f"{iterate}({code.text})")))
            kind = self.kind_of(code)
        names = [self.fresh("p") for _ in clause.targets]
        if len(items) == 1:
            self.open(f"for {names[0]} in {items[0].text}:")
        else:
            self.open(f"for {', '.join(names)} in zip({', '.join(item.text for item in items)}):")
            kind = ANY
        self.line("next(ticks)")
        for target, name in zip(clause.targets, names):
            self._bind_item(target, name, kind if kind.tag == "Integer" else ANY)

    def _bind_item(self, target: Variable | None, text: str, kind: Kind = ANY) -> None:
        """Write the binding of a loop variable or accumulator."""
        if target is not None:
            self.layout.add(target)
            self.bind(target, text, kind)

    def _step(self, node: ast.For, out: str, leaves: str, loops: Sequence[int]) -> None:
        """Write the body of a ``for`` form and the update of its result."""
        if node.kind == "each":
            self.effect(node.body)
            self.line("pass")
            return
        code = self.named(self.value(node.body))
        if node.kind == "list":
            self.line(f"{out}.append({code.text})")
        elif node.kind == "union":
            add = self.constant(generated.part_adder(self.rt, node.span))
            self.line(f"{add}({out}, {code.text})")
        elif node.kind == "append":
            add = self.constant(calls.item_adder(self.rt, node.span))
            self.line(f"{add}({out}, {code.text})")
        elif node.kind == "sum":
            slow = calls.slow_call(self.rt, self.rt.library.builtins["+"], node.span)
            total = self.arithmetic(
                "add", CodeText(out), code, self.constant(intrinsics.adder(lambda x, y: slow([x, y])))
            )
            self.line(f"{out} = {total.text}")
        else:
            self.choice_step(node.kind, code, out, leaves, loops)

    def _fold_step(self, node: ast.For, results: Sequence[str]) -> None:
        """Write a step of ``for/fold``: bind the accumulators, evaluate the body, and keep its values as results."""
        for accumulator, result in zip(node.accumulators, results):
            self._bind_item(accumulator.target, result)
        code = self.value(node.body)
        text = code.text
        if len(results) > 1:
            text = f"{self.constant(calls.unpacker(self.rt, len(results), node.span))}({text})"
        self.line(f"{', '.join(results)} = {text}")

    # --- calls of procedures -------------------------------------------------------------------------------------

    def _application(self, node: ast.Application, dest: Dest) -> Kind:
        """Write a call of a procedure: the next turn of a loop, a tail call, or a call with a value."""
        head = node.function
        target = head.target if type(head) is ast.Reference else None
        for index, loop in enumerate(dest.loops):
            if loop.variable is target:
                self._next_turn(node, dest, index)
                return NEVER
        if dest.returns and not enters_library(node):
            self._tail_call(node, dest)
            return ANY
        return self.finish(dest, self.call(node))

    def _head(self, node: ast.Application) -> tuple[CodeText | None, str, Any]:
        """Return the function of a call.

        Returns
        -------
        code, cell, known
            For a global variable that is never assigned: None, the constant of its cell, and the closure in it, if it
            is known. For any other head: its value, which is evaluated before the arguments, "" and None.
        """
        head = node.function
        target = head.target if type(head) is ast.Reference else None
        if isinstance(target, Variable) and target.is_global and not target.assigned:
            return None, self.constant(self.compiler.global_cell(target)), self.known_global(target)
        return self.atom(self.value(head)), "", None

    def call(self, node: ast.Application) -> CodeText:
        """Write a call that is not in tail position."""
        head, cell, known = self._head(node)
        values = self.operands(node.arguments, atomic=False)
        result = self.fresh("t")
        texts = [v.text for v in values]
        if known is not None and known.arity == len(values):
            self.known_call(result, cell, known, texts, node)
            return CodeText(result)
        function = self.fresh("p")
        self.line(f"{function} = {cell}.value" if head is None else f"{function} = {head.text}")
        site = CallSite(Local(function), node.span)
        call = ", ".join([f"{function}.code.entry({function}.env", *texts])
        is_direct = f"type({function}) is Closure and {function}.arity == {len(values)} and next(ticks) is None"
        other = self.constant(generated.caller(self.rt, self.global_head(node), node.span))
        arguments = "".join(f"{text}, " for text in texts)
        self.line(f"{result} = {call}) if {is_direct} else {other}({function}, ({arguments}))", site)
        self.line(f"if {result} is TAIL: {result} = bounce()", site)
        return CodeText(result)

    def _tail_call(self, node: ast.Application, dest: Dest) -> None:
        """Write a call in tail position: a turn of this function, or a request to the caller's trampoline."""
        head, cell, known = self._head(node)
        values = self.operands(node.arguments, atomic=False)
        function = self.fresh("p")
        callee = f"{cell}.value" if head is None else head.text
        is_itself = self.direct is not None and known is self.direct[0] and self.self_tail is not None
        if is_itself and not dest.loops and known.arity == len(values):
            self.line(f"if {callee} is {self.constant(known)}:")
            self.indent += 1
            self._assign_self_tail(values)
            self.line("next(ticks)")
            self.line("continue")
            self.indent -= 1
            # The function is defined again: a single call that is not a tail call.
            site = CallSite(self.constants[cell], node.span)
            self.line(f"return {self.other(cell, node)}({', '.join(v.text for v in values)})", site)
            return
        self.returns_tail = True
        self.line(f"{function} = {callee}")
        self.line(f"if type({function}) is Closure and {function}.arity == {len(values)}:")
        self.indent += 1
        self.line(f"rt.next_body = {function}.code.body")
        self.line(f"rt.next_frame = [{function}.env{''.join(f', {v.text}' for v in values)}]")
        self._leave(dest.loops)
        self.line("return TAIL")
        self.indent -= 1
        result = self.fresh("t")
        other = self.constant(generated.tail_caller(self.rt, self.global_head(node), node.span))
        self.line(f"{result} = {other}({function}, ({''.join(f'{v.text}, ' for v in values)}))")
        self._leave(dest.loops)
        self.line(f"return {result}")

    def _assign_self_tail(self, values: Sequence[CodeText]) -> None:
        """Write the new values of the parameters for a tail call of the function itself, which is a turn of a loop."""
        assert self.self_tail is not None
        pairs = [(name, v.text) for name, v in zip(self.self_tail, values) if name != v.text]
        if pairs:
            self.line(f"{', '.join(name for name, _ in pairs)} = {', '.join(text for _, text in pairs)}")

    # --- builtins ------------------------------------------------------------------------------------------------

    def builtin(self, builtin: Builtin, node: ast.Application) -> CodeText:
        """Write a call of a builtin: inline, with inlined type checks, or through its closure."""
        if builtin.intrinsic is not None:
            code = self._intrinsic(builtin, builtin.intrinsic, node)
            if code is not None:
                return code
        signature = builtin.signature
        count = len(node.arguments)
        is_general = not signature.takes(count) or count > _MAX_UNCHARGED or calls.calls_others(builtin, count)
        if is_general or (signature.keywords and not all(map(_is_plain, node.arguments))):
            names = calls.keyword_places(builtin, node.arguments)
            call = partial(calls.keyword_call, names=names) if names else calls.builtin_call
            return self.by_values(lambda nodes: call(self.rt, builtin, nodes, span=node.span), node.arguments)
        if builtin.name == "translate":
            (offset,) = node.arguments
            is_constant = type(offset) is ast.ArrayLiteral and all(type(each) is ast.Constant for each in offset.items)
            if type(offset) is ast.ArrayLiteral and len(offset.items) == 3 and not is_constant:
                return self._translation(builtin, node, offset)
        values = self.operands(node.arguments)
        if builtin.name == "list" and signature.rest is not None and count <= _MAX_INLINE_LIST:
            return self.list_of(values)
        if builtin.topic == "poses":
            pose = self._constant_pose(builtin, [self.operand_of(value.text) for value in values])
            if pose is not None:
                return pose
        if signature.keywords or count > 3:
            self.line(f"rt.site = {self.constant(node.span)}")  # as the closures of such builtins set it
        return self.checked_call(builtin, node, values)

    def _constant_pose(self, builtin: Builtin, operands: Sequence[Any]) -> CodeText | None:
        """Return the pose of literals, which is computed once.

        None if an operand is a variable, or if the computation fails, as every call then does.
        """
        if any(type(operand) is Local for operand in operands):
            return None
        try:
            parameters = builtin.signature.taking(len(operands))
            arguments = [p.type.converted(self.rt, operand) for p, operand in zip(parameters, operands)]
            pose = builtin.function(self.rt, *arguments)
        except (SceneError, Mismatch, ArithmeticError):
            return None
        if type(pose) is not Matrix:
            return None
        name = self.constant(pose)
        self.poses.add(name)
        return CodeText(name, MATRIX)

    def _translation(self, builtin: Builtin, node: ast.Application, offset: ast.ArrayLiteral) -> CodeText:
        """Write ``(translate [x y z])``, the pose of most parts."""
        values = self.operands(offset.items)
        make = self.constant(generated.translation_maker(self.rt, builtin, node.span, offset.span))
        code = self.temporary(CodeText(f"{make}({', '.join(value.text for value in values)})", MATRIX))
        self.poses.add(code.text)
        return code

    def _intrinsic(self, builtin: Builtin, name: str, node: ast.Application) -> CodeText | None:
        """Write a builtin with an inlined fast path, or return None for operands that have none."""
        operands = node.arguments
        if len(operands) == 1 and name in _UNARY:
            return self._unary(builtin, name, node)
        if name == "cons" and len(operands) == 2:
            x, y = self.operands(operands)
            slow = self.constant(self.slow(builtin, node))
            text = f"Pair({x.text}, {y.text}) if type({y.text}) is not MutableList else {slow}({x.text}, {y.text})"
            return self.temporary(CodeText(text, CONS))
        if name in intrinsics.ITEMS:
            count, make = intrinsics.ITEMS[name]
            if len(operands) != count:
                return None
            fast = self.constant(make(self.rt, calls.spread_call(self.rt, builtin, node.span)))
            return self.temporary(CodeText(f"{fast}({', '.join(code.text for code in self.operands(operands))})"))
        if name not in _BINARY:
            return None
        if len(operands) > 2 and name in ("add", "mul", "matmul"):
            nested = ast.Application(node.function, operands[:-1], node.span)
            return self._intrinsic(builtin, name, ast.Application(node.function, (nested, operands[-1]), node.span))
        if len(operands) != 2:
            return None
        x, y = self.operands(operands)
        call = self.slow(builtin, node)
        if name in intrinsics.ARITHMETIC:
            helper = self.constant(intrinsics.ARITHMETIC[name](call))
            return self.division(x, y, helper) if name == "div" else self.arithmetic(name, x, y, helper)
        other = self.constant(call)
        if name in COMPARISONS:
            return self.comparison(OPERATORS[name], x, y, other)
        if name == "matmul":
            text = f"compose({x.text}, {y.text}) if type({x.text}) is type({y.text}) is Matrix else "
            return self.temporary(CodeText(f"{text}{other}({x.text}, {y.text})"))
        return self.integer_division(name, x, y, other)

    def _unary(self, builtin: Builtin, name: str, node: ast.Application) -> CodeText:
        """Write ``not``, ``null?``, ``car`` or ``cdr``."""
        if name == "not":
            return CodeText(f"(not {self.test(node.arguments[0])})", BOOLEAN, True, False)
        x = self.named(self.value(node.arguments[0])).text
        call = calls.slow_call(self.rt, builtin, node.span)
        slow = self.constant(lambda value: call([value]))
        if name == "null?":
            return CodeText(f"({x} is NIL or (type({x}) is not Pair and {slow}({x})))", BOOLEAN, False, False)
        return CodeText(f"({x}.{name} if type({x}) is Pair else {slow}({x}))", ANY, False, False)


def _is_plain(argument: Any) -> bool:
    """Return whether an argument is certainly no keyword."""
    return type(argument) in (ast.ArrayLiteral, ast.Call) or (
        type(argument) is ast.Constant and type(argument.value) is not Keyword
    )


@lru_cache(maxsize=1_000)
def _code_of(source: str) -> CodeType:
    """Return the compiled text of a function, which names its constants, so that functions of one shape share it.

    After an edit of a helper, whatever calls it is generated again with the same text: compiling it was a seventh of
    the new scene's time. A thousand functions take some 5 MB.
    """
    return compile(source, "<generated>", "exec", dont_inherit=True)


# Start value of the result of a ``for`` form; the other kinds start with an empty list.
_STARTS = {"union": "PartCollector()", "sum": "0", "and": "True", "or": "False", "first": "False"}
_UNARY = frozenset({"not", "car", "cdr", "null?"})
_BINARY = frozenset({*OPERATORS, "div", "floordiv", "mod", "matmul"})
_VALUES: dict[type, Any] = {
    ast.Lambda: FunctionWriter._lambda, ast.Assignment: FunctionWriter._assignment,
    ast.ArrayLiteral: FunctionWriter._array,
    ast.First: FunctionWriter._first, ast.Transform: FunctionWriter._transform, ast.Union: FunctionWriter._union,
    ast.UnionLoop: FunctionWriter._union_loop, ast.Bind: FunctionWriter._bind, ast.Call: FunctionWriter._entity,
    ast.HandleLiteral: FunctionWriter._handle,
}  # fmt: skip
