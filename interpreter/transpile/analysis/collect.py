"""Detection of lists that are only built and then read; they become comprehensions and unions instead of mutable lists.

A list is *collected* if one block creates it, the following statements only append to it (also inside `for` and `if`),
and all reads come later. The items that a generator yields are collected in the same way.
"""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

from scenelang.interpreter.transpile.analysis.inference import (
    ARRAY,
    CHANGES,
    CONTAINERS,
    DRAWS,
    RECORD,
    AbstractType,
    Site,
    TypeFacts,
)
from scenelang.interpreter.transpile.analysis.liveness import Liveness
from scenelang.interpreter.transpile.analysis.python_text import child_nodes, walk_tree
from scenelang.interpreter.transpile.analysis.scopes import Function, PythonNames, PythonVariable, inner_blocks


@dataclass(eq=False, slots=True)
class Collection:
    """Collected list.

    Attributes
    ----------
    variable
        Variable of the list; a temporary one for a generator.
    start
        Statement that creates the list, or None for a generator.
    last
        Last statement of the block that adds to it.
    additions, adders
        Nodes and statements that add to it.
    is_union
        Whether it is a shape extended by ``concat_shapes``.
    """

    variable: PythonVariable
    start: ast.stmt | None
    last: ast.stmt
    additions: set[ast.AST] = field(default_factory=set)
    adders: set[ast.stmt] = field(default_factory=set)
    is_union: bool = False


@dataclass(eq=False)
class Collections:
    """All collections of a program, by the statement that creates the list and by generator.

    ``functional`` are statements that sort or shuffle a list that was just created, so that they can create a new list.
    """

    by_start: dict[ast.stmt, Collection] = field(default_factory=dict)
    by_generator: dict[Function, Collection] = field(default_factory=dict)
    additions: set[ast.AST] = field(default_factory=set)
    functional: set[ast.stmt] = field(default_factory=set)


def find_collections(names: PythonNames, liveness: Liveness) -> Collections:
    """Return the lists and generators of a program whose items are collected first and read later."""
    collections = Collections()
    finder = _Finder(names, liveness)
    for function in names.ordered:
        if isinstance(function.node, ast.Lambda):
            continue
        if function.is_generator:
            collection = finder.of_generator(function)
            if collection is not None:
                collections.by_generator[function] = collection
        for block in _blocks(function.body):
            for collection in finder.in_block(block):
                assert collection.start is not None
                collections.by_start[collection.start] = collection
        for block in _blocks(function.body):
            for statement, call in finder.functional(block):
                collections.functional.add(statement)
                collections.additions.add(call)
    _drop_entangled(collections)
    _drop_carried(collections, liveness)
    for collection in collections.by_start.values():
        collections.additions |= collection.additions
    return collections


Addition = tuple[ast.expr, bool]


def additions(statement: ast.stmt, variable: PythonVariable, names: PythonNames) -> list[Addition] | None:
    """Return the expressions that a statement adds to the list or union of ``variable``, each with whether it is
    spread.

    Returns None if the statement does not add to it.
    """
    if isinstance(statement, ast.Expr):
        call = statement.value
        if isinstance(call, ast.Yield) and variable.is_temporary and call.value is not None:
            return [(call.value, False)]
        if isinstance(call, ast.YieldFrom) and variable.is_temporary:
            return [(call.value, True)]
        if isinstance(call, ast.Call):
            return _list_additions(call, variable, names)
    if isinstance(statement, ast.AugAssign) and isinstance(statement.op, ast.Add):
        if isinstance(statement.target, ast.Name) and names.variables.get(statement.target) is variable:
            return [(statement.value, True)]
    return _union_additions(statement, variable, names)


def _list_additions(call: ast.Call, variable: PythonVariable, names: PythonNames) -> list[Addition] | None:
    """Return the additions of ``xs.append(a)`` or ``xs.extend(as)``."""
    func = call.func
    if not isinstance(func, ast.Attribute) or func.attr not in ("append", "extend") or call.keywords:
        return None
    if len(call.args) != 1 or isinstance(call.args[0], ast.Starred):
        return None
    if not isinstance(func.value, ast.Name) or names.variables.get(func.value) is not variable:
        return None
    return [(call.args[0], func.attr == "extend")]


