"""Names for the variables of the Python in the language: kebab-case, never hiding what their scope needs."""

from __future__ import annotations

import re
from collections.abc import Iterable

from scenelang.interpreter.forms import FORMS
from scenelang.interpreter.transpile.analysis.scopes import Variable
from scenelang.interpreter.transpile.writing.code import ArgumentName, Code, Form, Name, Ref, children, walk

_RESERVED = frozenset(FORMS) | {"none", "else", "unquote", "unquote-splicing", "=>", "...", "_", "scene", "param"}
_MACROS = frozenset({"call", "union", "union-loop", "transform"})


def kebab(name: str) -> str:
    """``num_steps`` -> ``num-steps``, ``FACE_COLORS`` -> ``face-colors``; underscores at the ends stay."""
    core = name.strip("_")
    if not core:
        return name
    start = name.index(core)
    lead, tail = name[:start], name[start + len(core) :]
    if core.isupper() and len(core) > 1:
        core = core.lower()
    elif core[0].isupper() and any(c.islower() for c in core):  # the name of a class
        core = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "-", core).lower()
    return lead + re.sub(r"_+", "-", core) + tail


class Namer:
    """Chooses ``Variable.text`` for every variable in a program's forms. ``kept`` are names of keyword parameters that
    tables hold as texts: they keep Python's spelling."""

    def __init__(self, forms: Iterable[Code], kept: Iterable[str] = ()) -> None:
        self._forms = list(forms)
        self._keywords: dict[str, str] = {}
        self._kept = set(kept)
        self._top: dict[str, str] = {}

    def choose(self) -> None:
        """Give every variable its name, outer ones first, and spell keyword arguments like their parameters."""
        keyword_names = {v.name for form in self._forms for v in _variables(form) if v.is_keyword}
        keyword_names |= {n.python for form in self._forms for n in walk(form) if type(n) is ArgumentName}
        for name in sorted(keyword_names):
            text = name if name in self._kept else kebab(name)
            self._keywords[name] = f"{text}2" if text in _RESERVED or text in _MACROS else text
        needed_anywhere = {n.text for form in self._forms for n in walk(form) if type(n) is Name}
        top = self._top_level_variables()
        taken: dict[str, Variable] = {}
        for variable in top:
            self._name(variable, needed_anywhere, taken, taken)
        for form in self._forms:
            self._scope(form, taken)
        for form in self._forms:
            for variable in _variables(form):  # read where nothing defines it: the checker says so
                variable.text = variable.text or _safe(kebab(variable.name))
            self._shadowed_keywords(form, frozenset())

    def keyword(self, python: str) -> str:
        """The name of a keyword argument."""
        return self._keywords.get(python, kebab(python))

    # --- scopes ------------------------------------------------------------------------------------------------

    def _top_level_variables(self) -> list[Variable]:
        found: dict[Variable, None] = {}
        for form in self._forms:
            if isinstance(form, Form) and len(form.items) > 1 and type(form.items[0]) is Name:
                head, target = form.items[0].text, form.items[1]
                if head == "define" and isinstance(target, Form):
                    target = target.items[0]
                if head in ("define", "define-record") and type(target) is Ref:
                    found[target.variable] = None
                elif head == "define-values":
                    found.update(dict.fromkeys(v for v in _variables(target)))
        records = {v: None for form in self._forms for v in _variables(form) if v.record is not None}
        return [*found, *(v for v in records if v not in found)]

    def _scope(self, code: Code, visible: dict[str, Variable]) -> None:
        """Name the variables that ``code`` brings, scope by scope: a function's, then those inside it."""
        stack: list[tuple[Code, dict[str, Variable]]] = [(code, visible)]
        while stack:
            node, names = stack.pop()
            scope = _bound_here(node)
            if scope:
                names = dict(names)
                needed = {n.text for n in walk(node) if type(n) is Name}
                referred = {n.variable for n in walk(node) if type(n) is Ref}
                outer = {t: v for t, v in names.items() if v in referred}
                for variable in sorted(scope, key=lambda v: v.is_temporary):
                    if not variable.text:
                        self._name(variable, needed, outer, names)
                    outer[variable.text] = variable
                    names[variable.text] = variable
            stack.extend((child, names) for child in children(node))

    def _name(
        self, variable: Variable, needed: set[str], conflicts: dict[str, Variable], taken: dict[str, Variable]
    ) -> None:
        if variable.text:
            return
        if variable.is_keyword:
            variable.text = self._keywords[variable.name]
        elif variable.record is not None:
            variable.text = _record_name(variable)
        else:
            stem = text = kebab(variable.name)
            count = 2
            while (
                text in _RESERVED
                or text in _MACROS
                or text in needed
                or (text in conflicts and _differ(conflicts[text], variable))
            ):
                text = f"{stem}{count}"
                count += 1
            variable.text = text
        taken[variable.text] = variable

    def _shadowed_keywords(self, code: Code, shadowed: frozenset[str]) -> None:
        """Where a parameter that must keep its name hides a builtin, the builtin is called by its full name."""
        stack: list[tuple[Code, frozenset[str]]] = [(code, shadowed)]
        while stack:
            node, hidden = stack.pop()
            scope = _bound_here(node)
            if scope:
                hidden = hidden | {v.text for v in scope if v.is_keyword}
            if type(node) is Name and node.text in hidden and node.text not in _RESERVED:
                node.text = f"std/{node.text}"
            stack.extend((child, hidden) for child in children(node))


