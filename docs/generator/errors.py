"""The errors that calls of each function raise, observed rather than derived from its source.

``python -m generator.errors`` (from ``docs``) evaluates the examples of every function with other arguments and
keywords and records one expression for each error in ``errors.tsv``; it takes 20 minutes, or seconds for the functions
that are named. The reference lists what the file has, and a test evaluates every expression of it. Reading the sources
for what they may raise, as was done before, named errors that no call causes (E411 of ``sort``, which copies its items
first) and missed those that arise from Python's arithmetic (E408 of ``iota``).
"""

from __future__ import annotations

import itertools
import re
import sys
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from pathlib import Path

from scenelang.grammar.datum import Atom, Keyword, ListDatum, Source, walk
from scenelang.grammar.diagnostics import CODES, SceneError
from scenelang.grammar.reader import read
from scenelang.interpreter.values.limits import Limits
from scenelang.session.session import Options, Session
from scenelang.stdlib.reference import RecordKind, ReferenceRecord, records

FILE = Path(__file__).with_name("errors.tsv")
# Errors of every call with wrong arguments or of limits, which the pages explain once.
OF_EVERY_CALL = frozenset({"type", "arity", "keyword", "steps", "time", "memory", "depth", "interrupted"})
_LIMITS = Limits(steps=50_000, seconds=5.0, size=200_000, memory=500_000_000, depth=2_000)
_DEFINITIONS = '(define s (set 1 2 3)) (define m (mutable-list 1 2 3)) (define t (table "a" 1 "b" 2))'
_PLAIN = """
0 -1 .5 3 -2.5 7 100 1e308 -1e308 1e-320 1000000 inf nan (expt 10 400) #t #f none 'x :x <red>
"" "x" "1 2" "red" "brick" '() '(1) '(1 2 3) '(-1 0 2) '(3 a) '((1 2) (3 4)) '(0 0 0)
[0 0 0] [1 2 3] [1 2] [-1 0 1] [[1 2] [3 4]] [[0 0] [0 0]] [[1 0 0 0] [0 1 0 0] [0 0 1 0] [0 0 0 2]] (vector)
(call "cube") (call "nothing") (union) (list (call "cube")) (transform (call "cube") (translate [1 0 0]))
(transform (call "cube") (translate [9 0 0])) (translate [1 2 3]) (scale [1 0 1]) (color "red")
(polygon [[0 0] [1 0] [0 1]]) (rectangle 1 2) (circle 0) (circle 1) s m t
"""
_FUNCTIONS = """
(lambda (x) x) (lambda () 1) (lambda (x y) x) (lambda (x) "s") (lambda (x) [x 0 0]) (lambda (x) none)
(lambda (x) (push! m 1) x) (lambda (x) (add! s (+ x 10)) x) (lambda (x) (set-ref! t "c" 1) x)
(lambda (x y) (push! m 1) x) (lambda (x y) (add! s (+ x y 10)) x) (lambda (x y) (set-ref! t "c" 1) 1)
"""
_COLLECTIONS = ("s", "m", "t")  # what the functions above change
_KEYWORD = re.compile(r"\(?:([\w?-]+)")


@cache
def observed() -> dict[str, dict[str, str]]:
    """Return for each function the expression that raises each error, by the error's name in the order of the codes."""
    table: dict[str, dict[str, str]] = {}
    for line in FILE.read_text("utf-8").splitlines():
        name, error, expression = line.split("\t")
        table.setdefault(name, {})[error] = expression
    return table


def errors_of(record: ReferenceRecord) -> tuple[str, ...]:
    """Return the names of the errors that calls of a function raise, besides those of every call."""
    return tuple(observed().get(record.name, ())) if record.kind is RecordKind.FUNCTION else ()


def examined() -> list[ReferenceRecord]:
    """Return the functions whose errors are recorded: those of the language, without the parts."""
    return [each for each in records() if each.kind is RecordKind.FUNCTION and each.topic != "parts" and each.examples]


def errors_in(record: ReferenceRecord, expression: str) -> list[str]:
    """Return the names of the errors of a function's call in an expression, besides those of every call."""
    program = f'{_DEFINITIONS}\n(define value {expression})\n(bind "a" (lambda () (call "cube")))\n'
    imported = f'(import "{record.module}")\n' if record.module is not None else ""
    try:
        result = Session(Options(limits=_LIMITS)).evaluate(Source("errors.scene", imported + program))
        diagnostics = result.diagnostics
    except SceneError as error:
        diagnostics = (error.diagnostic,)
    errors = [d for d in diagnostics if d.is_error and d.name not in OF_EVERY_CALL and d.span is not None]
    return [d.name for d in errors if d.span is not None and d.span.text.split(maxsplit=1)[0] == f"({record.name}"]