def _union_additions(statement: ast.stmt, variable: PythonVariable, names: PythonNames) -> list[Addition] | None:
    """Return the additions of ``x = concat_shapes(x, a, *bs)``."""
    if not isinstance(statement, ast.Assign) or len(statement.targets) != 1:
        return None
    target, call = statement.targets[0], statement.value
    if names.variables.get(target) is not variable or not isinstance(call, ast.Call) or call.keywords:
        return None
    if not isinstance(call.func, ast.Name) or call.func.id != "concat_shapes" or call.func in names.variables:
        return None
    if len(call.args) < 2:
        return None
    first = call.args[0].value if isinstance(call.args[0], ast.Starred) else call.args[0]
    if names.variables.get(first) is not variable:
        return None
    return [(a.value, True) if isinstance(a, ast.Starred) else (a, False) for a in call.args[1:]]


class _Finder:
    def __init__(self, names: PythonNames, liveness: Liveness) -> None:
        self._names = names
        self._liveness = liveness
        self._contents: dict[ast.stmt, Counter[PythonVariable]] = {}

    def of_generator(self, function: Function) -> Collection | None:
        variable = PythonVariable("frames" if function.is_animation else "items", function, is_temporary=True)
        body = function.body
        adders = [s for s in body if self._adds(s, variable)]
        if not adders or any(_contains(s, (ast.Return, ast.Try, ast.With)) for s in body):
            return None
        collection = Collection(variable, None, adders[-1])
        if all(self._collect(s, collection) for s in adders):
            return collection
        return None

    def in_block(self, block: Sequence[ast.stmt]) -> Iterator[Collection]:
        mentions: dict[PythonVariable, list[ast.stmt]] = {}
        for statement in block:
            for variable in self._variables_in(statement):
                mentions.setdefault(variable, []).append(statement)
        for variable, statements in mentions.items():
            if len(statements) < 2 or not self._is_local(variable):
                continue
            for position, statement in enumerate(statements):
                if self._assigned_variable(statement) is variable and not additions(statement, variable, self._names):
                    segment = self._until_reassigned(statements[position + 1 :], variable)
                    collection = self._collection_from(statement, segment, variable)
                    if collection is not None:
                        yield collection

    def _collection_from(
        self, start: ast.stmt, segment: Sequence[ast.stmt], variable: PythonVariable
    ) -> Collection | None:
        """Return the collection that starts with ``start``.

        ``segment`` are the later statements that mention the list.
        """
        adders = [s for s in segment if self._adds(s, variable)]
        if not adders:
            return None
        collection = Collection(variable, start, adders[-1])
        last = segment.index(adders[-1])
        if any(s not in adders for s in segment[:last]):
            return None
        if not all(self._collect(s, collection) for s in adders) or not self._fits(start, collection):
            return None
        return collection

    def _until_reassigned(self, statements: Sequence[ast.stmt], variable: PythonVariable) -> Sequence[ast.stmt]:
        for position, statement in enumerate(statements):
            is_reassignment = isinstance(statement, ast.Assign) and self._assigned_variable(statement) is variable
            if is_reassignment and self._count(statement, variable) == 1:
                return statements[:position]
        return statements

    def _fits(self, start: ast.stmt, collection: Collection) -> bool:
        """Return whether the additions are all of one kind: ``append`` and similar for a list, ``concat_shapes`` for a
        shape."""
        unions = {s for s in collection.adders if isinstance(s, ast.Assign)}
        lists = {s for s in collection.adders if isinstance(s, (ast.Expr, ast.AugAssign))}
        value = start.value if isinstance(start, (ast.Assign, ast.AnnAssign)) else None
        collection.is_union = bool(unions)
        if unions:
            return not lists
        is_list = isinstance(value, ast.Call) and isinstance(value.func, ast.Name) and value.func.id == "list"
        return is_list or isinstance(value, (ast.List, ast.ListComp))

    def functional(self, block: Sequence[ast.stmt]) -> Iterator[tuple[ast.stmt, ast.Call]]:
        """Iterate over statements such as ``random.shuffle(xs)`` and ``xs.sort()`` on a list created in the same block
        that has not been used since."""
        created: dict[PythonVariable, int] = {}
        for position, statement in enumerate(block):
            call = statement.value if isinstance(statement, ast.Expr) else None
            if isinstance(call, ast.Call):
                variable = self._in_place(call)
                if variable in created and variable is not None:
                    between = block[created[variable] + 1 : position]
                    if not any(self._count(s, variable) for s in between) and self._count(statement, variable) == 1:
                        created[variable] = position
                        yield statement, call
                        continue
            new = self._new_list_variable(statement)
            if new is not None:
                created[new] = position

    def _in_place(self, call: ast.Call) -> PythonVariable | None:
        func = call.func
        if not isinstance(func, ast.Attribute):
            return None
        if func.attr in ("sort", "reverse") and isinstance(func.value, ast.Name):
            return self._names.variables.get(func.value)
        is_shuffle = ast.unparse(func) in ("random.shuffle", "np.random.shuffle", "numpy.random.shuffle")
        if is_shuffle and self._is_module(func) and len(call.args) == 1 and isinstance(call.args[0], ast.Name):
            return self._names.variables.get(call.args[0])
        return None

    def _is_module(self, func: ast.Attribute) -> bool:
        """Return whether the first name of ``a.b.c`` is a module rather than a variable of the program."""
        root: ast.expr = func
        while isinstance(root, ast.Attribute):
            root = root.value
        variable = self._names.variables.get(root)
        return variable is None or variable in self._names.imports

    def _new_list_variable(self, statement: ast.stmt) -> PythonVariable | None:
        """Return the variable that a statement assigns an unshared new list to, or None."""
        if not isinstance(statement, ast.Assign) or len(statement.targets) != 1:
            return None
        value, target = statement.value, statement.targets[0]
        is_new = isinstance(value, (ast.List, ast.ListComp)) or (
            isinstance(value, ast.Call) and isinstance(value.func, ast.Name) and value.func.id in ("list", "sorted")
        )
        variable = self._names.variables.get(target)
        if not is_new or variable is None or variable.is_captured or variable.is_assigned_elsewhere or variable.is_cell:
            return None
        return variable

    def _assigned_variable(self, statement: ast.stmt) -> PythonVariable | None:
        """Return the variable that a statement assigns, or None."""
        if isinstance(statement, ast.Assign) and len(statement.targets) == 1:
            target: ast.expr = statement.targets[0]
        elif isinstance(statement, ast.AnnAssign) and statement.value is not None:
            target = statement.target
        else:
            return None
        return self._names.variables.get(target) if isinstance(target, ast.Name) else None

    def _is_local(self, variable: PythonVariable) -> bool:
        """Return whether all uses of a variable are in its own function."""
        if variable.is_captured or variable.is_assigned_elsewhere:
            return False
        return all(isinstance(store, ast.Name) for store in variable.stores)

    def _variables_in(self, statement: ast.stmt) -> Counter[PythonVariable]:
        contents = self._contents.get(statement)
        if contents is None:
            variables = self._names.variables
            contents = self._contents[statement] = Counter(variables[n] for n in walk_tree(statement) if n in variables)
        return contents

    def _count(self, node: ast.AST, variable: PythonVariable) -> int:
        if isinstance(node, ast.stmt):
            return self._variables_in(node)[variable]
        return sum(1 for n in walk_tree(node) if self._names.variables.get(n) is variable)

    def _adds(self, statement: ast.stmt, variable: PythonVariable) -> bool:
        if additions(statement, variable, self._names):
            return True
        if not variable.is_temporary and not self._count(statement, variable):
            return False
        return any(self._adds(s, variable) for block in inner_blocks(statement) for s in block)

    def _collect(self, statement: ast.stmt, collection: Collection) -> bool:
        """Return whether a statement only adds to the list, in a way that a comprehension can express."""
        variable = collection.variable
        added = additions(statement, variable, self._names)
        if added is not None:
            if any(self._count(value, variable) for value, _ in added):
                return False
            node = statement.value if isinstance(statement, ast.Expr) else statement
            collection.additions.add(node)
            collection.adders.add(statement)
            return True
        if not self._adds(statement, variable):
            return not self._count(statement, variable)
        collection.adders.add(statement)
        if isinstance(statement, ast.If):
            if self._count(statement.test, variable) or self._leaks(statement, variable):
                return False
            return all(self._collect(s, collection) for s in [*statement.body, *statement.orelse])
        if isinstance(statement, ast.For):
            if self._count(statement.iter, variable) or statement.orelse or _exits_loop(statement.body):
                return False
            return all(self._collect(s, collection) for s in statement.body)
        return False

    def _leaks(self, statement: ast.If, own: PythonVariable) -> bool:
        """Return whether the branches assign other variables that are read after the ``if``."""
        after = self._liveness.after.get(statement, frozenset())
        for node in walk_tree(statement):
            variable = self._names.variables.get(node)
            if variable in after and isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
                if variable is not None and variable is not own and not variable.is_cell:
                    return True
        return False


