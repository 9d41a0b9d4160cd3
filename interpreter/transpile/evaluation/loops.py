"""Loops of the program that remain loops.

The body of a loop is evaluated once, with the items of the loop as residual values; its additions to a list become the
body of a loop in the residual program (partial evaluation with generalisation; Jones, Gomard and Sestoft 1993, chapter
6). A loop whose body needs its items, or changes anything but that list, is unrolled: the evaluation starts again.

A comparison of everything reachable before and after finds all changes, so no operation needs a record of what it
does; programs that models write are evaluated in milliseconds, so some restarts cost little. After 50 restarts or
500,000 steps in evaluations that were given up, all loops are unrolled, so that a loaded machine changes nothing.
"""

from __future__ import annotations

import ast
import builtins
import copy
import keyword
import random
from collections import ChainMap, deque
from collections.abc import Callable, Iterable, Iterator, Sequence, Set
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field
from functools import partial
from types import BuiltinFunctionType, FunctionType, MethodType, MethodWrapperType
from typing import Any, Protocol

import numpy as np

from scenelang.interpreter.transpile.evaluation.list_usage import ListUsage, leaves
from scenelang.interpreter.transpile.evaluation.objects import (
    MISSING,
    BoundMethod,
    Cache,
    ClassMethod,
    Frame,
    IntMember,
    Metered,
    Module,
    NamedTuple,
    Native,
    Property,
    PythonClass,
    PythonFunction,
    PythonGenerator,
    PythonObject,
    StaticMethod,
    Super,
    TextMember,
    Unroll,
    ValueObject,
)
from scenelang.interpreter.transpile.evaluation.residue import (
    Holder,
    KeptLoop,
    Known,
    LoopNode,
    Part,
    Poison,
    Residual,
    call_node,
    is_shape,
    known_result,
    node_of,
)
from scenelang.interpreter.transpile.evaluation.scientific import library_class
from scenelang.interpreter.transpile.evaluation.structures import form_of, leaves_of, parts_of

_MIN_TURNS, _MAX_TURNS = 2, 5_000  # turns of a loop that remains
_MOST_WALKED, _MOST_WALKED_IN_ALL = 30_000, 1_500_000  # values that a loop might change
MOST_RESTARTS = 50  # of an evaluation, after which all loops are unrolled
# Steps take 1.4 to 1.9 microseconds each in three programs that make much residual code.
_MOST_STEPS = 500_000  # of evaluations that were given up, after which all loops are unrolled
_MOST_STEPS_OF_TRIAL = 250_000  # of the case of defaults, which may fail: half of those
_DEEPEST = 5  # objects in objects whose fields become columns
_CONSTANTS = (int, float, str, bool, type(None))


@dataclass(eq=False, slots=True)
class UnrollPlan:
    """What is unrolled or specialised, after what earlier evaluations have met.

    Attributes
    ----------
    refused
        Syntax nodes of loops that are unrolled, and of functions that are specialised, with those around them at the
        time of the failure.
    kinds
        Kinds of the parameters of functions that are not specialised, by function and parameter.
    levels
        What is specialised of functions: nothing (0), integers (1) or all (2).
    forms
        How the values of these parameters are made that are no numbers, by function and parameter.
    special
        Parameters of functions that are specialised, because the program decides something by them.
    is_off
        Whether all loops are unrolled.
    """

    refused: dict[ast.AST, tuple[ast.AST, ...]] = field(default_factory=dict)
    kinds: dict[str, dict[str, tuple[str, int]]] = field(default_factory=dict)
    levels: dict[ast.AST, int] = field(default_factory=dict)
    forms: dict[str, dict[str, Any]] = field(default_factory=dict)
    special: dict[ast.AST, frozenset[str]] = field(default_factory=dict)
    is_off: bool = False
    restarts: int = 0
    steps: int = 0

    def learn(self, failure: Unroll, steps: int) -> None:
        """Remember why an evaluation of some steps failed; what is inside of it may succeed the next time."""
        self.restarts += 1
        self.steps += steps
        if failure.place is not None and failure.parameters:
            self.special[failure.place] = self.special.get(failure.place, frozenset()) | failure.parameters
        elif failure.place is not None:
            self.refused = {k: around for k, around in self.refused.items() if failure.place not in around}
            level = self.levels.get(failure.place, 0) + 1
            if isinstance(failure.place, ast.FunctionDef) and level < 2:
                self.levels[failure.place] = level
            else:
                self.refused[failure.place] = failure.around
        if self.restarts > MOST_RESTARTS or self.steps > _MOST_STEPS:
            self.is_off = True


@dataclass(slots=True)
class Tryout:
    """Whether an evaluation that may fail has failed."""

    is_failed: bool = False


class Folds(Holder, Protocol):
    """What loops need of the folding."""

    parts: list[Part]
    streams: tuple[Any, ...]

    def union(self, shapes: Sequence[Any]) -> Residual:
        """Return the union of shapes."""
        ...