def altered(record: ReferenceRecord) -> Iterator[str]:
    """Yield calls of a function: those of its examples with one other argument or keyword, or with two."""
    seen = set[str]()
    for call in _calls(record):
        for expression in itertools.chain(_with_values(record, call), _with_mutations(call)):
            if expression not in seen:
                seen.add(expression)
                yield expression


def _calls(record: ReferenceRecord) -> Iterator[ListDatum]:
    """Yield the calls of a function in its examples, with lambdas for the functions that they pass by name.

    The errors of such a function, as of `second` in `(sort xs :key second)`, are those of a call of its own then.
    """
    functions = {each.name for each in records() if each.kind is RecordKind.FUNCTION}
    for example in record.examples:
        for datum in walk(*read(Source("example", example.expression)).forms):
            if isinstance(datum, ListDatum) and datum.items and datum.items[0].span.text == record.name:
                names = [(i, each.span.text) for i, each in enumerate(datum.items[1:], 1) if isinstance(each, Atom)]
                passed = [(i, f"(lambda xs (apply {name} xs))") for i, name in names if name in functions]
                (call,) = read(Source("call", _replaced(datum, passed))).forms
                if isinstance(call, ListDatum):
                    yield call


def _arguments(call: ListDatum) -> list[int]:
    """Return the positions of the arguments of a call that are values."""
    items = enumerate(call.items[1:], 1)
    return [i for i, each in items if not (isinstance(each, Atom) and isinstance(each.value, Keyword))]


def _replaced(call: ListDatum, values: Iterable[tuple[int, str]]) -> str:
    """Return the text of a call with other arguments, given by ascending positions."""
    text, start = call.span.text, call.span.start
    for position, value in sorted(values, reverse=True):
        span = call.items[position].span
        text = text[: span.start - start] + value + text[span.end - start :]
    return text


def _with_values(record: ReferenceRecord, call: ListDatum) -> Iterator[str]:
    """Yield a call with each argument replaced by each value, and with each keyword that it leaves out."""
    values = [each.span.text for each in read(Source("values", _PLAIN + _FUNCTIONS)).forms]
    given = {str(each.value) for each in call.items if isinstance(each, Atom) and isinstance(each.value, Keyword)}
    for value in values:
        yield from (_replaced(call, [(position, value)]) for position in _arguments(call))
        for keyword in dict.fromkeys(_KEYWORD.findall(record.signature)):
            if keyword not in given:
                yield f"{call.span.text[:-1]} :{keyword} {value})"


def _with_mutations(call: ListDatum) -> Iterator[str]:
    """Yield a call with a collection and a function that changes it."""
    functions = [each.span.text for each in read(Source("values", _FUNCTIONS)).forms]
    for first, second in itertools.permutations(_arguments(call), 2):
        for function, collection in itertools.product(functions, _COLLECTIONS):
            yield _replaced(call, [(first, function), (second, collection)])


def observe(names: Sequence[str] = ()) -> None:
    """Write the table anew, or the rows of some functions: the shortest expression for each error of each function."""
    lines = []
    for record in examined():
        known = observed().get(record.name, {})
        shortest = _shortest(record) if not names or record.name in names else known
        for error in sorted(shortest, key=lambda name: CODES[name].code):
            lines.append("\t".join((record.name, error, " ".join(shortest[error].split()))))
    FILE.write_text("\n".join(lines) + "\n", "utf-8")


def _shortest(record: ReferenceRecord) -> dict[str, str]:
    """Return the shortest expression for each error of a function."""
    shortest: dict[str, str] = {}
    for expression in altered(record):
        try:
            errors = errors_in(record, expression)
        except Exception as problem:  # a fault of the function, to be corrected
            print("FAULT", expression, repr(problem), file=sys.stderr, flush=True)
            errors = []
        for error in errors:
            if error not in shortest or len(expression) < len(shortest[error]):
                shortest[error] = expression
    print(record.name, *shortest, file=sys.stderr, flush=True)
    return shortest


if __name__ == "__main__":
    observe(sys.argv[1:])