def _safe(text: str) -> str:
    return f"{text}2" if text in _RESERVED or text in _MACROS else text


def _differ(a: Variable, b: Variable) -> bool:
    """Whether two variables may not share a name: only Python's own shadowing is kept."""
    return a is not b and (a.name != b.name or a.is_temporary or b.is_temporary or a.function is b.function)


def _record_name(variable: Variable) -> str:
    assert variable.record is not None
    record, kind, name = variable.record
    stem = record.text or kebab(record.name)
    return {
        "make": f"make-{stem}", "get": f"{stem}-{kebab(name)}", "set": f"set-{stem}-{kebab(name)}!", "is": f"{stem}?",
        "method": f"{stem}-{kebab(name)}", "constant": f"{stem}-{kebab(name)}",
    }[kind]  # fmt: skip


def _variables(code: Code) -> list[Variable]:
    return [node.variable for node in walk(code) if type(node) is Ref]


def _bound_here(node: Code) -> list[Variable]:
    """The variables that a form binds for its insides."""
    if type(node) is not Form or not node.items:
        return []
    head = node.items[0]
    if type(head) is not Name:
        return []
    text = head.text
    found: list[Variable] = []
    if text == "lambda" and len(node.items) > 1:
        found = _parameters(node.items[1])
    elif text == "define" and len(node.items) > 1 and isinstance(node.items[1], Form):
        signature = node.items[1]
        found = _parameters(Form(signature.items[1:], None, signature.rest))
    elif text in ("let", "let*") and len(node.items) > 1 and isinstance(node.items[1], Form):
        found = [
            v for binding in node.items[1].items if isinstance(binding, Form) for v in _variables(binding.items[0])
        ]
    elif text.startswith("for") and len(node.items) > 1 and isinstance(node.items[1], Form):
        found = [
            v for clause in node.items[1].items
            if isinstance(clause, Form) and len(clause.items) == 2 for v in _variables(clause.items[0])
        ]  # fmt: skip
    elif text == "let/ec" and len(node.items) > 1:
        found = _variables(node.items[1])
    elif text == "guard" and len(node.items) > 1 and isinstance(node.items[1], Form) and node.items[1].items:
        found = _variables(node.items[1].items[0])
    found += _defined_in_body(node)
    return list(dict.fromkeys(found))


def _parameters(code: Code) -> list[Variable]:
    if not isinstance(code, Form):
        return _variables(code)
    found: list[Variable] = []
    for item in [*code.items, *([code.rest] if code.rest is not None else [])]:
        if type(item) is Ref:
            found.append(item.variable)
        elif isinstance(item, Form) and item.items and type(item.items[0]) is Ref:
            found.append(item.items[0].variable)
    return found


def _defined_in_body(node: Form) -> list[Variable]:
    """What the definitions directly inside a form, or in the clauses of a ``cond`` or ``guard``, define."""
    found: list[Variable] = []
    head = node.items[0].text if type(node.items[0]) is Name else ""
    clauses = node.items[1:] if head == "cond" else []
    if head == "guard" and isinstance(node.items[1], Form):
        clauses = node.items[1].items[1:]
    for item in node.items[1:]:
        found += _definition(item)
    for clause in clauses:
        for inner in clause.items[1:] if isinstance(clause, Form) else ():
            found += _definition(inner)
    return found


def _definition(item: Code) -> list[Variable]:
    if not isinstance(item, Form) or len(item.items) < 2 or type(item.items[0]) is not Name:
        return []
    head, target = item.items[0].text, item.items[1]
    if head == "define":
        if isinstance(target, Form):
            target = target.items[0]
        return [target.variable] if type(target) is Ref else []
    if head == "define-values":
        return _variables(target)
    if head == "define-record":
        return [target.variable] if type(target) is Ref else []
    return []
