"""Partial evaluation of the parts of a Python program that the translation does not support.

The statements at the top level that do not translate, and all that use them, are evaluated; what remains of a
registered function is an expression of calls of the helper API, with the draws of random numbers in their order.
Everything else stays as it is. The result is a smaller Python program, which the translation proper then translates:
there is one semantics of Python for both (online partial evaluation; Jones, Gomard and Sestoft 1993, chapter 4).
"""

from __future__ import annotations

import ast
import contextlib
import copy
import keyword
import random
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from scenelang.grammar.datum import Span
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.interpreter.runtime.modelling_helpers import ASSERT_THAT, relation_helpers, scene_helpers
from scenelang.interpreter.transpile.analysis.python_text import PythonText, variable_of
from scenelang.interpreter.transpile.evaluation import METHODS, NeedsPrimitives, UnsupportedPython, words
from scenelang.interpreter.transpile.evaluation.classes import limited_draw
from scenelang.interpreter.transpile.evaluation.evaluator import PythonEvaluator, StepBudget
from scenelang.interpreter.transpile.evaluation.library import PythonLibrary
from scenelang.interpreter.transpile.evaluation.loops import MOST_RESTARTS, Heap, Loops, UnrollPlan
from scenelang.interpreter.transpile.evaluation.objects import (
    MISSING,
    Exhausted,
    IntMember,
    Native,
    PythonFunction,
    PythonGenerator,
    PythonObject,
    TextMember,
    Unroll,
    ValueObject,
    type_name,
    value_of_error,
)
from scenelang.interpreter.transpile.evaluation.residue import (
    Part,
    PartNames,
    Residual,
    Variant,
    call_node,
    has_kind,
    has_residual,
    is_identity,
    is_shape,
    node_of,
    parameter_in,
    place,
)
from scenelang.interpreter.transpile.evaluation.structures import (
    as_argument,
    generalised,
    is_general,
    lengths_in,
    part_of,
)

MAX_NODES = 60_000  # of a residual function
_DRAWS = words(
    "betavariate choice choices expovariate gauss normalvariate randint random randrange sample shuffle "
    "triangular uniform"
)
_ARRAY_DRAWS = words(
    "choice normal permutation rand randint randn random random_sample shuffle standard_normal uniform"
)  # those that the language has; others are drawn while the program is evaluated
_REGISTERED = "library_call(...)"  # stands for all registered functions
_STATE = "state"  # parameter of a function that depends on more than its arguments
_POSES = ("translation_matrix", "rotation_matrix", "scale_matrix", "reflection_matrix", "identity_matrix")
# Of results of builtins.
_KINDS = {"Entity": "shape", "Float": "float", "Vector": "array", "Array": "array", "Matrix": "pose"}
_BOXES = ("compute_shape_center", "compute_shape_min", "compute_shape_max", "compute_shape_sizes")


@dataclass(eq=False, slots=True)
class Item:
    """Statement at the top level: the names that it defines, and those that it uses."""

    node: ast.stmt
    names: frozenset[str]
    uses: frozenset[str]
    first_line: int


def items_of(tree: ast.Module) -> list[Item]:
    """Return the statements of a module."""
    items = [_item(node) for node in tree.body]
    changed = {
        name: frozenset(_changed(item.node))
        for item in items
        if isinstance(item.node, (ast.FunctionDef, ast.ClassDef))
        for name in item.names
    }
    for item in items:  # a decorator or a base class may change what it uses, such as a table of functions
        if isinstance(item.node, (ast.FunctionDef, ast.ClassDef)):
            parts = [*item.node.decorator_list, *getattr(item.node, "bases", ())]
            used = {n.id for part in parts for n in ast.walk(part) if isinstance(n, ast.Name)}
            item.names |= frozenset[str]().union(*(changed.get(name, frozenset()) for name in used))
    return items


def _item(node: ast.stmt) -> Item:
    names: set[str] = set()
    if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
        names.add(node.name)
    else:
        names |= {n.id for n in ast.walk(node) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
    uses = _uses(node)
    if isinstance(node, (ast.Expr, ast.AugAssign, ast.For, ast.If, ast.While, ast.Assign)):
        names |= _changed(node)  # it may change what it uses
    decorators = getattr(node, "decorator_list", [])
    for text in (n.value for each in decorators for n in ast.walk(each) if isinstance(n, ast.Constant)):
        if type(text) is str:  # with which the function is registered
            names |= {text, text.partition(";")[0].strip()}
            uses.discard(text)
    if any("register" in ast.unparse(each) for each in decorators):
        names.add(_REGISTERED)
    return Item(node, frozenset(names), frozenset(uses), min([node.lineno, *(d.lineno for d in decorators)]))


def _uses(node: ast.AST) -> set[str]:
    """Return the variables that a statement reads, and its texts, which may be words."""
    nodes = list(_without_annotations(node))
    names = {n.id for n in nodes if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Load)}
    names |= {n.value for n in nodes if isinstance(n, ast.Constant) and type(n.value) is str}
    return names | ({_REGISTERED} if any(map(_computes_word, nodes)) else set())


def _computes_word(node: ast.AST) -> bool:
    """Return whether a call computes the name of the registered function that it calls, which may be any."""
    if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Name) or node.func.id != "library_call":
        return False
    given = [*node.args[:1], *(each.value for each in node.keywords if each.arg in ("func_name", None))]
    return not all(isinstance(each, ast.Constant) for each in given)


def _without_annotations(node: ast.AST) -> Iterator[ast.AST]:
    """Iterate over the nodes that have a meaning when the program runs."""
    yield node
    for name, value in ast.iter_fields(node):
        if name not in ("annotation", "returns"):
            for child in value if isinstance(value, list) else [value]:
                if isinstance(child, ast.AST):
                    yield from _without_annotations(child)


def _changed(node: ast.AST) -> set[str]:
    """Return the variables whose values a statement may change: those before a dot or an index."""
    names: set[str] = set()
    for each in ast.walk(node):
        if isinstance(each, ast.Attribute) or (isinstance(each, ast.Subscript) and not isinstance(each.ctx, ast.Load)):
            variable = variable_of(each)
            names |= {variable.id} if variable is not None else set()
    return names


