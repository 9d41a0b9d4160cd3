"""Constructs of other languages in a program, with the code to write instead.

People bring habits from Python, JavaScript, Clojure, Common Lisp, Scheme and OpenSCAD. The tables of ``idioms`` show
each construct and its replacement. They are consulted only where a program has errors, and only a construct that
explains an error is reported, because a valid program may define any of these names itself.
"""

from __future__ import annotations

import re
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache, lru_cache
from typing import Any

from scenelang.grammar.datum import Source, Span, dataclass, field, replace
from scenelang.grammar.diagnostics import Diagnostic, Edit, Fix, Note, near_names
from scenelang.grammar.lazy_patterns import lazy_pattern
from scenelang.interpreter.checker.idioms import (
    COLON,
    FORMS,
    INFIX,
    LANGUAGES,
    MODULES,
    NAMES,
    OTHER,
    QUOTED_FUNCTION,
    SAME,
    SINGLE_QUOTES,
    SPELLINGS,
    SYMBOL,
    WORD,
    Idiom,
    Spelling,
    Term,
)
from scenelang.interpreter.checker.other_tools import meaning_of_function
from scenelang.interpreter.scene.primitives import is_word

_MAX_EXPLAINED = 300  # errors that are explained; messages show fewer
MAX_TEXT = 200_000  # characters of a program that is searched, so that a check of a huge text stays fast
_MAX_SHOWN = 60  # characters of code in a message


# --- tree of a text that may be malformed ----------------------------------------------------------------------------

_TOKEN = lazy_pattern(
    r"""(?P<space>\s+)|(?P<comment>;[^\n]*|\#\|.*?\|\#)|(?P<string>"(?:[^"\\]|\\.)*")|(?P<open>[(\[{])"""
    r"""|(?P<close>[)\]}])|(?P<prefix>'|`|,@|,)|(?P<atom>[^\s()\[\]{}";'`,]+)|(?P<other>.)""",
    re.S,
)
_CLOSERS = {"(": ")", "[": "]", "{": "}"}


@dataclass(slots=True)
class Tree:
    """Datum of a text that may be malformed: an atom, or a list with its opening bracket."""

    start: int
    end: int
    text: str
    opener: str = ""
    items: list[Tree] = field(default_factory=list)


def trees(text: str, start: int = 0, end: int | None = None) -> Tree:
    """Return the datums of a piece of a text under one root.

    The reader's datums cannot be used, because foreign code often does not read. Any closing bracket ends the innermost
    list, and lists that are not closed end with the piece.
    """
    end = len(text) if end is None else end
    root = Tree(start, end, "", "top")
    stack = [root]
    for match in _TOKEN.finditer(text, start, end):
        kind = match.lastgroup
        if kind in ("space", "comment"):
            continue
        if kind == "open":
            tree = Tree(match.start(), end, "", match.group())
            stack[-1].items.append(tree)
            stack.append(tree)
        elif kind == "close":
            if len(stack) > 1:
                tree = stack.pop()
                tree.end = match.end()
        else:
            stack[-1].items.append(Tree(match.start(), match.end(), match.group()))
    return root


def walk(root: Tree) -> Iterator[Tree]:
    """Iterate over the descendants of a tree."""
    stack = [root]
    while stack:
        tree = stack.pop()
        if tree is not root:
            yield tree
        stack.extend(tree.items)


@dataclass(frozen=True, slots=True)
class Habit:
    """One occurrence of a construct of another language: its range, the names it defines, and the diagnostic."""

    start: int
    end: int
    inner: tuple[tuple[int, int], ...]  # ranges of this language inside it, whose errors have other causes
    names: frozenset[str]
    diagnostic: Diagnostic
    row: Any = None  # the row of a table, or the name of a construct that has none
    hides: bool = False  # whether it hides brackets after it, so that earlier ones seem unclosed
    parameters: tuple[int, int] | None = None  # range of a parameter list that is not one of this language


def explain(source: Source, diagnostics: Sequence[Diagnostic]) -> list[Diagnostic]:
    """Replace the errors of a text that constructs of other languages explain by one diagnostic for each construct."""
    explainable = [
        d for d in diagnostics if d.name in _EXPLAINED and d.span is not None and d.span.source.name == source.name
    ]
    if not explainable or len(source.text) > MAX_TEXT:
        return list(diagnostics)
    explainable = explainable[:_MAX_EXPLAINED]
    habits = [piece for piece in _foreign_pieces(source) if any(_explains(piece, d) for d in explainable)]
    rest: list[Habit] = []
    unbound = frozenset(d.span.start for d in explainable if d.name == "unbound" and d.span is not None)
    for habit in sorted(
        _habits(source, _regions(source.text, explainable), unbound), key=lambda piece: (piece.start, -piece.end)
    ):
        if any(_covers(other, habit) for other in habits):
            continue
        (habits if any(_explains(habit, d) for d in explainable) else rest).append(habit)
    # The reader stops at the first spelling of a kind, so the others have no errors yet.
    rows = {id(habit.row) for habit in habits if isinstance(habit.row, Spelling)}
    habits += [habit for habit in rest if id(habit.row) in rows and not any(_covers(other, habit) for other in habits)]
    if not habits:
        return list(diagnostics)
    names = frozenset(name for habit in habits for name in habit.names)
    others = [d for d in diagnostics if not _is_explained(d, habits, names, source)]
    return [*others, *(_as_grave_as(habit, explainable) for habit in habits)]


def _as_grave_as(habit: Habit, explained: Sequence[Diagnostic]) -> Diagnostic:
    """Return the diagnostic of a construct, a warning if all that it explains may never happen."""
    names = {d.name for d in explained if _explains(habit, d)}
    return (
        replace(habit.diagnostic, name="conditional-failure") if names == {"conditional-failure"} else habit.diagnostic
    )


def _covers(outer: Habit, inner: Habit) -> bool:
    """Return whether a construct lies in another one, outside the ranges of this language in it."""
    if not outer.start <= inner.start < outer.end:
        return False
    return not any(start <= inner.start and inner.end <= end for start, end in outer.inner)


