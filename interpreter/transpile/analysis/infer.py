"""Type inference: the possible kinds of every expression of the Python code.

The whole program is abstractly interpreted: flow-sensitive within a function, with the arguments of all call sites
joined, and with containers represented by their allocation sites. Functions are analysed repeatedly until a fixed point
is reached.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property
from types import MappingProxyType
from typing import Any, TypeAlias

from scenelang.interpreter.runtime.modelling_helpers import scene_helpers
from scenelang.interpreter.transpile.analysis.collect import Effects
from scenelang.interpreter.transpile.analysis.expressions import (
    assign,
    call_function,
    call_value,
    expression_type,
    infer_defaults,
    operation,
    target_type,
)
from scenelang.interpreter.transpile.analysis.inference import (
    ANYTHING,
    ARRAY,
    BOOL,
    DICT,
    FLOAT,
    FUNCTION,
    INT,
    LIST,
    NOTHING,
    NUMBERS,
    POSE,
    RECORD,
    SET,
    SHAPE,
    T_NONE,
    T_SHAPE,
    TUPLE,
    UNKNOWN,
    AbstractType,
    InferenceState,
    TypeFacts,
    annotated_type,
    join_all,
    merge,
    narrow,
)
from scenelang.interpreter.transpile.analysis.python_text import child_nodes, variable_of, walk_tree
from scenelang.interpreter.transpile.analysis.scopes import (
    COMPREHENSIONS,
    Function,
    LibraryPaths,
    PythonNames,
    PythonVariable,
    is_annotation,
)
from scenelang.interpreter.transpile.analysis.value_classes import (
    classes_compared_by_value,
    compares_fields,
    keys_in,
)

# Inference of a whole program.


def infer(
    names: PythonNames, paths: LibraryPaths, words: dict[str, Function], root: Function | None, additions: set[ast.AST]
) -> TypeFacts:
    """Infer the types of a program.

    Parameters
    ----------
    words
        Registered functions by the argument of ``library_call``.
    root
        Root of the scene, which is called without arguments.
    additions
        Nodes that add to collected lists, which do not count as mutations.
    """
    state = InferenceState(names, paths, words, additions, call_value)
    state.enqueue(names.module)
    _run(state)
    if root is not None:
        call_function(state, root, root.node, [], {})
    _run(state)
    for function in names.ordered:  # functions without call sites get their annotated types
        if function not in state.facts.reached:
            _assume_annotations(state, function)
            state.enqueue(function)
            _run(state)
    _propagate_effects(state)
    return state.facts


def _propagate_effects(state: InferenceState) -> None:
    effects, callees = state.facts.effects, state.callees
    changed = True
    while changed:
        changed = False
        for function, called in callees.items():
            total = effects.get(function, 0)
            for callee in called:
                total |= effects.get(callee, 0)
            if total != effects.get(function, 0):
                effects[function] = total
                changed = True


# Work list and functions.


def _run(state: InferenceState) -> None:
    while state.queue:
        function = state.queue.popleft()
        state.visits[function] = state.visits.get(function, 0) + 1
        state.facts.reached.add(function)
        _analyse(state, function)


def _analyse(state: InferenceState, function: Function) -> None:
    saved = state.function, state.env, state.exits
    state.function, state.exits = function, []
    state.env = {p.variable: state.facts.variables.get(p.variable, NOTHING) for p in function.parameters}
    node = function.node
    if isinstance(node, ast.Lambda):
        state.add_return(function, expression_type(state, node.body))
    else:
        _block(state, node.body)
        if state.env is not None and not isinstance(node, ast.Module) and not function.is_generator:
            state.add_return(function, T_NONE)
    state.function, state.env, state.exits = saved


def _assume_annotations(state: InferenceState, function: Function) -> None:
    for parameter in function.parameters:
        if parameter.kind in ("plain", "keyword"):
            known = annotated_type(parameter.annotation)
            if parameter.default is not None:
                known = known | state.facts.type(parameter.default)
            state.store(parameter.variable, known)


# Statements.


_MAX_NESTED_LOOPS = 5  # analyzed in order of execution: every level multiplies the work
_MAX_ITERATIONS = 8  # of the analysis of a loop's body; types that still grow are joined by ``store``


def _block(state: InferenceState, body: Sequence[ast.stmt]) -> None:
    for statement in body:
        if state.env is None:
            state.env = {}  # unreachable statements are analysed too
            for rest in body[body.index(statement) :]:
                _statement(state, rest)
            state.env = None
            return
        _statement(state, statement)


def _statement(state: InferenceState, node: ast.stmt) -> None:
    handler = _STATEMENTS.get(type(node))
    if handler is not None:
        handler(state, node)


def _expression_statement(state: InferenceState, node: ast.Expr) -> None:
    expression_type(state, node.value)


def _assign_statement(state: InferenceState, node: ast.Assign) -> None:
    if is_annotation(state.paths, node.value):
        return
    value = expression_type(state, node.value)
    for target in node.targets:
        assign(state, target, value)


def _annotated_assign(state: InferenceState, node: ast.AnnAssign) -> None:
    if node.value is not None:
        assign(state, node.target, expression_type(state, node.value))


def _augmented_assign(state: InferenceState, node: ast.AugAssign) -> None:
    value = expression_type(state, node.value)
    old = target_type(state, node.target)
    if isinstance(node.op, ast.Add) and old.kinds & LIST:
        state.mutate(old, state.elements(value), node=node)
        if value.only(SHAPE):
            old = old | T_SHAPE
        state.facts.types[node] = old
        assign(state, node.target, old)
        return
    result = operation(state, node, node.op, old, value)
    if old.kinds & ARRAY:
        state.mutate(old, state.elements(result) if old.only(ARRAY) else NOTHING, node=node)
        if old.only(ARRAY):  # modified in place
            result = old
    state.facts.types[node] = result
    assign(state, node.target, result)


def _delete(state: InferenceState, node: ast.Delete) -> None:
    for target in node.targets:
        if isinstance(target, ast.Subscript):
            expression_type(state, target.slice)
            state.mutate(expression_type(state, target.value), node=target)


def _return(state: InferenceState, node: ast.Return) -> None:
    value = expression_type(state, node.value) if node.value is not None else T_NONE
    if not state.function.is_generator:
        state.add_return(state.function, value)
    state.env = None


def _raise(state: InferenceState, node: ast.Raise) -> None:
    if node.exc is not None:
        expression_type(state, node.exc)
    state.env = None


def _break(state: InferenceState, node: ast.Break) -> None:
    if state.exits and state.env is not None:
        state.exits[-1].append(state.env)
    state.env = None


def _assert(state: InferenceState, node: ast.Assert) -> None:
    expression_type(state, node.test)
    narrow(state, node.test, True)


def _if(state: InferenceState, node: ast.If) -> None:
    expression_type(state, node.test)
    before = dict(state.env or {})
    narrow(state, node.test, True)
    _block(state, node.body)
    after_body = state.env
    state.env = before
    narrow(state, node.test, False)
    _block(state, node.orelse)
    state.env = merge(after_body, state.env)


def _for(state: InferenceState, node: ast.For) -> None:
    elements = state.elements(expression_type(state, node.iter))
    state.facts.types[node] = elements
    _loop(state, node, lambda: assign(state, node.target, elements))


def _while(state: InferenceState, node: ast.While) -> None:
    def test() -> None:
        expression_type(state, node.test)
        narrow(state, node.test, True)

    _loop(state, node, test)


def _loop(state: InferenceState, node: ast.For | ast.While, bind_head: object) -> None:
    assert callable(bind_head)
    if len(state.exits) >= _MAX_NESTED_LOOPS:  # flow-insensitive, since every level of nesting multiplies the work
        state.env = {}
        state.exits.append([])
        bind_head()
        _block(state, node.body)
        state.exits.pop()
        state.env = {}
        _block(state, node.orelse)
        return
    loop_env = dict(state.env or {})
    for _ in range(_MAX_ITERATIONS):
        state.env = dict(loop_env)
        state.exits.append([])
        bind_head()
        _block(state, node.body)
        ends = state.exits.pop()
        merged = dict(loop_env)
        for env in (state.env, *ends):
            merged = merge(merged, env) or merged
        if all(merged.get(v) is loop_env.get(v) for v in merged):
            break
        loop_env = merged
    state.env = loop_env
    _block(state, node.orelse)


def _with(state: InferenceState, node: ast.With) -> None:
    for item in node.items:
        expression_type(state, item.context_expr)
    _block(state, node.body)


def _try(state: InferenceState, node: ast.Try) -> None:
    before = dict(state.env or {})
    _block(state, node.body)
    _block(state, node.orelse)
    merged = state.env
    for handler in node.handlers:
        state.env = merge(dict(before), merged) or {}
        if handler.name and handler in state.names.variables:
            state.store(state.names.variables[handler], ANYTHING)
        _block(state, handler.body)
        merged = merge(merged, state.env)
    state.env = merged
    _block(state, node.finalbody)


def _function(state: InferenceState, node: ast.FunctionDef) -> None:
    function = state.names.functions[node]
    infer_defaults(state, function)
    if function.variable is not None:
        state.store(function.variable, AbstractType(FUNCTION, frozenset((function,))))


def _class(state: InferenceState, node: ast.ClassDef) -> None:
    record = state.names.classes.get(node)
    if record is None:
        return
    for name, default in record.fields:
        if default is not None:
            state.set_field(record, name, expression_type(state, default))
    for value in record.constants.values():
        expression_type(state, value)
    for method in record.methods.values():
        infer_defaults(state, method)
        if method.parameters and not method.is_static:
            state.store(method.parameters[0].variable, AbstractType(RECORD, frozenset((record,))))
    state.store(record.variable, AbstractType(FUNCTION, frozenset((record,))))


_STATEMENTS: Mapping[type[ast.stmt], Callable[[InferenceState, Any], None]] = MappingProxyType({
    ast.AnnAssign: _annotated_assign, ast.Assert: _assert, ast.Assign: _assign_statement,
    ast.AugAssign: _augmented_assign, ast.Break: _break, ast.ClassDef: _class, ast.Continue: _break,
    ast.Delete: _delete, ast.Expr: _expression_statement, ast.For: _for, ast.FunctionDef: _function, ast.If: _if,
    ast.Raise: _raise, ast.Return: _return, ast.Try: _try, ast.While: _while, ast.With: _with,
})  # fmt: skip


# What the translation would change without an error; such parts are evaluated.


_LAZY = ("map", "filter", "zip", "reversed", "enumerate", "iter", "itertools.chain", "itertools.product")
_LOOKED_AT = [
    "len",
    "sorted",
    "list",
    "set",
    "frozenset",
    "sum",
    "min",
    "max",
    "tuple",
    "any",
    "all",
    "enumerate",
    "dict",
    "zip",
    "print",
    "str",
    "isinstance",
    "concat_shapes",
    "transform_shape",
    "compute_shape_center",
    "compute_shape_min",
    "compute_shape_max",
    "compute_shape_sizes",
    "loop",
    "bool",
    "map",
    "attach",
    "align_with_min",
    "align_with_center",
    "numpy.array",
]
_Departure: TypeAlias = tuple[ast.AST, str]


def _changed_names(nodes: Iterable[ast.AST]) -> set[str]:
    """Return the variables whose values are changed in place: those before a method, or an index that is assigned."""
    names: set[str] = set()
    for node in nodes:
        is_method = isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)
        is_stored = isinstance(node, (ast.Attribute, ast.Subscript)) and not isinstance(node.ctx, ast.Load)
        variable = variable_of(node.func if isinstance(node, ast.Call) else node) if is_method or is_stored else None
        names |= {variable.id} if variable is not None else set()
    return names


class Departures:
    """Finds what Python does in place, by identity or late, and the translation does not."""

    def __init__(self, names: PythonNames, paths: LibraryPaths, facts: TypeFacts) -> None:
        self._names, self._paths, self._facts = names, paths, facts
        self._tree = names.module.node
        self._effects = Effects(names, facts)
        self._parents = {child: outer for outer in walk_tree(self._tree) for child in child_nodes(outer)}
        self._reads: dict[PythonVariable, list[ast.Name]] = {}
        self._updates: dict[PythonVariable, list[ast.AST]] = {}
        for node, variable in names.variables.items():
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
                self._reads.setdefault(variable, []).append(node)

    def find(self) -> list[_Departure]:
        """Return the places, and what is not supported there."""
        departures: list[_Departure] = []
        for node in walk_tree(self._tree):
            if isinstance(node, ast.AugAssign):
                departures += self._in_place(node)
            elif self._is_lazy(node):
                departures += self._lazy(node)
            elif isinstance(node, ast.Call):
                departures += self._call(node)
            elif isinstance(node, (ast.Compare, ast.Dict, ast.Set, ast.DictComp, ast.SetComp)):
                departures += self._compared(node)
            if isinstance(node, (ast.Assign, ast.For)):
                departures += self._view(node)
            if isinstance(node, ast.For):
                departures += self._interleaved(node)
            if isinstance(node, ast.expr) and self._facts.type(node).kinds == SET:
                departures += self._order_of_set(node)
        return departures + self._keys()

    def _interleaved(self, node: ast.For) -> list[_Departure]:
        """Find a loop over a generator of which one looks at what the other changes in between."""
        made = [each for each in walk_tree(node.iter) if isinstance(each, (ast.GeneratorExp, ast.Call))]
        calls = [each for each in made if isinstance(each, ast.Call)]
        functions = [f for each in calls for f in self._facts.targets.get(each, ()) if f.is_generator]
        if not functions and not any(isinstance(each, ast.GeneratorExp) for each in made):
            return []
        given = {n.id for n in walk_tree(node.iter) if isinstance(n, ast.Name)}
        inside = [each for f in functions for each in walk_tree(f.node)]
        parameters = {p.variable.name for f in functions for p in f.parameters}
        changed_inside = _changed_names(inside)
        changes = changed_inside - parameters | (given if changed_inside & parameters else set())
        looks = given | {n.id for n in inside if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Load)}
        body = walk_tree(*node.body)
        stored = {n.id for n in body if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
        own = {n.id for n in inside if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)} | parameters
        read = {n.id for n in body if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Load)}
        changed = (_changed_names(body) | stored) & (looks - own | given) - self._modules
        seen = read & changes - self._modules - stored
        return [(node.iter, "a generator that looks at what the loop over it changes")] if changed or seen else []

    @cached_property
    def _modules(self) -> set[str]:
        """Names of modules, which change nothing: imported ones, and those of the helper API."""
        imports = (each for each in walk_tree(self._tree) if isinstance(each, (ast.Import, ast.ImportFrom)))
        named = {(alias.asname or alias.name).partition(".")[0] for each in imports for alias in each.names}
        return named | {"math", "np", "numpy", "random"}

    # --- places ------------------------------------------------------------------------------------------------

    def _outer(self, node: ast.AST, kinds: tuple[type, ...]) -> ast.AST | None:
        outer = self._parents.get(node)
        while outer is not None and not isinstance(outer, kinds):
            outer = self._parents.get(outer)
        return outer

    def _statement(self, node: ast.AST) -> ast.AST | None:
        return node if isinstance(node, ast.stmt) else self._outer(node, (ast.stmt,))

    def _function(self, node: ast.AST) -> ast.AST | None:
        return self._outer(node, (ast.FunctionDef, ast.Lambda, ast.Module))

    def _loops(self, node: ast.AST) -> list[ast.AST]:
        """Return the loops and comprehensions whose turns evaluate a node, from inside out, in its function."""
        loops: list[ast.AST] = []
        outer = self._parents.get(node)
        while outer is not None and not isinstance(outer, (ast.FunctionDef, ast.Lambda, ast.Module)):
            is_head = isinstance(outer, ast.For) and node is outer.iter
            if isinstance(outer, COMPREHENSIONS):
                is_head = node is outer.generators[0]
            if isinstance(outer, (ast.For, ast.While, *COMPREHENSIONS)) and not is_head:
                loops.append(outer)
            node, outer = outer, self._parents.get(outer)
            if isinstance(node, ast.comprehension) and isinstance(outer, COMPREHENSIONS):
                continue
        return loops

    def _is_before(self, first: ast.AST, second: ast.AST, variable: PythonVariable) -> bool:
        """Return whether the value that ``first`` uses may be that which ``second`` changes after it."""
        if self._function(first) is not self._function(second):
            return True
        stores = [
            s for s in map(self._statement, variable.stores) if s is not None and not isinstance(s, ast.AugAssign)
        ]
        a, b = _place(first), _place(second)
        if a <= b:
            block = self._parents.get(self._statement(second) or second)
            return not any(a < _place(s) < b and self._parents.get(s) is block for s in stores)
        shared = [loop for loop in self._loops(first) if loop in self._loops(second)]
        return any(not any(loop in self._loops(s) and _place(s) < b for s in stores) for loop in shared)

    # --- changes in place --------------------------------------------------------------------------------------

    def _in_place(self, node: ast.AugAssign) -> list[_Departure]:
        kinds = self._facts.type(node.target).kinds
        is_shape = isinstance(node.op, ast.Add) and bool(kinds & SHAPE) and not kinds & (LIST | TUPLE)
        is_table = isinstance(node.op, (ast.BitOr, ast.BitAnd, ast.Sub, ast.BitXor)) and bool(kinds & (SET | DICT))
        if not is_shape and not is_table:
            return []
        what: list[_Departure] = [(node, "changing a value in place that has two names")]
        target = node.target
        if not isinstance(target, ast.Name):
            return what if is_table or isinstance(target, ast.Attribute) else []
        variable = self._names.variables.get(target)
        if variable is None:
            return []
        if any(not self._is_new(store, node, variable) for store in variable.stores):
            return what
        for read in self._reads.get(variable, ()):
            if not self._only_looks(read) and self._is_before(read, node, variable):
                return what
        return []

    def _is_new(self, store: ast.AST, node: ast.AugAssign, variable: PythonVariable) -> bool:
        """Return whether what a variable gets has no other name."""
        statement = self._statement(store)
        if isinstance(store, ast.arg):
            others = [s for s in map(self._statement, variable.stores) if isinstance(s, ast.Assign)]
            return any(_place(s) < _place(node) and self._parents.get(s) is self._function(s) for s in others)
        if isinstance(statement, ast.AugAssign):
            return True
        if not isinstance(statement, (ast.Assign, ast.AnnAssign)) or statement.value is None:
            return False
        if isinstance(statement, ast.Assign) and (len(statement.targets) > 1 or store is not statement.targets[0]):
            first = statement.targets[0]
            is_parallel = isinstance(first, ast.Tuple) and isinstance(statement.value, ast.Tuple)
            if len(statement.targets) == 1 and is_parallel:
                pairs = zip(first.elts, statement.value.elts)  # type: ignore[attr-defined]
                return any(target is store and self._is_made(value) for target, value in pairs)
            return len(statement.targets) == 1 and isinstance(statement.value, ast.Call)
        return self._is_made(statement.value)

    def _is_made(self, value: ast.expr) -> bool:
        if isinstance(value, ast.IfExp):
            return self._is_made(value.body) and self._is_made(value.orelse)
        if isinstance(value, ast.Name):
            variable = self._names.variables.get(value)
            return variable is not None and variable.reads == 1 and not variable.is_parameter and not self._loops(value)
        if isinstance(value, ast.Call):
            return not any(self._returns_old(target) for target in self._facts.targets.get(value, ()))
        return not isinstance(value, (ast.Subscript, ast.Attribute, ast.BoolOp, ast.NamedExpr))

    def _returns_old(self, function: Function) -> bool:
        """Return whether a function returns what its caller, or others, have a name for."""
        if function.is_registered:
            return False
        values = [function.node.body] if isinstance(function.node, ast.Lambda) else [
            n.value for n in walk_tree(function.node) if isinstance(n, ast.Return)
        ]  # fmt: skip
        for value in values:
            variable = self._names.variables.get(value) if isinstance(value, ast.Name) else None
            if variable is not None and (variable.function is not function or variable.is_parameter):
                return len(variable.stores) == 1
        return False

    def _only_looks(self, read: ast.AST) -> bool:
        """Return whether an expression uses a value without giving it another name."""
        outer = self._parents.get(read)
        if isinstance(outer, ast.keyword):
            outer = self._parents.get(outer)
        if isinstance(outer, ast.Call) and read is not outer.func:
            path = self._paths.of(outer.func) or ""
            return (
                path in _LOOKED_AT
                or path in scene_helpers()
                or (
                    isinstance(outer.func, ast.Attribute)
                    and outer.func.attr in ("update", "extend", "join", "issubset")
                )
            )
        if isinstance(outer, (ast.Dict, ast.List, ast.Tuple, ast.Set, ast.Assign, ast.AnnAssign, ast.Yield)):
            return False
        if isinstance(outer, (ast.IfExp, ast.BoolOp)) and not (isinstance(outer, ast.IfExp) and outer.test is read):
            return self._only_looks(outer)
        return not isinstance(outer, (ast.Lambda, ast.NamedExpr)) and not isinstance(self._function(read), ast.Lambda)

    # --- iterators ---------------------------------------------------------------------------------------------

    def _is_lazy(self, node: ast.AST) -> bool:
        if isinstance(node, ast.GeneratorExp):
            return True
        if not isinstance(node, ast.Call):
            return False
        if self._paths.of(node.func) in _LAZY:
            return True
        is_view = isinstance(node.func, ast.Attribute) and node.func.attr in ("keys", "values", "items")
        return is_view and not node.args and bool(self._facts.type(node.func.value).kinds & DICT)  # type: ignore[attr-defined]

    def _lazy(self, node: ast.AST) -> list[_Departure]:
        """Find an iterator that is not used up where it is made."""
        assert isinstance(node, ast.expr)
        outer = self._parents.get(node)
        is_view = isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)
        what: list[_Departure] = [
            (node, "a view of a table that changes" if is_view else "an iterator that is used later")
        ]
        if is_view and not any(site.is_mutated for site in self._facts.type(node.func.value).sites):  # type: ignore[attr-defined]
            return []
        own = self._effects.of(node)
        if isinstance(outer, (ast.Assign, ast.AnnAssign)):
            target = outer.targets[0] if isinstance(outer, ast.Assign) else outer.target
            if isinstance(target, (ast.Tuple, ast.List)):
                return []
            if not isinstance(target, ast.Name) or (isinstance(outer, ast.Assign) and len(outer.targets) > 1):
                return what
            variable = self._names.variables.get(target)
            return [] if variable is None or self._is_used_next(outer, node, variable) else what
        if isinstance(outer, ast.Call) and isinstance(outer.func, ast.Attribute) and node is not outer.func.value:
            if outer.func.attr in ("append", "insert", "add", "appendleft", "setdefault"):
                return what
        if isinstance(
            outer,
            (ast.NamedExpr, ast.Return, ast.Lambda, ast.Dict, ast.List, ast.Tuple, ast.Set, ast.IfExp, ast.BoolOp),
        ):
            return what if not is_view else []
        if isinstance(outer, ast.For):
            return what if own.draws and self._effects.of(*outer.body).draws else []
        if isinstance(outer, ast.comprehension):
            comprehension = self._parents.get(outer)
            rest = [n for n in child_nodes(comprehension) if n is not outer] if comprehension else []
            return what if own.draws and self._effects.of(*rest, *outer.ifs).draws else []
        if isinstance(outer, ast.keyword):
            outer = self._parents.get(outer)
        if isinstance(outer, ast.Call):
            if self._is_lazy(outer) and own.draws:
                others = [each for each in outer.args if each is not node]
                if self._effects.of(*others).draws:
                    return what
            if self._facts.type(outer.func).classes:  # a field
                return what
            for function in self._facts.targets.get(outer, ()):
                for parameter in function.parameters:
                    variable = parameter.variable
                    if isinstance(outer.func, ast.Name) and outer.func.id == "library_call":
                        break
                    reads = self._reads.get(variable, ())
                    place = outer.args.index(node) if node in outer.args else -1
                    plain = function.parameters[place] if 0 <= place < len(function.parameters) else parameter
                    if plain is parameter and (len(reads) != 1 or self._loops(reads[0]) or own.draws):
                        return what
        return []

    def _is_used_next(self, store: ast.stmt, node: ast.expr, variable: PythonVariable) -> bool:
        """Return whether an iterator is used once, after nothing that it could observe."""
        reads = self._reads.get(variable, [])
        if not reads:
            return True
        outer = self._parents.get(store)
        block = next((b for b in (getattr(outer, n, None) for n in ("body", "orelse")) if b and store in b), None)
        if len(reads) != 1 or len(variable.stores) != 1 or block is None:
            return False
        statement: ast.AST | None = reads[0]
        while statement is not None and statement not in block:
            statement = self._parents.get(statement)
        is_deeper = self._function(reads[0]) is not self._function(store) or len(self._loops(reads[0])) > len(
            self._loops(store)
        )
        if (
            statement is None
            or is_deeper
            or (not self._only_looks(reads[0]) and not isinstance(self._parents.get(reads[0]), (ast.Call, ast.Starred)))
        ):
            return False
        if self._facts.targets.get(self._parents.get(reads[0])):  # type: ignore[call-overload]
            return False
        if isinstance(statement, (ast.If, ast.While, ast.Try, ast.With)):
            return False
        between = block[block.index(store) + 1 : block.index(statement)]
        own, used = self._effects.of(node), {self._names.variables.get(n) for n in walk_tree(node)} - {None}
        for each in between:
            effect = self._effects.of(each)
            if (effect.has_effect and not effect.commutes(own)) or any(
                isinstance(n, ast.Name) and self._names.variables.get(n) in used
                and (not isinstance(n.ctx, ast.Load) or isinstance(self._parents.get(n), ast.Attribute))
                for n in walk_tree(each)
            ):  # fmt: skip
                return False
        return own.commutes(self._effects.of(statement))

    # --- identity and equality ---------------------------------------------------------------------------------

    def _call(self, node: ast.Call) -> list[_Departure]:
        """Find frozen sets that become items, and searches in which Python's equality differs from the language's."""
        if self._paths.of(node.func) == "frozenset" and node.args:
            outer = self._parents.get(node)
            # a set whose name is only looked at does not become an item
            is_name = isinstance(outer, (ast.Assign, ast.AnnAssign)) and all(
                self._only_looks(read) and not isinstance(self._parents.get(read), ast.Return)
                for variable in [self._names.variables.get(n) for n in walk_tree(outer) if n is not node]
                if variable is not None and any(s in walk_tree(outer) for s in variable.stores)
                for read in self._reads.get(variable, ())
                if not (isinstance(up := self._parents.get(read), ast.Compare) and up.left is read)
            )
            if not is_name and not (isinstance(outer, ast.Compare) and outer.left is not node):
                return [(node, "a `frozenset` as an item")]
        if isinstance(node.func, ast.Attribute) and node.func.attr in ("remove", "index", "count", "add"):
            owner = self._facts.type(node.func.value)
            item = self._facts.type(node.args[0]) if node.args else NOTHING
            elements = join_all([site.key if site.kind == DICT else site.element for site in owner.sites])
            if owner.kinds & (LIST | TUPLE | SET) and self._has_objects(elements | item):
                return [(node, "the identity of objects")]
            if owner.kinds & (LIST | TUPLE) and _mixes(elements | item):
                return [(node, "comparing numbers with Booleans")]
        return []

    def _compared(self, node: ast.expr) -> list[_Departure]:
        """Find comparisons and keys for which Python's equality differs from the language's."""
        if isinstance(node, ast.Compare):
            for op, left, right in zip(node.ops, [node.left, *node.comparators], node.comparators):
                types = self._facts.type(left), self._facts.type(right)
                if isinstance(op, (ast.Is, ast.IsNot)) and all(t.kinds & RECORD for t in types):
                    return [(node, "the identity of objects")]
                if isinstance(op, (ast.Eq, ast.NotEq)) and all(self._has_objects(t) for t in types):
                    return [(node, "the identity of objects")]
                items = join_all([s.key if s.kind == DICT else s.element for s in types[1].sites])
                if isinstance(op, (ast.In, ast.NotIn)) and _is_set_among_others(types[0], items):
                    return [(node, "comparing sets of different kinds")]
                if isinstance(op, (ast.Eq, ast.NotEq)) and len({bool(t.kinds & SET) for t in types}) > 1:
                    if all(t.kinds & (SET | TUPLE | RECORD) for t in types):
                        return [(node, "comparing sets of different kinds")]
                if isinstance(op, (ast.In, ast.NotIn)) and types[1].sites:
                    if self._has_objects(types[0]):
                        return [(node, "the identity of objects")]
                    if _mixes(items | types[0]):
                        return [(node, "comparing numbers with Booleans")]
            return []
        keys = join_all([site.key if site.kind == DICT else site.element for site in self._facts.type(node).sites])
        if self._has_objects(keys):
            return [(node, "the identity of objects")]
        return [(node, "keys that are numbers and Booleans")] if _mixes(keys) else []

    def _has_objects(self, value: AbstractType, depth: int = 3) -> bool:
        """Return whether a value is, or contains, an instance of a class whose instances are equal by identity."""
        if value.kinds & RECORD and any(not compares_fields(record) for record in value.classes):
            return True
        return depth > 0 and any(self._has_objects(site.element, depth - 1) for site in value.sites)

    def _order_of_set(self, node: ast.expr) -> list[_Departure]:
        """Find where the order of a set of numbers, or of tuples of these, matters: Python goes by their hashes."""
        items = join_all([site.element for site in self._facts.type(node).sites])
        parts = join_all([site.element for site in items.sites])
        if not items.only(NUMBERS | TUPLE) or (items.kinds & TUPLE and not parts.only(NUMBERS)):
            return []
        outer = self._parents.get(node)
        if isinstance(outer, ast.For):
            matters = node is outer.iter and self._makes_shapes(*outer.body)
        elif isinstance(outer, ast.comprehension):
            made = self._parents.get(outer)
            taker = self._parents.get(made) if made is not None else None
            is_kept = made is not None and not self._is_unordered(taker)
            matters = node is outer.iter and is_kept and self._makes_shapes(made)
        elif isinstance(outer, ast.Call) and node in outer.args:
            name = self._paths.of(outer.func)
            matters = name in _ORDERED_TAKERS and not self._is_unordered(self._parents.get(outer))
        elif isinstance(outer, ast.Starred):
            display = self._parents.get(outer)
            matters = not isinstance(display, ast.Set) and not self._is_unordered(self._parents.get(display or outer))
        else:
            pop = self._parents.get(outer) if isinstance(outer, ast.Attribute) and outer.attr == "pop" else None
            matters = isinstance(pop, ast.Call) and not pop.args
        return [(node, "the order of a set of numbers")] if matters else []

    def _makes_shapes(self, *nodes: ast.AST | None) -> bool:
        """Return whether a part makes shapes, whose order is seen; that of what a search looks at is not."""
        parts = walk_tree(*(each for each in nodes if each is not None))
        return any(isinstance(each, ast.expr) and self._facts.type(each).kinds & SHAPE for each in parts)

    def _is_unordered(self, taker: ast.AST | None) -> bool:
        """Return whether a call gives the same for items in any order."""
        return isinstance(taker, ast.Call) and self._paths.of(taker.func) in _UNORDERED_TAKERS

    def _keys(self) -> list[_Departure]:
        """Find the sets and tables with members or keys that the language compares by identity, and Python by value."""
        departures: list[_Departure] = []
        for node, keys in keys_in(self._facts):
            classes = classes_compared_by_value(keys)
            what = "a `frozenset`" if keys.kinds & SET else f"an instance of `{classes[0].name}`" if classes else ""
            if what and (not departures or departures[-1][0] is not node):
                departures.append((node, f"{what} as the key of a table or the member of a set"))
        return departures

    # --- views of arrays ---------------------------------------------------------------------------------------

    def _view(self, node: ast.Assign | ast.For) -> list[_Departure]:
        """Find a name for a part of an array that is changed in place."""
        target = node.targets[0] if isinstance(node, ast.Assign) else node.target
        if not isinstance(target, ast.Name) or (variable := self._names.variables.get(target)) is None:
            return []
        base = node.iter if isinstance(node, ast.For) else self._viewed(node.value)
        if base is None or not self._facts.type(base).kinds & (ARRAY | POSE):
            return []
        part = self._facts.type(node) if isinstance(node, ast.For) else self._facts.type(node.value)
        places = self._changes(variable)
        if part.kinds and not part.kinds & (ARRAY | POSE | UNKNOWN) and not self._is_deep(base):
            places = [each for each in places if not _is_of_name(each)]  # else it may be a number
            if not places:
                return []
        if isinstance(node, ast.Assign) and isinstance(base, ast.Name) and (own := self._names.variables.get(base)):
            last = max((_place(read) for read in self._reads.get(variable, ())), default=(0, 0))
            places += [each for each in self._changes(own) if _place(node) < _place(each) < last]
        return [(node, "changing a part of an array by another name")] if places else []

    def _is_deep(self, base: ast.expr) -> bool:
        for site in self._facts.type(base).sites:
            made = site.node
            path = (self._paths.of(made.func) or "") if isinstance(made, ast.Call) else ""
            if isinstance(made, ast.Call) and isinstance(made.func, ast.Attribute) and made.func.attr == "reshape":
                return True
            if isinstance(made, ast.Call) and path.startswith("numpy.") and made.args:
                if isinstance(made.args[0], ast.Tuple) and path.rpartition(".")[2] in (
                    "zeros",
                    "ones",
                    "full",
                    "empty",
                ):
                    return len(made.args[0].elts) > 1
            if site.element.kinds & (ARRAY | LIST | TUPLE):
                return True
        return False

    def _viewed(self, node: ast.expr) -> ast.expr | None:
        if isinstance(node, ast.Subscript):
            if self._facts.type(node.slice).kinds & (ARRAY | LIST):
                return None
            return self._viewed(node.value) or node.value
        if isinstance(node, ast.Attribute) and node.attr == "T":
            return node.value
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
            return node.func.value if node.func.attr in ("reshape", "ravel", "transpose", "view") else None
        return None

    def _changes(self, variable: PythonVariable) -> list[ast.AST]:
        """Return the statements that change the array of a variable in place."""
        if not self._updates:
            for node in walk_tree(self._tree):
                targets = node.targets if isinstance(node, ast.Assign) else []
                is_method = isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)
                if isinstance(node, ast.AugAssign):
                    targets = [node.target]
                elif is_method and node.func.attr in ("fill", "sort"):  # type: ignore[attr-defined]
                    targets = [ast.Subscript(node.func.value, ast.Slice())]  # type: ignore[attr-defined]
                for target in targets:
                    inner = target
                    while isinstance(inner, ast.Subscript):
                        inner = inner.value
                    changed = self._names.variables.get(inner)
                    if changed is not None and (inner is not target or isinstance(node, ast.AugAssign)):
                        self._updates.setdefault(changed, []).append(node)
        return list(self._updates.get(variable, ()))


def _place(node: ast.AST) -> tuple[int, int]:
    return getattr(node, "lineno", 0), getattr(node, "col_offset", 0)


def _is_of_name(node: ast.AST) -> bool:
    """Return whether a change in place is one of a whole variable, ``x += 1``."""
    return isinstance(node, ast.AugAssign) and isinstance(node.target, ast.Name)


_UNORDERED_TAKERS = ("sorted", "sum", "min", "max", "any", "all", "len", "set", "frozenset")
_ORDERED_TAKERS = ("list", "tuple", "enumerate", "zip", "map", "iter", "next", "filter", "dict")


def _is_set_among_others(value: AbstractType, items: AbstractType) -> bool:
    """Return whether a set is looked for among values of other kinds, or the other way round."""
    return bool(items.kinds) and bool(value.kinds & SET) is not bool(items.kinds & SET)


def _mixes(value: AbstractType) -> bool:
    """Return whether values that are equal in Python only, such as 1 and True, may be among some."""
    return bool(value.kinds & BOOL) and bool(value.kinds & (INT | FLOAT))