def closure(items: Sequence[Item], start: set[int], is_user: bool) -> set[int]:
    """Return the numbers of items that use the items of ``start``, or that these use, directly or through others."""
    defined: dict[str, list[int]] = {}
    used: dict[str, list[int]] = {}
    for number, item in enumerate(items):
        for name in item.names:
            defined.setdefault(name, []).append(number)
        for name in item.uses:
            used.setdefault(name, []).append(number)
    reached, pending = set(start), list(start)
    while pending:
        item = items[pending.pop()]
        names, table = (item.names, used) if is_user else (item.uses, defined)
        for name in names:
            for number in table.get(name, ()):
                if number not in reached:
                    reached.add(number)
                    pending.append(number)
    return reached


@dataclass(frozen=True, slots=True)
class Remaining:
    """Program that remains; the reason why it cannot be evaluated, if a part that the root needs cannot; else None.

    ``with_originals`` is the program in which functions stay as they are that only call evaluated words.
    """

    text: PythonText | Diagnostic | None
    with_originals: PythonText | None = None


def fold(text: PythonText, root: str | None, errors: Sequence[Diagnostic], way: str, budget: StepBudget) -> Remaining:
    """Evaluate the parts of a program that have errors.

    Parameters
    ----------
    text
        The program.
    root
        Name of its root function.
    errors
        Errors of its translation.
    way
        What remains: "loops", where they can; "unrolled" loops; or "drawn", with the random numbers of the seed 0.
    budget
        Steps that are left for the evaluations of the program.
    """
    items = items_of(text.tree)
    wrong = {number for number, item in enumerate(items) if any(map(_inside(text, item), errors))}
    start = {number for number, item in enumerate(items) if root is not None and root in item.names}
    reached = closure(items, start, is_user=False)
    if any(d.span is not None and d.span.start == d.span.end for d in errors):
        wrong |= reached  # an error in the Python of a library function, which has no place
    if not start or not all(any(_inside(text, items[number])(d) for number in wrong) for d in errors):
        return Remaining(None)
    evaluated = closure(items, wrong & reached, is_user=True) & reached
    if not start & evaluated:
        return Remaining(_rewritten(text, items, reached - evaluated, {}))
    plan = UnrollPlan(is_off=way == "unrolled")
    if way != "drawn":
        folding = _evaluated(text, items, evaluated, str(root), plan, budget)
        if folding.error is None:
            rewritten = _rewritten(text, items, reached - evaluated, folding.found, folding.printed)
            originals = _with_originals(text, items, start, wrong, evaluated, folding) if way == "loops" else None
            return Remaining(_warned(rewritten, folding), _warned(originals, folding))
        if not folding.draws:
            return Remaining(_problem(text, folding, folding.error))
    folding = _evaluated(text, items, reached, str(root), plan, budget, True)
    if folding.error is not None:
        return Remaining(_problem(text, folding, folding.error))
    return Remaining(_with_fixed_draws(text, items, reached, folding, str(root)))


def _warned(text: PythonText | None, folding: Folding) -> PythonText | None:
    return replace(text, diagnostics=[*text.diagnostics, *folding.warnings]) if text is not None else None


def _with_originals(
    text: PythonText,
    items: Sequence[Item],
    start: set[int],
    wrong: set[int],
    evaluated: set[int],
    folding: Folding,
) -> PythonText | None:
    """Return the program in which only those functions are evaluated that need it; None if that makes no difference.

    A function stays as it is if it uses nothing that does not translate but by ``library_call``: it passes the
    arguments for which the word has been evaluated.
    """
    words = folding.words()
    users: dict[str, list[int]] = {}
    for number in evaluated:
        for name in items[number].uses:
            users.setdefault(name, []).append(number)
    needed = wrong & evaluated
    pending = list(needed)
    while pending:
        item = items[pending.pop()]
        word = item.node.name if isinstance(item.node, ast.FunctionDef) and item.node.name in words else None
        for user in (number for name in item.names for number in users.get(name, ())):
            if user not in needed and (word is None or word in _names_in(items[user].node)):
                needed.add(user)
                pending.append(user)
    reached = closure(items, start, is_user=False)
    if not words or not evaluated - needed:
        return None
    definitions = {name: made for name, made in folding.found.items() if any(name in items[n].names for n in needed)}
    return _rewritten(text, items, reached - needed, definitions, folding.printed, (start, words))


def _names_in(node: ast.AST) -> set[str]:
    return {each.id for each in _without_annotations(node) if isinstance(each, ast.Name)}


def _evaluated(
    text: PythonText,
    items: Sequence[Item],
    evaluated: set[int],
    root: str,
    plan: UnrollPlan,
    budget: StepBudget,
    *fixed: bool,
) -> Folding:
    """Evaluate a program; lists contain primitives in place of shapes only if that makes a difference."""
    is_exact = False
    while True:
        folding = Folding(text, items, evaluated, plan, budget, *fixed)
        folding.evaluator.is_exact = is_exact
        try:
            folding.evaluate(root)
        except Unroll as failure:
            assert not plan.is_off or plan.restarts <= MOST_RESTARTS + 1, "an evaluation without loops needs none"
            plan.learn(failure, folding.evaluator.steps)
            continue
        finally:
            budget.left -= folding.evaluator.steps
        if isinstance(folding.error, NeedsPrimitives) and not is_exact:
            is_exact = True
        elif folding.error is not None and folding.loops.is_used and not plan.is_off:
            plan.is_off = True
        else:
            return folding