def _drop_entangled(lists: Collections) -> None:
    """Drop collections that share an adding statement with another one; these lists remain mutable."""
    owners: dict[ast.stmt, list[Collection]] = {}
    for collection in [*lists.by_start.values(), *lists.by_generator.values()]:
        for adder in collection.adders:
            if isinstance(adder, (ast.For, ast.If)):
                owners.setdefault(adder, []).append(collection)
    for collections in owners.values():
        if len(collections) > 1:
            for collection in collections:
                if collection.start is not None:
                    lists.by_start.pop(collection.start, None)
                else:
                    lists.by_generator = {f: c for f, c in lists.by_generator.items() if c is not collection}


def _drop_carried(lists: Collections, liveness: Liveness) -> None:
    """Drop collections whose variable must outlive iterations of a loop that does not add to it.

    The variables of the other collections need not be cells.
    """
    by_variable: dict[PythonVariable, list[Collection]] = {}
    for collection in lists.by_start.values():
        by_variable.setdefault(collection.variable, []).append(collection)
    for variable, collections in by_variable.items():
        adders = {adder for collection in collections for adder in collection.adders}
        if not variable.is_cell:
            continue
        if liveness.carried.get(variable, set()) <= adders:
            variable.is_cell = False
            continue
        for collection in collections:
            assert collection.start is not None
            del lists.by_start[collection.start]