def _explains(habit: Habit, diagnostic: Diagnostic) -> bool:
    """Return whether a construct of another language is the cause of an error.

    The error is then in it, in the text that it leaves over, or in the form around it.
    """
    span = diagnostic.span
    assert span is not None
    knows = any(fix.safe or diagnostic.name == "bad-atom" for fix in diagnostic.fixes)
    is_array = isinstance(habit.row, Idiom) and habit.row.pattern.startswith("[")
    if is_array and habit.start <= span.start and span.end <= habit.end:
        # The datums of a comprehension in brackets are not items of an array, and errors say so.
        return diagnostic.name in ("type", "misplaced") or not any(
            start <= span.start and span.end <= end for start, end in habit.inner
        )
    if habit.parameters is not None and habit.parameters[0] <= span.start and span.end <= habit.parameters[1]:
        return True
    if habit.row not in ("whole", "call") and knows and diagnostic.name not in ("bracket", "unbound", "idle-attribute"):
        return False  # the diagnostic has a fix of its own
    if diagnostic.name == "unbound" and span.text in habit.names:
        return True
    if diagnostic.name == "unclosed":
        return (habit.hides and span.start < habit.start) or habit.start <= span.start < habit.end
    is_inside = habit.start <= span.start < max(habit.end, habit.start + 1)
    if habit.row == "commas" and diagnostic.name != "misplaced":
        return False
    if diagnostic.name == "conditional-failure" and habit.row != "infix":
        return False
    if habit.row == "infix":
        written = habit.diagnostic.span
        assert written is not None
        is_in_run = written.start <= span.start and span.end <= written.end and span.text in _POWER_OF
        return diagnostic.name in _OF_INFIX and (is_in_run or (span.start, span.end) == (habit.start, habit.end))
    if habit.row == "call" and habit.start == span.start:
        is_function = diagnostic.found is not None and diagnostic.found.startswith("a Function")
        if diagnostic.name == "attribute" or is_function:
            return True
    if isinstance(habit.row, Idiom) and habit.row.hint == INFIX and diagnostic.name == "arity":
        return False  # the head is a function
    if not is_inside and not (diagnostic.name == "bad-atom" and span.start == habit.end):
        around = span.start <= habit.start and habit.end <= span.end
        if isinstance(habit.row, Spelling):
            return _is_left_by(habit, diagnostic, around=around)
        return around and isinstance(habit.row, Idiom) and diagnostic.name in _AROUND
    if diagnostic.name in _STRUCTURE and (span.start, span.end) in habit.inner:
        return True
    return not any(start <= span.start and span.end <= end for start, end in habit.inner)


def _is_left_by(habit: Habit, diagnostic: Diagnostic, *, around: bool) -> bool:
    """Return whether an error is about the rest of a spelling: ``'f`` of ``#'f``, or ``:`` among operands."""
    span = diagnostic.span
    assert span is not None
    assert isinstance(habit.row, Spelling)
    text = span.source.text
    if habit.row.pattern == QUOTED_FUNCTION:
        return around and diagnostic.message.endswith(text[habit.end - 1 : span.end].split()[0].rstrip(")"))
    if habit.row.pattern == SINGLE_QUOTES:  # a symbol, and a quote before the next datum
        quoted = text[habit.start : habit.end].strip("'")
        return around and diagnostic.message.endswith(f"got a symbol: {quoted}")
    if habit.row.pattern == COLON:
        is_same_line = "\n\n" not in text[habit.end : span.start]
        return diagnostic.name == "syntax" and span.start >= habit.end and is_same_line
    return False


# Errors that a construct of another language can cause.
_EXPLAINED = frozenset((
    "unbound", "bad-atom", "bad-string", "bad-dot", "misplaced", "syntax", "bracket", "unclosed", "extra-close",
    "lambda-list", "empty-application", "not-a-procedure", "attribute", "arity", "type", "value", "parts",
    "embedding", "word", "keyword", "idle-attribute", "dropped-value", "conditional-failure",
))  # fmt: skip

# Errors whose span is the form around the construct, and errors about the structure of a form.
_AROUND = frozenset(("syntax", "bracket", "arity", "type", "not-a-procedure", "parts", "embedding", "word"))
_OF_INFIX = frozenset((
    "type", "arity", "embedding", "attribute", "keyword", "not-a-procedure", "value", "parts", "conditional-failure",
))  # fmt: skip
_STRUCTURE = frozenset(("syntax", "bracket", "lambda-list"))


def _is_explained(diagnostic: Diagnostic, habits: Sequence[Habit], names: frozenset[str], source: Source) -> bool:
    """Return whether constructs explain a diagnostic; ``names`` are those that the constructs define."""
    span = diagnostic.span
    if diagnostic.name not in _EXPLAINED or span is None or span.source.name != source.name:
        return False
    if diagnostic.name == "unbound" and span.text in names:
        return True
    shadowed = re.search(r"got a Function: (\S+)\Z", diagnostic.message)
    if shadowed is not None and shadowed[1] in names:
        return True  # the name refers to the builtin, as the construct that redefines it was not understood
    return any(_explains(habit, diagnostic) for habit in habits)


def _diagnostic(source: Source, start: int, end: int, message: str, hint: str, fix: Fix | None) -> Diagnostic:
    """Return the diagnostic of a construct."""
    return Diagnostic("foreign-syntax", message, Span(source, start, end), hint, fixes=(fix,) if fix else ())


def _shown(text: str) -> str:
    """Return code on one line for error messages, with ``...`` for the insides of its longest lists if it is long.

    A reader can then copy its beginning and its end, which a cut at the end would hide.
    """
    text = " ".join(text.split())
    omitted: list[tuple[int, int]] = []
    while len(shown := _without(text, omitted)) > _MAX_SHOWN:
        whole = trees(text)
        insides = [p for tree in walk(whole) if tree not in whole.items and (p := _inside(tree)) is not None]
        open_ = [piece for piece in insides if not any(start <= piece[0] < end for start, end in omitted)]
        inner = [piece for piece in open_ if not any(piece[0] < other[0] and other[1] <= piece[1] for other in open_)]
        if not inner:
            return _beginning(shown)
        omitted.append(max(inner, key=lambda piece: piece[1] - piece[0]))
    return shown


def _inside(tree: Tree) -> tuple[int, int] | None:
    """Return the range of the arguments of a call behind its head and word, or None if leaving them out saves nothing.

    An array, whose numbers are short and say where something is, stays.
    """
    items = tree.items
    kept = 2 if len(items) > 1 and items[1].text.startswith('"') else 1
    if tree.opener != "(" or len(items) <= kept:
        return None
    start, end = items[kept].start, tree.end - 1
    return (start, end) if end - start > len("...") else None


def _beginning(text: str) -> str:
    """Return the first items of a list that fit into a message, with ``...`` for the others."""
    (tree, *more) = trees(text).items
    items = tree.items if not more else []
    fitting = [item.end for item in items if item.end <= _MAX_SHOWN - len(" ...)")]
    if not fitting:
        return text[: _MAX_SHOWN - len(" ...")] + " ..."
    return f"{text[: fitting[-1]]} ...{_CLOSERS[tree.opener]}"


def _without(text: str, omitted: Sequence[tuple[int, int]]) -> str:
    """Return a text with ``...`` in place of ranges, the outermost ones."""
    for start, end in sorted(omitted, reverse=True):
        if not any(a <= start and end <= b and (a, b) != (start, end) for a, b in omitted):
            text = f"{text[:start]}...{text[end:]}"
    return text