class Runs(Protocol):
    """What loops need of the evaluator."""

    module: Frame
    tries: int

    def limited(self, steps: int) -> AbstractContextManager[None]:
        """Take at most some steps."""
        ...

    def call(self, function: Any, arguments: tuple[Any, ...], named: dict[str, Any]) -> Any:
        """Call a value."""
        ...

    def eval(self, node: ast.expr, frame: Frame) -> Any:
        """Evaluate an expression."""
        ...

    def execute(self, body: list[ast.stmt], frame: Frame) -> Iterator[Any]:
        """Evaluate statements; iterate over what they yield."""
        ...

    def store(self, target: ast.expr, value: Any, frame: Frame) -> None:
        """Assign a value to a target."""
        ...

    def iterate(self, value: Any) -> Iterator[Any]:
        """Iterate over a value; every item is a step."""
        ...


class Loops:
    """Evaluates loops so that they remain."""

    def __init__(self, plan: UnrollPlan, evaluator: Runs, folding: Folds, tree: ast.Module) -> None:
        self._plan, self._evaluator, self._folding = plan, evaluator, folding
        self._around: list[ast.AST] = []  # loops and functions that are being evaluated
        self._branches: list[Heap] = []
        self._usages: dict[ast.AST, ListUsage] = {}
        self._walked = 0
        self.is_used = False
        self._called = {n.id for n in ast.walk(tree) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Load)}
        self._reserved = {*dir(builtins), *keyword.kwlist, "math", "np", "random", "numpy", "P", "T", "Shape"}
        for node in tree.body:
            names = [getattr(node, "name", "")]
            names += [n.id for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)]
            self._reserved |= {*names} if not isinstance(node, (ast.FunctionDef, ast.ClassDef)) else {names[0]}

    def failure(self) -> Unroll:
        """Return the exception that unrolls the innermost loop."""
        if not self._around:
            self._plan.is_off = True
            return Unroll()
        return Unroll(self._around[-1], tuple(self._around[:-1]))

    @contextmanager
    def inside(self, node: ast.AST) -> Iterator[None]:
        """Unroll a loop, or specialise a function, whatever goes wrong in it."""
        self._around.append(node)
        try:
            yield
        except Unroll as failure:
            raise failure if failure.is_final or self._plan.is_off else self.failure() from None
        except (KeyboardInterrupt, SystemExit, MemoryError):
            raise
        except BaseException as error:
            raise self._blamed(error) or self.failure() from error
        finally:
            self._around.pop()

    def _blamed(self, error: BaseException) -> Unroll | None:
        """Return the exception that specialises the parameters of a function that are the reason of an error."""
        reasons = getattr(error, "because", ())
        root = self._folding.parts[-1].root
        if not reasons or root.function not in self._around or self._plan.is_off:
            return None
        names = {name for each in reasons for name in self._folding.parts[-1].names_in(each.node)}
        if not names or not names <= root.parameters.keys():
            return None
        index = len(self._around) - 1 - self._around[::-1].index(root.function)
        around = tuple(self._around[:index])
        if not names <= self.special_of(root.function):
            return Unroll(root.function, around, parameters=frozenset(names))
        return Unroll(around[-1], around[:-1]) if around else None  # its arguments are not known in the loop around it

    def touch(self, value: Any) -> None:
        """Raise an exception if the body of a loop takes an item of an iterator from before the loop."""
        if not self._around or not isinstance(value, (PythonGenerator, Iterator)):
            return
        loops = (part.loop for part in self._folding.parts[-1].around())
        if any(loop is not None and id(value) in loop.reached for loop in loops):
            raise self.failure()

    def may_keep(self, node: ast.AST) -> bool:
        """Return whether a loop or a function is tried."""
        return not self._plan.is_off and node not in self._plan.refused and not self._evaluator.tries

    @contextmanager
    def tried(self) -> Iterator[Tryout]:
        """Evaluate what may fail, without any change of the plan."""
        plan = self._plan
        self._plan = copy.copy(plan)
        self._plan.kinds, self._plan.forms = copy.deepcopy(plan.kinds), copy.deepcopy(plan.forms)
        trial = Tryout()
        try:
            with self._evaluator.limited(_MOST_STEPS_OF_TRIAL):
                yield trial
        except (KeyboardInterrupt, SystemExit, MemoryError):
            raise
        except (Unroll, Exception):
            trial.is_failed = True
        finally:
            self._plan = plan

    # --- loops -------------------------------------------------------------------------------------------------

    def statement(self, node: ast.For, items: Any, frame: Frame) -> tuple[Any, list[Any] | None]:
        """Evaluate a ``for`` statement once for all items.

        Returns the items and what the loop yields, None if it is to be unrolled.
        """
        usage = self._usage(frame)
        if usage is None or not self.may_keep(node) or not usage.may_keep(node):
            return items, None
        items, heap = self._prepared(node, items, frame, usage.stored[node])
        if heap is None:
            return items, None
        lists = {name: each for name in usage.grown[node] if type(each := frame.names.get(name)) is list}
        with self.inside(node), self._loop(items, node.target, frame, heap) as loop:
            before = {name: len(each) for name, each in lists.items()}
            changing = usage.stored[node] - lists.keys()
            carried = self._carry(loop, changing, frame)
            self._evaluator.store(node.target, loop.item, frame)
            frames = list(self._evaluator.execute(usage.bodies[node], frame))
            heap.check(frame, changing, list(lists.values()), self.failure)
            self._close(loop, changing, carried, frame)
            grown = [(each, before[name], each[before[name] :]) for name, each in lists.items()]
            added = [each[2] for name, each in zip(lists, grown) if name in usage.frames]
            if any(len(each) != 1 or self._is_many(each[0]) for each in [*added, *([frames] if frames else [])]):
                raise self.failure()  # each item is a frame
            self._grow([*(each for each in grown if each[2]), *([(frames, 0, frames[:])] if frames else [])], loop)
        return items, frames

    def _carry(self, loop: KeptLoop, names: set[str], frame: Frame) -> dict[str, tuple[Any, list[Any]]]:
        """Make numbers that the turns of a loop hand on residual; other variables may not be read."""
        carried: dict[str, tuple[Any, list[Any]]] = {}
        for name in sorted(names & frame.names.keys()):
            value = frame.names[name]
            if type(value) not in (int, float) or loop.numbers is not None:
                frame.names[name] = Poison()
                continue
            final: list[Any] = []  # the value at the end of a turn, once it is known
            known = Known(loop, _carried_row(value, final, self.failure))
            kind = type(value).__name__
            column = self._name(loop, name, kind)
            loop.carried[column] = known
            frame.names[name] = Residual(ast.Name(column, ast.Load()), kind, self._folding, known=known)
            carried[name] = frame.names[name], final
        return carried

    def _close(self, loop: KeptLoop, names: set[str], carried: dict[str, tuple[Any, list[Any]]], frame: Frame) -> None:
        """Give variables the values that they have after a loop, if these are known."""
        for name in names:
            value = frame.names.get(name, MISSING)
            if name in carried:
                residual, final = carried[name]
                final.append(value)
                column = residual.node.id
                if any(_kind(each) != residual.kind for each in residual.known.values()):
                    raise self.failure()
                loop.columns[column] = residual.known.values()
            known = value.known if type(value) is Residual and value.kind != "shape" else None
            frame.names[name] = known.row(loop.count - 1) if known is not None and known.loop is loop else Poison()

    def _grow(self, grown: list[tuple[list[Any], int, list[Any]]], loop: KeptLoop) -> None:
        outer = loop.part.outer
        is_stated = bool(loop.part.statements)
        if is_stated and len(grown) > 1:
            raise self.failure()
        results = []
        for _, _, new in grown:
            if not all(map(is_shape, new)):
                raise self.failure()
            results.append(node_of(new[0] if len(new) == 1 else self._folding.union(new)))
        for (items, length, _), result in zip(grown, results):
            items[length:] = [self._made(loop, result)]
        if not grown and is_stated and outer is not None:
            outer.statements.append(("", LoopNode(loop, None)))

    def _made(self, loop: KeptLoop, result: ast.expr) -> Residual:
        """Return the shape of all turns of a loop, for the part around it."""
        part = loop.part.outer
        assert part is not None
        name = part.new_name("parts")
        node = LoopNode(loop, result, name)
        if loop.part.statements:
            part.statements.append((name, node))
        else:
            part.values[name] = Residual(node, "list", self._folding, name)
        self.is_used = True
        spread = ast.Starred(ast.Name(name, ast.Load()), ast.Load())
        made = Residual(call_node("concat_shapes", [spread]), "shape", self._folding)
        made.primitives = self._unknown
        return made

    def _unknown(self) -> list[Residual]:
        self._plan.is_off = True
        raise Unroll()

    def comprehension(self, node: Any, items: Any, frame: Frame) -> tuple[Residual | None, Any]:
        """Evaluate a comprehension of shapes once for all items; returns None and the items if it is to be unrolled."""
        usage = self._usage(frame)
        if usage is None or node not in usage.spread or not self.may_keep(node):
            return None, items
        scope = Frame({}, frame, is_comprehension=True, function=frame.function, first=frame.first)
        items, heap = self._prepared(node, items, scope)
        return (self._level(node, 0, items, scope, heap) if heap is not None else None), items

    def _level(self, node: Any, level: int, items: Any, scope: Frame, heap: Heap) -> Residual:
        generator = node.generators[level]
        with self.inside(node), self._loop(items, generator.target, scope, heap) as loop:
            self._evaluator.store(generator.target, loop.item, scope)
            if not all(self._evaluator.eval(test, scope) for test in generator.ifs):
                raise self.failure()
            if level + 1 == len(node.generators):
                shape = self._evaluator.eval(node.elt, scope)
            else:
                given = self._evaluator.eval(node.generators[level + 1].iter, scope)
                given, inner = self._prepared(node, given, scope)
                if inner is None:
                    raise self.failure()
                shape = self._level(node, level + 1, given, scope, inner)
            if not is_shape(shape):
                raise self.failure()
            heap.check(scope, set(scope.names), [], self.failure)
            made = self._made(loop, node_of(shape))
        return made

    def _heap(self, frame: Frame) -> Heap | None:
        """Return all that a part of the program can change, None if that is too much."""
        return Heap.of((frame, self._evaluator.module, *self._folding.streams))

    def _refusal(self, node: ast.AST) -> Unroll:
        return Unroll(node, tuple(self._around))

    def call(self, count: Any, function: Any) -> Residual | None:
        """Evaluate ``loop(count, function)``; returns None if it is to be unrolled."""
        node: Any = getattr(function, "node", None)
        if type(function) is not PythonFunction or not self.may_keep(node):
            return None
        is_open = type(count) is Residual
        numbers = range(0) if is_open else range(count)
        turns = Residual(call_node("range", [node_of(count)]), "range", self._folding) if is_open else numbers
        items, heap = self._prepared(function.node, turns, function.outer)
        if heap is None:
            return None
        given = function.node.args.args
        target = ast.Name(given[0].arg if given else "i", ast.Store())
        with self.inside(function.node), self._loop(items, target, function.outer, heap) as loop:
            shape = self._evaluator.call(function, (loop.item,), {})
            shape = shape if is_shape(shape) else self._folding.union([shape])
            heap.check(function.outer, set(), [], self.failure)
            made = self._made(loop, node_of(shape))
        return made

    def _prepared(
        self, node: ast.AST, items: Any, frame: Frame, changing: Set[str] = frozenset()
    ) -> tuple[Any, Heap | None]:
        """Return the items of a loop, and what its body may not change; None if the loop is to be unrolled."""
        heap = self._heap(frame)
        self._walked += _MOST_WALKED // 10 if heap is None else len(heap.held)
        if self._walked > _MOST_WALKED_IN_ALL:
            self._plan.is_off = True
        if heap is None or self._plan.is_off:
            return items, None
        if type(items) is Residual and items.kind == "range":
            return items, heap
        if type(items) not in (range, list, tuple, np.ndarray, dict):
            if not isinstance(items, (Iterable, PythonClass)) or type(items) is Residual:
                return items, None
            if changing & frame.names.keys() and not _is_eager(items):
                raise self._refusal(node)  # it may look at what the loop changes
            items = self._listed(node, items, heap, frame)
        if not _MIN_TURNS <= len(items) <= _MAX_TURNS:
            return items, None
        return items, heap

    def _listed(self, node: ast.AST, items: Any, heap: Heap, frame: Frame) -> list[Any]:
        """Return the items of an iterator; what it does must not depend on when it does it."""
        listed: list[Any] = []
        with self._quiet(lambda: self._refusal(node)):
            for item in self._evaluator.iterate(items):
                listed.append(item)
                if len(listed) > _MAX_TURNS:
                    raise self._refusal(node)
        if isinstance(items, (PythonGenerator, Iterator)) and type(items) is not PythonObject:
            heap.drop(items)
        held = {id(each) for each in heap.held}
        is_mutable = any(not isinstance(each, _PLAIN) and id(each) not in held for each in listed)
        if isinstance(items, (PythonGenerator, PythonObject)) and (
            is_mutable and len({*map(id, listed)}) < len(listed)
        ):
            raise self._refusal(node)  # it may have changed since
        heap.check(frame, set(), [], lambda: self._refusal(node))
        return listed

    @contextmanager
    def _loop(self, items: Any, target: ast.expr, frame: Frame, heap: Heap) -> Iterator[KeptLoop]:
        """Yield a loop that remains, with its residual item; the statements of its body are recorded in its part."""
        outer = self._folding.parts[-1]
        part = Part(outer.names, outer=outer)
        is_open = type(items) is Residual
        count = 0 if is_open else len(items)
        loop = part.loop = KeptLoop(part, items if type(items) is range else None, count, heap.seen)
        if is_open:
            # the number of iterations is known only when the translated program runs
            name = self._name(loop, _hint(target), "int")
            loop.columns[name], loop.numbers = [], items.node
            part.names.columns.add(name)
            loop.item = Residual(ast.Name(name, ast.Load()), "int", self._folding)
        elif type(items) is range:
            loop.item = self.column(loop, list(items), _hint(target))
        else:
            loop.item = self.general(loop, list(items), target)
        heap.add(loop.item)
        self._folding.parts.append(part)
        try:
            yield loop
        finally:
            self._folding.parts.pop()

    def level_of(self, function: ast.AST) -> int:
        """Return what is specialised of a function."""
        return self._plan.levels.get(function, 0)

    def special_of(self, function: ast.AST) -> frozenset[str]:
        """Return the parameters of a function that are specialised."""
        return self._plan.special.get(function, frozenset())

    def is_loop(self, shape: Residual) -> bool:
        """Return whether a shape is that of all turns of a loop."""
        return shape.primitives == self._unknown and isinstance(shape.node, ast.Call)

    def _is_many(self, shape: Any) -> bool:
        return type(shape) is Residual and shape.primitives == self._unknown

    def is_conditional(self, value: Residual) -> bool:
        """Return whether a value belongs to one branch of a condition, so that it may not be computed before."""
        return bool(self._branches) and id(value) not in self._branches[-1].seen

    def specialised(self, function: ast.AST, parameters: Iterable[str]) -> Unroll:
        """Return the exception that specialises some parameters of a function."""
        return Unroll(
            function, tuple(each for each in self._around if each is not function), False, frozenset(parameters)
        )

    def kind_of_parameter(self, name: str, key: str, value: Any, function: ast.AST | None) -> Any:
        """Return the kind of a parameter, or of its items; all calls of a function have to agree.

        For a value that is made of others these are the kinds of the numbers in it by their places.
        """
        if parts_of(value) is not None and type(value) not in (tuple, list):
            forms = self._plan.forms.setdefault(name, {})
            if forms.setdefault(key, form_of(value)) != form_of(value) and function is not None:
                raise self.specialised(function, {key})
            leaves = list(leaves_of(value))
            return {path: self.kind_of_parameter(name, f"{key}{path}", each, function) for path, each in leaves}
        items = value if isinstance(value, (tuple, list)) else [value]
        kind = _common_kind(items)
        length = len(value) if isinstance(value, (tuple, list)) else -1
        if self._plan.is_off:
            return kind
        known = self._plan.kinds.setdefault(name, {})
        before, size = known.setdefault(key, (kind, length))
        if size != length:
            if function is not None:
                raise Unroll(function, tuple(self._around))
            raise self.failure()
        if before not in (kind, "any", *(["number"] if kind in ("int", "float") else [])):
            known[key] = _merged({kind, before}), length
            raise Unroll(is_again=True)
        return before

    # --- branches ----------------------------------------------------------------------------------------------

    def branch(self, node: ast.If, test: Residual, frame: Frame) -> bool:
        """Evaluate both branches of a condition that is not known; what they assign and add becomes conditional."""
        usage = self._usage(frame)
        if usage is None or not self.may_keep(node) or any(map(leaves, (*node.body, *node.orelse))):
            return False
        heap = self._heap(frame)
        if heap is None:
            return False
        inner = [each for part in (*node.body, *node.orelse) for each in ast.walk(part)]
        names = {each.id for each in inner if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store)}
        known = usage.lists - usage.frames
        lists = {name: each for name, each in frame.names.items() if name in known and type(each) is list}
        names -= lists.keys()
        before = {name: frame.names.get(name, MISSING) for name in names}
        sizes = {name: len(each) for name, each in lists.items()}
        with self.inside(node):
            outcomes = []
            for body in (node.body, node.orelse):
                with self._branch(heap):
                    for _ in self._evaluator.execute(body, frame):
                        raise self.failure()
                heap.check(frame, names, list(lists.values()), self.failure)
                assigned = {name: frame.names.get(name, MISSING) for name in names}
                outcomes.append((assigned, {name: each[sizes[name] :] for name, each in lists.items()}))
                for name, value in before.items():
                    frame.names.pop(name, None) if value is MISSING else frame.names.update({name: value})
                for name, each in lists.items():
                    del each[sizes[name] :]
            self._merge(test, outcomes, frame, lists)
        return True

    def choose(self, node: ast.IfExp, test: Residual, frame: Frame) -> Any:
        """Evaluate both values of a conditional expression; returns MISSING if that is not possible."""
        heap = self._heap(frame) if self.may_keep(node) else None
        if heap is None or self._usage(frame) is None:
            return MISSING
        with self.inside(node):
            with self._branch(heap):
                values = [self._evaluator.eval(each, frame) for each in (node.body, node.orelse)]
            heap.check(frame, set(), [], self.failure)
            return self._choice(test, *values)

    def quietly(self, node: ast.expr, frame: Frame) -> Any:
        """Evaluate an expression that Python evaluates in some turns only: it may not draw or print."""
        with self._quiet(self.failure):
            return self._evaluator.eval(node, frame)

    @contextmanager
    def _branch(self, heap: Heap) -> Iterator[None]:
        """Evaluate what Python evaluates in some turns only."""
        self._branches.append(heap)
        try:
            with self._quiet(self.failure):
                yield
        finally:
            self._branches.pop()

    @contextmanager
    def _quiet(self, failure: Callable[[], Unroll]) -> Iterator[None]:
        """Raise an exception if something is drawn or printed."""
        statements = self._folding.parts[-1].statements
        count = len(statements)
        yield
        if len(statements) > count:
            raise failure()

    def _merge(self, test: Residual, outcomes: Sequence[Any], frame: Frame, lists: dict[str, list[Any]]) -> None:
        (first, grown), (second, also_grown) = outcomes
        for name in first:
            values = first[name], second[name]
            is_missing = [each is MISSING for each in values]
            if not all(is_missing):
                frame.names[name] = Poison() if any(is_missing) else self._choice(test, *values)
        for name, items in lists.items():
            if grown[name] or also_grown[name]:
                shapes = [self._folding.union(each) for each in (grown[name], also_grown[name])]
                items.append(self._choice(test, *shapes))

    def _choice(self, test: Residual, first: Any, second: Any) -> Any:
        """Return a value that depends on a condition."""
        if first is second or (type(first) is type(second) and type(first) in _CONSTANTS and first == second):
            return first
        if type(first) is type(second) and type(first) in (tuple, list) and len(first) == len(second):
            return type(first)(self._choice(test, *pair) for pair in zip(first, second))
        if not all(isinstance(each, (*_SCALARS, Residual, type(None))) for each in (first, second)):
            raise self.failure()
        kind = _common_kind((first, second))
        if kind != "shape" and (is_shape(first) or is_shape(second)):
            raise self.failure()
        known = known_result(lambda is_true, a, b: a if is_true else b, (test, first, second))
        node = ast.IfExp(node_of(test), node_of(first), node_of(second))
        choice = Residual(node, kind, self._folding, known=known)
        if kind == "shape":
            choice.primitives = self._unknown
        return choice

    # --- items -------------------------------------------------------------------------------------------------

    def general(self, loop: KeptLoop, values: Sequence[Any], target: Any, depth: int = 0) -> Any:
        """Return what stands for a value that differs from turn to turn; the same value stays itself."""
        first = values[0]
        kind = type(first)
        if all(each is first for each in values):
            return first
        if all(isinstance(each, _SCALARS) or each is None for each in values):
            is_same = all(type(each) is kind and each == first for each in values)
            if not is_same and {"bool"} < {*map(_kind, values)}:
                raise self.failure()
            return first if is_same else self.column(loop, values, _hint(target))
        if depth > _DEEPEST or any(type(each) is not kind for each in values):
            raise self.failure()
        if kind in (tuple, list, NamedTuple) and len({*map(len, values)}) == 1:
            return self._general_sequence(loop, values, target, depth)
        if kind is dict and len({tuple(each) for each in values}) == 1:
            return {key: self.general(loop, [each[key] for each in values], key, depth + 1) for key in first}
        if kind is np.ndarray and len({(each.shape, each.dtype) for each in values}) == 1 and 0 < first.size <= 16:
            made = np.empty(first.shape, dtype=object)
            names = [each.id for each in getattr(target, "elts", ()) if isinstance(each, ast.Name)]
            for number, index in enumerate(np.ndindex(first.shape)):
                hint = names[number] if len(names) == first.size else f"{_hint(target)}_{number}"
                made[index] = self.general(loop, [each[index] for each in values], hint, depth + 1)
            return made
        if kind is PythonObject and first.cls.members is not None and all(each.cls is first.cls for each in values):
            return self.column(loop, values, _hint(target))
        if kind is PythonObject and first.cls.members is None:
            if len({(id(each.cls), tuple(each.fields)) for each in values}) == 1:
                fields = {n: self.general(loop, [v.fields[n] for v in values], n, depth + 1) for n in first.fields}
                return PythonObject(first.cls, fields, is_general=True)
        raise self.failure()

    def _general_sequence(self, loop: KeptLoop, values: Sequence[Any], target: Any, depth: int) -> Any:
        first = values[0]
        targets = list(getattr(target, "elts", ()))
        if type(first) is NamedTuple:
            if any(each.cls is not first.cls for each in values):
                raise self.failure()
            targets = list(first.cls.tuple_fields or ())
        elif len(targets) != len(first) or any(isinstance(each, ast.Starred) for each in targets):
            targets = [f"{_hint(target)}_{i}" for i in range(len(first))]
        made = [self.general(loop, column, each, depth + 1) for each, column in zip(targets, zip(*values))]
        if type(first) is NamedTuple:
            result = NamedTuple(made)
            result.cls, result.fields = first.cls, dict(first.fields)
            return result
        return type(first)(made)

    def column(self, loop: KeptLoop, values: Sequence[Any], hint: str) -> Residual:
        """Return a residual value that is another in every turn."""
        text = [(type(each), repr(each)) for each in values]
        same = (n for n, each in loop.columns.items() if [(type(one), repr(one)) for one in each] == text)
        kind = _common_kind(values)
        name = next(same, None)
        if name is None:
            name = self._name(loop, hint, kind)
            loop.columns[name] = list(values)
            loop.part.names.columns.add(name)
        return Residual(ast.Name(name, ast.Load()), kind, self._folding, known=Known(loop, values.__getitem__))

    def _name(self, loop: KeptLoop, hint: str, kind: str) -> str:
        """Return a name for a column that is free in the function; loops one after the other may share one."""
        stem = hint.strip("_") if hint.strip("_").isidentifier() else "value"
        root = loop.part.root
        loops = [loop, *(part.loop for part in self._folding.parts if part.loop is not None)]
        active = {name for each in loops for name in (*each.columns, *each.carried)}
        number = 1
        name = stem
        while name in self._reserved or name in active or name in root.parameters or root.taken.get(name, kind) != kind:
            number += 1
            name = f"{stem}{number}"
        root.taken[name] = kind
        return name

    def looked_up(self, container: Any, index: Any) -> Any:
        """Return an item of a container by an index that differs from turn to turn, MISSING if it is left to run."""
        hint = getattr(getattr(index, "node", None), "id", "value")
        return self.computed(container.__getitem__, (index,), f"{hint}_item") if self._around else MISSING

    def computed(self, function: Callable[..., Any], operands: Sequence[Any], hint: str = "value") -> Any:
        """Return the result of a function without effects for values that are known in the turns of a loop.

        Returns MISSING if they are not known.
        """
        known = known_result(function, tuple(operands))
        return MISSING if known is None else self.general(known.loop, known.values(), hint)

    def texts(self, parts: Sequence[Any], joined: Callable[[list[Any]], str]) -> Any:
        """Return a text that differs from turn to turn."""
        text = self.computed(lambda *row: joined(list(row)), parts, "text")
        if text is MISSING:
            raise self.failure()
        return text

    def _usage(self, frame: Frame) -> ListUsage | None:
        while frame.is_comprehension and frame.outer is not None:
            frame = frame.outer
        function = frame.function.node if frame.function is not None and not frame.is_class else None
        if not isinstance(function, ast.FunctionDef):
            return None
        if function not in self._usages:
            self._usages[function] = ListUsage(function, function.name in self._called)
        return self._usages[function]


