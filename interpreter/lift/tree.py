"""Mutable tree of a program with its comments, and what the rules of lifting ask about it: names, scopes, effects."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeAlias

from scenelang.grammar.datum import ArrayDatum, Atom, Datum, Keyword, ListDatum, Source, Span, Symbol, print_datum
from scenelang.grammar.layout import Row, Trivia
from scenelang.grammar.reader import read
from scenelang.interpreter.runtime.types import STD

# Levels of nesting of a form: the rules recurse several Python frames per level. The examples and the corpus have at
# most 13; a program with more than this is left as it is.
_MAX_DEPTH = 150
NO_COMMENTS = Trivia()


class CodeTree:
    """Datum that can be changed in place. ``items`` is None for an atom; ``tail`` is that of an improper list."""

    __slots__ = ("is_array", "items", "span", "spelling", "tail", "trivia", "value")

    def __init__(self, items: list[CodeTree] | None, value: Any, span: Span, is_array: bool = False) -> None:
        self.items, self.value, self.span, self.is_array = items, value, span, is_array
        self.tail: CodeTree | None = None
        self.trivia = NO_COMMENTS
        self.spelling: str | None = None

    @property
    def parts(self) -> Sequence[CodeTree]:
        """The direct children."""
        if self.items is None:
            return ()
        return self.items if self.tail is None else [*self.items, self.tail]

    @property
    def head(self) -> str | None:
        """The symbol that a list begins with."""
        if not self.items or self.is_array:
            return None
        first = self.items[0].value
        return str(first) if type(first) is Symbol else None

    @property
    def name(self) -> str | None:
        """The name, if the node is a symbol."""
        return str(self.value) if type(self.value) is Symbol else None

    @property
    def is_number(self) -> bool:
        return self.items is None and type(self.value) in (int, float)

    @property
    def operands(self) -> list[CodeTree]:
        return self.items[1:] if self.items else []

    def become(self, other: CodeTree) -> None:
        """Take the contents of another node, keeping the comments of both."""
        trivia = joined(self.trivia, other.trivia)
        self.items, self.value, self.tail = other.items, other.value, other.tail
        self.is_array, self.spelling, self.span = other.is_array, other.spelling, other.span
        self.trivia = trivia


def joined(outer: Trivia, inner: Trivia) -> Trivia:
    """Return the comments of a node and of the one that replaces it or is put before it."""
    if inner is NO_COMMENTS:
        return outer
    if outer is NO_COMMENTS:
        return inner
    after, before = outer.after or inner.after, (*outer.before, *inner.before)
    if outer.after and inner.after:
        before = (*before, inner.after)
    return replace(
        outer,
        before=before,
        after=after,
        blank=outer.blank or inner.blank,
        end=(*inner.end, *outer.end),
        opening=outer.opening or inner.opening,
        closing=outer.closing or inner.closing,
        lead=outer.lead + inner.lead,
        trail=inner.trail + outer.trail,
    )


def comments_of(node: CodeTree) -> tuple[Row, ...]:
    """Return all comments in and around a node, as lines of their own."""
    comments: list[Row] = []
    for inner in walk(node):
        own = inner.trivia
        if own is not NO_COMMENTS:
            rows = (*own.before, own.lead.strip(), own.opening, own.after, own.closing, own.trail.strip(), *own.end)
            comments += [row for row in rows if row]
    return tuple(comments)


# Construction.


def symbol(name: str, span: Span) -> CodeTree:
    return CodeTree(None, Symbol(name), span)


def atom(value: Any, span: Span) -> CodeTree:
    return CodeTree(None, value, span)


def form(head: str, *items: CodeTree, span: Span) -> CodeTree:
    return CodeTree([symbol(head, span), *items], None, span)


def array(items: Iterable[CodeTree], span: Span) -> CodeTree:
    return CodeTree(list(items), None, span, is_array=True)


def listed(items: Iterable[CodeTree], span: Span) -> CodeTree:
    return CodeTree(list(items), None, span)


def keyword(name: str, span: Span) -> CodeTree:
    return CodeTree(None, Keyword(name), span)


def copied(node: CodeTree, comments: bool = False) -> CodeTree:
    """Return a copy, with or without comments."""
    items = [copied(item, comments) for item in node.items] if node.items is not None else None
    new = CodeTree(items, node.value, node.span, node.is_array)
    new.spelling = node.spelling
    if comments:
        new.trivia = node.trivia
    if node.tail is not None:
        new.tail = copied(node.tail, comments)
    return new


# Conversion.


def depth_exceeds(datum: Datum, limit: int = _MAX_DEPTH) -> bool:
    """Return whether a datum is nested too deeply for functions that recurse."""
    level: list[Any] = [datum]
    for _ in range(limit):
        level = [part for one in level if not isinstance(one, Atom) for part in _parts_of(one)]
        if not level:
            return False
    return True


def _parts_of(datum: Any) -> Iterable[Any]:
    return datum.items if getattr(datum, "tail", None) is None else (*datum.items, datum.tail)


def node_of(datum: Datum, trivia: Mapping[int, Trivia], spelling: Mapping[int, str]) -> CodeTree:
    """Return the tree of a datum; ``trivia`` and ``spelling`` are by ``id(datum)``."""
    if isinstance(datum, Atom):
        node = CodeTree(None, datum.value, datum.span)
        node.spelling = spelling.get(id(datum))
        if datum.value is None and node.spelling is not None and node.spelling.startswith('"'):
            node.value = _string(node.spelling)  # the concrete syntax tree does not decode strings
    else:
        node = CodeTree([node_of(item, trivia, spelling) for item in datum.items], None, datum.span)
        node.is_array = isinstance(datum, ArrayDatum)
        if isinstance(datum, ListDatum) and datum.tail is not None:
            node.tail = node_of(datum.tail, trivia, spelling)
    own = trivia.get(id(datum))
    if own is not None:
        node.trivia = own
    return node


def _string(spelling: str) -> str:
    if "\\" not in spelling:
        return spelling[1:-1]
    (datum,) = read(Source("<string>", spelling)).forms
    return str(datum.value) if isinstance(datum, Atom) else spelling


def datum_of(node: CodeTree, trivia: dict[int, Trivia], spelling: dict[int, str]) -> Datum:
    """Return the datum of a tree, and record its comments and spellings by ``id(datum)``."""
    datum: Datum
    if node.items is None:
        datum = Atom(node.value, node.span)
        spelling.pop(id(datum), None)  # of another datum that is gone
        if node.spelling is not None:
            spelling[id(datum)] = node.spelling
    else:
        items = tuple([datum_of(item, trivia, spelling) for item in node.items])
        tail = datum_of(node.tail, trivia, spelling) if node.tail is not None else None
        datum = ArrayDatum(items, node.span) if node.is_array else ListDatum(items, tail, node.span)
    trivia.pop(id(datum), None)
    if node.trivia is not NO_COMMENTS:
        trivia[id(datum)] = node.trivia
    return datum


# Questions.


def walk(node: CodeTree) -> Iterator[CodeTree]:
    """Iterate over a node and all below it, in the order of the text."""
    stack = [node]
    while stack:
        one = stack.pop()
        yield one
        if one.items is not None:
            stack.extend(reversed(one.parts))


def code(node: CodeTree) -> Iterator[CodeTree]:
    """Iterate over a node and all below it that is not quoted."""
    stack = [node]
    pop, extend = stack.pop, stack.extend
    while stack:
        one = pop()
        yield one
        items = one.items
        if items:
            first = items[0].value
            if type(first) is not Symbol or first != "quote" or one.is_array:
                extend(reversed(items) if one.tail is None else (one.tail, *reversed(items)))


def expressions(node: CodeTree) -> Iterator[CodeTree]:
    """Iterate over an expression or definition and all expressions in it, which patterns and parameters are not."""
    stack = [node]
    while stack:
        one = stack.pop()
        yield one
        if one.items:
            stack.extend(reversed(list(_subexpressions(one))))


def _subexpressions(node: CodeTree) -> Iterator[CodeTree]:
    """Yield the expressions directly inside a form, without the patterns and parameters that it binds."""
    head, items = node.head or "", node.items or []
    if head == "quote" or len(items) < 2:
        if head != "quote":
            yield from items
    elif head == "lambda" or (head == "define" and items[1].items is not None):
        yield from _defaults(items[1])
        yield from items[2:]
    elif head in ("define", "define-values", "set!", "let/ec", "param", "bind"):
        yield from items[2:]
    elif head == "define-record":
        yield from _defaults(items[1])
    elif head == "guard":
        yield from _clauses(items[1].items or [])
        yield from items[2:]
    elif head == "cond":
        yield from _clauses(items)
    elif head == "case":
        yield items[1]
        yield from _clauses([items[0], *(listed(one.items[1:], one.span) for one in items[2:] if one.items)])
    elif head.startswith("let") or (head.startswith("for") and head != "for-each") or head == "do":
        start = body_start(node) or 2
        for group in items[1:start]:
            clauses = group.items or [group]
            for before, clause in zip([None, *clauses], clauses):
                if before is not None and type(before.value) is Keyword:
                    yield clause  # the test after `:when`, which binds nothing
                else:
                    yield from clause.items[1:] if clause.items else [clause] if clause.name is None else []
        yield from items[start:]
    else:
        yield from items


def _defaults(parameters: CodeTree) -> Iterator[CodeTree]:
    for one in parameters.items or ():
        if one.items:
            yield from one.items[1:]


def _clauses(items: Sequence[CodeTree]) -> Iterator[CodeTree]:
    for clause in items[1:]:
        yield from (one for one in clause.items or () if one.name not in ("else", "=>"))


def size(node: CodeTree) -> int:
    """Return the number of nodes: atoms, lists and arrays."""
    return sum(1 for _ in walk(node))


def names(node: CodeTree) -> Counter[str]:
    """Return how often each symbol occurs outside quoted data."""
    symbols: list[str] = [one.value for one in code(node) if type(one.value) is Symbol]
    return Counter(symbols)  # a Symbol hashes and compares like its name


def same(a: CodeTree, b: CodeTree) -> bool:
    """Return whether two nodes are equal, their comments aside."""
    if a.items is None or b.items is None:
        return a.items is b.items and type(a.value) is type(b.value) and a.value == b.value
    if a.is_array is not b.is_array or len(a.items) != len(b.items) or (a.tail is None) is not (b.tail is None):
        return False
    return all(map(same, a.parts, b.parts))


def is_constant(node: CodeTree) -> bool:
    """Return whether a node is a literal: a number, text, keyword, quoted datum, or array of these."""
    if node.items is None:
        return type(node.value) is not Symbol
    if node.is_array:
        return all(map(is_constant, node.items))
    return node.head == "quote"


def bound_names(node: CodeTree) -> Iterator[str]:
    """Iterate over the names that a form binds for what is inside it, and those that its body defines."""
    yield from own_bindings(node)
    for item in node.items or ():
        if item.items:
            yield from defined_names(item)


def own_bindings(node: CodeTree) -> Iterator[str]:
    """Iterate over the names of parameters and bindings of a form."""
    head, items = node.head, node.items or []
    if head is None:
        return
    if head in ("lambda", "let/ec") and len(items) > 1:
        yield from _parameters(items[1])
    elif head in ("define", "define-macro") and len(items) > 1 and items[1].items is not None:
        yield from _parameters(items[1], 1)
    elif (head.startswith(("let", "for")) or head == "do") and len(items) > 1:
        bindings = items[1]
        if bindings.name is not None:  # a named loop
            yield bindings.name
            bindings = items[2] if len(items) > 2 else bindings
        groups = [bindings, *(items[2:3] if head.endswith("/fold") else [])]
        for binding in (one for group in groups for one in group.items or ()):
            if binding.items:
                yield from _pattern(binding.items[0])
    elif head == "guard" and len(items) > 1 and items[1].items:
        yield from _pattern(items[1].items[0])


def _parameters(node: CodeTree, first: int = 0) -> Iterator[str]:
    for item in [node] if node.items is None else [*node.items[first:], *([node.tail] if node.tail else [])]:
        target = item.items[0] if item.items else item
        if type(target.value) in (Symbol, Keyword):
            yield str(target.value).partition("::")[0]


def _pattern(node: CodeTree) -> Iterator[str]:
    yield from (str(one.value) for one in walk(node) if type(one.value) is Symbol)


def defined_names(statement: CodeTree) -> Iterator[str]:
    """Iterate over the names that a definition defines in its body."""
    head, items = statement.head, statement.items or []
    if len(items) < 2:
        return
    if head in ("define", "define-syntax", "define-macro", "param"):
        target = items[1].items[0] if items[1].items else items[1]
        if target.name is not None:
            yield target.name
    elif head == "define-values":
        yield from _pattern(items[1])
    elif head == "define-record" and items[1].name is not None:
        yield from _record_names(items)
    elif head == "begin":
        for item in items[1:]:
            yield from defined_names(item)


def _record_names(items: Sequence[CodeTree]) -> Iterator[str]:
    stem = str(items[1].value)
    yield from (stem, f"{stem}?")
    for item in items[2:]:
        target = item.items[0] if item.items else item
        name = str(target.value).partition("::")[0]
        yield from (f"{stem}-{name}", f"set-{stem}-{name}!")


def body_start(node: CodeTree) -> int | None:
    """Return the index of the first statement of a form's body, or None if the form has no body."""
    head, items = node.head, node.items or []
    if head is None:
        return None
    is_function = head == "define" and len(items) > 2 and items[1].items is not None
    start = None
    if is_function or head in ("lambda", "when", "unless", "let/ec", "guard"):
        start = 2
    elif head.startswith("let") and len(items) > 1:
        start = 3 if items[1].name is not None else 2
    elif head.startswith("for") and head != "for-each":
        start = 3 if head.endswith("/fold") else 2
    return start if start is not None and len(items) > start else None