def _habits(source: Source, regions: Sequence[tuple[int, int]], unbound: frozenset[int]) -> Iterator[Habit]:
    """Iterate over the constructs in some ranges of a text; ``unbound`` are the starts of undefined names."""
    words = frozenset(re.findall(r'\(bind\s+"([^"\s]+)"', source.text))
    for start, end in regions:
        root = trees(source.text, start, end)
        yield from _commas(source, root)
        yield from _spellings(source, start, end)
        for tree in walk(root):
            if tree.opener:
                yield from _forms(source, tree)
                yield from _infix(source, tree)
                yield from _parallel_lets(source, tree, unbound)
                yield from _bare_calls(source, tree, words)
                if not _calls_defined_name(source, tree, unbound):
                    yield from _calls_of_words(source, tree, words, unbound)
                    yield from _primitives_of_other_tools(source, tree, words, unbound)
                yield from _adjacent_calls(source, tree)
                yield from _color_names(source, tree, unbound)
            else:
                yield from _named(source, tree, unbound)
        yield from _adjacent_calls(source, root)
        yield from _assignments(source, root)


def _regions(text: str, errors: Sequence[Diagnostic]) -> list[tuple[int, int]]:
    """Return the ranges (start, end) of the top-level forms that contain errors; overlapping ones are joined."""
    form_starts = _form_starts(text)
    regions: list[tuple[int, int]] = []
    for start, end in sorted({(d.span.start, d.span.end) for d in errors if d.span is not None}):
        end = max(end, start + 1)  # an empty span, such as that of a missing bracket, is in the form that begins there
        started = bisect_right(form_starts, start)  # number of forms that begin at the error or before it
        following = bisect_left(form_starts, end)  # number of the first form behind the error
        region_start = form_starts[started - 1] if started else 0
        region_end = form_starts[following] if following < len(form_starts) else len(text)
        if regions and region_start < regions[-1][1]:
            regions[-1] = (regions[-1][0], max(regions[-1][1], region_end))
        else:
            regions.append((region_start, region_end))
    return regions


def _form_starts(text: str) -> list[int]:
    """Return the starts of the top-level lists that begin a line; of all such lists if brackets do not match."""
    ranges, is_balanced = _ranges(text, restarts=False)
    if not is_balanced:
        return [match.start() for match in re.finditer(r"^\(", text, re.M)]
    return sorted(start for start, _, _ in ranges if text[start] == "(" and text[start - 1 : start] in ("", "\n"))


# --- names -----------------------------------------------------------------------------------------------------------


# Foreign names that are also plain words, and so likely names of variables: reported only as the head of a list.
_WORDS = frozenset((
    "move", "place", "group", "combine", "assembly", "resize", "turn", "rotation", "translation", "module", "colour",
    "power", "display", "size", "head", "throw", "extend", "div", "rem",
))  # fmt: skip
_CLOCKS = frozenset(("t", "$t", "time", "frame"))  # names of the time in other tools
_TESTED = lazy_pattern(r"\((?:(?:if|when|unless|while|and|or|not|define\s+\S+)\s+)?\Z")  # before the test of a form
_TRUE = "write `#t`"
_VIDEO = "a video lists its frames: `(frames (for/list ((i (iota 24))) ...))`, where an angle is `(* tau (/ i 24))`"
_OPERATORS = frozenset(("&&", "||", "==", "===", "**", "^"))


# Text before a name that a form of any language defines; the rest of "def..." may be misspelled.
_DEFINERS = r"\((?:def\w*|param|setq|setf|const|let|var|function)\s+\(?"


def _named(source: Source, tree: Tree, unbound: frozenset[int]) -> Iterator[Habit]:
    """Names, methods and module functions of other languages."""
    if tree.text in _CLOCKS and tree.start in unbound:
        is_truth = tree.text == "t" and _TESTED.search(source.text, 0, tree.start) is not None
        hint = _TRUE if is_truth else _VIDEO
        message = f"`{tree.text}` is not defined{'' if is_truth else ', and there is no clock'}"
        fix = Fix("Change to `#t`", (Edit(Span(source, tree.start, tree.end), "#t"),), safe=True) if is_truth else None
        diagnostic = _diagnostic(source, tree.start, tree.end, message, hint, fix)
        yield Habit(tree.start, tree.end, (), frozenset(), diagnostic)
        return
    name = NAMES.get(tree.text)
    if tree.text in _WORDS and source.text[tree.start - 1 : tree.start] != "(":
        return
    if name is not None and re.search(rf"{_DEFINERS}{re.escape(tree.text)}(?=[\s)])", source.text):
        return  # the program defines the name itself
    if tree.text in _OPERATORS and source.text[tree.start - 1 : tree.start] != "(":
        name = Term(NAMES[tree.text].language, hint=f"the operator comes first: `({NAMES[tree.text].instead} a b)`")
    instead = name.instead if name is not None else _module_function(tree.text)
    language = name.language if name is not None else "JavaScript" if tree.text.startswith("Math.") else "Python"
    hint = name.hint if name is not None else ""
    if not instead and not hint:
        yield from _member(source, tree)
        return
    fix = None
    if instead:
        hint = f"write `{instead}`"
        fix = Fix(f"Change to `{instead}`", (Edit(Span(source, tree.start, tree.end), instead),), safe=True)
    message = f"`{tree.text}` is {language}, not the Scene Language"
    yield Habit(tree.start, tree.end, (), frozenset(), _diagnostic(source, tree.start, tree.end, message, hint, fix))


_MEMBER = lazy_pattern(rf"({WORD})\.({WORD})\Z")

# Methods of other languages, and the functions of this one.
_METHODS = {
    "append": "push!", "push": "push!", "add": "add!", "extend": "extend!", "pop": "pop!", "length": "length",
    "size": "length", "map": "map", "filter": "filter", "reverse": "reverse", "sort": "sort", "keys": "keys",
    "values": "values", "insert": "insert!", "remove": "remove!", "slice": "slice", "concat": "append", "get": "ref",
    "count": "length", "upper": "string-upcase", "lower": "string-downcase", "split": "string-split",
}  # fmt: skip
_FUNCTION_FIRST = frozenset(("map", "filter"))
_COPIES = frozenset(("clone", "copy", "deepcopy", "duplicate", "instance"))