def _with_fixed_draws(
    text: PythonText, items: Sequence[Item], reached: set[int], folding: Folding, root: str
) -> PythonText | None:
    """Return what remains of a program in which random numbers decide what happens: they are those of the seed 0."""
    span = text.span(next(items[n].node for n in reached if root in items[n].names))
    message = "random numbers decide what this program builds, and are those of the seed 0"
    warning = Diagnostic("fixed-draws", message, Span(span.source, span.start, span.start + 1))
    rewritten = _rewritten(text, items, set(), folding.found, folding.printed)
    return replace(rewritten, diagnostics=[*text.diagnostics, warning]) if rewritten is not None else None


def _inside(text: PythonText, item: Item) -> Callable[[Diagnostic], bool]:
    end = text.span(item.node).end
    start = text.offset(item.first_line, 0)
    return lambda d: d.span is not None and start <= d.span.start <= end


def _problem(text: PythonText, folding: Folding, error: Exception) -> Diagnostic:
    """Return the diagnostic of what ends an evaluation: unsupported Python, or an exception that is not caught."""
    evaluator = folding.evaluator
    node = error.node if isinstance(error, UnsupportedPython) else evaluator.failed or evaluator.node
    span = text.span(node) if node is not None else Span(text.source, text.response.start, text.response.start)
    if isinstance(error, UnsupportedPython):
        return Diagnostic(error.name, error.message, span, error.hint)
    seen = value_of_error(error)
    name, message = type_name(seen), "" if isinstance(error, Exhausted) else str(seen).partition("\n")[0]
    return Diagnostic("python-exception", f"Python: {name}: {message}" if message else f"Python: {name}", span)


def _rewritten(
    text: PythonText,
    items: Sequence[Item],
    kept: set[int],
    definitions: Mapping[str, ast.FunctionDef],
    printed: Sequence[ast.stmt] = (),
    callers: tuple[set[int], frozenset[str]] = (set(), frozenset()),
) -> PythonText | None:
    """Return the program with evaluated functions replaced by what remains of them.

    ``callers`` are the statements from which the rest is reached, and the evaluated words that what is kept may call.
    """
    start, words_for_all = callers
    if definitions:
        used = frozenset[str]().union(*map(_uses, definitions.values()))
        needed = {number for number in kept if items[number].names & used}
        kept = closure(items, needed | start, is_user=False) & kept
    kept = kept - {number for number in kept if items[number].names & definitions.keys() - {_REGISTERED}}
    if any(items[number].uses & (definitions.keys() - words_for_all) for number in kept):
        return None  # a function that stays calls one for other arguments
    body: list[ast.stmt] = []
    if definitions:
        for module, alias in (("numpy", "numpy_module"), ("math", "math_module"), ("random", "random_module")):
            body.append(_located(ast.Import([ast.alias(module, alias)]), 1))
    for number, item in enumerate(items):
        name = item.node.name if isinstance(item.node, ast.FunctionDef) else ""
        if number in kept or isinstance(item.node, (ast.Import, ast.ImportFrom)):
            body.append(item.node)
        elif name in definitions:
            body.append(definitions[name])
    body += [_located(statement, 1) for statement in printed]
    body += [made for name, made in definitions.items() if not any(made is each for each in body)]
    lines = [(items[n].first_line, items[n].node.end_lineno or 0) for n in range(len(items)) if n not in kept]
    comments = [c for c in text.comments if not any(first <= c.line <= last for first, last in lines)]
    return replace(text, tree=ast.Module(body, []), comments=comments)


def _located(node: Any, line: int) -> Any:
    for each in ast.walk(node):
        for name in each._attributes:
            setattr(each, name, line if "lineno" in name else 0)
    return node


# --- evaluation ----------------------------------------------------------------------------------------------------


_SIZE_AT = {
    "choice": 1, "random": 0, "random_sample": 0, "standard_normal": 0, "normal": 2, "randint": 2, "uniform": 2,
}  # fmt: skip
_MAX_DRAWN_NUMBERS = 5_000  # of one call
_KINDS = {"randint": "int", "randrange": "int", "permutation": "number"}  # of draws; others are floats


def _kind_of_items(items: Any) -> str:
    """Return the kind of a draw from a collection."""
    kinds = {type(each) for each in items} if isinstance(items, (list, tuple)) else {type(items)}
    if len(kinds) == 1 and kinds <= {int, float}:
        return kinds.pop().__name__
    return "number" if kinds <= {int, float, range, np.ndarray} else "any"


def _drawn_shape(method: str, arguments: tuple[Any, ...], named: Mapping[str, Any]) -> tuple[int, ...]:
    """Return the shape of the array that a draw of numpy gives, () for a number."""
    if method in ("rand", "randn"):
        shape = tuple(int(each) for each in arguments)
    elif method == "permutation":
        shape = np.shape(np.arange(arguments[0]) if isinstance(arguments[0], int) else arguments[0])
    else:
        place = _SIZE_AT.get(method, 9)
        size = named.get("size", arguments[place] if len(arguments) > place else None)
        if size is not None:
            shape = tuple(size) if isinstance(size, (tuple, list)) else (int(size),)
        else:
            given = [each for each in (*arguments[:2], *named.values()) if isinstance(each, (list, tuple, np.ndarray))]
            shape = np.broadcast_shapes(*map(np.shape, given)) if given and method in ("normal", "uniform") else ()
    if int(np.prod(shape)) > _MAX_DRAWN_NUMBERS:
        raise UnsupportedPython("this draw has too many numbers")
    return shape


def _kept(shape: Residual) -> Residual:
    """Return a shape as it is now; others may add to it later."""
    if shape.primitives is None or ast.unparse(getattr(shape.node, "func", shape.node)) == "concat_shapes":
        return Residual(shape.node, shape.kind, shape.holder, shape.name, shape.primitives)
    known = shape.primitives
    kept = Residual(shape.node, shape.kind, shape.holder, shape.name)
    kept.primitives = lambda: [kept if each is shape else each for each in known()]
    return kept