_SCALARS = (int, float, str, np.integer, np.floating, np.bool_)
_PLAIN = (*_SCALARS, type(None), tuple, NamedTuple)


def _is_eager(items: Any) -> bool:
    """Return whether an iterator only passes items of containers on, so that it does not matter when they are taken."""
    if isinstance(items, Metered):
        return _is_eager(items.items)
    if isinstance(items, (enumerate, zip)):
        inner = items.__reduce__()[1]
        return all(_is_eager(each) for each in (inner if isinstance(items, zip) else inner[:1]))
    return isinstance(items, _EAGER)


_WALKED: tuple[Any, ...] = (
    iter([]), iter(()), iter(""), iter(range(0)), reversed([]), iter({}), {}.keys(), {}.values(), {}.items(),
    iter({}.items()), iter({}.values()), range(0), [], (),
)  # fmt: skip
_EAGER = tuple({type(each) for each in _WALKED})


def _carried_row(first: Any, final: list[Any], failure: Callable[[], Unroll]) -> Callable[[int], Any]:
    def row(number: int) -> Any:
        if number == 0:
            return first
        if not final:
            raise failure()
        last = final[0]
        if type(last) is not Residual:
            return last
        if last.known is None:
            raise failure()
        return last.known.row(number - 1)

    return row