def _member(source: Source, tree: Tree) -> Iterator[Habit]:
    """``leg.height`` and ``xs.append``: fields of records, and methods."""
    match = _MEMBER.match(tree.text)
    if match is None:
        return
    owner, name = match.groups()
    fix = None
    record = re.search(rf"\(define-record\s+\(?([\w-]+)[^()]*[\s(]{re.escape(name)}[\s):]", source.text)
    if record is not None:
        written = f"({record[1]}-{name} {owner})"
        hint = f"write `{written}`: a field is read by its function"
        fix = Fix(f"Change to `{written}`", (Edit(Span(source, tree.start, tree.end), written),), safe=True)
    elif name in _METHODS:
        instead = _METHODS[name]
        hint = f"write `({instead} f {owner})`" if name in _FUNCTION_FIRST else f"write `({instead} {owner} ...)`"
        if name == "length":
            hint = f"write `(length {owner})`"
    elif re.search(r"\(set!\s+\Z", source.text[: tree.start]):
        hint = f"entities do not change: give `:{name}` in the call that makes `{owner}`"
    elif name in _COPIES:
        hint = f"a value is used as often as it is named: `(transform {owner} (translate [1 0 0]))`"
    else:
        hint = f"fields are read by functions, `(leg-{name} {owner})`, and items of tables by `(ref {owner} key)`"
    message = f"`{tree.text}` is Python, not the Scene Language"
    yield Habit(tree.start, tree.end, (), frozenset(), _diagnostic(source, tree.start, tree.end, message, hint, fix))


def _module_function(text: str) -> str:
    """Return the name of a function of a module, such as ``math.sin``, in this language; empty if it has none."""
    module, dot, name = text.partition(".")
    if not dot or module not in MODULES:
        return ""
    return name if name in SAME else OTHER.get(name, "")


def _calls_defined_name(source: Source, tree: Tree, unbound: frozenset[int]) -> bool:
    """Return whether a form of another language, which has an error of its own, defines the name that is called."""
    head = tree.items[0] if tree.items else tree
    return head.start in unbound and head.text in _defined_names(source.text)


def _calls_of_words(source: Source, tree: Tree, words: frozenset[str], unbound: frozenset[int]) -> Iterator[Habit]:
    """``(cube :scale 2)`` and ``(call cube)``: words that are written as names, unless such a name is defined."""
    items = tree.items
    if tree.opener != "(" or not items:
        return
    head = items[0]
    if head.start in unbound and (is_word(head.text) or head.text in words):
        instead = f'call "{head.text}"'
        rest = source.text[head.end : tree.end]
        text = f"({instead}{rest}"
        edit = Edit(Span(source, head.start, head.end), instead)
        if source.text[: tree.start].rstrip().endswith("(call") and len(items) == 1:
            text = f'"{head.text}"'
            edit = Edit(Span(source, tree.start, tree.end), text)
        hint = f"write `{_shown(text)}`"
        is_sure = len(items) == 1 or is_word(head.text) or items[1].text.startswith((":", '"', "<"))
        if not is_sure:
            hint = f'a word takes attributes: `(call "{head.text}" :name value)`'
        fix = Fix("Call the word", (edit,), safe=True) if is_sure else None
        message = f'"{head.text}" is a word, not a function: it is called by `call`'
        inner = tuple((item.start, item.end) for item in items[1:])
        yield Habit(tree.start, tree.end, inner, frozenset(),
                    _diagnostic(source, head.start, head.end, message, hint, fix))  # fmt: skip
    elif head.text == "call" and len(items) > 1 and _is_function(source.text, items[1].text.strip('"'), words):
        name = items[1].text.strip('"')
        rest = f"{name}{source.text[items[1].end : tree.end]}"
        fix = Fix("Call the function", (Edit(Span(source, tree.start, tree.end), f"({rest}"),), safe=True)
        message = f"`{name}` is a function, not a word"
        yield Habit(tree.start, tree.end, (), frozenset(), _diagnostic(
            source, items[1].start, items[1].end, message, f"write `({_shown(rest)}`", fix))  # fmt: skip
    elif head.text in ("call", "bind", "primitive") and len(items) > 1 and re.fullmatch(WORD, items[1].text):
        word = items[1]
        fix = Fix("Write the word in quotes", (Edit(Span(source, word.start, word.end), f'"{word.text}"'),), safe=True)
        message = f"a word is a string: `{word.text}` has no quotes"
        yield Habit(word.start, word.end, (), frozenset(),
                    _diagnostic(source, word.start, word.end, message, f'write `"{word.text}"`', fix))  # fmt: skip


def _is_function(text: str, name: str, words: frozenset[str]) -> bool:
    """Return whether a text defines a function ``name``, and no word of this name."""
    if name in words or is_word(name) or re.fullmatch(WORD, name) is None:
        return False
    return re.search(rf"\(define (\({re.escape(name)}[\s)]|{re.escape(name)}\s+\(lambda)", text) is not None


def _primitives_of_other_tools(
    source: Source, tree: Tree, words: frozenset[str], unbound: frozenset[int]
) -> Iterator[Habit]:
    """``(plane 4 4)`` and ``(perspective-camera 40)``: primitives, lights and cameras of other tools."""
    head = tree.items[0] if tree.items else tree
    if tree.opener != "(" or head.start not in unbound or is_word(head.text) or head.text in words:
        return
    hint = meaning_of_function(head.text) if head.text not in NAMES else None
    if hint is not None:
        message = f"`{head.text}` is a name of other tools, not of the Scene Language"
        inner = tuple((item.start, item.end) for item in tree.items[1:])
        yield Habit(tree.start, tree.end, inner, frozenset(),
                    _diagnostic(source, head.start, head.end, message, hint, None))  # fmt: skip


def _adjacent_calls(source: Source, tree: Tree) -> Iterator[Habit]:
    """``f(3)`` and ``rgb(255, 0, 0)``: a name directly before its arguments."""
    for head, arguments in zip(tree.items, tree.items[1:]):
        is_call = head.end == arguments.start and arguments.opener == "(" and re.fullmatch(WORD, head.text)
        if not is_call or any(item.text == "'" for item in arguments.items):
            continue
        items = [source.text[item.start : item.end] for item in arguments.items if item.text != ","]
        instead = f"({' '.join([head.text, *items])})"
        fix = Fix("Move the name inside", (Edit(Span(source, head.start, arguments.end), instead),), safe=True)
        message = f"`{_shown(source.text[head.start : arguments.end])}` is a call as in Python or JavaScript"
        inner = ((head.start, head.end), *((item.start, item.end) for item in arguments.items if item.text != ","))
        diagnostic = _diagnostic(
            source,
            head.start,
            arguments.end,
            message,
            f"write `{_shown(instead)}`: the function stands inside the parentheses",
            fix,
        )
        yield Habit(head.start, arguments.end, inner, frozenset(), diagnostic, "call")


_DEFINITION = _DEFINERS + r"([^\s()\[\]]+)|\(\(([^\s()\[\]:]+)\s"


