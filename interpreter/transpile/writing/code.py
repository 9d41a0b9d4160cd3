"""Intermediate representation of the output: like datums, but with unnamed variables and attached comments."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, TypeAlias

from scenelang.grammar.datum import ArrayDatum, Atom, Datum, Keyword, ListDatum, Source, Span, Symbol
from scenelang.grammar.diagnostics import Diagnostic, SceneError
from scenelang.grammar.formatter import settled
from scenelang.grammar.layout import Trivia, layout, line_comment
from scenelang.grammar.reader import read
from scenelang.interpreter.expand.forms import FORMS, INDENTS
from scenelang.interpreter.lift.lift import Lifted
from scenelang.interpreter.transpile.analysis.scopes import PythonVariable

Finish: TypeAlias = Callable[[Sequence[Datum], Mapping[int, Trivia], Mapping[int, str]], Lifted]


class Code:
    """Node of the output.

    ``span`` is its location in the Python code; ``before``, ``after`` and ``blank`` are comments and spacing.
    """

    __slots__ = ("after", "before", "blank", "span")

    def __init__(self, span: Span | None) -> None:
        self.span = span
        self.before: tuple[str, ...] = ()
        self.after: str | None = None
        self.blank = False


class LiteralCode(Code):
    """Number, string, Boolean or ``none``; ``text`` preserves the spelling of a number."""

    __slots__ = ("text", "value")

    def __init__(self, value: Any, span: Span | None = None, text: str | None = None) -> None:
        super().__init__(span)
        self.value = value
        self.text = text


class Name(Code):
    """Name of the language: the head of a form, a builtin, or a literal such as ``else``."""

    __slots__ = ("text",)

    def __init__(self, text: str, span: Span | None = None) -> None:
        super().__init__(span)
        self.text = text


class Key(Code):
    """Keyword of a library function, ``:name``."""

    __slots__ = ("text",)

    def __init__(self, text: str, span: Span | None = None) -> None:
        super().__init__(span)
        self.text = text


class VariableRef(Code):
    """Variable of the Python program, read or bound; printed as ``:name`` if ``is_keyword``."""

    __slots__ = ("is_keyword", "variable")

    def __init__(self, variable: PythonVariable, span: Span | None = None, is_keyword: bool = False) -> None:
        super().__init__(span)
        self.variable = variable
        self.is_keyword = is_keyword


class ArgumentName(Code):
    """Name of a keyword argument, ``:name``, spelled like the parameters of that name."""

    __slots__ = ("python",)

    def __init__(self, python: str, span: Span | None = None) -> None:
        super().__init__(span)
        self.python = python


class FormCode(Code):
    """List ``(a b c)``; ``rest`` is the tail after a dot in a parameter list."""

    __slots__ = ("items", "rest")

    def __init__(self, items: Sequence[Code], span: Span | None = None, rest: Code | None = None) -> None:
        super().__init__(span)
        self.items = list(items)
        self.rest = rest


def lambda_list(parameters: FormCode) -> Code:
    """Return the parameters of a ``lambda``: a list, or only the rest parameter."""
    return parameters if parameters.items or parameters.rest is None else parameters.rest


class Brackets(Code):
    """Array ``[a b c]``."""

    __slots__ = ("items",)

    def __init__(self, items: Sequence[Code], span: Span | None = None) -> None:
        super().__init__(span)
        self.items = list(items)


Node: TypeAlias = LiteralCode | Name | Key | VariableRef | ArgumentName | FormCode | Brackets


def children(code: Code) -> Sequence[Code]:
    """Return the direct children of a node."""
    if isinstance(code, FormCode):
        return code.items if code.rest is None else [*code.items, code.rest]
    return code.items if isinstance(code, Brackets) else ()


def walk(*codes: Code) -> Iterator[Code]:
    """Iterate over all nodes below and including ``codes`` in source order."""
    stack = list(reversed(codes))
    while stack:
        code = stack.pop()
        yield code
        if type(code) is FormCode or type(code) is Brackets:
            stack.extend(reversed(children(code)))


def count_refs(code: Code, variable: PythonVariable) -> int:
    """Return the number of occurrences of ``variable`` in ``code``."""
    return sum(1 for node in walk(code) if type(node) is VariableRef and node.variable is variable)


def replace(code: Code, match: Callable[[Code], bool], by: Code) -> bool:
    """Replace the first node inside ``code`` that matches with ``by``; return whether there was one."""
    stack: list[Code] = [code]
    while stack:
        node = stack.pop()
        if isinstance(node, (FormCode, Brackets)):
            for position, item in enumerate(node.items):
                if match(item):
                    move_comments(item, by)
                    node.items[position] = by
                    return True
            stack.extend(reversed(node.items))
    return False


def move_comments(source: Code, target: Code) -> None:
    """Move the comments of ``source`` to ``target``, before its own."""
    target.before = (*source.before, *target.before)
    if source.after:
        if target.after:
            target.before = (*target.before, source.after)
        else:
            target.after = source.after
    target.blank = source.blank or target.blank


# --- constructors ----------------------------------------------------------------------------------------------


def form(head: str, *items: Code, span: Span | None = None) -> FormCode:
    """Return ``(head item ...)``."""
    return FormCode([Name(head), *items], span)


def number(value: int | float, span: Span | None = None) -> LiteralCode:
    return LiteralCode(value, span)


def quote(code: Code, span: Span | None = None) -> FormCode:
    return FormCode([Name("quote"), code], span)


def none(span: Span | None = None) -> LiteralCode:
    return LiteralCode(None, span)


def is_form(code: Code, head: str) -> bool:
    """Return whether ``code`` is ``(head ...)`` with a name of the language as its head."""
    return type(code) is FormCode and bool(code.items) and type(code.items[0]) is Name and code.items[0].text == head


def is_literal(code: Code) -> bool:
    return type(code) is LiteralCode


def returns_parts(code: Code) -> bool:
    """Return whether the value is a list of parts already, so that a ``union`` around it is redundant."""
    head = code.items[0] if isinstance(code, FormCode) and code.items else None
    if type(head) is not Name:
        return False
    return head.text in ("union", "union-loop", "primitives") or head.text.endswith("/union")


# Names of variables in the output: kebab-case, without shadowing names that their scope uses.


_RESERVED = frozenset(FORMS) | {"none", "else", "unquote", "unquote-splicing", "=>", "...", "_", "scene", "param"}
_MACROS = frozenset({"call", "union", "union-loop", "transform"})


def kebab(name: str) -> str:
    """Convert a name to kebab-case: ``num_steps`` to ``num-steps``, ``FACE_COLORS`` to ``face-colors``.

    Underscores at the ends are preserved.
    """
    core = name.strip("_")
    if not core:
        return name
    start = name.index(core)
    prefix, suffix = name[:start], name[start + len(core) :]
    if core.isupper() and len(core) > 1:
        core = core.lower()
    elif core[0].isupper() and any(c.islower() for c in core):  # a class name
        core = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "-", core).lower()
    return prefix + re.sub(r"_+", "-", core) + suffix


class Namer:
    """Chooses ``PythonVariable.text`` for all variables of the output, which keep their names where they can.

    A builtin that a variable shadows is referred to by its qualified name, ``std/length``.

    ``table_keys`` are keyword parameters that tables contain as strings, which therefore keep their Python spelling.
    """

    def __init__(self, forms: Iterable[Code], table_keys: Iterable[str] = ()) -> None:
        self._forms = list(forms)
        self._keywords: dict[str, str] = {}
        self._table_keys = set(table_keys)
        self._own: set[str] = set()
        self._hidden: dict[PythonVariable, set[str]] = {}  # names of keyword parameters of scopes that use a variable

    def choose(self) -> None:
        """Name all variables, outer scopes first, and spell keyword arguments like their parameters."""
        keyword_names = {v.name for form in self._forms for v in _variables(form) if v.is_keyword}
        keyword_names |= {n.python for form in self._forms for n in walk(form) if type(n) is ArgumentName}
        for name in sorted(keyword_names):
            text = name if name in self._table_keys else kebab(name)
            self._keywords[name] = f"the-{text}" if text in _RESERVED or text in _MACROS else text
        self._own = {name for form in self._forms for node in walk(form) for name in _own_names(node)}
        for form in self._forms:
            self._find_hidden(form)
        top = self._top_level_variables()
        taken: dict[str, PythonVariable] = {}
        for variable in top:
            self._name(variable, taken, taken)
        for form in self._forms:
            self._scope(form, taken)
        for form in self._forms:
            for variable in _variables(form):  # undefined variables, which the checker reports
                variable.text = variable.text or _safe(kebab(variable.name))
            self._qualify_shadowed_builtins(form, frozenset(v.text for v in top))

    def keyword(self, python: str) -> str:
        """Return the name of a keyword argument."""
        return self._keywords.get(python, kebab(python))

    # --- scopes ------------------------------------------------------------------------------------------------

    def _top_level_variables(self) -> list[PythonVariable]:
        variables: dict[PythonVariable, None] = {}
        for form in self._forms:
            if isinstance(form, FormCode) and len(form.items) > 1 and type(form.items[0]) is Name:
                head, target = form.items[0].text, form.items[1]
                if head == "define" and isinstance(target, FormCode):
                    target = target.items[0]
                if head in ("define", "define-record") and type(target) is VariableRef:
                    variables[target.variable] = None
                elif head == "define-values":
                    variables.update(dict.fromkeys(v for v in _variables(target)))
        records = {v: None for form in self._forms for v in _variables(form) if v.record is not None}
        return [*variables, *(v for v in records if v not in variables)]

    def _find_hidden(self, code: Code) -> None:
        """Record which names a variable must not get, since a word keeps those of its parameters.

        Python has ``N`` beside ``n``.
        """
        for node in walk(code):
            keywords = [v for v in _bound_variables(node) if v.is_keyword]
            if keywords:
                texts = {self._keywords[v.name] for v in keywords}
                for variable in {n.variable for n in walk(node) if type(n) is VariableRef}.difference(keywords):
                    self._hidden.setdefault(variable, set()).update(texts)

    def _scope(self, code: Code, visible: dict[str, PythonVariable]) -> None:
        """Name the variables that ``code`` binds, scope by scope from the outermost."""
        stack: list[tuple[Code, dict[str, PythonVariable]]] = [(code, visible)]
        while stack:
            node, names = stack.pop()
            scope = _bound_variables(node)
            if scope:
                names = dict(names)
                referred = {n.variable for n in walk(node) if type(n) is VariableRef}
                outer = {t: v for t, v in names.items() if v in referred}
                for variable in sorted(scope, key=lambda v: v.is_temporary):
                    if not variable.text:
                        self._name(variable, outer, names)
                    outer[variable.text] = variable
                    names[variable.text] = variable
            stack.extend((child, names) for child in children(node))

    def _name(
        self,
        variable: PythonVariable,
        conflicts: dict[str, PythonVariable],
        taken: dict[str, PythonVariable],
    ) -> None:
        """Choose the text of a variable: its Python name in kebab case, numbered if that is taken."""
        if variable.text:
            return
        if variable.is_keyword:
            variable.text = self._keywords[variable.name]
        elif variable.record is not None:
            variable.text = _record_name(variable)
        else:
            stem = text = kebab(variable.name)
            count = 2
            if text in _RESERVED or text in _MACROS:
                stem = text = f"the-{stem}"
            hidden = self._hidden.get(variable, ())
            # only names that the scope refers to conflict; others may be shadowed
            while text in self._own or text in hidden or (text in conflicts and _differ(conflicts[text], variable)):
                text = f"{stem}{count}"
                count += 1
            variable.text = text
        taken[variable.text] = variable

    def _qualify_shadowed_builtins(self, code: Code, shadowed: frozenset[str]) -> None:
        """Refer to a builtin by its qualified name where a variable of the Python shadows it."""
        stack: list[tuple[Code, frozenset[str]]] = [(code, shadowed)]
        while stack:
            node, hidden = stack.pop()
            scope = _bound_variables(node)
            if scope:
                hidden = hidden | {v.text for v in scope}
            if type(node) is Name and node.text in hidden and node.text not in _RESERVED | self._own:
                node.text = f"std/{node.text}"
            stack.extend((child, hidden) for child in _without_fields(node))


def _without_fields(node: Code) -> Iterable[Code]:
    """Return the parts of a form; the names of the fields of a record are none of a builtin."""
    if not is_form(node, "define-record") or not isinstance(node, FormCode):
        return children(node)
    return [part for each in node.items[2:] if isinstance(each, FormCode) for part in each.items[1:]]


def _own_names(node: Code) -> Iterator[str]:
    """Names that a form of the output defines itself, such as the exit of a loop."""
    if is_form(node, "let/ec") or is_form(node, "define"):
        assert isinstance(node, FormCode)
        target = node.items[1]
        if isinstance(target, FormCode) and target.items:
            target = target.items[0]
        if type(target) is Name:
            yield target.text


def _safe(text: str) -> str:
    return f"the-{text}" if text in _RESERVED or text in _MACROS else text


def _differ(a: PythonVariable, b: PythonVariable) -> bool:
    """Return whether two variables must have different names; only shadowing in the Python code is preserved."""
    return a is not b and (a.name != b.name or a.is_temporary or b.is_temporary or a.function is b.function)


def _record_name(variable: PythonVariable) -> str:
    assert variable.record is not None
    record, kind, name = variable.record
    stem = record.text or kebab(record.name)
    return {
        "make": f"make-{stem}", "get": f"{stem}-{kebab(name)}", "set": f"set-{stem}-{kebab(name)}!", "is": f"{stem}?",
        "method": f"{stem}-{kebab(name)}", "constant": f"{stem}-{kebab(name)}",
    }[kind]  # fmt: skip


def _variables(code: Code) -> list[PythonVariable]:
    return [node.variable for node in walk(code) if type(node) is VariableRef]


def _bound_variables(node: Code) -> list[PythonVariable]:
    """Return the variables that a form binds for its body."""
    if type(node) is not FormCode or not node.items:
        return []
    head = node.items[0]
    if type(head) is not Name:
        return []
    text = head.text
    variables: list[PythonVariable] = []
    if text == "lambda" and len(node.items) > 1:
        variables = _parameters(node.items[1])
    elif text == "define" and len(node.items) > 1 and isinstance(node.items[1], FormCode):
        signature = node.items[1]
        variables = _parameters(FormCode(signature.items[1:], None, signature.rest))
    elif text in ("let", "let*") and len(node.items) > 1 and isinstance(node.items[1], FormCode):
        variables = [
            v for binding in node.items[1].items if isinstance(binding, FormCode) for v in _variables(binding.items[0])
        ]
    elif text.startswith("for") and len(node.items) > 1 and isinstance(node.items[1], FormCode):
        variables = [
            v for clause in node.items[1].items
            if isinstance(clause, FormCode) and len(clause.items) == 2 for v in _variables(clause.items[0])
        ]  # fmt: skip
    elif text == "let/ec" and len(node.items) > 1:
        variables = _variables(node.items[1])
    elif text == "guard" and len(node.items) > 1 and isinstance(node.items[1], FormCode) and node.items[1].items:
        variables = _variables(node.items[1].items[0])
    variables += _defined_in_body(node)
    return list(dict.fromkeys(variables))


def _parameters(code: Code) -> list[PythonVariable]:
    if not isinstance(code, FormCode):
        return _variables(code)
    variables: list[PythonVariable] = []
    for item in [*code.items, *([code.rest] if code.rest is not None else [])]:
        if type(item) is VariableRef:
            variables.append(item.variable)
        elif isinstance(item, FormCode) and item.items and type(item.items[0]) is VariableRef:
            variables.append(item.items[0].variable)
    return variables


def _defined_in_body(node: FormCode) -> list[PythonVariable]:
    """Return the variables defined directly inside a form, or in the clauses of a ``cond`` or ``guard``."""
    variables: list[PythonVariable] = []
    head = node.items[0].text if type(node.items[0]) is Name else ""
    clauses = node.items[1:] if head == "cond" else []
    if head == "guard" and isinstance(node.items[1], FormCode):
        clauses = node.items[1].items[1:]
    for item in node.items[1:]:
        variables += _definition(item)
    for clause in clauses:
        for inner in clause.items[1:] if isinstance(clause, FormCode) else ():
            variables += _definition(inner)
    return variables


def _definition(item: Code) -> list[PythonVariable]:
    if not isinstance(item, FormCode) or len(item.items) < 2 or type(item.items[0]) is not Name:
        return []
    head, target = item.items[0].text, item.items[1]
    if head == "define":
        if isinstance(target, FormCode):
            target = target.items[0]
        return [target.variable] if type(target) is VariableRef else []
    if head == "define-values":
        return _variables(target)
    if head == "define-record":
        return [target.variable] if type(target) is VariableRef else []
    return []


# Round-trip check: the text of the program must read back as the generated forms.


_NUMBER_NAMES = {"inf": math.inf, "-inf": -math.inf, "nan": math.nan}


def misread(forms: Sequence[Datum], text: str, outer: Span) -> Diagnostic | None:
    """Return a diagnostic for the first form that does not read back from ``text`` as generated, or None."""
    try:
        parsed = read(Source("<translation>", text))
    except (SceneError, RecursionError):
        return _problem(outer)
    if parsed.diagnostics:
        return _problem(outer)
    if len(parsed.forms) != len(forms):
        return _problem(outer)
    stack = list(zip(forms, parsed.forms))
    while stack:
        expected, actual = stack.pop()
        parts = _pairs(expected, actual)
        if parts is None:
            return _problem(expected.span)
        stack += parts
    return None


def _problem(span: Span) -> Diagnostic:
    message = "this code cannot be expressed in the language: its translation would be read differently"
    return Diagnostic("python-unsupported", message, span)


def _pairs(expected: Datum, actual: Datum) -> list[tuple[Datum, Datum]] | None:
    """Return the corresponding parts of two datums, or None if the datums differ."""
    if isinstance(expected, Atom):
        return [] if isinstance(actual, Atom) and _same(expected.value, actual.value) else None
    if type(expected) is not type(actual) or isinstance(actual, Atom) or len(expected.items) != len(actual.items):
        return None
    parts = list(zip(expected.items, actual.items))
    if isinstance(expected, ListDatum) and isinstance(actual, ListDatum):
        if (expected.tail is None) != (actual.tail is None):
            return None
        if expected.tail is not None:
            parts.append((expected.tail, actual.tail))
    assert isinstance(expected, (ListDatum, ArrayDatum))
    return parts


def _same(expected: object, actual: object) -> bool:
    if type(expected) is float and type(actual) is Symbol:
        named = _NUMBER_NAMES.get(str(actual))
        return named is not None and (named == expected or (math.isnan(named) and math.isnan(expected)))
    if type(expected) is float and type(actual) is float:
        return expected == actual and math.copysign(1, expected) == math.copysign(1, actual)
    return type(expected) is type(actual) and expected == actual


# Conversion of the output to datums with spans in the Python code, and to text with comments.


class Output:
    """Converts code to datums, and records their comments and spellings."""

    def __init__(self, namer: Namer, outer: Span) -> None:
        self._namer = namer
        self._outer = outer
        self.trivia: dict[int, Trivia] = {}
        self.spelling: dict[int, str] = {}

    def datum(self, code: Code, outer: Span | None = None) -> Datum:
        """Return the datum of ``code``; code without a span has that of the enclosing code."""
        span = code.span or outer or self._outer
        datum = self._bare(code, span)
        if code.before or code.after or code.blank:
            after = line_comment(code.after) if code.after else None
            self.trivia[id(datum)] = Trivia(_comments(code.before), after, code.blank)
        return datum

    def _bare(self, code: Code, span: Span) -> Datum:
        """Return the datum of ``code`` without its comments."""
        if type(code) is FormCode:
            rest = self.datum(code.rest, span) if code.rest is not None else None
            return ListDatum(tuple([self.datum(item, span) for item in code.items]), rest, span)
        if type(code) is Brackets:
            return ArrayDatum(tuple([self.datum(item, span) for item in code.items]), span)
        if type(code) is LiteralCode:
            atom = Atom(code.value, span)
            if code.text is not None:
                self.spelling[id(atom)] = code.text
            return atom
        if type(code) is VariableRef:
            text = code.variable.text
            return Atom(Keyword(text) if code.is_keyword else Symbol(text), span)
        if type(code) is Key:
            return Atom(Keyword(code.text), span)
        if type(code) is ArgumentName:
            return Atom(Keyword(self._namer.keyword(code.python)), span)
        assert type(code) is Name
        return Atom(Symbol(code.text), span)

    def text(
        self, forms: Sequence[Datum], header: Sequence[str], footer: Sequence[str | None], finish: Finish | None
    ) -> str | Diagnostic:
        """Return the text of the program, or a diagnostic if it would not read back as ``forms``.

        ``header`` and ``footer`` are lines of comments at the start and the end; ``finish`` lifts the program.
        """
        trivia: Mapping[int, Trivia] = self.trivia
        spelling: Mapping[int, str] = self.spelling
        if finish is not None:
            lifted = finish(forms, trivia, spelling)
            forms, trivia, spelling = lifted.forms, lifted.trivia, lifted.spelling
        if forms and header:
            first = trivia.get(id(forms[0]), Trivia())
            before = (*_comments(header), None, *first.before)
            trivia = {**trivia, id(forms[0]): Trivia(before, first.after, first.blank, first.end)}
        text = layout(forms, indents=INDENTS, trivia=trivia, spelling=spelling, end=_comments(footer))
        problem = misread(forms, text, self._outer)
        if problem is not None:
            return problem
        final = settled(text, INDENTS)
        return final if final == text else misread(forms, final, self._outer) or final


def _comments(texts: Sequence[str | None]) -> tuple[str | None, ...]:
    """Return lines of comments; None is an empty line."""
    return tuple(None if text is None else line_comment(text) for text in texts)


_PROSE_WIDTH = 86  # characters in a line of a comment


def prose(text: str) -> list[str]:
    """Wrap prose to lines of a comment; empty lines are preserved."""
    lines: list[str] = []
    for paragraph in text.strip().splitlines():
        lines += textwrap.wrap(paragraph, _PROSE_WIDTH) or [""]
    return lines