def _common_kind(values: Iterable[Any]) -> str:
    """Return the kind of a residual value that is one of some values."""
    return _merged({each.kind if type(each) is Residual else _kind(each) for each in values})


def _merged(kinds: set[str]) -> str:
    if len(kinds) == 1:
        return next(iter(kinds))
    return "number" if kinds <= {"int", "float", "number"} else "any"


def _kind(value: Any) -> str:
    if isinstance(value, bool):
        return "bool"
    if type(value) in (int, float):
        return type(value).__name__
    return "number" if isinstance(value, (np.integer, np.floating)) else "any"


def _hint(target: Any) -> str:
    return target if isinstance(target, str) else target.id if isinstance(target, ast.Name) else "value"


# What a loop may not change.


@dataclass(eq=False, slots=True)
class Heap:
    """Values that the body of a loop can reach, as they are before it."""

    held: list[Any] = field(default_factory=list)
    seen: dict[int, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, frames: Iterable[Any]) -> Heap | None:
        """Return what can be reached from frames, None if that is too much or cannot be compared."""
        heap = cls()
        return heap if heap.add(*frames) else None

    def add(self, *values: Any) -> bool:
        """Add values and all that they contain; returns False if a value cannot be compared."""
        pending = list(values)
        while pending:
            value = pending.pop()
            if isinstance(value, _LEAVES) or id(value) in self.seen:
                continue
            if len(self.held) > _MOST_WALKED:
                return False
            parts = _contents(value)
            if parts is None:
                return False
            self.held.append(value)
            self.seen[id(value)] = _signature(value)
            pending += parts
        return True

    def drop(self, value: Any) -> None:
        """Leave out an iterator that is used up."""
        self.held = [each for each in self.held if each is not value]

    def is_unchanged(self) -> bool:
        """Return whether nothing has changed."""
        return all(self.seen[id(value)] == _signature(value) for value in self.held)

    def check(self, frame: Frame, names: set[str], grown: list[Any], failure: Callable[[], Unroll]) -> None:
        """Raise an exception if anything has changed but some variables of a frame and the end of some lists."""
        for value in self.held:
            before, after = self.seen[id(value)], _signature(value)
            if before == after:
                continue
            if value is frame:
                changed = {each for each, _ in {*before} ^ {*after}}
                if changed <= names:
                    continue
            elif any(value is each for each in grown) and after[: len(before)] == before:
                continue
            raise failure()