@lru_cache(maxsize=4)
def _defined_names(text: str) -> tuple[str, ...]:
    """Return the names that a text seems to define, and the first ones that its loops and ``let`` bind."""
    return tuple({name for pair in re.findall(_DEFINITION, text) for name in pair if name})


_BODIES = ("lambda", "define", "let", "let*", "begin", "union")


def _bare_calls(source: Source, tree: Tree, words: frozenset[str]) -> Iterator[Habit]:
    """``(lambda () fence 5)``: a function of the program with its argument, without parentheses."""
    items = tree.items
    if tree.opener != "(" or len(items) < _BINDING_LENGTH + 1 or items[0].text not in _BODIES:
        return
    name, argument = items[-2], items[-1]
    if name.opener or (items[0].text == "define" and len(items) == _BINDING_LENGTH + 1):
        return
    if not _is_function(source.text, name.text, words):
        return
    written = f"({source.text[name.start : argument.end]})"
    fix = Fix("Call the function", (Edit(Span(source, name.start, argument.end), written),), safe=True)
    message = f"`{name.text}` is a function, and is called in parentheses"
    diagnostic = _diagnostic(source, name.start, argument.end, message, f"write `{_shown(written)}`", fix)
    yield Habit(name.start, argument.end, (), frozenset(), diagnostic)


_BINDING_LENGTH = 2  # items of `(name value)`


def _parallel_lets(source: Source, tree: Tree, unbound: frozenset[int]) -> Iterator[Habit]:
    """``(let ((a 1) (b (+ a 1))) ...)``: a value that reads a name of the same ``let``, which it does not see."""
    if tree.opener != "(" or len(tree.items) < _BINDING_LENGTH or tree.items[0].text != "let":
        return
    bindings = [item for item in tree.items[1].items if len(item.items) == _BINDING_LENGTH]
    names = {item.items[0].text: number for number, item in enumerate(bindings)}
    for number, binding in enumerate(bindings):
        value = binding.items[1]
        for atom in (value, *walk(value)):
            if atom.start not in unbound or atom.text not in names:
                continue
            head, defined = tree.items[0], bindings[names[atom.text]]
            edit = Edit(Span(source, head.start, head.end), "letrec" if names[atom.text] == number else "let*")
            hint = f"write `{edit.text}`, which binds the names one after another"
            fixes: tuple[Fix, ...] = (Fix(f"Change to `{edit.text}`", (edit,), safe=True),)
            if names[atom.text] == number:
                hint = "write `letrec`, whose values see all its names"
            elif names[atom.text] > number:
                hint, fixes = f"write `let*`, and bind `{atom.text}` first", ()
            message = f"`{atom.text}` is not visible in the values of the `let` that binds it"
            note = Note("it is bound here", Span(source, defined.start, defined.end))
            diagnostic = Diagnostic("unbound", message, Span(source, atom.start, atom.end), hint, (note,), fixes=fixes)
            yield Habit(atom.start, atom.end, (), frozenset((atom.text,)), diagnostic)


def _color_names(source: Source, tree: Tree, unbound: frozenset[int]) -> Iterator[Habit]:
    """``:color red``."""
    for key, value in zip(tree.items, tree.items[1:]):
        known = ("color", "rgb", "hsv", "hsl", *_defined_names(source.text))
        is_name = value.text.isalpha() and value.text not in (*known, *NAMES) and not near_names(value.text, known)
        if key.text == ":color" and value.start in unbound and is_name:
            instead = f'(color "{value.text}")'
            fix = Fix("Convert the name", (Edit(Span(source, value.start, value.end), instead),), safe=True)
            diagnostic = _diagnostic(source, value.start, value.end, "the name of a color is converted by `color`",
                                     f"write `{instead}`", fix)  # fmt: skip
            yield Habit(value.start, value.end, (), frozenset(), diagnostic)


def _assignments(source: Source, root: Tree) -> Iterator[Habit]:
    """``x = 3`` and ``(x = 3)`` at top level."""
    items = root.items
    triples = [*zip(items, items[1:], items[2:]), *(tree.items for tree in items if len(tree.items) == 3)]
    for name, sign, value in triples:
        if sign.text == "=" and re.fullmatch(WORD, name.text):
            text = f"(define {name.text} {source.text[value.start : value.end]})"
            around = next((tree for tree in items if tree.items[:1] == [name]), None)
            span = Span(source, around.start, around.end) if around else Span(source, name.start, value.end)
            fix = Fix("Write a definition", (Edit(span, text),), safe=True)
            yield Habit(name.start, value.end, ((value.start, value.end),), frozenset((name.text,)),
                        _diagnostic(source, name.start, value.end, "names are defined by `define`, not by `=`",
                                    f"write `{_shown(text)}`", fix))  # fmt: skip


_DECIMAL = lazy_pattern(r":[\w-]+\s+-?\d+,\d\Z")


def _is_decimal(text: str, comma: Tree) -> bool:
    """Return whether a comma is a decimal separator, as in ``:scale 1,5``."""
    return _DECIMAL.search(text[max(0, comma.start - _MAX_SHOWN) : comma.end + 1]) is not None


def _is_unquote(text: str, comma: Tree) -> bool:
    """Return whether a comma belongs to the next datum, as in a template: `` `(1 ,size) ``."""
    return text[comma.start - 1 : comma.start].isspace() and not text[comma.end : comma.end + 1].isspace()


def _commas(source: Source, root: Tree) -> Iterator[Habit]:
    """Commas between the items of an array or a call, and in the lists inside it, which are one habit."""
    pending = list(root.items)
    while pending:
        tree = pending.pop()
        commas = _separators(source.text, tree)
        if not commas:
            pending += tree.items
        elif _is_tuple(tree):
            yield _tuple(source, tree)
        else:
            edits = tuple(_edits_of_commas(source, tree))
            inner = tuple(
                (item.start, item.end) for item in tree.items if item.opener and not _has_commas(source, item)
            )
            hint = f"write `{_shown(_edited(source, tree, edits))}`"
            fix = Fix("Remove the commas", edits, safe=True)
            yield Habit(tree.start, tree.end, inner, frozenset(),
                        _diagnostic(source, commas[0].start, commas[0].end,
                                    "items are separated by spaces, not by commas", hint, fix), "commas")  # fmt: skip


def _separators(text: str, tree: Tree) -> list[Tree]:
    """Return the commas that separate the items of a list; a decimal comma, and one of a template, do not."""
    commas = [item for item in tree.items if item.text == "," and not _is_unquote(text, item)]
    return [] if tree.opener == "(" and all(_is_decimal(text, comma) for comma in commas) else commas


def _has_commas(source: Source, tree: Tree) -> bool:
    """Return whether commas separate the items of a list or of a list inside it."""
    return any(_separators(source.text, part) for part in (tree, *walk(tree)))