def _exits_loop(body: Sequence[ast.stmt]) -> bool:
    """Return whether a loop's body may break or return; a ``continue`` must end the branch of an ``if``."""
    for statement in body:
        if isinstance(statement, (ast.Break, ast.Return)):
            return True
        if isinstance(statement, (ast.For, ast.While)):
            if _contains(statement, (ast.Return,)):
                return True
            continue
        if isinstance(statement, (ast.Try, ast.With)) and _contains(statement, (ast.Return, ast.Break, ast.Continue)):
            return True
        if any(_exits_loop(block) for block in inner_blocks(statement)):
            return True
    return False


def _contains(statement: ast.stmt, kinds: tuple[type, ...]) -> bool:
    stack: list[ast.AST] = [statement]
    while stack:
        node = stack.pop()
        if isinstance(node, kinds):
            return True
        if not isinstance(node, (ast.FunctionDef, ast.Lambda)):
            stack.extend(child_nodes(node))
    return False


def _blocks(body: list[ast.stmt]) -> Iterator[list[ast.stmt]]:
    yield body
    for statement in body:
        for block in inner_blocks(statement):
            yield from _blocks(block)


# Side effects of expressions, which determine whether two expressions can be reordered.


_EMPTY: frozenset[PythonVariable] = frozenset()