def bodies(node: CodeTree) -> Iterator[tuple[CodeTree, int]]:
    """Iterate over all forms with a body, inner ones first, and where it starts. Clauses of ``cond`` count as forms."""
    placed: list[tuple[CodeTree, int]] = []
    for one in code(node):
        start = body_start(one)
        if start is not None:
            placed.append((one, start))
        if one.head == "cond":
            placed += [(clause, 1) for clause in one.operands if clause.items and len(clause.items) > 1]
    return reversed(placed)


# SideEffects.


DRAWS = frozenset((
    *("uniform", "normal", "randint", "rand", "randn", "choice", "shuffle", "permutation", "random", "random-state"),
    *("py-random", "py-uniform", "py-gauss", "py-randint", "py-randrange", "py-choice", "py-choices", "py-sample"),
    *("py-shuffle", "jitter", "scatter"),
))  # fmt: skip
_HIGHER_ORDER = frozenset((
    *("map", "for-each", "apply", "filter", "filter-map", "append-map", "remove", "partition", "find", "list-index"),
    *("any", "every", "fold", "fold-left", "fold-right", "reduce", "update!", "sort", "min-of", "max-of", "array-map"),
    *("map-parts", "union-loop", "ring", "grid", "scatter"),
))  # fmt: skip
_ACTS = frozenset(["print", "error", "raise", "gensym", "assert", "assertion-failed", "let/ec"])
ANY = "!"  # changes of data, prints, and what is not known