def _is_tuple(tree: Tree) -> bool:
    """Return whether a list in parentheses begins with a number."""
    return tree.opener == "(" and re.match(r"[-+.]?\d", tree.items[0].text) is not None


def _edits_of_commas(source: Source, tree: Tree) -> Iterator[Edit]:
    """Iterate over the edits that remove the commas of a list and of those inside it, in order."""
    edits: list[Edit] = []
    for part in (tree, *walk(tree)):
        commas = _separators(source.text, part)
        for comma in commas:
            after = source.text[comma.end : comma.end + 1]
            edits.append(Edit(Span(source, comma.start, comma.end), "" if after.isspace() else " "))
        if commas and _is_tuple(part):
            edits.append(Edit(Span(source, part.start, part.start + 1), "["))
            edits.append(Edit(Span(source, part.end - 1, part.end), "]"))
    yield from sorted(edits, key=lambda edit: edit.span.start)


def _edited(source: Source, tree: Tree, edits: Sequence[Edit]) -> str:
    """Return the text of a list after edits in it, which are in order."""
    written = source.text[tree.start : tree.end]
    for edit in reversed(edits):
        start, end = edit.span.start - tree.start, edit.span.end - tree.start
        written = written[:start] + edit.text + written[end:]
    return written


_INFIX_NAMES = {form.pattern.split()[1]: form.instead.split()[0].lstrip("(") for form in FORMS if form.hint == INFIX}
_BINDING_POWERS = (
    ("or", "||"),
    ("and", "&&"),
    ("<", ">", "<=", ">=", "=="),
    ("+", "-"),
    ("*", "/", "%", "//"),
    ("**", "^"),
)
_POWER_OF = {operator: power for power, operators in enumerate(_BINDING_POWERS) for operator in operators}


def _infix(source: Source, tree: Tree) -> Iterator[Habit]:
    """Arithmetic in infix notation among the items of an array or the arguments of a call: ``[i * 1.5 0 0]``."""
    first = 0 if tree.opener == "[" else 1
    items = tree.items[first:]
    start = 0
    while start + 2 < len(items):
        end = start + 1
        while end + 1 < len(items) and _is_operator(items[end]) and _is_operand(items[end - 1], items[end + 1]):
            end += 2
        run = items[start:end]
        if len(run) > 1 and "\n" not in source.text[run[0].start : run[-1].end]:
            text = _prefixed(source, run)
            edits = (Edit(Span(source, run[0].start, run[-1].end), text),)
            written = _edited(source, tree, edits) if tree.opener == "[" else text
            message = f"`{_shown(source.text[run[0].start : run[-1].end])}` is infix notation: {INFIX}"
            diagnostic = _diagnostic(source, run[0].start, run[-1].end, message, f"write `{_shown(written)}`",
                                     Fix("Write the operator first", edits))  # fmt: skip
            inner = tuple((item.start, item.end) for item in run if item.opener)
            yield Habit(tree.start, tree.end, inner, frozenset(), diagnostic, "infix")
        start = end


def _is_operator(tree: Tree) -> bool:
    """Return whether a datum is an operator; ``//`` more often begins a comment of another language."""
    return tree.text in _POWER_OF and tree.text != "//"


def _is_operand(*items: Tree) -> bool:
    """Return whether datums may be operands: no operators, keywords or strings."""
    return not any(
        _is_operator(item) or _is_entity(item) or item.text.startswith((":", '"', "'", ",", "//")) for item in items
    )


def _prefixed(source: Source, run: Sequence[Tree]) -> str:
    """Return operands and operators in turn as a nested call; operators of one power group to the left."""
    if len(run) == 1:
        return source.text[run[0].start : run[0].end]
    operators = range(1, len(run), 2)
    last = min(reversed(operators), key=lambda i: _POWER_OF[run[i].text])
    left, right = _prefixed(source, run[:last]), _prefixed(source, run[last + 1 :])
    name = _INFIX_NAMES[run[last].text]
    same = left.startswith(f"({name} ") and last > 1 and name in ("+", "*") and run[last - 2].text == run[last].text
    return f"{left[:-1]} {right})" if same else f"({name} {left} {right})"


def _tuple(source: Source, tree: Tree) -> Habit:
    """``(1, 2, 3)``: numbers in parentheses."""
    written = f"[{' '.join(source.text[item.start : item.end] for item in tree.items if item.text != ',')}]"
    fix = Fix("Write an array", (Edit(Span(source, tree.start, tree.end), written),), safe=True)
    message = f"`{_shown(source.text[tree.start : tree.end])}` is Python, not the Scene Language"
    hint = f"write `{_shown(written)}`: an array is written in square brackets"
    return Habit(tree.start, tree.end, (), frozenset(), _diagnostic(source, tree.start, tree.end, message, hint, fix))


def _spellings(source: Source, first: int, last: int) -> Iterator[Habit]:
    """Literals, comments and accesses that are spelled as in another language."""
    text = _masked(source.text[first:last])
    for row in SPELLINGS:
        for match in re.finditer(row.pattern, text, re.S):
            start, end = match.start() + first, match.end() + first
            written = source.text[start:end]
            if written.startswith("//") and text[: match.start()].rstrip().endswith("("):
                continue  # the function `//`
            if "comment" in row.hint and row.instead == "":
                yield _comment(source, start, end, row)
                continue
            instead = match.expand(row.instead)
            is_filled = written == "f" and "{" in source.text[end : source.text.find('"', end + 1)]  # an f-string
            fix = Fix(f"Change to `{_shown(instead)}`" if instead else "Remove it",
                      (Edit(Span(source, start, end), instead),), row.is_sure and not is_filled)  # fmt: skip
            hint = f"write `{_shown(instead.strip())}`: {row.hint}" if instead.strip() else row.hint
            message = f"`{_shown(written)}` is {row.language}, not the Scene Language"
            hides = row.pattern.startswith(";")
            if hides:
                message = "`;` begins a comment, which hides the rest of the line"
            diagnostic = _diagnostic(source, start, end, message, hint, fix)
            yield Habit(start, end, (), frozenset(), diagnostic, row, hides)


def _comment(source: Source, start: int, end: int, row: Spelling) -> Habit:
    """Return the occurrence of a comment of another language; its text is kept."""
    written = source.text[start:end]
    lead = len(written) - len(written.lstrip())
    mark = re.match(r"//|#|/\*|--+", written.strip())
    begin = start + lead
    length = len(mark.group()) if mark else 1
    if written.strip().startswith("/*"):
        edits: tuple[Edit, ...] = (Edit(Span(source, begin, begin + 2), "#|"), Edit(Span(source, end - 2, end), "|#"))
    else:
        edits = (Edit(Span(source, begin, begin + length), ";"),)
    message = f"`{mark.group() if mark else '#'}` does not begin a comment"
    fix = Fix("Write `;`", edits, safe=True)
    return Habit(begin, end, (), frozenset(), _diagnostic(source, begin, begin + length, message, row.hint, fix))


