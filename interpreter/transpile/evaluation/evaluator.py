"""Evaluator of Python's syntax tree. It never executes Python: all operations are its own or listed in ``library``.

A statement is a step of a host generator, so that generators of the program can be suspended anywhere.
"""

from __future__ import annotations

import ast
import functools
import re
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np

from scenelang.grammar.diagnostics import SceneError
from scenelang.interpreter.transpile.analysis.python_text import construct_of, scope_of
from scenelang.interpreter.transpile.evaluation import (
    BINARY,
    COMPARISONS,
    COMPUTED,
    DEEP,
    KEPT,
    MAX_BITS,
    MAX_ITEMS,
    SCALARS,
    STRUCTURAL,
    UNARY,
    WHOLE,
    NeedsPrimitives,
    UnsupportedPython,
    check_widths,
    instead_of,
    weigh,
)
from scenelang.interpreter.transpile.evaluation.classes import (
    attribute_name,
    attribute_of,
    bound_arguments,
    create,
    define,
    is_instance,
    mapping_of,
    set_attribute,
    type_of,
)
from scenelang.interpreter.transpile.evaluation.matching import as_conditions, matches
from scenelang.interpreter.transpile.evaluation.modules import check_digits
from scenelang.interpreter.transpile.evaluation.objects import (
    MISSING,
    BoundMethod,
    ClassMethod,
    Exhausted,
    Frame,
    HostObject,
    Metered,
    Module,
    Native,
    PythonClass,
    PythonFunction,
    PythonGenerator,
    PythonObject,
    Raised,
    StaticMethod,
    Super,
    delete_attribute,
    refused,
    renamed,
    same,
    type_name,
    value_of_error,
)
from scenelang.interpreter.transpile.evaluation.residue import (
    Poison,
    Residual,
    because,
    call_node,
    formatted,
    has_kind,
    has_residual,
    is_decided,
    is_open,
    is_shape,
    known_result,
    node_of,
    residual,
    residuals,
    undecided,
)
from scenelang.interpreter.transpile.evaluation.scientific import call_of_library, library_class
from scenelang.interpreter.values.limits import resident_bytes

# Steps of all evaluations of one program. A step takes 1.3 microseconds on the 2-core test machine, and up to 3 where
# much residual code is made. The longest program of tests/transpile/modern, a traffic simulation, takes 3.2 million.
MAX_STEPS = 5_000_000
MAX_DEPTH = 300
MAX_BYTES = 1_000_000_000
_SMALL = 20_000  # items
_PASSED = (UnsupportedPython, NeedsPrimitives, SceneError, RecursionError, MemoryError)  # never caught by the program


@dataclass(slots=True)
class StepBudget:
    """Steps that are left for the evaluations of one program."""

    left: int = MAX_STEPS


class _Return(Exception):
    def __init__(self, value: Any) -> None:
        super().__init__()
        self.value = value


class _Break(Exception):
    pass


class _Continue(Exception):
    pass


_SIGNALS = (_Return, _Break, _Continue)