@dataclass(frozen=True, slots=True)
class SideEffects:
    """What evaluating an expression does besides giving a value.

    Attributes
    ----------
    draws
        Whether it draws random numbers.
    changes
        Names that it assigns; ``ANY`` if it changes data, prints, or ends an evaluation.
    reads
        Names that it reads, by way of the functions that it calls, too.
    """

    draws: bool
    changes: frozenset[str]
    reads: frozenset[str]

    def commutes(self, other: SideEffects) -> bool:
        """Return whether the order of two expressions does not matter."""
        if self.draws and other.draws:
            return False
        return not _disturbs(self, other) and not _disturbs(other, self)

    @property
    def is_pure(self) -> bool:
        return not self.draws and not self.changes


_PURE = SideEffects(False, frozenset(), frozenset())


def _disturbs(first: SideEffects, second: SideEffects) -> bool:
    if ANY in first.changes:
        return bool(second.reads or second.changes or second.draws)
    return bool(first.changes & (second.reads | second.changes))


@dataclass(slots=True)
class OpenProgram:
    """Top-level forms of a program while they are changed, and facts about its names.

    Attributes
    ----------
    forms
        Trees of the top-level forms.
    language, known
        Names of the language, and those that the program does not define itself.
    is_blocks
        Whether the program builds of blocks, whose poses are rounded.
    has_imports, macros
        Whether names come from other files, and the names of the program's macros.
    catches
        Whether the program catches errors.
    """

    forms: list[CodeTree]
    language: frozenset[str]
    is_blocks: bool
    has_imports: bool = False
    macros: frozenset[str] = frozenset()
    known: frozenset[str] = frozenset()
    catches: bool = False
    _is_pure: bool = False  # whether nothing in the program draws or changes anything
    _names: frozenset[str] = frozenset()
    _defined: dict[str, list[CodeTree]] = field(default_factory=dict)
    _closures: dict[str, SideEffects] = field(default_factory=dict)
    _unknown: tuple[bool, frozenset[str]] = (False, frozenset())  # what a function that is not known may do

    def survey(self) -> None:
        """Find the definitions again, after the forms were changed."""
        self._defined, self._closures = {}, {}
        nodes = [one for top in self.forms for one in code(top)]
        lists = [one for one in nodes if one.items]
        self.known = self.language - {name for one in lists for name in (*own_bindings(one), *defined_names(one))}
        self._names = frozenset(name for top in self.forms for name in defined_names(top))
        symbols = {str(one.value) for one in nodes if type(one.value) is Symbol}
        draws = any(name.removeprefix(STD) in DRAWS for name in symbols)
        acts = any(name in _ACTS or name.endswith("!") for name in symbols)
        self.catches = self.has_imports or "guard" in symbols
        self._is_pure = not (draws or acts or self.catches or "set!" in symbols)
        if self._is_pure:
            return
        for one in lists:
            head = one.head or ""
            if head in ("define", "bind") and len(one.items or ()) > 2:
                self._define(one)
            elif head.startswith("let") and len(one.items or ()) > 1:
                self._define_bindings(one)
        acts = acts or self.has_imports
        self._unknown = draws or self.has_imports, frozenset([ANY]) if acts else frozenset()
        self._close()

    def is_understood(self, top: CodeTree) -> bool:
        """Return whether a form surely consists of the language's forms: it uses no macro."""
        used = names(top).keys()
        if used & self.macros:
            return False
        return (
            not self.has_imports
            or used <= self.known | {name for one in code(top) for name in bound_names(one)} | self._names
        )

    def _define(self, one: CodeTree) -> None:
        """Record a function. Reading any other variable has no effect, and calling its value is not known."""
        assert one.items is not None
        target, value = one.items[1], one.items[2]
        if one.head == "bind":
            self._defined.setdefault("", []).append(one)
            if type(target.value) is str:
                self._defined.setdefault(f'"{target.value}', []).append(one)
        elif target.items is not None or value.head == "lambda":
            for name in defined_names(one):
                self._defined.setdefault(name, []).append(one)

    def _define_bindings(self, one: CodeTree) -> None:
        assert one.items is not None
        if one.items[1].name is not None:  # a named loop
            self._defined.setdefault(one.items[1].name, []).append(one)
            return
        for binding in one.items[1].items or ():
            if binding.items and len(binding.items) == 2 and binding.items[1].head == "lambda":
                for name in _pattern(binding.items[0]):
                    self._defined.setdefault(name, []).append(binding)

    def _close(self) -> None:
        """Compute the effects of evaluating, or calling, each defined name: a fixed point over all definitions."""
        own = {name: self._direct(nodes) for name, nodes in self._defined.items()}
        users: dict[str, set[str]] = {}
        for name, effects in own.items():
            for used in effects.reads & own.keys():
                users.setdefault(used, set()).add(name)
        waiting = list(own)
        while waiting:
            used = waiting.pop()
            inner = own[used]
            for name in users.get(used, ()):
                outer = own[name]
                new = SideEffects(outer.draws or inner.draws, outer.changes | inner.changes, outer.reads | inner.reads)
                if new != outer:
                    own[name] = new
                    waiting.append(name)
        self._closures = own

    def _direct(self, nodes: Iterable[CodeTree]) -> SideEffects:
        """Return the effects of evaluating nodes, without those of the definitions that they refer to."""
        draws, changes, reads = False, set[str](), set[str]()
        for node in nodes:
            for one in expressions(node):
                name = one.name
                if name is None:
                    if one.head == "set!" and len(one.operands) == 2:
                        changes.add(str(one.operands[0].value))
                    elif one.head == "call" and len(one.operands) > 0:
                        word = one.operands[0].value
                        # words are read under their name after a quote, which no variable has; "" is any word
                        reads.add(f'"{word}' if type(word) is str else "")
                    if self._calls_unknown(one):
                        draws = draws or self._unknown[0]
                        changes |= self._unknown[1]
                    continue
                if name.removeprefix(STD) in DRAWS:
                    draws = True
                elif name in _ACTS or (name.endswith("!") and name != "set!"):
                    changes.add(ANY)
                reads.add(name)
        return SideEffects(draws, frozenset(changes), frozenset(reads - self.known))

    def _calls_unknown(self, node: CodeTree) -> bool:
        """Return whether an application calls a function that is the value of a parameter or of an expression."""
        if not node.items or node.is_array:
            return False
        head = node.head
        if head is None:
            return node.items[0].items is not None
        if head in _HIGHER_ORDER:
            return any(one.name is not None and not self._is_known(one.name) for one in node.operands)
        return not self._is_known(head)

    def _is_known(self, name: str) -> bool:
        return name in self.known or name in self._defined or name.startswith(STD)

    def effects(self, *nodes: CodeTree) -> SideEffects:
        """Return the effects of evaluating nodes. Where the program catches errors, an error is an effect."""
        if self._is_pure:
            return _PURE
        direct = self._direct(nodes)
        if self.catches and not all(is_constant(node) or node.items is None for node in nodes):
            direct = SideEffects(direct.draws, direct.changes | {ANY}, direct.reads)
        draws, changes, reads = direct.draws, direct.changes, direct.reads
        for name in direct.reads:
            inner = self._closures.get(name)
            if inner is not None:
                draws, changes, reads = draws or inner.draws, changes | inner.changes, reads | inner.reads
        return SideEffects(draws, changes, reads)