class Folding:
    """Evaluates functions of a program, and collects what remains of them."""

    def __init__(
        self,
        text: PythonText,
        items: Sequence[Item],
        evaluated: set[int],
        plan: UnrollPlan,
        budget: StepBudget,
        has_fixed_draws: bool = False,
    ) -> None:
        self._items = items
        self._evaluated = {name for number in evaluated for name in items[number].names}
        self.evaluator = PythonEvaluator({}, {}, budget)
        self.tick = self.evaluator.tick
        self.loops = Loops(plan, self.evaluator, self, text.tree)
        library = PythonLibrary(self.evaluator)
        self.evaluator.modules = library.modules
        self.evaluator.builtins = {**library.builtins, **self._helpers(), **library.modules["typing"].names}
        self.evaluator.builtins |= {name: library.modules[name] for name in ("math", "np", "random")}
        self.evaluator.builtins["print"] = Native("print", self._print)
        self.evaluator.builtins |= {"numpy": library.modules["np"], "Shape": library.builtins["list"]}
        self.evaluator.builtins |= dict.fromkeys(("P", "T"), library.builtins["object"])
        self.streams = random.Random(0), np.random.RandomState(0)
        if has_fixed_draws:
            self._fix_draws(library)
        else:
            self._add_draws(library)
        self._functions: dict[str, tuple[Any, str]] = {}
        self._animations: set[str] = set()
        self.parts: list[Part] = []
        self._names = PartNames()
        self._defaults: dict[str, dict[str, ast.expr]] = {}  # of parameters, by function
        self._shown: dict[str, set[str]] = {}  # parameters that calls pass, by function
        self._variants: dict[str, dict[Any, list[Variant]]] = {}
        self.warnings: list[Diagnostic] = []
        self.printed: list[ast.stmt] = []  # by the statements at the top level
        self._opaque: set[str] = set()  # functions whose callers pass other things than they do in Python
        self._is_pure = False  # whether the root has changed nothing outside of it
        self._objects: dict[str, dict[str, int]] = {}  # numbers of arguments by their states
        self._failed: dict[str, Exception] = {}
        self._is_started = False
        self.found: Mapping[str, ast.FunctionDef] = {}
        self.error: Exception | None = None
        self.draws = "random" in text.source.text and not has_fixed_draws
        self._text = text
        self._required: dict[str, dict[str, Any]] = {}  # arguments of the first call of a function that have no default

    def evaluate(self, root: str) -> None:
        """Evaluate the module and its root function; ``found`` or ``error`` is what comes of it."""
        try:
            self.found = self.definitions(root)
        except SceneError:
            raise
        except Exception as error:
            self.error = error

    def definitions(self, root: str) -> dict[str, ast.FunctionDef]:
        """Evaluate the module and its root function; return what remains of the functions, by name."""
        for item in self._items:
            try:
                self.parts.append(Part(self._names))
                self.evaluator.run(item.node)
                if any(name for name, _ in self.parts[-1].statements):
                    raise UnsupportedPython("random numbers at the top level cannot be evaluated here")
                self.printed += [ast.Expr(node) for _, node in self.parts[-1].statements]
            except UnsupportedPython as error:
                error.node = error.node or item.node
                self._failed |= dict.fromkeys(item.names, error)
            except NameError as error:
                if self._cause_of(error) is error:
                    raise
                self._failed |= dict.fromkeys(item.names, self._cause_of(error))
            finally:
                self.parts.pop()
        if root not in self._functions:
            raise self._failed.get(root) or UnsupportedPython(f"`{root}` is not registered")
        function = self._functions[root][0]
        for stream in self.streams:
            stream.seed(0)
        self._is_started = True
        self.evaluator.loops = self.loops
        heap = Heap.of((self.evaluator.module, *self.streams))
        self._is_pure = False
        try:
            self._variant(root, function, {})
        except NameError as error:
            raise self._cause_of(error) from None
        self._is_pure = heap is not None and heap.is_unchanged()
        for name in list(self._variants):
            if heap is not None and heap.is_unchanged():  # else the case may depend on when it is evaluated
                self._add_case_of_defaults(name, heap)
        return {name: self._definition(name, variants) for name, variants in self._variants.items()}

    def words(self) -> frozenset[str]:
        """Return the evaluated words that other functions may call as the Python does: with plain arguments."""
        if not self._is_pure or not self._is_started:
            return frozenset()
        states = {name for name, cases in self._variants.items() if any(len(each) > 1 for each in cases.values())}
        return frozenset(self.found.keys() - self._opaque - states - self._animations)

    def _cause_of(self, error: NameError) -> Exception:
        """Return the exception that ended the statement that defines the unbound name, or else the error itself."""
        return self._failed.get(str(error).partition("'")[2].partition("'")[0], error)

    # --- the helper API ----------------------------------------------------------------------------------------

    def _helpers(self) -> dict[str, Native]:
        functions: dict[str, Callable[..., Any]] = {
            "register": self._register, "register_animation": lambda text=None: self._register(text, is_animation=True),
            "library_call": self._library_call,
            "loop": self._loop,
            "concat_shapes": lambda *shapes: self.union(shapes),
        }  # fmt: skip
        functions["transform_shape"] = self._transform
        functions["primitive_call"] = self._primitive
        for name in _POSES:
            functions[name] = self._maker(name, "pose")
        for name in _BOXES:
            functions[name] = self._maker(name, "array")
        for name, helper in scene_helpers().items():
            functions[name] = self._modelling(name, _KINDS.get(helper.result, "any"))
        for name in relation_helpers():
            functions[name] = self._relation_named(name)
        functions[ASSERT_THAT] = self._declare
        return {name: Native(name, function) for name, function in functions.items()}

    def _modelling(self, name: str, kind: str) -> Callable[..., Residual]:
        """Return the function for solids, profiles or paths of a name, whose calls remain."""

        def make(*arguments: Any, **named: Any) -> Residual:
            result = self._residual(name, arguments, named, kind)
            result.primitives = (lambda: [result]) if kind == "shape" else None
            return result

        return make

    def _relation_named(self, name: str) -> Callable[..., Residual]:
        """Return the function for a relation: its call is a statement that remains, until ``assert_that`` takes it."""

        def state(*operands: Any, **options: Any) -> Residual:
            relation = self._residual(name, operands, options, "any")
            if self.parts:
                self.parts[-1].statements.append(("", relation.node))
            return relation

        return state

    def _declare(self, *relations: Any, **named: Any) -> None:
        """Leave declarations to the program."""
        if not self.parts:
            raise UnsupportedPython("`assert_that` about what is evaluated belongs into a registered function")
        nodes = {key: node_of(value) for key, value in named.items()}
        call = call_node(ASSERT_THAT, [node_of(each) for each in relations], nodes)
        taken = [each.node for each in relations if type(each) is Residual]
        statements = self.parts[-1].statements
        statements[:] = [each for each in statements if not any(each[1] is node for node in taken)]
        statements.append(("", call))

    def _maker(self, name: str, kind: str) -> Callable[..., Residual]:
        def make(*arguments: Any, **named: Any) -> Residual:
            given = [self._whole(each) if name in _BOXES else each for each in arguments]
            named = {key: self._whole(each) if name in _BOXES else each for key, each in named.items()}
            result = self._residual(name, given, named, kind)
            result.size = 3 if name in _BOXES else None
            return result

        return make

    def _residual(self, name: str, arguments: Sequence[Any], named: Mapping[str, Any], kind: str) -> Residual:
        nodes = {key: node_of(value) for key, value in named.items()}
        return Residual(call_node(name, [node_of(each) for each in arguments], nodes), kind, self)

    def _print(self, *values: Any, sep: Any = " ", end: Any = "\n", file: Any = None, **_: Any) -> None:
        """Leave a ``print`` to the program, of one text if its values are known."""
        if getattr(file, "path", "") == "sys.stderr":
            return
        is_known = not any(type(each) is Residual for each in values)
        text = [str(sep).join(map(str, values)) + str(end).removesuffix("\n")] if is_known else values
        self.parts[-1].statements.append(("", call_node("print", [node_of(each) for each in text])))

    def _loop(self, n: int, fn: Any) -> Residual:
        made = (
            self.loops.call(n, fn)
            if self.evaluator.loops is not None and (type(n) is int or has_kind(n, "int"))
            else None
        )
        if made is not None:
            return made
        return self.union([self.evaluator.call(fn, (i,), {}) for i in self.evaluator.iterate(range(n))])

    def _transform(self, shape: Any, pose: Any) -> Residual:
        inner = self._whole(shape)
        if is_identity(pose):
            return _kept(inner)
        moved = self._residual("transform_shape", (inner, pose), {}, "shape")
        if inner.primitives is not None:
            kept = _kept(inner)
            moved.primitives = lambda: self._moved(moved, kept, pose)
        return moved

    def extended(self, value: Residual, other: Any) -> Any:
        """Return ``value += other``; all names of a shape see what is added."""
        if not is_shape(value):
            return value + other
        made = self.union([_kept(value), *self._flat(other)])
        value.node, value.primitives, value.name = made.node, made.primitives, ""
        return value

    def method_of(self, shape: Residual, name: str) -> Any:
        """Return a method of a shape, else MISSING."""
        if name == "copy":
            return Native(name, lambda: _kept(shape))
        if name not in ("append", "extend"):
            return MISSING

        def add(other: Any) -> None:
            self.extended(shape, other)

        return Native(name, add)

    def _moved(self, moved: Residual, inner: Residual, pose: Any) -> list[Residual]:
        """Return the primitives of a shape that has been moved."""
        parts = inner.parts()
        return [moved] if len(parts) == 1 and parts[0] is inner else [self._transform(each, pose) for each in parts]

    def _primitive(self, *arguments: Any, **named: Any) -> Residual:
        primitive = self._residual("primitive_call", arguments, named, "shape")
        primitive.primitives = lambda: [primitive]
        return primitive

    def _whole(self, shape: Any) -> Residual:
        """Return a shape that may be given as a list of shapes."""
        if type(shape) is Residual and shape.kind in ("shape", "any"):
            return shape
        if isinstance(shape, (list, tuple)):
            return self.union(shape)
        raise UnsupportedPython(f"expected a shape, got {type_name(shape)}")

    def union(self, shapes: Sequence[Any]) -> Residual:
        parts = [each for shape in shapes for each in self._flat(shape)]
        joined = Residual(call_node("concat_shapes", [node_of(each) for each in parts]), "shape", self)
        if all(each.primitives is not None for each in parts):
            kept = [_kept(each) for each in parts]
            joined.primitives = lambda: [primitive for each in kept for primitive in each.parts()]
        return joined

    def _flat(self, shape: Any) -> Iterator[Residual]:
        if type(shape) is Residual and shape.kind in ("shape", "any"):
            yield shape
        elif isinstance(shape, (list, tuple, PythonGenerator)):
            for each in self.evaluator.iterate(shape):
                yield from self._flat(each)
        else:
            raise UnsupportedPython(f"expected a shape, got {type_name(shape)}")

    def _register(self, docstring: Any = None, *, is_animation: bool = False) -> Any:
        def register(function: Any, text: str = "") -> Any:
            name = function.name if type(function) is PythonFunction else getattr(function, "path", "")
            if not name.isidentifier() or keyword.iskeyword(name):
                raise UnsupportedPython("only functions of the program that have a name can be registered")
            self._functions[name] = function, text
            if is_animation:
                self._animations.add(name)
            return function

        if type(docstring) is PythonFunction:
            return register(docstring)
        return Native("register", lambda function: register(function, docstring or ""))

    def _library_call(self, func_name: str, /, **named: Any) -> Residual:
        name = self._find(func_name)
        if name is None and func_name in self._failed:  # its decorator ended with an error: it is no unknown word
            raise self._failed[func_name]
        if name is None or (name not in self._evaluated and all(map(_is_literal, named.values()))):
            nodes = {key: node_of(value) for key, value in named.items()}
            return self._ordered(call_node("library_call", [ast.Constant(func_name)], nodes))
        shown = self._variant(name, self._functions[name][0], named)
        return self._ordered(call_node("library_call", [ast.Constant(func_name)], shown))

    def _find(self, name: str) -> str | None:
        if name in self._functions:
            return name
        texts = {text: key for key, (_, text) in reversed(self._functions.items())}
        starts = {text.partition(";")[0].strip(): key for text, key in texts.items()}
        return texts.get(name) or starts.get(name)

    def _ordered(self, node: ast.expr) -> Residual:
        """Return the value of a call that may draw random numbers."""
        return self._stated(node, "shape", "part") if self.draws else Residual(node, "shape", self)

    def _stated(self, node: ast.expr, kind: str, prefix: str) -> Residual:
        """Return the value of an expression that is computed at this point of the function."""
        name = self.parts[-1].new_name(prefix)
        self.parts[-1].statements.append((name, node))
        return Residual(ast.Name(name, ast.Load()), kind, self)

    # --- random numbers ----------------------------------------------------------------------------------------

    def _add_draws(self, library: PythonLibrary) -> None:
        plain, arrays = library.modules["random"].names, library.modules["np"].names["random"].names
        for name in _DRAWS:
            plain[name] = Native(f"random.{name}", self._draw(f"random.{name}"))
        for name in _ARRAY_DRAWS:
            arrays[name] = Native(f"np.random.{name}", self._draw(f"np.random.{name}"))
        plain["seed"] = arrays["seed"] = Native("seed", self._seed)

    def _fix_draws(self, library: PythonLibrary) -> None:
        """Draw random numbers while the program is evaluated, as the paper's tool does."""
        plain, arrays = library.modules["random"].names, library.modules["np"].names["random"].names
        stream, array_stream = self.streams
        for name in METHODS[random.Random]:
            plain[name] = Native(f"random.{name}", limited_draw(name, getattr(stream, name)))
        for name in METHODS[np.random.RandomState]:
            arrays[name] = Native(f"np.random.{name}", limited_draw(name, getattr(array_stream, name)))

    def _seed(self, *rest: Any) -> None:
        if self._is_started:
            raise UnsupportedPython(
                "a seed inside a function is not supported here", "seed once, at the top of the program"
            )

    def _draw(self, path: str) -> Callable[..., Any]:
        """Return a function that leaves a draw of random numbers to the translated program."""
        method = path.rpartition(".")[2]

        def draw(*arguments: Any, **named: Any) -> Any:
            """Add the draw to the statements of the current function, and return its residual result."""
            nodes = {key: node_of(value) for key, value in named.items()}
            call = call_node(path, [node_of(each) for each in arguments], nodes)
            given = arguments[0] if arguments else named.get("a", named.get("seq", named.get("population")))
            if method in ("choice", "choices") and isinstance(given, (list, tuple, str)) and not len(given):
                raise IndexError("Cannot choose from an empty sequence")
            if method == "shuffle":
                return self._shuffle(path, arguments[0])
            kind = (
                _KINDS.get(method, "float") if method not in ("choice", "choices", "sample") else _kind_of_items(given)
            )
            numbers = self._stated(call, "number" if path == "np.random.choice" and kind != "any" else kind, "draw")
            shape = _drawn_shape(method, arguments, named) if path.startswith("np.") else ()
            if shape:
                items = np.empty(shape, dtype=object)
                for index in np.ndindex(shape):
                    items[index] = numbers[index[0] if len(index) == 1 else index]
                return items
            count = self._drawn(method, arguments, named)
            return numbers if count is None else [numbers[i] for i in range(count)]

        return draw

    @staticmethod
    def _drawn(method: str, arguments: tuple[Any, ...], named: Mapping[str, Any]) -> int | None:
        """Return the length of the list that a draw gives, None for a number."""
        if method not in ("sample", "choices"):
            return None
        count = int(named.get("k", arguments[1] if method == "sample" and len(arguments) > 1 else 1))
        if count > _MAX_DRAWN_NUMBERS:
            raise UnsupportedPython("this draw has too many numbers")
        return count

    def _shuffle(self, path: str, items: list[Any]) -> None:
        held = self._stated(node_of(list(items)), "any", "items")
        self.parts[-1].statements.append(("", call_node(path, [held.node])))
        items[:] = [held[i] for i in range(len(items))]

    # --- functions ---------------------------------------------------------------------------------------------

    def hold(self, value: Residual) -> Residual:
        """Return a residual value that is computed once, however often it is used."""
        if isinstance(value.node, ast.Name):
            return value
        if parameter_in(value.node) in self.parts[-1].root.parameters:
            return Residual(copy.deepcopy(value.node), value.kind, self)  # an item of a parameter
        current = self.parts[-1]
        home = self._names.parts.get(value.name)
        if home is not None and current.reaches(home) and home.values[value.name].node is value.node:
            return Residual(ast.Name(value.name, ast.Load()), value.kind, self)
        node = self._brought(value.node, current)
        if self.loops.is_conditional(value):
            return Residual(node if node is not value.node else copy.deepcopy(node), value.kind, self)
        part = current
        while part.loop is not None and part.outer is not None and id(value) in part.loop.reached:
            part = part.outer  # it is computed before the loop
        value.name = part.new_name("part" if is_shape(value) else "value")
        part.values[value.name] = Residual(value.node, value.kind, self, value.name)
        if node is not value.node:
            part.values[value.name].node = value.node = node
        return Residual(ast.Name(value.name, ast.Load()), value.kind, self)

    def _brought(self, node: ast.expr, part: Part) -> ast.expr:
        """Return an expression with values of other functions, or of loops that have ended, written out."""
        homes = self._names.parts
        foreign = {
            each.id
            for each in ast.walk(node)
            if isinstance(each, ast.Name) and each.id in homes and not part.reaches(homes[each.id])
        }
        return _Brought(foreign, homes).visit(copy.deepcopy(node)) if foreign else node

    def _variant(self, name: str, function: Any, named: dict[str, Any]) -> dict[str, ast.expr]:
        """Evaluate a registered function for some arguments; return the arguments that its callers pass."""
        shown: dict[str, ast.expr] = {}
        test: dict[str, ast.expr] = {}
        inner: dict[str, Any] = {}
        defaults = defaults_of(function)
        self._required.setdefault(name, {key: value for key, value in named.items() if key not in defaults})
        general = self._general(name, function, {**defaults, **named})
        self._opaque |= {name} if not all(map(_is_plain, named.values())) else set()
        part = Part(self._names, function=getattr(function, "node", None))
        for key, value in {**defaults, **named}.items():
            if type(value) is Residual or key in general or has_residual(value):
                node = as_argument(value) if key in general else node_of(value)
                inner[key] = self._parameter(name, function, key, value)
                part.parameters[key] = lengths_in(key, value)
            else:
                node = test[key] = self._literal(f"{name}.{key}", value)
            if key not in named:
                self._defaults.setdefault(name, {})[key] = node
                continue
            shown[key] = node
            inner.setdefault(key, value)
        self._shown.setdefault(name, set()).update(shown)
        self.parts.append(part)
        stand_ins = {key: value for key, value in inner.items() if type(value) is PythonObject and value.is_general}
        before = {key: list(value.fields.items()) for key, value in stand_ins.items()}
        try:
            self.loops.is_used |= bool(general)
            with self.loops.inside(function.node) if general else contextlib.nullcontext():
                part.result = self._result(name, self.evaluator.call(function, (), inner))
                changed = {key for key, value in stand_ins.items() if before[key] != list(value.fields.items())}
                if changed:  # which the caller has to see
                    raise self.loops.specialised(function.node, changed)
        finally:
            self.parts.pop()
        given = tuple((each, ast.dump(node)) for each, node in test.items()), tuple(sorted(part.parameters))
        variants = self._variants.setdefault(name, {}).setdefault(given, [])
        made = Variant(test, part)
        number = (
            next((i for i, each in enumerate(variants) if each.text == made.text), len(variants)) if variants else 0
        )
        if number == len(variants):
            variants.append(made)
        if number:  # the function depends on more than its arguments
            shown[_STATE] = ast.Constant(number)
        return shown

    def _general(self, name: str, function: Any, given: Mapping[str, Any]) -> set[str]:
        """Return the parameters of a function that are not specialised for their arguments: numbers and points."""
        if type(function) is not PythonFunction or not self.loops.may_keep(function.node) or not self._is_started:
            return set()
        kinds = {
            key: self.loops.kind_of_parameter(name, key, value, function.node)
            for key, value in given.items()
            if is_general(value) and key not in self.loops.special_of(function.node)
        }
        are_integers_specialised = self.loops.level_of(function.node) > 0
        return {key for key, kind in kinds.items() if kind != "int" or not are_integers_specialised}

    def _parameter(self, name: str, function: Any, key: str, value: Any) -> Any:
        """Return the residual value of a parameter: one, or a tuple of them for a tuple."""
        kind = self.loops.kind_of_parameter(name, key, value, getattr(function, "node", None))
        if type(kind) is dict:  # the kinds of the numbers in it, by their places
            return generalised(value, (), lambda path: Residual(part_of(key, path), kind[path], self))
        if isinstance(value, (tuple, list)):
            items = [Residual(part_of(key, (i,)), kind, self) for i in range(len(value))]
            return type(value)(items) if type(value) in (tuple, list) else tuple(items)
        return Residual(ast.Name(key, ast.Load()), kind, self)

    def _literal(self, place: str, value: Any) -> ast.expr:
        """Return a literal for an argument: the number of the object if it has none."""
        try:
            if not isinstance(value, np.ndarray):  # which does not compare as a whole
                return node_of(value)
        except UnsupportedPython:
            pass
        known = self._objects.setdefault(place, {})
        return ast.Constant(known.setdefault(_state(value), len(known)))

    def _result(self, name: str, value: Any) -> ast.expr:
        if name in self._animations:
            frames = [self._frame(self._whole(frame)) for frame in self.evaluator.iterate(value)]
            return ast.List(frames, ast.Load())  # becomes a comprehension if the frames are similar
        if value is None:
            raise UnsupportedPython(f"`{name}` returns no shape", "return a shape from every path of the function")
        return node_of(self._whole(list(value) if type(value) is PythonGenerator else value))

    def _frame(self, shape: Residual) -> ast.expr:
        """Return the frame of an animation, or the frames of a loop."""
        return shape.node.args[0] if self.loops.is_loop(shape) else node_of(shape)  # type: ignore[attr-defined]

    def _add_case_of_defaults(self, name: str, heap: Heap) -> None:
        """Evaluate a function for its defaults, which the program itself may never use, if that is possible.

        A case that fails, or that the evaluation has changed meanwhile, is left out: calling it is an error.
        """
        function = self._functions[name][0]
        if not defaults_of(function) or name in self._animations:
            return
        before = self._defaults.get(name, {}), self._shown[name], self._variants[name]
        cases = {given: list(variants) for given, variants in before[2].items()}
        self._defaults[name], self._shown[name] = {**before[0]}, {*before[1]}
        self._variants[name] = {given: list(variants) for given, variants in cases.items()}
        with self.loops.tried() as trial:
            self._variant(name, function, self._required[name])
        made = self._variants[name]
        is_as_before = heap.is_unchanged() and all(made[given] == variants for given, variants in cases.items())
        if trial.is_failed or not is_as_before:
            self._defaults[name], self._shown[name], self._variants[name] = before

    # --- what remains ------------------------------------------------------------------------------------------

    def _definition(self, name: str, variants_by_call: Mapping[Any, Sequence[Variant]]) -> ast.FunctionDef:
        function, text = self._functions[name]
        node: Any = next((item.node for item in self._items if getattr(item.node, "name", "") == name), function.node)
        given = [each.arg for each in (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs)]
        passed = {key for literal, rest in variants_by_call for key in (*(each for each, _ in literal), *rest)}
        known, shown = self._defaults.get(name, {}), self._shown.get(name, set())
        tests_of = [dict(literal) for literal, _ in variants_by_call]
        same = {key for key in tests_of[0] if all(each.get(key) == tests_of[0][key] for each in tests_of)}
        same = {key for key in same if key not in shown and f"{name}.{key}" in self._objects}
        passed -= same  # objects that no call names
        tested = {key for tests in tests_of for key in tests} & set(given) - same
        self.warnings += [fixed_parameter(name, key, self._text.span(node)) for key in sorted(tested)]
        names = [each for each in given if each in passed] + sorted(passed - set(given))
        has_states = any(len(variants) > 1 for variants in variants_by_call.values())
        if has_states and _STATE in names:
            raise UnsupportedPython(f"`{name}` depends on variables that change", f"rename its parameter `{_STATE}`")
        defaults: list[ast.expr] = [
            *(known[each] for each in names if each in known),
            *([ast.Constant(0)] * has_states),
        ]
        names.sort(key=lambda each: each in known)  # those without a default first
        parameters = [ast.arg(each) for each in (*names, *([_STATE] if has_states else ()))]
        arguments = ast.arguments([], parameters, None, [], [], None, defaults)
        body: list[ast.stmt] = []
        ordered = sorted(variants_by_call.values(), key=lambda each: -len(each[0].test))  # the most general last
        for variants in reversed(ordered):
            for number, variant in reversed(list(enumerate(variants))):
                test = {key: value for key, value in variant.test.items() if key not in same}
                test |= {_STATE: ast.Constant(number)} if has_states else {}
                tests: list[ast.expr] = [
                    ast.Compare(ast.Name(key, ast.Load()), [ast.Eq()], [value]) for key, value in test.items()
                ]
                statements = variant.statements
                both = ast.BoolOp(ast.And(), tests) if len(tests) > 1 else tests[0] if tests else None
                other = body or [self._unknown_case(name, node)]
                body = [ast.If(both, statements, other)] if both is not None else statements
        doc = ast.get_docstring(node) if isinstance(node, ast.FunctionDef) else None
        note = "Evaluated from Python; its objects are written as values."
        body = [ast.Expr(ast.Constant(f"{doc}\n\n{note}" if doc else note)), *body]
        decorator = "register_animation" if name in self._animations else "register"
        call = call_node(decorator, [ast.Constant(text)] if text else [])
        made = ast.FunctionDef(name, arguments, body, [call], None)
        if sum(1 for _ in ast.walk(made)) > MAX_NODES:
            raise UnsupportedPython(
                f"what remains of `{name}` is too long", "write its loops with `for` and plain lists"
            )
        for each in ast.walk(made):
            place(each, node)
        return made

    def _unknown_case(self, name: str, node: ast.AST) -> ast.Raise:
        """Return the error of a call of a function for arguments for which it has not been evaluated."""
        span = self._text.span(node)
        line = span.source.text.count("\n", 0, span.start) + 1
        text = f"`{name}` (line {line} of the Python) was evaluated for other arguments only"
        text += ": change them there, and translate that"
        return ast.Raise(call_node("ValueError", [ast.Constant(text)]), None)