_LEAVES = (
    int, float, complex, str, bytes, type(None), range, type, np.generic, np.dtype, Module, IntMember, TextMember,
)  # fmt: skip


def _contents(value: Any) -> list[Any] | None:
    """Return the values in a value, None for a value with a state of its own."""
    kind = type(value)
    if kind is Frame:
        return [*value.names.values(), *([value.outer] if value.outer is not None else [])]
    if kind is PythonFunction:
        return [value.outer, *value.defaults, *value.keyword_defaults.values(), *value.attributes.values()]
    if kind is Native:
        return [*value.attributes.values(), *_hidden(value.function)]
    if kind is BoundMethod:
        return [value.function, value.value]
    if kind is PythonClass:
        made = [each for field in value.data or () for each in (field.default, field.factory)]
        return [*value.names.values(), *value.bases, *(each for each in made if each is not MISSING)]
    if kind is PythonObject:
        return [value.cls, *value.fields.values()]
    if kind is Cache:
        return list(value.values())
    if isinstance(value, ValueObject):
        return [value.cls, *value.fields.values(), *(_items(value.plain()) or ())]
    if kind in (Property, StaticMethod, ClassMethod, Super, Residual, Poison) or value is MISSING:
        return [getattr(value, name) for name in ("get", "set", "delete", "function") if hasattr(value, name)]
    if kind is np.ndarray:
        return value.ravel().tolist() if value.dtype == object else [] if value.size < 100_000 else None
    return _items(value)