# --- arithmetic -------------------------------------------------------------------------------------------------------


Monomial: TypeAlias = tuple[tuple[str, int], ...]  # factors by text, with exponents other than 0, in order
_MAX_TERMS = 40  # of a polynomial, since a product has their product; those of the examples and the corpus have 3
_CLOSE = 1e-12  # relative difference of equal coefficients: thousands of roundings of 1.1e-16


class Poly:
    """Polynomial with real coefficients; exponents may be negative. ``atoms`` are the nodes of its factors by text."""

    __slots__ = ("atoms", "terms")

    def __init__(self, terms: Mapping[Monomial, float], atoms: Mapping[str, CodeTree]) -> None:
        self.terms = {key: value for key, value in terms.items() if value != 0}
        self.atoms = atoms

    @classmethod
    def number(cls, value: float) -> Poly:
        return cls({(): value}, {})

    @classmethod
    def factor(cls, node: CodeTree, text: str | None = None) -> Poly:
        text = text or print_datum(datum_of(node, {}, {}))
        return cls({((text, 1),): 1}, {text: node})

    def __add__(self, other: Poly) -> Poly:
        terms = dict(self.terms)
        for key, value in other.terms.items():
            total = terms.get(key, 0) + value
            terms[key] = 0 if abs(total) <= _CLOSE * abs(value) else total
        return Poly(terms, {**self.atoms, **other.atoms})

    def __neg__(self) -> Poly:
        return Poly({key: -value for key, value in self.terms.items()}, self.atoms)

    def __sub__(self, other: Poly) -> Poly:
        return self + -other

    def __mul__(self, other: Poly) -> Poly:
        terms: dict[Monomial, float] = {}
        for a, x in self.terms.items():
            for b, y in other.terms.items():
                key = _product(a, b)
                terms[key] = terms.get(key, 0) + x * y
        return Poly(terms, {**self.atoms, **other.atoms})

    def over(self, other: Poly) -> Poly | None:
        """Return the quotient by a polynomial of one term, or None."""
        if len(other.terms) != 1:
            return None
        ((key, value),) = other.terms.items()
        inverse = tuple((text, -power) for text, power in key)
        return self * Poly({inverse: 1 / value}, other.atoms)

    @property
    def constant(self) -> float | None:
        """The value, if it is a number."""
        if not self.terms:
            return 0
        return self.terms.get(()) if len(self.terms) == 1 else None

    def equals(self, other: Poly) -> bool:
        keys = self.terms.keys() | other.terms.keys()
        pairs = [(self.terms.get(key, 0), other.terms.get(key, 0)) for key in keys]
        return all(math.isclose(x, y, rel_tol=_CLOSE) for x, y in pairs)

    def split(self, name: str, depends: Callable[[CodeTree], bool]) -> tuple[Poly, Poly] | None:
        """Return slope and offset, if the polynomial is linear in the variable ``name``.

        ``depends`` tells whether another factor depends on the variable.
        """
        slope: dict[Monomial, float] = {}
        offset: dict[Monomial, float] = {}
        for key, value in self.terms.items():
            powers = dict(key)
            power = powers.pop(name, 0)
            if power not in (0, 1) or any(depends(self.atoms[text]) for text in powers):
                return None
            (slope if power else offset)[tuple(powers.items())] = value
        return Poly(slope, self.atoms), Poly(offset, self.atoms)