class _Brought(ast.NodeTransformer):
    """Writes values of other functions out."""

    def __init__(self, foreign: set[str], homes: Mapping[str, Part]) -> None:
        self._foreign, self._homes = foreign, homes

    def visit_Name(self, node: ast.Name) -> ast.expr:
        home = self._homes[node.id] if node.id in self._foreign else None
        if home is None or node.id not in home.values:
            return node  # a draw: it is an error when the function is written
        inner = copy.deepcopy(home.values[node.id].node)
        self._foreign |= {each.id for each in ast.walk(inner) if isinstance(each, ast.Name) and each.id in home.values}
        return self.visit(inner)  # type: ignore[no-any-return]


def fixed_parameter(function: str, parameter: str, span: Span) -> Diagnostic:
    """Return the warning that a parameter of a word has no other values than those of the evaluation."""
    message = f"`{parameter}` of `{function}` has only the values for which this was evaluated; others are errors"
    hint = "write this with plain functions, loops and lists, so that it stays in the program"
    return Diagnostic("fixed-parameter", message, Span(span.source, span.start, span.start + 1), hint)


def defaults_of(function: Any) -> dict[str, Any]:
    """Return the defaults of the parameters of a function of the program."""
    if type(function) is not PythonFunction:
        return {}
    given = function.node.args
    names = [each.arg for each in (*given.posonlyargs, *given.args)]
    return dict(zip(names[len(names) - len(function.defaults) :], function.defaults)) | function.keyword_defaults