@dataclass(frozen=True, slots=True)
class Effect:
    """Side effects of an expression.

    Attributes
    ----------
    draws
        Whether it draws random numbers.
    changes
        Whether it modifies containers.
    inspects
        Whether it reads containers that are modified somewhere.
    reads, writes
        Cells that it reads and writes.
    """

    draws: bool = False
    changes: bool = False
    inspects: bool = False
    reads: frozenset[PythonVariable] = _EMPTY
    writes: frozenset[PythonVariable] = _EMPTY

    def __or__(self, other: Effect) -> Effect:
        return Effect(
            self.draws or other.draws,
            self.changes or other.changes,
            self.inspects or other.inspects,
            self.reads | other.reads,
            self.writes | other.writes,
        )

    @property
    def has_effect(self) -> bool:
        """Whether there is any effect other than reads."""
        return self.draws or self.changes or bool(self.writes)

    def commutes(self, other: Effect) -> bool:
        """Return whether two expressions with these effects can be reordered."""
        if self.draws and other.draws:
            return False
        if (self.changes and (other.changes or other.inspects)) or (other.changes and self.inspects):
            return False
        return not (self.writes & (other.reads | other.writes) or other.writes & self.reads)


PURE = Effect()


class Effects:
    """Effects of the expressions of a program."""

    def __init__(self, names: PythonNames, facts: TypeFacts) -> None:
        self._names = names
        self._facts = facts
        self._cells: dict[Function, tuple[frozenset[PythonVariable], frozenset[PythonVariable]]] = {}

    def of(self, *nodes: ast.AST | None) -> Effect:
        """Return the effect of evaluating ``nodes``; functions defined in them count as called."""
        draws = changes = inspects = False
        reads: set[PythonVariable] = set()
        writes: set[PythonVariable] = set()
        for node in _walk(nodes):
            effect = self._facts.effect_nodes.get(node, 0)
            if type(node) is ast.Call or type(node) is ast.Attribute:
                for target in self._facts.callbacks.get(node, ()):
                    effect |= self._facts.effects.get(target, 0)
                    read, written = self._cells_of(target)
                    reads |= read
                    writes |= written
            draws |= bool(effect & DRAWS)
            changes |= bool(effect & CHANGES)
            if type(node) is ast.Name:
                variable = self._names.variables.get(node)
                if variable is not None and variable.is_cell:
                    (reads if type(node.ctx) is ast.Load else writes).add(variable)
                value = self._facts.types.get(node)
                if value is not None and value.kinds & (CONTAINERS | ARRAY | RECORD):
                    inspects |= bool(value.kinds & RECORD) or self._reaches_mutated(value)
        return Effect(draws, changes, inspects, frozenset(reads), frozenset(writes))

    def _reaches_mutated(self, value: AbstractType) -> bool:
        """Return whether a value is, or contains at any depth, a container that is modified somewhere."""
        seen: set[Site] = set()
        stack = value.sites
        while stack:
            site = stack.pop()
            if site in seen:
                continue
            seen.add(site)
            if site.is_mutated:
                return True
            stack += [*site.element.sites, *site.key.sites]
        return False

    def _cells_of(self, function: Function) -> tuple[frozenset[PythonVariable], frozenset[PythonVariable]]:
        """Return the cells of other functions that a call of ``function`` reads and writes, directly or through its
        callees."""
        known = self._cells.get(function)
        if known is not None:
            return known
        self._cells[function] = (_EMPTY, _EMPTY)
        reads: set[PythonVariable] = set()
        writes: set[PythonVariable] = set()
        for node in walk_tree(function.node):
            variable = self._names.variables.get(node)
            if variable is not None and variable.is_cell and variable.function is not function:
                is_load = isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load)
                (reads if is_load else writes).add(variable)
            if isinstance(node, ast.Call):
                for target in self._facts.callbacks.get(node, ()):
                    read, written = self._cells_of(target)
                    reads |= read
                    writes |= written
        self._cells[function] = (frozenset(reads), frozenset(writes))
        return self._cells[function]


def _walk(nodes: Iterable[ast.AST | None]) -> Iterable[ast.AST]:
    for node in nodes:
        if node is not None:
            yield from walk_tree(node)
