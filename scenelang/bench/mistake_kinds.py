"""Kinds of mistakes that language models make in programs, each a function that lists the edits that make one.

Diagnostics were tuned on half of the kinds, and measured on the others, which they were not changed for. The split is
by kind within each family of mistakes, and was made before any kind was measured.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from random import Random
from typing import NamedTuple, TypeAlias

from scenelang.grammar.datum import (
    ArrayDatum,
    Atom,
    Datum,
    Keyword,
    ListDatum,
    Source,
    Symbol,
    dataclass,
    subdatums,
)
from scenelang.grammar.reader import read
from scenelang.interpreter.scene.primitives.base import encoded


class TextChange(NamedTuple):
    """Replacement of the text from ``start`` to ``end``; ``declaration`` is a form that the program states besides."""

    start: int
    end: int
    text: str
    declaration: str = ""


Planter: TypeAlias = Callable[["Text", Random], Iterator[TextChange]]


@dataclass(frozen=True, slots=True)
class MistakeKind:
    """A kind of mistakes.

    Attributes
    ----------
    name, family, doc
        What it is called, the family that the name belongs to, and what is done to a program.
    tuned
        Whether diagnostics were improved by looking at mistakes of this kind.
    plant
        Lists the edits of a text that may make such a mistake.
    evidence
        What shows that an edit made one: ``outcome`` (an error, or another scene), ``error``, or ``geometry`` (a
        finding about the scene that it had not before).
    """

    name: str
    family: str
    tuned: bool
    doc: str
    plant: Planter
    evidence: str = "outcome"


KINDS: dict[str, MistakeKind] = {}


def _kind(name: str, family: str, evidence: str = "outcome", *, tuned: bool) -> Callable[[Planter], Planter]:
    """Register a kind; its documentation is that of the function."""

    def register(plant: Planter) -> Planter:
        KINDS[name] = MistakeKind(name, family, tuned, plant.__doc__ or "", plant, evidence)
        return plant

    return register


# --- texts -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Text:
    """A program as datums, and the names of the language; ``counts`` are the instances of each word in its scene."""

    text: str
    builtins: frozenset[str]
    variadic: frozenset[str]
    counts: Mapping[str, int]

    @cached_property
    def nodes(self) -> Sequence[tuple[Datum, Datum | None, int]]:
        """Every datum that is no quoted data, with its parent and its position in it, in the order of the text."""
        nodes: list[tuple[Datum, Datum | None, int]] = []
        forms = read(Source("<program>", self.text)).forms
        stack: list[tuple[Datum, Datum | None, int]] = []
        stack += [(form, None, i) for i, form in enumerate(forms)][::-1]
        while stack:
            node, parent, place = stack.pop()
            if isinstance(node, ListDatum) and self.text[node.span.start] != "(":
                continue  # quoted
            nodes.append((node, parent, place))
            stack += [(child, node, i) for i, child in enumerate(subdatums(node))][::-1]
        return nodes

    @cached_property
    def lists(self) -> Sequence[ListDatum]:
        return [node for node, _, _ in self.nodes if isinstance(node, ListDatum)]

    @cached_property
    def arrays(self) -> Sequence[ArrayDatum]:
        return [node for node, _, _ in self.nodes if isinstance(node, ArrayDatum)]

    @cached_property
    def symbols(self) -> Sequence[Atom]:
        return [node for node, _, _ in self.nodes if isinstance(node, Atom) and type(node.value) is Symbol]

    @cached_property
    def uses(self) -> Sequence[Atom]:
        """Symbols in the places of expressions, as far as the text shows: no names that a form binds."""
        return [
            node
            for node, parent, place in self.nodes
            if isinstance(node, Atom)
            and type(node.value) is Symbol
            and isinstance(parent, ListDatum | ArrayDatum)
            and not (place == 1 and head_of(parent) in ("define", "define-record", "param", "set!"))
            and id(parent) not in self._binders
        ]

    @cached_property
    def _binders(self) -> frozenset[int]:
        """Ids of parameter lists, and of the bindings and clauses that name a variable."""
        binders: set[int] = set()
        for form in self.lists:
            head, items = head_of(form), form.items
            if head in ("lambda", "define") and len(items) > 1:
                binders |= {id(items[1]), *map(id, subdatums(items[1]))}
            elif head is not None and (head.startswith(("let", "for"))) and len(items) > 1:
                binders |= {id(clause) for clause in subdatums(items[1]) if isinstance(clause, ListDatum)}
        return frozenset(binders)

    def calls(self, *heads: str) -> Iterator[ListDatum]:
        """Forms with one of these heads."""
        return (form for form in self.lists if head_of(form) in heads)

    @cached_property
    def functions(self) -> frozenset[str]:
        """Names of the functions that the program defines."""
        return frozenset(
            name
            for form in self.calls("define")
            if len(form.items) > 1 and isinstance(form.items[1], ListDatum) and (name := head_of(form.items[1]))
        )

    def of(self, *datums: Datum) -> str:
        """The text from the first datum to the last."""
        return self.text[datums[0].span.start : datums[-1].span.end]


def head_of(datum: Datum | None) -> str | None:
    """The symbol at the head of a list, or None."""
    if isinstance(datum, ListDatum) and datum.items and isinstance(datum.items[0], Atom):
        value = datum.items[0].value
        return str(value) if type(value) is Symbol else None
    return None


def _number(datum: Datum) -> float | None:
    if isinstance(datum, Atom) and type(datum.value) in (int, float):
        return float(datum.value)
    return None


def _numbers(datum: Datum | None) -> list[float] | None:
    """The numbers of an array of literals, or None."""
    if not isinstance(datum, ArrayDatum):
        return None
    numbers = [_number(item) for item in datum.items]
    return [x for x in numbers if x is not None] if None not in numbers else None


def _replace(datum: Datum, text: str) -> TextChange:
    return TextChange(datum.span.start, datum.span.end, text)


def _swap(text: Text, form: ListDatum, first: Datum, second: Datum) -> TextChange:
    between = text.text[first.span.end : second.span.start]
    return TextChange(first.span.start, second.span.end, text.of(second) + between + text.of(first))


def _short(value: float) -> str:
    return f"{round(value, 4) + 0.0:g}"


def _misspelled(pick: Random, name: str) -> str:
    """A name with two letters swapped, one left out, doubled, or replaced by its neighbor on the keyboard."""
    at = pick.randrange(1, len(name) - 1)
    kind = pick.randrange(4)
    if kind == 0:
        return name[:at] + name[at + 1] + name[at] + name[at + 2 :]
    if kind == 1:
        return name[:at] + name[at + 1 :]
    if kind == 2:
        return name[: at + 1] + name[at] + name[at + 1 :]
    return name[:at] + _NEIGHBORS.get(name[at], "e") + name[at + 1 :]


_NEIGHBORS = dict(zip("qwertyuiopasdfghjklzxcvbnm", "wertyuiopoasdfghjkkxcvbnmn", strict=True))
_LEAST = 4  # letters of a name that is misspelled


# --- wrong names -----------------------------------------------------------------------------------------------------


@_kind("misspelled builtin", "wrong name", tuned=True)
def _misspelled_builtin(text: Text, pick: Random) -> Iterator[TextChange]:
    """A letter of a builtin's name, or of a form's, is wrong."""
    for atom in text.uses:
        if atom.value in text.builtins and len(atom.value) >= _LEAST:
            yield _replace(atom, _misspelled(pick, str(atom.value)))


@_kind("misspelled variable", "wrong name", tuned=False)
def _misspelled_variable(text: Text, pick: Random) -> Iterator[TextChange]:
    """A letter of a variable's name, or of a function's of the program, is wrong where it is used."""
    for atom in text.uses:
        if atom.value not in text.builtins and len(atom.value) >= _LEAST:
            yield _replace(atom, _misspelled(pick, str(atom.value)))


@_kind("misspelled word", "wrong name", tuned=True)
def _misspelled_word(text: Text, pick: Random) -> Iterator[TextChange]:
    """A letter of a word is wrong where it is called."""
    for form in text.calls("call"):
        if len(form.items) > 1 and isinstance(form.items[1], Atom) and type(form.items[1].value) is str:
            word = form.items[1].value
            if len(word) >= _LEAST and word.isascii():
                yield _replace(form.items[1], f'"{_misspelled(pick, word)}"')


@_kind("misspelled option", "wrong name", tuned=False)
def _misspelled_option(text: Text, pick: Random) -> Iterator[TextChange]:
    """A letter of a keyword is wrong where an argument is passed."""
    for node, parent, place in text.nodes:
        if isinstance(node, Atom) and type(node.value) is Keyword and len(node.value) >= _LEAST and place > 0:
            if isinstance(parent, ListDatum) and head_of(parent) is not None:
                yield _replace(node, f":{_misspelled(pick, str(node.value))}")


_PYTHON = {
    "length": ("len",), "expt": ("pow", "**", "math.pow"), "sin": ("math.sin", "np.sin"), "cos": ("math.cos", "np.cos"),
    "sqrt": ("math.sqrt",), "pi": ("math.pi", "np.pi"), "tau": ("math.tau",), "ceiling": ("ceil", "math.ceil"),
    "floor": ("math.floor",), "atan": ("math.atan2",), "=": ("==",), "abs": ("fabs",), "string": ("str",),
    "truncate": ("int",), "inexact": ("float",), "deg": ("math.radians", "np.deg2rad"),
    "random": ("random.random",), "uniform": ("random.uniform",), "choice": ("random.choice",),
    "iota": ("range", "np.arange"), "and": ("&&",),
    "or": ("||",), "ref": ("get",), "list": ("array",), "mutable-list": ("list",), "print": ("println",),
    "append": ("concat", "extend"), "hypot": ("math.hypot",), "linspace": ("np.linspace",), "fold": ("reduce",),
}  # fmt: skip
_PYTHON_LITERALS = {"#t": "True", "#f": "False", "none": "None"}


@_kind("name of Python", "wrong name", tuned=True)
def _python_name(text: Text, pick: Random) -> Iterator[TextChange]:
    """A function or constant is called as in Python or JavaScript."""
    yield from _renamed(text, pick, _PYTHON, _PYTHON_LITERALS)


_SCHEME = {
    "none?": ("null?",), "empty?": ("null?", "endp"), "length": ("vector-length", "size"), "ref": ("vector-ref", "nth"),
    "list-ref": ("nth", "elt"), "%": ("modulo", "mod", "rem"), "//": ("quotient", "div"), "begin": ("progn", "do"),
    "map": ("mapcar", "vector-map"), "fold": ("foldl", "fold-left"), "round": ("exact-round",), "error": ("throw",),
    "floor": ("exact-floor",), "inexact": ("exact->inexact",), "even?": ("evenp",), "odd?": ("oddp",),
    "zero?": ("zerop",), "expt": ("power",), "string-append": ("string-concat", "concatenate"),
    "print": ("display", "printf"), "for/list": ("for/vector", "map-indexed"), "iota": ("build-list",),
    "list": ("vector",), "cons": ("conj",), "set!": ("setf", "setq"), "first": ("head",), "append": ("append*",),
    "apply": ("funcall",), "pi": ("PI",), "reverse": ("rev", "nreverse"), "cond": ("case",), "lambda": ("fn",),
    "for/union": ("for/entities", "for/all"), "unless": ("if-not",), "filter": ("remove-if-not", "keep"),
}  # fmt: skip
_SCHEME_LITERALS = {"#t": "t", "#f": "nil", "none": "nil"}


@_kind("name of another Lisp", "wrong name", tuned=False)
def _scheme_name(text: Text, pick: Random) -> Iterator[TextChange]:
    """A function, form or constant is called as in Scheme, Racket, Common Lisp or Clojure."""
    yield from _renamed(text, pick, _SCHEME, _SCHEME_LITERALS)


def _renamed(
    text: Text, pick: Random, names: Mapping[str, Sequence[str]], literals: Mapping[str, str]
) -> Iterator[TextChange]:
    for atom in text.uses:
        if atom.value in names:
            yield _replace(atom, pick.choice(names[atom.value]))
    for node, parent, _ in text.nodes:
        if isinstance(node, Atom) and parent is not None and text.of(node) in literals:
            yield _replace(node, literals[text.of(node)])


_CAD = {
    "union": ("group", "combine", "assembly"), "transform": ("place", "apply-transform"), "translate": ("move",),
    "difference": ("subtract",), "extrude": ("linear-extrude",), "rotate": ("rotation", "turn"),
    "lathe": ("revolve",), "scale": ("resize",), "ring": ("circular-array",), "grid": ("grid-array",),
    "row": ("linear-array",), "union-loop": ("repeat", "loop-union"), "mirror": ("reflect-copy",), "bind": ("module",),
    "color": ("colour", "hex-color"), "rgb": ("rgb-color",), "on-top-of": ("stack-on", "place-on-top"),
}  # fmt: skip


@_kind("name of CAD", "wrong name", tuned=True)
def _cad_name(text: Text, pick: Random) -> Iterator[TextChange]:
    """A combinator or pose is called as in OpenSCAD, CadQuery or a scene graph."""
    yield from _renamed(text, pick, _CAD, {})


_SYNONYMS = {
    "color": ("colour", "col", "fill"), "radius": ("r", "rad"), "scale": ("size", "dimensions"), "p0": ("from",),
    "p1": ("to", "end"), "opacity": ("alpha",), "tube": ("tube-radius", "thickness"),
    "emission": ("emissive", "glow"), "metallic": ("metalness",),
}  # fmt: skip


@_kind("synonym of an option", "wrong name", tuned=True)
def _option_synonym(text: Text, pick: Random) -> Iterator[TextChange]:
    """An attribute of a primitive has the name that other systems give it."""
    for form in text.calls("call"):
        if len(form.items) > 1 and isinstance(form.items[1], Atom) and form.items[1].value in _PRIMITIVES:
            for item in form.items[2:]:
                if isinstance(item, Atom) and type(item.value) is Keyword and item.value in _SYNONYMS:
                    yield _replace(item, f":{pick.choice(_SYNONYMS[item.value])}")


_PRIMITIVES = frozenset(("cube", "sphere", "cylinder", "cone", "capsule", "torus", "rounded-cube"))


@_kind("wrong case", "wrong name", tuned=False)
def _wrong_case(text: Text, pick: Random) -> Iterator[TextChange]:
    """A builtin is capitalized, in upper case, or written in camel case."""
    for atom in text.uses:
        name = str(atom.value)
        if name in text.builtins and re.fullmatch(r"[a-z][a-z-]+", name):
            words = name.split("-")
            camel = words[0] + "".join(word.capitalize() for word in words[1:])
            yield _replace(atom, camel if len(words) > 1 else pick.choice((name.capitalize(), name.upper())))


@_kind("underscores", "wrong name", tuned=False)
def _underscores(text: Text, pick: Random) -> Iterator[TextChange]:
    """A name of several words, or a keyword, has underscores instead of hyphens."""
    for atom in text.uses:
        if re.fullmatch(r"[a-z]+(-[a-z]+)+", str(atom.value)):
            yield _replace(atom, str(atom.value).replace("-", "_"))
    for node, parent, place in text.nodes:
        if isinstance(node, Atom) and type(node.value) is Keyword and "-" in node.value and place > 0:
            if head_of(parent) is not None:
                yield _replace(node, text.of(node).replace("-", "_"))


# --- arity -----------------------------------------------------------------------------------------------------------


def _applications(text: Text) -> Iterator[ListDatum]:
    """Calls of functions with positional arguments only."""
    known = (text.builtins - _FORMS) | text.functions
    for node, parent, _ in text.nodes:
        if isinstance(node, ListDatum) and len(node.items) > 1 and node.tail is None and head_of(node) in known:
            if not any(isinstance(item, Atom) and type(item.value) is Keyword for item in node.items):
                if head_of(parent) != "define" or parent is None or node is not parent.items[1]:  # type: ignore[union-attr]
                    yield node


_FORMS = frozenset((
    "define", "lambda", "let", "let*", "letrec", "bind", "scene", "param", "if", "cond", "case", "when", "unless",
    "begin", "quote", "set!", "import", "union", "list", "call", "define-record", "define-values", "define-syntax",
    "guard", "define-macro", "and", "or", "embedding", "table", "do", "for/union", "for*/union", "for/list",
    "for*/list", "for", "for*", "assert-that", "assert",
))  # fmt: skip


@_kind("missing argument", "arity", tuned=True, evidence="error")
def _missing_argument(text: Text, pick: Random) -> Iterator[TextChange]:
    """The last argument of a call is left out."""
    for form in _applications(text):
        yield TextChange(form.items[-2].span.end, form.items[-1].span.end, "")


@_kind("superfluous argument", "arity", tuned=False, evidence="error")
def _superfluous_argument(text: Text, pick: Random) -> Iterator[TextChange]:
    """A call has one argument more, a zero or the last one again."""
    for form in _applications(text):
        if head_of(form) not in text.variadic:
            end = form.items[-1].span.end
            yield TextChange(end, end, f" {pick.choice(('0', text.of(form.items[-1])))}")


@_kind("vector in pieces", "arity", tuned=True)
def _vector_in_pieces(text: Text, pick: Random) -> Iterator[TextChange]:
    """The numbers of a vector are arguments of their own: ``(translate 1 2 3)``."""
    for form in text.calls("translate", "scale", "rotate", "rgb"):
        for item in form.items[1:]:
            if isinstance(item, ArrayDatum) and len(item.items) > 1:
                yield _replace(item, text.of(*item.items))


@_kind("missing lambda", "arity", tuned=False)
def _missing_lambda(text: Text, pick: Random) -> Iterator[TextChange]:
    """A word is bound to parts, or a loop has a body, without a function around it."""
    for form in text.calls("lambda"):
        if len(form.items) == 3 and isinstance(form.items[1], ListDatum) and len(form.items[1].items) <= 1:
            yield _replace(form, text.of(form.items[2]))


# --- brackets --------------------------------------------------------------------------------------------------------


@_kind("missing bracket", "bracket", tuned=True)
def _missing_close(text: Text, pick: Random) -> Iterator[TextChange]:
    """A closing parenthesis is left out."""
    for form in text.lists:
        yield TextChange(form.span.end - 1, form.span.end, "")


@_kind("superfluous bracket", "bracket", tuned=False)
def _extra_close(text: Text, pick: Random) -> Iterator[TextChange]:
    """A closing parenthesis is written twice."""
    for form in text.lists:
        yield TextChange(form.span.end, form.span.end, ")")


@_kind("open vector", "bracket", tuned=False)
def _open_vector(text: Text, pick: Random) -> Iterator[TextChange]:
    """The closing bracket of a vector is left out."""
    for array in text.arrays:
        yield TextChange(array.span.end - 1, array.span.end, "")


@_kind("open string", "bracket", tuned=False)
def _open_string(text: Text, pick: Random) -> Iterator[TextChange]:
    """The closing quote of a string is left out."""
    for node, _, _ in text.nodes:
        if isinstance(node, Atom) and type(node.value) is str:
            yield TextChange(node.span.end - 1, node.span.end, "")


@_kind("vector in parentheses", "bracket", tuned=True)
def _vector_in_parentheses(text: Text, pick: Random) -> Iterator[TextChange]:
    """A vector has parentheses."""
    for array in text.arrays:
        if array.items:
            yield _replace(array, f"({text.of(*array.items)})")


@_kind("length of a vector", "bracket", tuned=True)
def _vector_length(text: Text, pick: Random) -> Iterator[TextChange]:
    """A point or color has a fourth component, or a point of the plane z = 0 has only two."""
    for node, parent, _ in text.nodes:
        if isinstance(node, ArrayDatum) and len(node.items) == 3 and isinstance(parent, ListDatum):
            last = node.items[-1]
            yield TextChange(last.span.end, last.span.end, " 1")
            if _number(last) == 0:
                yield TextChange(node.items[1].span.end, last.span.end, "")


@_kind("clauses in brackets", "bracket", tuned=False)
def _clauses_in_brackets(text: Text, pick: Random) -> Iterator[TextChange]:
    """A binding or clause has square brackets, as in Racket or Clojure."""
    for form in text.lists:
        head = head_of(form)
        if head is not None and re.match(r"let|for|cond|case", head) and len(form.items) > 1:
            around = form.items[1]
            clauses = form.items[1:] if head in ("cond", "case") else subdatums(around)
            for clause in clauses:
                if isinstance(clause, ListDatum) and clause.items:
                    yield _replace(clause, f"[{text.of(*clause.items)}]")


# --- units -----------------------------------------------------------------------------------------------------------


@_kind("degrees", "unit", tuned=True)
def _degrees(text: Text, pick: Random) -> Iterator[TextChange]:
    """A constant angle, a whole number of degrees, is written in degrees."""
    for form in text.calls("rotate"):
        angle = _constant(form.items[1]) if len(form.items) > 1 else None
        if angle is not None and math.isclose(math.degrees(angle), round(math.degrees(angle)), abs_tol=1e-6):
            yield _replace(form.items[1], str(round(math.degrees(angle))))


def _constant(datum: Datum) -> float | None:
    """The value of an angle that is a number, ``pi`` or ``tau``, or arithmetic of these."""
    value = _number(datum)
    if value is not None or isinstance(datum, Atom):
        return {"pi": math.pi, "tau": math.tau}.get(str(datum.value)) if value is None else value  # type: ignore[union-attr]
    operands = [_constant(item) for item in subdatums(datum)][1:]
    if None in operands or not operands:
        return None
    first, rest = float(operands[0] or 0.0), [float(x or 0.0) for x in operands[1:]]
    head = head_of(datum)
    if head == "deg":
        return math.radians(first)
    if head == "-":
        return first - sum(rest) if rest else -first
    if head == "+":
        return first + sum(rest)
    if head == "*":
        return first * math.prod(rest)
    return first / math.prod(rest) if head == "/" and rest and 0.0 not in rest else None


@_kind("bytes of a color", "unit", tuned=False)
def _color_bytes(text: Text, pick: Random) -> Iterator[TextChange]:
    """The components of a color go from 0 to 255, in sRGB as everywhere else."""
    for node, parent, place in text.nodes:
        numbers = _numbers(node)
        if numbers and len(numbers) == 3 and isinstance(parent, ListDatum) and place > 0:
            before = parent.items[place - 1]
            is_named = isinstance(before, Atom) and (type(before.value) is Keyword or place == 1 or _defines(parent))
            if is_named and "color" in str(before.value) and max(numbers) > 0:
                yield _replace(node, "[" + " ".join(str(round(255 * encoded(x))) for x in numbers) + "]")


def _defines(form: ListDatum) -> bool:
    return head_of(form) in ("define", "param", "set!")


# --- order -----------------------------------------------------------------------------------------------------------


@_kind("order of transform", "order", tuned=True)
def _transform_order(text: Text, pick: Random) -> Iterator[TextChange]:
    """The pose stands before the part."""
    for form in text.calls("transform"):
        if len(form.items) == 3:
            yield _swap(text, form, form.items[1], form.items[2])


@_kind("order of poses", "order", tuned=True)
def _pose_order(text: Text, pick: Random) -> Iterator[TextChange]:
    """A part is moved by a constant translation before it is turned by a constant angle, instead of after it."""
    for form in text.calls("@"):
        if len(form.items) == 3:
            move, turn = form.items[1:]
            if head_of(move) == "translate" and head_of(turn) == "rotate" and len(turn.items) == 3:
                angle = turn.items[1]
                if _numbers(move.items[1]) and _constant(angle) is not None:
                    yield _swap(text, form, move, turn)


@_kind("order of rotate", "order", tuned=False)
def _rotate_order(text: Text, pick: Random) -> Iterator[TextChange]:
    """The axis stands before the angle."""
    for form in text.calls("rotate"):
        if len(form.items) >= 3:
            yield _swap(text, form, form.items[1], form.items[2])


@_kind("order of arguments", "order", tuned=False, evidence="error")
def _function_order(text: Text, pick: Random) -> Iterator[TextChange]:
    """The first two arguments of a loop, of a function of lists, or of an access are in the other order."""
    for form in text.calls("union-loop", "map", "ref", "list-ref", "ring", "scatter", "fold", "filter", "on-top-of",
                           "grid", "apply", "expt", "list-head", "lathe", "extrude"):  # fmt: skip
        if len(form.items) >= 3:
            if not any(isinstance(item, Atom) and type(item.value) is Keyword for item in form.items[1:3]):
                yield _swap(text, form, form.items[1], form.items[2])


# --- off by one ------------------------------------------------------------------------------------------------------


@_kind("count off by one", "off by one", tuned=True)
def _count_off_by_one(text: Text, pick: Random) -> Iterator[TextChange]:
    """A loop makes one thing too many or too few, of which a declaration says the number."""
    for literal, form in _loop_counts(text):
        words = {
            str(node.items[1].value)
            for node in text.calls("call")
            if form.span.start < node.span.start < form.span.end
            and len(node.items) > 1
            and isinstance(node.items[1], Atom)
        }
        count = int(literal.value)
        for word in sorted(words):
            if text.counts.get(word, 0) > 0 and text.counts[word] % count == 0:
                declaration = f'(assert-that (count "{word}" {text.counts[word]}))'
                changed = count + 1 if count < 2 else count + pick.choice((-1, 1))
                yield TextChange(literal.span.start, literal.span.end, str(changed), declaration)


def _loop_counts(text: Text) -> Iterator[tuple[Atom, ListDatum]]:
    """Literal counts of loops: of ``union-loop`` and ``ring``, in ``(iota n)`` and as the count of a clause."""
    for form in text.lists:
        head, items = head_of(form), form.items
        if head in ("union-loop", "ring", "scatter") and len(items) > 1:
            counts = [items[1]]
        elif head is not None and head.startswith("for") and len(items) > 1 and isinstance(items[1], ListDatum):
            sources = [
                clause.items[1] for clause in items[1].items if isinstance(clause, ListDatum) and len(clause.items) == 2
            ]
            counts = [
                each.items[1] if head_of(each) in ("iota", "range") and len(each.items) == 2 else each
                for each in sources
            ]
        else:
            continue
        yield from (
            (each, form) for each in counts if isinstance(each, Atom) and type(each.value) is int and each.value > 0
        )


@_kind("index off by one", "off by one", tuned=False, evidence="error")
def _index_off_by_one(text: Text, pick: Random) -> Iterator[TextChange]:
    """An index is one beyond the last item: counted from 1, or a bound that is the length."""
    for form in text.calls("ref", "list-ref"):
        if len(form.items) >= 3:
            index = form.items[2]
            yield _replace(index, str(int(index.value) + 1) if type(getattr(index, "value", None)) is int
                           else f"(+ {text.of(index)} 1)")  # fmt: skip
    for literal, _ in _loop_counts(text):
        yield _replace(literal, str(literal.value + 1))
    for form in text.calls("%", "-"):
        if len(form.items) == 3 and head_of(form.items[2]) == "length":
            yield _replace(form.items[2], f"(+ {text.of(form.items[2])} 1)")


# --- floating parts --------------------------------------------------------------------------------------------------


@_kind("floating part", "floating part", tuned=True, evidence="geometry")
def _floating(text: Text, pick: Random) -> Iterator[TextChange]:
    """The height in a translation is raised, so that a part touches nothing."""
    yield from _raised(text, pick, 1)


@_kind("sunken part", "floating part", tuned=False, evidence="geometry")
def _sunken(text: Text, pick: Random) -> Iterator[TextChange]:
    """The height in a translation is lowered, so that a part is sunk into another."""
    yield from _raised(text, pick, -1)


def _raised(text: Text, pick: Random, sign: int) -> Iterator[TextChange]:
    for form in text.calls("translate"):
        array = form.items[1] if len(form.items) > 1 else None
        if isinstance(array, ArrayDatum) and len(array.items) == 3:
            height = _number(array.items[1])
            if height is not None:
                for share in (0.05, 0.1, 0.2, 0.5):
                    by = sign * share * max(abs(height), 0.5)
                    yield _replace(array.items[1], _short(height + by))


# --- notation --------------------------------------------------------------------------------------------------------


@_kind("commas", "notation", tuned=True)
def _commas(text: Text, pick: Random) -> Iterator[TextChange]:
    """The numbers of a vector are separated by commas."""
    for array in text.arrays:
        if len(array.items) > 1 and not any(isinstance(item, ArrayDatum) for item in array.items):
            yield _replace(array, "[" + ", ".join(text.of(item) for item in array.items) + "]")


def _options(text: Text) -> Iterator[tuple[Atom, Datum]]:
    """Keyword arguments: their names and values."""
    for form in text.lists:
        if head_of(form) in ("call", *text.functions) or head_of(form) in text.builtins - _FORMS:
            for key, value in zip(form.items[1:], form.items[2:]):
                if isinstance(key, Atom) and type(key.value) is Keyword:
                    yield key, value


@_kind("equals sign", "notation", tuned=True)
def _equals(text: Text, pick: Random) -> Iterator[TextChange]:
    """A keyword argument has an equals sign: ``radius=.5``."""
    for key, value in _options(text):
        name = str(key.value)
        yield TextChange(key.span.start, value.span.end, f"{pick.choice((name, f':{name}'))}={text.of(value)}")


@_kind("bare option", "notation", tuned=False)
def _bare_option(text: Text, pick: Random) -> Iterator[TextChange]:
    """The name of a keyword argument has no colon, or the colon behind it."""
    for key, _ in _options(text):
        yield _replace(key, pick.choice((str(key.value), f"{key.value}:")))


@_kind("single quotes", "notation", tuned=True)
def _single_quotes(text: Text, pick: Random) -> Iterator[TextChange]:
    """A string has single quotes."""
    for node, _, _ in text.nodes:
        if isinstance(node, Atom) and type(node.value) is str and re.fullmatch(r"[\w -]+", node.value):
            yield _replace(node, f"'{node.value}'")


@_kind("word without quotes", "notation", tuned=False)
def _unquoted(text: Text, pick: Random) -> Iterator[TextChange]:
    """A word has no quotes where it is called or bound."""
    for form in text.calls("call", "bind"):
        word = form.items[1].value if len(form.items) > 1 and isinstance(form.items[1], Atom) else None
        if type(word) is str and re.fullmatch(r"[a-z][a-z-]*", word):
            yield _replace(form.items[1], word)


@_kind("definition of another language", "notation", tuned=True)
def _definition(text: Text, pick: Random) -> Iterator[TextChange]:
    """A definition is written with ``def``, ``defun``, ``defn``, ``setq``, ``const`` or ``let``."""
    for form in text.calls("define"):
        head, named = form.items[0], form.items[1] if len(form.items) > 1 else None
        if isinstance(named, ListDatum) and named.items and named.tail is None:
            name, parameters = text.of(named.items[0]), text.of(*named.items[1:]) if len(named.items) > 1 else ""
            written = pick.choice(
                (f"def {text.of(named)}", f"defun {name} ({parameters})", f"defn {name} [{parameters}]")
            )
            yield TextChange(head.span.start, named.span.end, written)
        elif isinstance(named, Atom):
            yield _replace(head, pick.choice(("def", "setq", "const", "let", "defparameter")))


@_kind("function of another language", "notation", tuned=False)
def _function(text: Text, pick: Random) -> Iterator[TextChange]:
    """A function is written with ``fn``, ``function``, ``λ`` or the colon of Python."""
    for form in text.calls("lambda"):
        if len(form.items) > 2 and isinstance(form.items[1], ListDatum) and form.items[1].tail is None:
            inner = text.of(form.items[1])[1:-1]
            written = pick.choice(
                (f"fn [{inner}]", f"fn ({inner})", f"λ ({inner})", f"function ({inner})", f"lambda {inner}:")
            )
            yield TextChange(form.items[0].span.start, form.items[1].span.end, written)


@_kind("infix", "notation", tuned=False)
def _infix(text: Text, pick: Random) -> Iterator[TextChange]:
    """An operator stands between its operands."""
    for form in text.calls("+", "*", "-", "/"):
        if len(form.items) == 3:
            sign, left, right = form.items
            yield TextChange(sign.span.start, right.span.end, f"{text.of(left)} {sign.value} {text.of(right)}")


def tuned_kinds() -> tuple[str, ...]:
    return tuple(name for name, kind in KINDS.items() if kind.tuned)


def untouched_kinds() -> tuple[str, ...]:
    return tuple(name for name, kind in KINDS.items() if not kind.tuned)