def _state(value: Any) -> str:
    """Describe an object with all that it contains, as it is now."""
    seen: dict[int, int] = {}

    def described(each: Any) -> str:
        if isinstance(each, (int, float, str, bool, bytes, type(None))):
            return repr(each)
        if id(each) in seen:
            return f"#{seen[id(each)]}"
        seen[id(each)] = len(seen)
        if type(each) is PythonObject:
            return f"{id(each.cls)}{described(each.fields)}"
        if isinstance(each, dict):
            return "{" + ",".join(f"{described(k)}:{described(v)}" for k, v in each.items()) + "}"
        if isinstance(each, (list, tuple, set, frozenset, deque)):
            return f"{type(each).__name__}({','.join(map(described, each))})"
        if isinstance(each, np.ndarray) and each.dtype != object:
            return f"{each.dtype}{each.tolist()}"
        return f"@{id(each)}"

    return described(value)


def _is_plain(value: Any) -> bool:
    """Return whether a value is passed to a word as it is."""
    if type(value) in (tuple, list):
        return all(map(_is_plain, value))
    return type(value) in (int, float, bool, str, type(None), Residual) or isinstance(value, (np.integer, np.floating))


def _is_literal(value: Any) -> bool:
    if type(value) is Residual:
        return True
    if isinstance(value, (ValueObject, PythonObject, TextMember, IntMember)):
        return False  # it has a class, which a literal has not
    try:
        node_of(value)
    except UnsupportedPython:
        return False
    return True