def _product(a: Monomial, b: Monomial) -> Monomial:
    powers = dict(a)
    for text, power in b:
        powers[text] = powers.get(text, 0) + power
    return tuple(sorted((text, power) for text, power in powers.items() if power))


def poly(node: CodeTree, values: Mapping[str, CodeTree], rebound: frozenset[str] = frozenset()) -> Poly:
    """Return the polynomial of an expression. What is not arithmetic is a factor.

    Parameters
    ----------
    values
        Expressions of local variables, which are inserted.
    rebound
        Names that the program defines although the language does: they are not arithmetic.
    """
    polynomial = _poly(node, values, rebound, 30)
    return polynomial if len(polynomial.terms) <= _MAX_TERMS else Poly.factor(node)


def _poly(node: CodeTree, values: Mapping[str, CodeTree], rebound: frozenset[str], depth: int) -> Poly:
    """Return the polynomial of an expression, with local values inserted up to ``depth`` levels deep."""
    if node.is_number and math.isfinite(node.value):
        return Poly.number(node.value)
    name = node.name
    if name is not None:
        if name in values and depth:
            return _poly(values[name], values, rebound, depth - 1)
        if name == "tau" and name not in rebound:
            return Poly({(("pi", 1),): 2}, {"pi": symbol("pi", node.span)})
        return Poly.factor(node, name)
    head, operands = node.head, node.operands
    if head not in ("+", "-", "*", "/") or not operands or head in rebound or not depth or len(operands) > 8:
        return Poly.factor(node)
    first, *rest = [_poly(operand, values, rebound, depth - 1) for operand in operands]
    # products of sums would grow exponentially
    if any(len(one.terms) > _MAX_TERMS for one in (first, *rest)):
        return Poly.factor(node)
    if head == "-" and not rest:
        return -first
    for other in rest:
        if head == "+":
            first = first + other
        elif head == "-":
            first = first - other
        elif head == "*":
            first = first * other
        else:
            quotient = first.over(other)
            if quotient is None:
                return Poly.factor(node)
            first = quotient
    return first if head != "/" or rest else Poly.factor(node)