_HIDDEN = lazy_pattern(r'"(?:[^"\\]|\\.)*"|(?<!#);[^\n]*(?=\n|$)', re.S)


def _masked(text: str) -> str:
    """Return a text of the same length with blank strings and comments; a comment of brackets only is kept."""

    def blank(match: re.Match[str]) -> str:
        hidden = match.group()
        if hidden.startswith(";"):
            return hidden if not hidden.strip(";)]} \t") else " " * len(hidden)
        return '"' + " " * (len(hidden) - 2) + '"'

    return _HIDDEN.sub(blank, text)


# --- forms -----------------------------------------------------------------------------------------------------------


@cache
def _patterns() -> dict[str, list[tuple[Idiom, Tree]]]:
    """Return the patterns by the literal that a form must contain: the head, or the second datum of an infix form."""
    by_literal: dict[str, list[tuple[Idiom, Tree]]] = {}
    for form in FORMS:
        tree = trees(form.pattern).items[0]
        literal = next((item.text for item in tree.items[:2] if item.text and not item.text.startswith("?")), "")
        by_literal.setdefault(literal, []).append((form, tree))
    return by_literal


def _forms(source: Source, tree: Tree) -> Iterator[Habit]:
    """Yield a diagnostic for a form of another language, of the first pattern that matches it, with its replacement."""
    patterns = _patterns()
    keys = dict.fromkeys([*(item.text for item in tree.items[:2] if item.text), ""])
    for form, pattern in (row for key in keys for row in patterns.get(key, ())):
        bound: dict[str, list[Tree]] = {}
        if not _matches(pattern, tree, bound):
            continue
        start, end = tree.start, tree.end
        inner = tuple((part.start, part.end) for parts in bound.values() for part in parts)
        names = frozenset(part.text for part in bound.get(form.defines, ()) if part.text)
        if form.instead.startswith(("(for", "(apply")):
            variables = [*bound.get("i", ()), *bound.get("x", ())]
            variables += [clause.items[0] for clause in bound.get("clauses", ()) if clause.items]
            names |= {variable.text for variable in variables if variable.text}
        parameters = _parameter_list(form, tree, bound)
        if parameters is not None:
            names |= {
                name for parameter in (*bound.get("args", ()), *bound.get("a", ())) if (name := _parameter(parameter))
            }
        if form.instead.startswith("(define-record"):
            names |= {f"{name}{end}" for name in names for end in _record_names(bound["fields"])}
        message = f"`{_shown(source.text[start:end])}` is {form.language}, not the Scene Language"
        if not form.instead:
            diagnostic = _diagnostic(source, start, end, message, form.hint, None)
        else:
            instead = _filled(source, form.instead, bound)
            fix = Fix(f"Change to `{_shown(instead)}`", (Edit(Span(source, start, end), instead),), form.is_sure)
            hint = f"write `{_shown(instead)}`: {form.hint}"
            diagnostic = _diagnostic(source, start, end, message, hint, fix)
        yield Habit(start, end, inner, names, diagnostic, form, parameters=parameters)
        return


def _parameter_list(form: Idiom, tree: Tree, bound: Mapping[str, Sequence[Tree]]) -> tuple[int, int] | None:
    """Return the range of the parameters of a function that is written as in another language."""
    if not form.instead.startswith("(lambda ("):
        return None
    listed = next((item for item in tree.items[1:2] if item.opener and bound.get("args")), None)
    if listed is not None:
        return listed.start, listed.end
    named = [*bound.get("a", ()), *bound.get("x", ())]
    return (named[0].start, named[-1].end + 1) if named else None


def _parameter(tree: Tree) -> str:
    """Return the name of a parameter: ``x``, ``:x``, ``x::Number``, or the first of ``(:x 1)``; empty for others."""
    first = tree.items[0] if tree.items else tree
    return first.text.lstrip(":").partition("::")[0]


def _record_names(fields: Sequence[Tree]) -> Iterator[str]:
    """Iterate over the endings of the names of a record's procedures."""
    yield "?"
    yield from (f"-{field.text}" for field in fields)


def _is_parameter(tree: Tree) -> bool:
    """Return whether a datum may be a parameter of a function, or a separator of two."""
    if tree.opener:
        first = tree.items[0] if len(tree.items) == _WITH_DEFAULT else None
        return first is not None and not first.opener and _is_parameter(first)
    return re.fullmatch(r"[,.:&]|[:&]?[A-Za-z_][^\s()\[\]\"';,]*", tree.text) is not None


_WITH_DEFAULT = 2  # items of a parameter with its default

_NOT_AN_ENTITY = lazy_pattern(r'[-+.]?\d|["\':#]')


def _is_entity(tree: Tree) -> bool:
    """Return whether a datum is certainly an entity: a call of a word, or a combination of parts."""
    return tree.opener == "(" and bool(tree.items) and tree.items[0].text in ("call", "union", "transform", "primitive")


_INDEX = r"\d|[a-z]\Z|i(ndex|dx)?\Z|[-+*%]\Z|//\Z"  # a number, a short name, or arithmetic


# Datums that the pattern variables of these names match; other variables match any datum.
_SHAPES: Mapping[str, Callable[[Tree], bool]] = {
    "?name": lambda tree: not tree.opener and re.fullmatch(SYMBOL, tree.text) is not None,
    "?parameters": _is_parameter,
    "?entity": _is_entity,
    "?index": lambda tree: re.match(_INDEX, tree.items[0].text if tree.items else tree.text) is not None,
    "?plural": lambda tree: re.fullmatch(r"[a-z-]+[^s]s", tree.text) is not None,
    "?child": lambda tree: tree.opener == "(" or (not tree.opener and _NOT_AN_ENTITY.match(tree.text) is None),
    "?v": lambda tree: bool(tree.opener) or _NOT_AN_ENTITY.match(tree.text) is None,
    "?vector": lambda tree: tree.opener == "[" or (not tree.opener and bool(re.match(r"[-+.]?\d", tree.text))),
}