def _items(value: Any) -> list[Any] | None:
    if isinstance(value, ChainMap):
        return list(value.maps)
    if isinstance(value, dict):
        return [*value.keys(), *value.values()]
    if isinstance(value, (list, tuple, set, frozenset, deque, int, float, str)):
        return list(value) if not isinstance(value, (int, float, str)) else []
    if type(value) is PythonGenerator:
        return [value.steps]
    if isinstance(value, (Iterator, *_STREAMS)):
        return []  # nobody may advance it
    row = library_class(value)
    if row is not None:
        return [getattr(value, name) for name in row.state]
    is_plain = type(value).__name__ in _UNCHANGING
    return [] if is_plain or isinstance(value, Exception) else None


_UNCHANGING = (
    "Fraction", "Decimal", "Pattern", "Match", "date", "datetime", "time", "timedelta", "mappingproxy", "ellipsis",
    "NotImplementedType",
)  # fmt: skip
_OWN = (PythonFunction, PythonObject, PythonClass, BoundMethod, Native, Frame, list, dict, set, deque, Cache)


def _hidden(function: Any) -> list[Any]:
    """Return what a function of the host holds on to: its object, what it closes over, and its first arguments."""
    own: list[Any] = []
    pending, seen = [function], set()
    while pending:
        each = pending.pop()
        if id(each) in seen:
            continue
        seen.add(id(each))
        if type(each) in _OWN or isinstance(each, (PythonGenerator, Iterator, *_STREAMS)):
            own.append(each)
        elif isinstance(each, _HOST_FUNCTIONS):
            pending.append(getattr(each, "__self__", None))
            pending += [cell.cell_contents for cell in getattr(each, "__closure__", None) or () if _is_full(cell)]
            pending += [each.func, *each.args, *each.keywords.values()] if isinstance(each, partial) else []
    return own