def expression(value: Poly, like: CodeTree) -> CodeTree | None:
    """Return an expression for a polynomial, or None if it has no short one. ``like`` supplies the span."""
    span = like.span
    if not value.terms:
        return atom(0, span)
    terms = [_term(value, key, number, like) for key, number in value.terms.items()]
    if len(terms) > 4 or any(term is None for term in terms):
        return None
    plus = [node for node, negative in filter(None, terms) if not negative]
    minus = [node for node, negative in filter(None, terms) if negative]
    if not plus:
        whole = minus[0] if len(minus) == 1 else form("+", *minus, span=span)
        return atom(-whole.value, span) if whole.is_number else form("-", whole, span=span)
    total = plus[0] if len(plus) == 1 else form("+", *plus, span=span)
    return form("-", total, *minus, span=span) if minus else total


def _term(value: Poly, key: Monomial, number: float, like: CodeTree) -> tuple[CodeTree, bool] | None:
    """Return the absolute value of a term, and whether it is negative."""
    span = like.span
    above = [copied(value.atoms[text]) for text, power in key for _ in range(power)]
    below = [copied(value.atoms[text]) for text, power in key for _ in range(-power)]
    scale = abs(number)
    over, under = _fraction(scale, is_factor=bool(above))
    if not math.isclose(over / under, scale, rel_tol=1e-15):
        return None
    if over != 1 or not above:
        above.insert(0, atom(over, span))
    if under != 1:
        below.append(atom(under, span))
    node = above[0] if len(above) == 1 else form("*", *above, span=span)
    if below:
        node = form("/", node, *below, span=span)
    return node, number < 0


def _fraction(scale: float, *, is_factor: bool) -> tuple[float | int, int]:
    """Return a number as a short decimal, or as a quotient by a small integer."""
    if scale == round(scale):
        return round(scale), 1
    if is_factor and 1 / scale == round(1 / scale):
        return 1, round(1 / scale)
    if scale != round(scale, 9):
        for under in (2, 3, 4, 5, 6, 7, 8, 9, 12, 16, 18, 24, 36, 180, 360):
            if math.isclose(scale * under, round(scale * under, 6), rel_tol=1e-14):
                over = round(scale * under, 6)
                return (round(over) if over == round(over) else over), under
    short = float(f"{scale:.15g}")
    return (short, 1)