def _matches(pattern: Tree, tree: Tree, bound: dict[str, list[Tree]]) -> bool:
    """Return whether a datum matches a pattern, and enter the datums of the pattern variables into ``bound``."""
    if not pattern.opener:
        if pattern.text.startswith("?"):
            if pattern.text.endswith(":"):
                if not tree.text.endswith(":"):
                    return False
                tree = Tree(tree.start, tree.end - 1, tree.text[:-1])
            shape = _SHAPES.get(pattern.text)
            if shape is not None and not shape(tree):
                return False
            bound[pattern.text[1:].rstrip(":")] = [tree]
            return True
        return tree.text == pattern.text
    if tree.opener != pattern.opener:
        return False
    items, wanted = _with_prefixes(tree.items), pattern.items
    if len(wanted) > 1 and wanted[-1].text == "...":
        fixed = wanted[:-2]
        if len(items) < len(fixed):
            return False
        rest, shape = wanted[-2].text, _SHAPES.get(wanted[-2].text)
        if shape is not None and not all(map(shape, items[len(fixed) :])):
            return False
        bound[rest[1:]] = items[len(fixed) :]
        return all(_matches(p, item, bound) for p, item in zip(fixed, items))
    return len(items) == len(wanted) and all(_matches(p, item, bound) for p, item in zip(wanted, items))


def _with_prefixes(items: list[Tree]) -> list[Tree]:
    """Return datums in which a quote and the quoted datum are one."""
    if not any(item.text == "'" for item in items[:-1]):
        return items
    joined: list[Tree] = []
    for item in items:
        if joined and joined[-1].text == "'":
            joined[-1] = Tree(joined[-1].start, item.end, "'...")
        else:
            joined.append(item)
    return joined


_VARIABLE = lazy_pattern(r"\?([a-z]+)(/2)?( \.\.\.)?")


def _filled(source: Source, template: str, bound: Mapping[str, Sequence[Tree]]) -> str:
    """Return a template in which the source text of the matched datums replaces the variables."""

    def text_of(match: re.Match[str]) -> str:
        parts = bound.get(match[1], ())
        if not parts:
            return ""
        if match[2]:
            texts = [source.text[part.start : part.end].lstrip(":") for part in parts]
            if all(part.opener and len(part.items) == 2 for part in parts):  # pairs already
                return " ".join(f"({text[1:-1].strip()})" for text in texts)
            return " ".join(f"({' '.join(texts[i : i + 2])})" for i in range(0, len(texts), 2))
        return source.text[parts[0].start : parts[-1].end]

    filled = _VARIABLE.sub(text_of, template)
    return re.sub(r"(?<=\() +| +(?=\))", "", filled)


# --- whole languages -------------------------------------------------------------------------------------------------

_LINE_START = lazy_pattern(r"^\s*[(\[;'`\"#)]")  # of a line of this language outside all brackets
_SHARE = 3  # a third of the lines of a piece, or three lines, decide its language; fewer may be chance


def _foreign_pieces(source: Source) -> list[Habit]:
    """Return the runs of top-level lines that are code of another language as a whole."""
    pieces = []
    for start, end, lines in _pieces(source.text):
        language = _language(lines)
        if language is None:
            continue
        name, hint = language
        first = source.text.find("\n", start, end)
        shown_end = first if first > 0 else end
        message = f"this is {name}, not the Scene Language"
        pieces.append(Habit(start, end, (), _names_in(lines),
                           _diagnostic(source, start, shown_end, message, hint, None), "whole"))  # fmt: skip
    return pieces


def _pieces(text: str) -> Iterator[tuple[int, int, list[str]]]:
    """Iterate over the start, the end and the lines of each run of lines that begin outside all brackets."""
    offset, start = 0, 0
    continued = _continued_lines(text)
    lines: list[str] = []
    for line in [*text.splitlines(keepends=True), "("]:
        is_native = not line.strip() or offset in continued or _LINE_START.match(line) is not None
        is_foreign = not is_native if not lines else not re.match(r"[(;]", line)
        if is_foreign or (lines and not line.strip()):
            if not lines:
                start = offset
            lines.append(line)
        elif lines:
            end = start + len("".join(lines).rstrip())
            yield start, end, [line_of_run for line_of_run in lines if line_of_run.strip()]
            lines = []
        offset += len(line)


def _continued_lines(text: str) -> frozenset[int]:
    """Return the starts of the lines inside a list, a string or a comment of the program.

    If some brackets do not match, a bracket in the first column begins a new list, and only indented lines count as
    items of an unclosed list, because code of another language begins in the first column.
    """
    ranges, is_balanced = _ranges(text, restarts=False)
    if not is_balanced:
        ranges, _ = _ranges(text, restarts=True)
    continued: set[int] = set()
    last = 0
    for start, end, is_closed in sorted(ranges):
        for match in re.finditer(r"\n" if is_closed else r"\n(?=[ \t])", text[max(start, last) : end]):
            continued.add(max(start, last) + match.end())
        last = max(last, end) if is_closed else last
    return frozenset(continued)


def _ranges(text: str, *, restarts: bool) -> tuple[list[tuple[int, int, bool]], bool]:
    """Return ``(start, end, is_closed)`` of each list, string and comment at top level, and whether all brackets match.

    The items of an unclosed list are included. If ``restarts``, a bracket in the first column begins a new list.
    """
    stack: list[int] = []
    closed: list[tuple[int, int, bool]] = []
    unclosed: list[tuple[int, int, bool]] = []
    is_balanced = True
    for match in _TOKEN.finditer(text):
        kind, start = match.lastgroup, match.start()
        if kind == "open":
            if restarts and stack and text[start - 1 : start] == "\n":
                unclosed.append((stack[0], start, False))
                stack.clear()
            stack.append(start)
        elif kind == "close":
            is_balanced = is_balanced and bool(stack)
            if stack:
                _close(closed, stack.pop(), match.end())
        elif kind in ("string", "comment"):
            _close(closed, start, match.end())
    if stack:
        unclosed.append((stack[0], len(text), False))
    return closed + unclosed, is_balanced and not stack


def _close(closed: list[tuple[int, int, bool]], start: int, end: int) -> None:
    """Add a range, and remove the ranges inside it, which are the last ones."""
    while closed and closed[-1][0] > start:
        closed.pop()
    closed.append((start, end, True))


def _language(lines: Sequence[str]) -> tuple[str, str] | None:
    """Return the language of a piece and a hint: that of its first line, else that of most lines."""
    best: tuple[bool, int, str, str] | None = None
    for name, pattern, hint in LANGUAGES:
        matches = [bool(pattern.match(line.strip())) for line in lines]
        row = (matches[0], sum(matches), name, hint)
        if any(matches) and (best is None or row[:2] > best[:2]):
            best = row
    if best is None or not (best[0] or best[1] * _SHARE >= len(lines) or best[1] >= _SHARE):
        return None
    return best[2], best[3]


_DEFINED = lazy_pattern(r"(?:def|function|module|class|const|let|var)\s+(\w+)|^(\w+)\s*=", re.M)


def _names_in(lines: Sequence[str]) -> frozenset[str]:
    """Return the names that foreign code defines, which the rest of the text may use."""
    return frozenset(name for pair in _DEFINED.findall("".join(lines)) for name in pair if name)


__all__ = ["FORMS", "NAMES", "SPELLINGS", "Habit", "explain"]