class PythonEvaluator:
    """Evaluates a module.

    Parameters
    ----------
    names
        Builtins, and what the helper API provides.
    modules
        Modules that may be imported, by their dotted names.
    budget
        Steps that the evaluation may take.
    """

    def __init__(
        self, names: Mapping[str, Any], modules: Mapping[str, Module], budget: StepBudget | None = None
    ) -> None:
        self.budget = budget or StepBudget()
        self.builtins = dict(names)
        self.modules = modules
        self.module = Frame({"__name__": "scene"}, None)
        self.mixins: dict[str, Any] = {}  # classes of `collections.abc` with methods
        self.mixin: Callable[[str], Any] = lambda name: None
        self.module_of: Callable[[str], Any] = modules.get
        self.node: ast.AST | None = None  # the statement that is evaluated
        self.failed: ast.AST | None = None  # the statement that has raised the last exception
        self._error: BaseException | None = None
        self.steps = 0
        self._most_bytes = resident_bytes() + MAX_BYTES
        self._depth = 0
        self._handled: list[BaseException] = []  # by the `except` clauses that are evaluated
        self.loops: Any = None  # keeps loops, if there is one
        self.tries = 0  # around what is evaluated
        self.is_exact = False  # whether lists contain primitives where shapes are added to them
        self._spread: set[int] = set()
        self.types: dict[type, Native] = {}  # types that have no name in the program
        self._expressions: dict[type[ast.expr], Callable[[Any, Frame], Any]] = {
            ast.Constant: lambda node, frame: self.checked(node.value), ast.Name: self._name,
            ast.Attribute: self._attribute,
            ast.Call: self._call, ast.BinOp: self._binary, ast.UnaryOp: self._unary, ast.BoolOp: self._boolean,
            ast.Compare: self._compare, ast.IfExp: self._conditional, ast.Subscript: self._subscript,
            ast.Slice: self._slice, ast.Tuple: lambda node, frame: self.checked(tuple(self._items(node.elts, frame))),
            ast.List: lambda node, frame: self._items(node.elts, frame),
            ast.Set: self._set, ast.Dict: self._dict,
            ast.Lambda: lambda node, frame: self._function(node, "<lambda>", frame), ast.JoinedStr: self._joined,
            ast.FormattedValue: self._formatted, ast.NamedExpr: self._walrus, ast.GeneratorExp: self._generator,
            ast.ListComp: lambda node, frame: list(self._comprehension(node, frame)),
            ast.SetComp: lambda node, frame: set(self._comprehension(node, frame)),
            ast.DictComp: lambda node, frame: dict(self._comprehension(node, frame)),
        }  # fmt: skip
        self._simple: dict[type[ast.stmt], Callable[[Any, Frame], None]] = {
            ast.Pass: lambda node, frame: None, ast.Delete: self._delete, ast.Raise: self._raise,
            ast.Assert: self._assert, ast.Import: self._import, ast.ImportFrom: self._import_from,
            ast.Global: lambda node, frame: None, ast.Nonlocal: lambda node, frame: None,
            ast.Break: self._break, ast.Continue: self._continue, ast.FunctionDef: self._define,
            ast.ClassDef: self._define_class, ast.AnnAssign: self._annotated, ast.AugAssign: self._augmented,
        }  # fmt: skip
        self._compound: dict[type[ast.stmt], Callable[[Any, Frame], Generator[Any, Any, Any]]] = {
            ast.Expr: self._expression_statement, ast.Assign: self._assign, ast.Return: self._return, ast.If: self._if,
            ast.For: self._for, ast.While: self._while, ast.With: self._with, ast.Try: self._try,
            ast.Match: self._match,
        }  # fmt: skip

    # --- limits ------------------------------------------------------------------------------------------------

    def tick(self, count: int = 1) -> None:
        """Count steps; raises UnsupportedPython beyond a limit."""
        self.steps += count
        if self.steps & 1023 < count:
            self._look()

    def _look(self) -> None:
        """Raise UnsupportedPython if a limit is reached."""
        if self.steps > self.budget.left:
            raise UnsupportedPython("this part of the Python runs for too long to be evaluated")
        if resident_bytes() > self._most_bytes:
            raise UnsupportedPython("this part of the Python needs too much memory to be evaluated")

    @contextmanager
    def limited(self, steps: int) -> Iterator[None]:
        """Take at most some steps inside."""
        whole = self.budget
        self.budget = StepBudget(min(whole.left, self.steps + steps))
        try:
            yield
        finally:
            self.budget = whole

    def checked(self, value: Any) -> Any:
        """Return a value whose size is within the limits; a large one counts as many steps."""
        kind = type(value)
        size = 0
        if kind is int:
            if value.bit_length() > MAX_BITS:
                raise UnsupportedPython("this number has too many digits")
        elif kind is Decimal:
            check_digits(value)
        elif kind is Fraction:
            self.checked(max(abs(value.numerator), value.denominator))
        elif kind in (str, list, tuple, dict, set, bytes):
            size = len(value)
            if kind is tuple and any(type(each) is tuple for each in value):
                weigh(value)
        elif isinstance(value, np.ndarray):
            size = value.size
        if size > _SMALL:
            if size > MAX_ITEMS:
                raise UnsupportedPython(f"this {type_name(value)} has more than {MAX_ITEMS:,} items")
            self.tick(size >> 4)
        return value

    def iterate(self, value: Any) -> Iterator[Any]:
        """Iterate over a value; every item is a step."""
        if type(value) is Residual:
            if value.size is not None:
                value = [value[i] for i in range(value.size)]
            elif value.kind != "shape":
                raise UnsupportedPython("a value that is known only in the finished scene cannot be iterated over here")
            else:
                value = value.parts()
        self.touch(value)
        for item in value:
            self.tick()
            yield item

    def touch(self, value: Any) -> None:
        """Tell a loop that remains that items of an iterator are taken."""
        if self.loops is not None:
            self.loops.touch(value)

    # --- statements --------------------------------------------------------------------------------------------

    def run(self, statement: ast.stmt) -> None:
        """Evaluate a statement of the module."""
        for _ in self.execute([statement], self.module):
            raise UnsupportedPython("'yield' outside function")

    def execute(self, body: list[ast.stmt], frame: Frame) -> Generator[Any, Any, Any]:
        """Evaluate statements; iterate over what they yield."""
        for statement in body:
            self.tick()
            is_own = statement.lineno > 0  # else it is a library's
            self.node = statement if is_own else self.node
            try:
                simple = self._simple.get(type(statement))
                if simple is not None:
                    simple(statement, frame)
                    continue
                compound = self._compound.get(type(statement))
                yield from compound(statement, frame) if compound is not None else _unknown(statement)
            except UnsupportedPython as error:
                error.node = error.node or (statement if is_own else None)
                raise
            except _SIGNALS:
                raise
            except Exception as error:
                if self._error is not error and is_own:  # the innermost statement is the place
                    self._error, self.failed = error, statement
                raise

    def _expression_statement(self, node: ast.Expr, frame: Frame) -> Generator[Any, Any, Any]:
        yield from self._value(node.value, frame)

    def _value(self, node: ast.expr, frame: Frame) -> Generator[Any, Any, Any]:
        """Evaluate an expression that may be a ``yield``; its value is the generator's."""
        if type(node) is ast.Yield:
            return (yield self.eval(node.value, frame) if node.value is not None else None)
        if type(node) is ast.YieldFrom:
            inner = self.eval(node.value, frame)
            if type(inner) is PythonGenerator:
                self.touch(inner)
                return (yield from inner.steps)
            yield from self.iterate(inner)
            return None
        return self.eval(node, frame)

    def _assign(self, node: ast.Assign, frame: Frame) -> Generator[Any, Any, Any]:
        value = yield from self._value(node.value, frame)
        for target in node.targets:
            self.store(target, value, frame)

    def _return(self, node: ast.Return, frame: Frame) -> Generator[Any, Any, Any]:
        value = None
        if node.value is not None:
            value = yield from self._value(node.value, frame)
        raise _Return(value)

    def _annotated(self, node: ast.AnnAssign, frame: Frame) -> None:
        if node.value is not None:
            self.store(node.target, self.eval(node.value, frame), frame)

    def _augmented(self, node: ast.AugAssign, frame: Frame) -> None:
        target = node.target
        in_place = BINARY[type(node.op)][1]
        if isinstance(target, ast.Name):
            old = self._name(target, frame)
            self._store_name(target.id, self.operate(node.op, in_place, old, self.eval(node.value, frame)), frame)
        elif isinstance(target, ast.Attribute):
            owner = self.eval(target.value, frame)
            name = attribute_name(target, frame)
            old = self.attribute(owner, name)
            new = self.operate(node.op, in_place, old, self.eval(node.value, frame))
            self.set_attribute(owner, name, new)
        else:
            container, index = self.eval(target.value, frame), self.eval(target.slice, frame)
            old = self._item(container, index)
            self._set_item(container, index, self.operate(node.op, in_place, old, self.eval(node.value, frame)))

    def _if(self, node: ast.If, frame: Frame) -> Generator[Any, Any, Any]:
        test = self.eval(node.test, frame)
        if self.loops is not None and has_kind(test, "bool", "any", "int", "float", "number"):
            if not is_decided(test) and self.loops.branch(node, test, frame):
                return
        yield from self.execute(node.body if test else node.orelse, frame)

    def _break(self, node: ast.Break, frame: Frame) -> None:
        raise _Break

    def _continue(self, node: ast.Continue, frame: Frame) -> None:
        raise _Continue

    def _for(self, node: ast.For, frame: Frame) -> Generator[Any, Any, Any]:
        items = self.eval(node.iter, frame)
        if self.loops is not None:
            items, frames = self.loops.statement(node, items, frame)
            if frames is not None:
                yield from frames
                return
        for item in self.iterate(items):
            self.store(node.target, item, frame)
            if not (yield from self._turn(node.body, frame)):
                return
        yield from self.execute(node.orelse, frame)

    def _turn(self, body: list[ast.stmt], frame: Frame) -> Generator[Any, Any, bool]:
        """Run the body of a loop once; return whether the loop continues."""
        try:
            yield from self.execute(body, frame)
        except _Break:
            return False
        except _Continue:
            pass
        return True

    def _while(self, node: ast.While, frame: Frame) -> Generator[Any, Any, Any]:
        while self.eval(node.test, frame):
            self.tick()
            if not (yield from self._turn(node.body, frame)):
                return
        yield from self.execute(node.orelse, frame)

    def _with(self, node: ast.With, frame: Frame) -> Generator[Any, Any, Any]:
        self.tries += 1
        try:
            yield from self._within(node.items, node.body, frame)
        finally:
            self.tries -= 1

    def _within(self, items: list[ast.withitem], body: list[ast.stmt], frame: Frame) -> Generator[Any, Any, Any]:
        """Execute a body inside context managers, which are entered from left to right."""
        if not items:
            yield from self.execute(body, frame)
            return
        manager = self.eval(items[0].context_expr, frame)
        value = self.call(self.attribute(manager, "__enter__"), (), {})
        if items[0].optional_vars is not None:
            self.store(items[0].optional_vars, value, frame)
        # looked up before the body runs, as in CPython
        leave = self.attribute(manager, "__exit__")
        try:
            yield from self._within(items[1:], body, frame)
        except _SIGNALS:
            self.call(leave, (None, None, None), {})
            raise
        except _PASSED:
            raise
        except Exception as error:
            value = value_of_error(error)
            if not self.call(leave, (type_of(self, value), value, None), {}):
                raise
        else:
            self.call(leave, (None, None, None), {})

    def _try(self, node: ast.Try, frame: Frame) -> Generator[Any, Any, Any]:
        """Execute a ``try`` statement."""
        try:
            try:
                self.tries += 1
                try:
                    yield from self.execute(node.body, frame)
                finally:
                    self.tries -= 1
            except (*_SIGNALS, *_PASSED, GeneratorExit):
                # control flow, or an error of the evaluator itself
                raise
            except Exception as error:
                handler = next((each for each in node.handlers if self._catches(each, error, frame)), None)
                if handler is None:
                    raise
                if handler.name:
                    self._store_name(handler.name, value_of_error(error), frame)
                self._handled.append(error)
                try:
                    yield from self.execute(handler.body, frame)
                finally:
                    self._handled.pop()
            else:
                yield from self.execute(node.orelse, frame)
        finally:
            if node.finalbody:
                yield from self.execute(node.finalbody, frame)

    def _catches(self, handler: ast.ExceptHandler, error: Exception, frame: Frame) -> bool:
        if handler.type is None:
            return True
        return is_instance(self, value_of_error(error), self.eval(handler.type, frame))

    def _raise(self, node: ast.Raise, frame: Frame) -> None:
        """Raise the exception of a ``raise`` statement."""
        if node.exc is None:
            if not self._handled:
                raise RuntimeError("No active exception to reraise")
            raise self._handled[-1]
        value = self.eval(node.exc, frame)
        if type(value) in (PythonClass, Native):
            value = self.call(value, (), {})
        cause = self.eval(node.cause, frame) if node.cause is not None else None
        if type(value) is PythonObject:
            value.fields["__cause__"] = cause
        elif isinstance(value, Exception):
            value.__cause__ = cause if isinstance(cause, BaseException) else None
        if type(value) is PythonObject and value.cls.is_subclass(BaseException):
            raise Raised(value)
        if isinstance(value, StopIteration):
            # a StopIteration would become a RuntimeError in the evaluator's own generators (PEP 479)
            raise Exhausted(value.value)
        if isinstance(value, Exception):
            raise value
        raise TypeError("exceptions must derive from BaseException")

    def _assert(self, node: ast.Assert, frame: Frame) -> None:
        if not self.eval(node.test, frame):
            raise AssertionError(*([] if node.msg is None else [self.eval(node.msg, frame)]))

    def _delete(self, node: ast.Delete, frame: Frame) -> None:
        for target in node.targets:
            if isinstance(target, ast.Name):
                self._holder(target.id, frame).names.pop(target.id)
            elif isinstance(target, ast.Subscript):
                container, index = self.eval(target.value, frame), self.eval(target.slice, frame)
                del self._plain_container(container)[index]
            elif isinstance(target, ast.Attribute):
                delete_attribute(self, self.eval(target.value, frame), attribute_name(target, frame))

    def _import(self, node: ast.Import, frame: Frame) -> None:
        for alias in node.names:
            path = alias.name if alias.asname else alias.name.partition(".")[0]
            self._store_name(alias.asname or path, self.module_of(path), frame)

    def _import_from(self, node: ast.ImportFrom, frame: Frame) -> None:
        if node.module in ("__future__", "helper", "minecraft_helper", "mi_helper"):
            return
        module = self.module_of(node.module or "")
        for alias in node.names:
            if alias.name == "*":
                frame.names.update(getattr(module, "names", {}))
            elif type(module) is Module:
                value = module.names.get(alias.name, MISSING)
                if value is MISSING:
                    path = f"{module.path}.{alias.name}"
                    value = refused(UnsupportedPython(f"`{path}` is not supported", instead_of(path)))
                self._store_name(alias.asname or alias.name, value, frame)
            else:
                self._store_name(alias.asname or alias.name, module, frame)

    # --- match -------------------------------------------------------------------------------------------------

    def _match(self, node: ast.Match, frame: Frame) -> Generator[Any, Any, Any]:
        subject = self.eval(node.subject, frame)
        conditions = as_conditions(node) if type(subject) is Residual and subject.known is not None else None
        if conditions is not None:
            yield from self.execute([conditions], frame)
            return
        for case in node.cases:
            bound: dict[str, Any] = {}
            if matches(self, case.pattern, subject, bound, frame):
                for name, value in bound.items():
                    self._store_name(name, value, frame)
                if case.guard is None or self.eval(case.guard, frame):
                    yield from self.execute(case.body, frame)
                    return

    # --- names -------------------------------------------------------------------------------------------------

    def _name(self, node: ast.Name, frame: Frame) -> Any:
        return self.lookup(node.id, frame)

    def lookup(self, name: str, frame: Frame) -> Any:
        """Return the value of a variable."""
        scope: Frame | None = self.module if frame.shared.get(name) else frame
        while scope is not None:
            value = scope.names.get(name, MISSING)
            if value is not MISSING:
                if value.__class__ is Poison:
                    raise self.loops.failure()
                return value
            if name in scope.local and name not in scope.shared:
                raise UnboundLocalError(
                    f"cannot access local variable '{name}' where it is not associated with a value"
                )
            scope = scope.outer
        value = self.builtins.get(name, MISSING)
        if value is MISSING:
            raise NameError(f"name '{name}' is not defined")
        return value

    def _holder(self, name: str, frame: Frame) -> Frame:
        """Return the frame in which a variable is assigned."""
        while frame.is_comprehension and frame.outer is not None:
            frame = frame.outer
        if name not in frame.shared:
            return frame
        if frame.shared[name]:
            return self.module
        scope = frame.outer
        while scope is not None and (name not in scope.local or name in scope.shared):
            scope = scope.outer
        return scope or self.module

    def _store_name(self, name: str, value: Any, frame: Frame) -> None:
        self._holder(name, frame).names[name] = value

    def store(self, target: ast.expr, value: Any, frame: Frame) -> None:
        """Assign a value to a target."""
        if isinstance(target, ast.Name):
            if frame.is_comprehension:
                frame.names[target.id] = value
            else:
                self._store_name(target.id, value, frame)
        elif isinstance(target, (ast.Tuple, ast.List)):
            self._unpack(target.elts, value, frame)
        elif isinstance(target, ast.Attribute):
            self.set_attribute(self.eval(target.value, frame), attribute_name(target, frame), value)
        elif isinstance(target, ast.Subscript):
            self._set_item(self.eval(target.value, frame), self.eval(target.slice, frame), value)
        else:
            raise UnsupportedPython("this target of an assignment is not supported")

    def _unpack(self, targets: list[ast.expr], value: Any, frame: Frame) -> None:
        star = next((i for i, target in enumerate(targets) if isinstance(target, ast.Starred)), None)
        items: list[Any]
        if type(value) is Residual and star is None:
            items = [value[i] for i in range(len(targets))]
        else:
            items = list(self.iterate(value)) if star is not None else self._first_items(value, len(targets))
        if star is None:
            for target, item in zip(targets, items):
                self.store(target, item, frame)
            return
        after = len(targets) - star - 1
        if len(items) < star + after:
            raise ValueError(f"not enough values to unpack (expected at least {star + after}, got {len(items)})")
        middle = items[star : len(items) - after]
        for target, item in zip(targets, [*items[:star], middle, *items[len(items) - after :]]):
            self.store(target.value if isinstance(target, ast.Starred) else target, item, frame)

    def _first_items(self, value: Any, count: int) -> list[Any]:
        items: list[Any] = []
        try:
            iterator = value if type(value) is Residual else iter(value)
        except TypeError:
            raise TypeError(f"cannot unpack non-iterable {type_name(value)} object") from None
        for item in self.iterate(iterator):
            items.append(item)
            if len(items) > count:
                raise ValueError(f"too many values to unpack (expected {count})")
        if len(items) < count:
            raise ValueError(f"not enough values to unpack (expected {count}, got {len(items)})")
        return items

    # --- expressions -------------------------------------------------------------------------------------------

    def eval(self, node: ast.expr, frame: Frame) -> Any:
        """Evaluate an expression."""
        self.steps += 1  # as `tick` does; a fifth of the time is that of the calls of both
        if not self.steps & 1023:
            self._look()
        kind = node.__class__
        if kind is ast.Name and not frame.shared:
            value = frame.names.get(node.id, MISSING)  # type: ignore[attr-defined]
            if value is not MISSING and value.__class__ is not Poison:
                return value
        handler = self._expressions.get(kind)
        if handler is None:
            return _unknown(node)
        return handler(node, frame)

    def _items(self, nodes: list[ast.expr], frame: Frame) -> list[Any]:
        items: list[Any] = []
        for node in nodes:
            if isinstance(node, ast.Starred):
                value = self.eval(node.value, frame)
                items += self.spread(value) if is_shape(value) else self.iterate(value)
            else:
                items.append(self.eval(node, frame))
        return items

    def _set(self, node: ast.Set, frame: Frame) -> set[Any]:
        """Return a set in the order of Python, whose compiler adds constants in the order of a frozen set."""
        items = self._items(node.elts, frame)
        is_constant = len(items) > 2 and all(map(_is_constant, node.elts))
        members: set[Any] = set()
        members.update(frozenset(tuple(frozenset(items))) if is_constant else items)
        return members

    def _dict(self, node: ast.Dict, frame: Frame) -> dict[Any, Any]:
        entries: dict[Any, Any] = {}
        for key, value in zip(node.keys, node.values):
            if key is None:
                entries.update(mapping_of(self, self.eval(value, frame)))
            else:
                name = self.eval(key, frame)
                entries[name] = self.eval(value, frame)
        return entries

    def spread(self, shape: Residual) -> list[Residual]:
        """Return a shape for a list to which its primitives are added; it stays whole until someone looks."""
        if self.is_exact and shape.primitives is not None:
            return shape.parts()
        self._spread.add(id(shape))
        return [shape]

    def look(self, items: Any) -> Any:
        """Return a list that the program counts or takes items of; raises NeedsPrimitives if that matters."""
        if self._spread and type(items) is list:
            for each in items:
                if id(each) in self._spread and is_shape(each) and each.primitives is not None and not self.is_exact:
                    if len(each.parts()) != 1:
                        raise NeedsPrimitives
        return items

    def _binary(self, node: ast.BinOp, frame: Frame) -> Any:
        left, right = self.eval(node.left, frame), self.eval(node.right, frame)
        return self.operate(node.op, BINARY[type(node.op)][0], left, right)

    def operate(self, op: ast.operator, function: Callable[[Any, Any], Any], left: Any, right: Any) -> Any:
        kind = type(op)
        if kind is ast.Mult:
            self._check_product(left, right)
        elif kind is ast.Pow and type(left) is Fraction and isinstance(right, int):
            if max(abs(left.numerator), left.denominator).bit_length() * abs(right) > MAX_BITS:
                raise UnsupportedPython("this number has too many digits")
        elif kind in (ast.Pow, ast.LShift) and isinstance(left, int) and isinstance(right, int):
            size = left.bit_length() * right if kind is ast.Pow else left.bit_length() + right
            if size > MAX_BITS:
                raise UnsupportedPython("this number has too many digits")
        elif kind is ast.Mod and isinstance(left, (str, bytes)):
            template = left if isinstance(left, str) else left.decode("latin-1")
            if "%" in template:
                check_widths(template)
                weigh(right)
                if re.search(r"%[^a-zA-Z%]*\*", template):
                    raise UnsupportedPython("widths that are arguments are not supported", "use an f-string")
        elif kind is ast.Add and isinstance(left, list) and is_shape(right):
            right = self.spread(right)
        elif kind is ast.BitOr and (isinstance(left, (Native, PythonClass)) or type(right) in (Native, PythonClass)):
            return (*_kinds(left), *_kinds(right))  # a union of types
        if isinstance(left, np.ndarray) and isinstance(right, np.ndarray) and left.size * right.size > MAX_ITEMS:
            shapes = left.shape, right.shape
            if kind is ast.MatMult:
                shapes = (*left.shape[:-1], 1), (1, right.shape[-1])
            if left.ndim and right.ndim and int(np.prod(np.broadcast_shapes(*shapes))) > MAX_ITEMS:
                raise UnsupportedPython(f"this array has more than {MAX_ITEMS:,} items")
        try:
            return self.checked(function(left, right))
        except TypeError as error:
            raise renamed(error, left, right) from None

    def _check_product(self, left: Any, right: Any) -> None:
        for sequence, count in ((left, right), (right, left)):
            if isinstance(sequence, (str, list, tuple, bytes, bytearray)):
                number = int(count) if type(count) is PythonObject and count.method("__index__") else count
                if isinstance(number, int) and len(sequence) * number > MAX_ITEMS:
                    raise UnsupportedPython(f"this {type_name(sequence)} has more than {MAX_ITEMS:,} items")

    def _unary(self, node: ast.UnaryOp, frame: Frame) -> Any:
        value = self.eval(node.operand, frame)
        try:
            if type(node.op) is ast.Not and is_open(value):
                return residual(value.holder, "not", (value,))
            return UNARY[type(node.op)](value)
        except TypeError as error:
            raise renamed(error, value) from None

    def _boolean(self, node: ast.BoolOp, frame: Frame) -> Any:
        is_and = type(node.op) is ast.And
        value: Any = self.eval(node.values[0], frame)
        for each in node.values[1:]:
            if is_open(value):
                value = self._both(node.op, value, self.loops.quietly(each, frame))
            elif bool(value) is not is_and:
                return value
            else:
                value = self.eval(each, frame)
        return value

    @staticmethod
    def _both(op: ast.boolop, value: Residual, other: Any) -> Residual:
        """Return ``value and other``, or ``value or other``, of conditions that differ from turn to turn."""
        if value.kind != "bool" or not (type(other) is bool or has_kind(other, "bool")):
            raise undecided(value)
        return residual(value.holder, "and" if type(op) is ast.And else "or", (value, other))

    def _compare(self, node: ast.Compare, frame: Frame) -> Any:
        left: Any = self.eval(node.left, frame)
        result: Any = True
        for number, (op, each) in enumerate(zip(node.ops, node.comparators)):
            if number and is_open(result):
                right = self.loops.quietly(each, frame)
                result = self._both(ast.And(), result, self._compared(op, left, right))
            elif number and not result:
                return result
            else:
                right = self.eval(each, frame)
                result = self._compared(op, left, right)
            left = right
        return result

    def _compared(self, op: ast.cmpop, left: Any, right: Any) -> Any:
        is_identity = type(op) in (ast.Is, ast.IsNot)
        if type(op) in (ast.In, ast.NotIn) and isinstance(right, Iterator) and type(right) is not PythonObject:
            right = self.iterate(right)
        if is_identity and type(left) is PythonObject:
            same(left, right)
        if (is_identity or type(op) in (ast.In, ast.NotIn)) and self.loops is not None:
            outcome = self.loops.computed(COMPARISONS[type(op)], (left, right))
            if outcome is not MISSING:
                return outcome
        if is_identity and (has_kind(left, "any") or has_kind(right, "any")):
            raise undecided(left if type(left) is Residual else right)
        weigh(left)
        try:
            return COMPARISONS[type(op)](left, right)
        except TypeError as error:
            raise renamed(error, left, right) from None

    def _conditional(self, node: ast.IfExp, frame: Frame) -> Any:
        test = self.eval(node.test, frame)
        if type(test) is not Residual or test.kind == "shape":
            return self.eval(node.body if test else node.orelse, frame)
        if is_decided(test):
            return self.eval(node.body if test else node.orelse, frame)
        if self.loops is not None and test.kind == "bool":
            chosen = self.loops.choose(node, test, frame)
            if chosen is not MISSING:
                return chosen
        if any(isinstance(each, ast.Call) for part in (node.body, node.orelse) for each in ast.walk(part)):
            raise undecided(test)  # it may do things
        values = self.eval(node.body, frame), self.eval(node.orelse, frame)
        is_number = all(type(each) in (int, float) or has_kind(each, "number", "int", "float") for each in values)
        return Residual(ast.IfExp(node_of(test), *map(node_of, values)), "number" if is_number else "any", test.holder)

    def _subscript(self, node: ast.Subscript, frame: Frame) -> Any:
        container = self.eval(node.value, frame)
        if isinstance(container, (Native, PythonClass)) and getattr(container, "members", None) is None:
            if type(container) is Native and container.path in ("typing.Union", "typing.Optional"):
                return _kinds(self.eval(node.slice, frame)) + ((None,) if container.path[-1] == "l" else ())
            return container  # a generic type
        return self._item(container, self.eval(node.slice, frame))

    def _item(self, container: Any, index: Any) -> Any:
        if isinstance(container, Native):
            return container
        if type(index) is Residual or (type(index) is tuple and self.loops is not None and has_residual(index)):
            return self._residual_item(container, index)
        try:
            return self.look(container)[index]
        except TypeError as error:
            raise renamed(error, container) from None

    def _residual_item(self, container: Any, index: Any) -> Any:
        if self.loops is not None and type(container) is not Residual:
            item = self.loops.looked_up(self.look(container), index)
            if item is not MISSING:
                return item
        holder = next(residuals((index,))).holder
        return Residual(ast.Subscript(node_of(container), node_of(index), ast.Load()), "any", holder)

    def _set_item(self, container: Any, index: Any, value: Any) -> None:
        self._plain_container(container)[index] = value

    def _plain_container(self, container: Any) -> Any:
        if isinstance(container, (Native, Module, PythonClass, Residual)):
            raise UnsupportedPython(f"items of this {type_name(container)} cannot be assigned")
        return container

    def _slice(self, node: ast.Slice, frame: Frame) -> slice:
        bounds = [self.eval(each, frame) if each is not None else None for each in (node.lower, node.upper, node.step)]
        return slice(*bounds)

    def _joined(self, node: ast.JoinedStr, frame: Frame) -> str:
        texts = [self.eval(each, frame) for each in node.values]
        if self.loops is not None and any(type(each) is Residual for each in texts):
            return self.loops.texts(texts, "".join)  # type: ignore[no-any-return]
        return str(self.checked("".join(texts)))

    def _formatted(self, node: ast.FormattedValue, frame: Frame) -> str:
        value = self.eval(node.value, frame)
        specification = self._joined(node.format_spec, frame) if isinstance(node.format_spec, ast.JoinedStr) else ""
        if node.conversion in (115, 114, 97):
            weigh(value)
            convert: Callable[[Any], str] = ascii if node.conversion == 97 else str if node.conversion == 115 else repr
            value = convert(value)
        if type(value) is Residual and value.known is not None:
            return self.loops.texts([value], lambda row: formatted(row[0], specification))  # type: ignore[no-any-return]
        return formatted(value, specification)

    def _walrus(self, node: ast.NamedExpr, frame: Frame) -> Any:
        value = self.eval(node.value, frame)
        self._store_name(node.target.id, value, frame)
        return value

    def _generator(self, node: ast.GeneratorExp, frame: Frame) -> PythonGenerator:
        return PythonGenerator(self._comprehension(node, frame), "<genexpr>")

    def _comprehension(self, node: Any, frame: Frame) -> Generator[Any, Any, Any]:
        items = self.eval(node.generators[0].iter, frame)
        if self.loops is not None and type(node) in (ast.ListComp, ast.GeneratorExp):
            made, items = self.loops.comprehension(node, items, frame)
            if made is not None:
                return (each for each in (made,))
        first = self.iterate(items)
        scope = Frame({}, frame, is_comprehension=True, function=frame.function, first=frame.first)
        return self._generated(node, 0, first, scope)

    def _gathered(self, node: Any, level: int, frame: Frame) -> list[Residual] | None:
        """Return the shape whose primitives a comprehension only adds to its list, as a list; else None."""
        part = node.generators[level]
        if level + 1 < len(node.generators) or part.ifs or type(node) is not ast.ListComp:
            return None
        if not isinstance(part.target, ast.Name) or not isinstance(node.elt, ast.Name) or node.elt.id != part.target.id:
            return None
        value = self.eval(part.iter, frame)
        return self.spread(value) if is_shape(value) else list(self.iterate(value))

    def _generated(self, node: Any, level: int, items: Iterable[Any], frame: Frame) -> Generator[Any, Any, Any]:
        part = node.generators[level]
        for item in items:
            self.store(part.target, item, frame)
            if not all(self.eval(test, frame) for test in part.ifs):
                continue
            if level + 1 < len(node.generators):
                if (gathered := self._gathered(node, level + 1, frame)) is not None:
                    yield from gathered
                    continue
                inner = self.iterate(self.eval(node.generators[level + 1].iter, frame))
                yield from self._generated(node, level + 1, inner, frame)
            elif isinstance(node, ast.DictComp):
                yield self.eval(node.key, frame), self.eval(node.value, frame)
            else:
                yield self.eval(node.elt, frame)

    # --- calls -------------------------------------------------------------------------------------------------

    def _call(self, node: ast.Call, frame: Frame) -> Any:
        if isinstance(node.func, ast.Name) and node.func.id == "super" and not node.args:
            return self._super(frame)
        function = self.eval(node.func, frame)
        arguments = tuple(self._items(node.args, frame))
        named: dict[str, Any] = {}
        for keyword in node.keywords:
            value = self.eval(keyword.value, frame)
            if keyword.arg is None:
                named.update(mapping_of(self, value))
            else:
                named[keyword.arg] = value
        return self.call(function, arguments, named)

    def _super(self, frame: Frame) -> Super:
        scope: Frame | None = frame
        while scope is not None and (scope.function is None or scope.function.owner is None):
            scope = scope.outer
        if scope is None or scope.function is None or scope.function.owner is None:
            raise RuntimeError("super(): no arguments")
        return Super(scope.function.owner, scope.first)

    def call(self, function: Any, arguments: tuple[Any, ...], named: dict[str, Any]) -> Any:
        """Call a value."""
        self.tick()
        kind = type(function)
        if kind is PythonFunction:
            return self._call_function(function, arguments, named)
        if kind is BoundMethod:
            return self.call(function.function, (function.value, *arguments), named)
        if kind is PythonClass:
            return create(self, function, arguments, named)
        if kind is Native:
            return self._call_native(function, arguments, named)
        if kind is PythonObject:
            return self.call(
                function._required("__call__", f"'{type_name(function)}' object is not callable"), arguments, named
            )
        if kind in (StaticMethod, ClassMethod):
            return self.call(function.function, arguments, named)
        if isinstance(function, HostObject) and callable(function):
            return self._call_native(Native(type_name(function), function), arguments, named)
        row = library_class(function)
        if row is not None and "__call__" in row.attributes:
            return self._call_native(Native("", functools.partial(call_of_library, function)), arguments, named)
        raise TypeError(f"'{type_name(function)}' object is not callable")

    def _call_function(self, function: PythonFunction, arguments: tuple[Any, ...], named: dict[str, Any]) -> Any:
        local, shared, is_generator = scope_of(function.node)
        frame = Frame(bound_arguments(function, arguments, named), function.outer, local, shared, function=function)
        frame.first = arguments[0] if arguments else next(iter(frame.names.values()), None)
        if isinstance(function.node, ast.Lambda):
            return self._deeper(lambda: self.eval(function.node.body, frame))  # type: ignore[arg-type]
        if is_generator:
            return PythonGenerator(self._steps_of(function.node.body, frame), function.name)
        return self._deeper(lambda: self._result_of(function.node.body, frame))  # type: ignore[arg-type]

    def _deeper(self, action: Callable[[], Any]) -> Any:
        self._depth += 1
        node = self.node
        try:
            if self._depth > MAX_DEPTH:
                raise UnsupportedPython("this recursion is too deep to be evaluated")
            return action()
        finally:
            self._depth -= 1
            self.node = node

    def _result_of(self, body: list[ast.stmt], frame: Frame) -> Any:
        try:
            for _ in self.execute(body, frame):
                pass
        except _Return as signal:
            return signal.value
        return None

    def _steps_of(self, body: list[ast.stmt], frame: Frame) -> Generator[Any, Any, Any]:
        try:
            yield from self.execute(body, frame)
        except _Return as signal:
            return signal.value
        return None

    def _call_native(self, function: Native, arguments: tuple[Any, ...], named: dict[str, Any]) -> Any:
        """Call a function of a library; unknown arguments in loops that remain give a residual result."""
        if function.is_numeric and any(map(has_residual, (*arguments, *named.values()))):
            return self._numeric_call(function, arguments, named)
        if self.loops is not None:
            for each in (getattr(function.function, "__self__", None), *arguments):
                self.loops.touch(each)
            if function.path == "range" and all(type(each) is int or has_kind(each, "int") for each in arguments):
                if any(type(each) is Residual for each in arguments):
                    holder = next(residuals(arguments)).holder
                    return Residual(call_node("range", [node_of(each) for each in arguments]), "range", holder)
            if function.path in COMPUTED and any(has_kind(each, "any", "int", "float", "number") for each in arguments):
                result = self.loops.computed(lambda *items: self._call_native(function, items, named), arguments)
                if result is not MISSING:
                    return result
        # `iter` and `next` need the iterator itself, not a metered wrapper
        plain = arguments if function.path in ("iter", "next") else tuple(map(self._argument, arguments))
        if function.path in DEEP:
            weigh((*arguments, *named.values()))
        try:
            return self.checked(function.function(*plain, **named))
        except TypeError as error:
            raise because(renamed(error, *arguments), plain) from None
        except StopIteration as error:
            raise Exhausted(error.value) from None
        except UnsupportedPython as error:
            raise because(error, plain)

    def _argument(self, value: Any) -> Any:
        is_iterator = isinstance(value, (PythonGenerator, Iterator)) and not isinstance(value, PythonObject)
        if is_iterator and library_class(value) is None:
            return value if type(value) is PythonGenerator else self.metered(value)
        return self.metered(iter(value)) if type(value) is range and len(value) > MAX_ITEMS else value

    def metered(self, items: Any) -> Any:
        return Metered(self, items)

    def _numeric_call(self, function: Native, arguments: tuple[Any, ...], named: dict[str, Any]) -> Any:
        """Call a numeric function with values that are not known: item by item, if it works on items."""
        arrays = [each for each in arguments if isinstance(each, np.ndarray)]
        host = getattr(np, function.path.removeprefix("np."), None)
        if arrays and isinstance(host, np.ufunc) and not named:
            each = np.frompyfunc(lambda *items: self._call_native(function, items, {}), len(arguments), 1)
            return each(*(np.asarray(value) if isinstance(value, (list, tuple)) else value for value in arguments))
        if self.loops is not None and function.path.startswith("np.") and function.path not in KEPT:
            result = self.loops.computed(lambda *items: self._call_native(function, items, named), arguments)
            if result is not MISSING:
                return result
        if function.path in STRUCTURAL:
            return function.function(*arguments, **named)
        return self._residual_call(function, arguments, named)

    def _residual_call(self, function: Native, arguments: tuple[Any, ...], named: dict[str, Any]) -> Residual:
        held = next(residuals((*arguments, *named.values())))
        nodes = {name: node_of(value) for name, value in named.items()}
        kind = "array" if function.path.startswith("np.") and function.path not in SCALARS else "number"
        if function.path in ("int", "float") or function.path.startswith("math."):
            kind = "int" if function.path.rpartition(".")[2] in WHOLE else "float"
        known = known_result(function.function, arguments) if not named else None
        node = call_node(function.path, [node_of(each) for each in arguments], nodes)
        return Residual(node, kind, held.holder, known=known)

    # --- definitions -------------------------------------------------------------------------------------------

    def _function(self, node: Any, name: str, frame: Frame) -> PythonFunction:
        given = node.args
        defaults = tuple(self.eval(each, frame) for each in given.defaults)
        keyword_defaults = {
            argument.arg: self.eval(value, frame)
            for argument, value in zip(given.kwonlyargs, given.kw_defaults)
            if value is not None
        }
        outer = frame
        while outer.is_class and outer.outer is not None:
            outer = outer.outer  # the names of a class body are not visible to its functions
        return PythonFunction(node, name, outer, self, defaults, keyword_defaults)

    def _define(self, node: ast.FunctionDef, frame: Frame) -> None:
        decorators = [self.eval(each, frame) for each in node.decorator_list]
        value: Any = self._function(node, node.name, frame)
        doc = ast.get_docstring(node)
        value.attributes["__doc__"] = doc
        for decorator in reversed(decorators):
            value = self.call(decorator, (value,), {})
        self._store_name(node.name, value, frame)

    def _define_class(self, node: ast.ClassDef, frame: Frame) -> None:
        value: Any = define(self, node, frame)
        for decorator in reversed([self.eval(each, frame) for each in node.decorator_list]):
            value = self.call(decorator, (value,), {})
        self._store_name(node.name, value, frame)

    # --- attributes --------------------------------------------------------------------------------------------

    def _attribute(self, node: ast.Attribute, frame: Frame) -> Any:
        return self.attribute(self.eval(node.value, frame), attribute_name(node, frame))

    def attribute(self, value: Any, name: str, default: Any = UnsupportedPython) -> Any:
        """Return an attribute of a value."""
        return attribute_of(self, value, name, default)

    def set_attribute(self, value: Any, name: str, new: Any) -> None:
        """Assign an attribute of a value."""
        set_attribute(self, value, name, new)


def _unknown(node: ast.stmt | ast.expr) -> Any:
    """Raise the error of a statement or expression that is not supported."""
    construct, hint = construct_of(node)
    raise UnsupportedPython(f"{construct} is not supported", hint)


def _kinds(value: Any) -> tuple[Any, ...]:
    return value if isinstance(value, tuple) else (value,)


def _is_constant(node: ast.expr) -> bool:
    """Return whether Python knows the value of an expression before it runs."""
    if isinstance(node, ast.Tuple):
        return all(map(_is_constant, node.elts))
    return isinstance(node, ast.Constant) or (isinstance(node, ast.UnaryOp) and _is_constant(node.operand))