_HOST_FUNCTIONS = (BuiltinFunctionType, MethodType, FunctionType, MethodWrapperType, partial)


def _is_full(cell: Any) -> bool:
    try:
        _ = cell.cell_contents
    except ValueError:
        return False
    return True


_STREAMS = (random.Random, np.random.RandomState, np.random.Generator)


def _state_of(stream: Any) -> Any:
    if isinstance(stream, random.Random):
        return stream.getstate()
    if isinstance(stream, np.random.RandomState):
        state: Any = stream.get_state()
        return state[1].tobytes(), state[2:]
    return stream.bit_generator.state


def _signature(value: Any) -> Any:
    """Describe which values a value contains now."""
    kind = type(value)
    if kind is Frame:
        return tuple((name, id(each)) for name, each in value.names.items())
    if kind is PythonClass:
        return tuple((name, id(each)) for name, each in value.names.items())
    if kind is PythonObject:
        return tuple((name, id(each)) for name, each in value.own_fields().items())
    if kind is Cache:
        return None
    if kind in (PythonFunction, Native):
        return tuple((name, id(each)) for name, each in value.attributes.items())
    if isinstance(value, ValueObject):
        return _signature(value.plain()), _signature(value.fields)
    if kind is Residual:
        return id(value.node)
    if kind is np.ndarray:
        return [*map(id, value.ravel().tolist())] if value.dtype == object else value.tobytes()
    if isinstance(value, _STREAMS):
        return repr(_state_of(value))
    if isinstance(value, dict):
        return tuple((id(key), id(each)) for key, each in value.items())
    if isinstance(value, (list, tuple, deque)):
        return tuple(map(id, value))
    return frozenset(map(id, value)) if isinstance(value, (set, frozenset)) else None
