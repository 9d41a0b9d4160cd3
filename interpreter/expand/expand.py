"""Macro expander: convert datums to core datums, resolving names, expanding macros and lowering derived forms.

The output is parsed by ``core.lark``: heads are ``ast.Head``, and identifiers are replaced by their bindings. Derived
forms are in ``derived``, macros in ``macros``; this module handles names, bodies, functions and calls.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeGuard

from scenelang.grammar import ast
from scenelang.grammar.ast import Head, Opaque
from scenelang.grammar.datum import ArrayDatum, Atom, Datum, Keyword, ListDatum, Span, Symbol, dataclass, replace
from scenelang.grammar.diagnostics import (
    Diagnostic,
    Edit,
    Fix,
    LimitError,
    Note,
    SceneError,
    did_you_mean,
    near_names,
    rename_fixes,
    suggest,
)
from scenelang.interpreter.expand import macros
from scenelang.interpreter.expand.forms import ABSENT, FORMS, RENAMED
from scenelang.interpreter.expand.macros import BRACKETS, quoted_value
from scenelang.interpreter.expand.scope import (
    Alias,
    Annotated,
    ConstantBinding,
    Macro,
    PaperForm,
    Scope,
    Special,
    TemplateKeyword,
    Variable,
    base_name,
    make_alias,
)
from scenelang.interpreter.runtime.procedures import MAKE_RECORD, record_procedure_names
from scenelang.interpreter.runtime.types import BASE_TYPES, STD, Builtin, Type, parse_type, record_type

# Runs a macro's function on operands as data; returns the value, and whether it is deterministic.
RunMacro = Callable[[Datum, list[Any]], tuple[Any, bool]]

# Limits of macros, which stop an infinite expansion; the bodies of procedural macros have limits of their own.
MAX_EXPANSIONS = 100_000  # macro uses in a file
MAX_EXPANDED = 200_000  # forms of a file that macros produced
MAX_MACRO_DEPTH = 1_000  # nested expansions

_PLACEMENT_HINTS = {
    "else": "use `else` to start the last clause of `cond` or `case`",
    "=>": "use `=>` in a clause of `cond`: `(test => function)`",
    "_": "`_` is only allowed as a parameter or in a pattern, where it ignores a value",
    "unquote": "use `,` inside a quasiquote: `` `(a ,b) ``",
    "unquote-splicing": "use `,@` inside a quasiquote: `` `(a ,@b) ``",
}


def _renamed(atom: Atom, name: str, scope: Scope) -> SceneError:
    """Return the error for a name of an earlier version, with the fix that writes ``name``, that of today."""
    old = base_name(atom.value)
    written = f"{STD}{name}" if old.startswith(STD) or name in scope.names() else name
    has_fix = atom.span.expansion is None and atom.span.text == old
    fixes = (Fix(f"Change to `{written}`", (Edit(atom.span, written),), safe=True),) if has_fix else ()
    hint = f"it is called `{written}`"
    return SceneError("unbound", f"`{old}` is not defined", hint, atom.span, fixes=fixes, near=(written,))


def _arithmetic(name: str, scope: Scope) -> str | None:
    """Return the call that a name such as ``height-1`` means whose parts are variables and numbers, else None."""
    for operators in ("+-", "*/%"):  # the last one that binds least is applied last
        for at in range(len(name) - 2, 0, -1):
            if name[at] not in operators:
                continue
            left, right = (_operand(part, scope) for part in (name[:at], name[at + 1 :]))
            if left is not None and right is not None and not (_is_number(left) and _is_number(right)):
                return f"({name[at]} {left} {right})"
    return None


def _operand(text: str, scope: Scope) -> str | None:
    """Return a variable, a number or arithmetic with them as code, None for any other text."""
    if _is_number(text) or (text.strip("+-*/%") and isinstance(scope.lookup(Symbol(text)), Variable)):
        return text
    return _arithmetic(text, scope)


def _is_number(text: str) -> bool:
    """Return whether a text is a number, such as ``1`` and ``.5``."""
    return text.replace(".", "", 1).isdecimal()


def core(head: str, items: Iterable[Datum], span: Span) -> ListDatum:
    """Return the core form with the terminal ``head`` of ``core.lark`` and the operands ``items``."""
    return ListDatum((Atom(Head(head), span), *items), None, span)


def opaque(terminal: str, value: Any, span: Span) -> Atom:
    """Return a datum that contains ``value``, which the core grammar treats as one token, ``terminal``."""
    return Atom(Opaque(terminal, value), span)


def is_identifier(datum: Any) -> TypeGuard[Atom]:
    """Return whether a datum is a symbol."""
    return isinstance(datum, Atom) and isinstance(datum.value, Symbol)


_MAX_SHOWN = 40  # characters of source text in a hint
_MAX_USAGE = 200  # characters of a parameter list in messages


def _local_hint(name: str, span: Span) -> str | None:
    """Return the hint for a name that another top-level form of the file defines for itself; None if none does."""
    text = span.source.text
    for match in re.finditer(rf"\(define\s+\(?{re.escape(name)}(?=[\s)])", text):
        start = text.rfind("\n(", 0, match.start()) + 1
        if match.start() <= start:
            continue
        owner = re.match(r"\((?:bind|define)\s+\(?(\"[^\"\n]+\"|[^\s()]+)", text[start:])
        if owner is not None and not start <= span.start < match.end():
            line = span.source.position(match.start())[0]
            return f"{owner[1]} defines it for itself, in line {line}: define it at top level to use it here"
    return None


def syntax_error(form: str, message: str, span: Span, hint: str | None = None) -> SceneError:
    """Return the error for a malformed special form at ``span``; the default hint is the usage of ``form``."""
    usage = FORMS[form].usage if form in FORMS else None
    return SceneError("syntax", message, hint or (f"usage: {usage}" if usage else None), span)


def none(span: Span) -> Datum:
    """Return the constant ``none``."""
    return Atom(None, span)


def bracket_error(what: str, array: ArrayDatum, *others: ArrayDatum) -> SceneError:
    """Return the error for ``[...]`` in place of ``(...)``; the fix corrects ``others`` too."""
    text = array.span.text
    is_short = len(text) <= _MAX_SHOWN and "\n" not in text and text.startswith("[")
    hint = f"write `({text[1:-1]})`" if is_short else "replace `[` and `]` with parentheses"
    spans = [item.span for item in (array, *others)]
    fixes: tuple[Fix, ...] = ()
    if all(span.expansion is None and span.text.startswith("[") and span.text.endswith("]") for span in spans):
        edits = tuple(Edit(span, f"({span.text[1:-1]})") for span in spans)
        fixes = (Fix("Replace brackets with parentheses", edits, safe=True),)
    message = f"expected parentheses around {what}, found square brackets"
    return SceneError("bracket", message, hint, array.span, fixes=fixes)


@dataclass(frozen=True, slots=True, eq=False)
class Use:
    """Occurrence of an identifier with its binding; ``defines`` is set where it is bound."""

    span: Span
    binding: Any
    defines: bool


@dataclass(frozen=True, slots=True, eq=False)
class Pending:
    """Form of a body that is not expanded yet, because all definitions of the body must be declared first.

    ``finish`` expands it, and ``defines`` is whether it is a definition.
    """

    finish: Callable[[], Datum]
    defines: bool
    datum: Datum


# Searches for similar names in a file: each takes a millisecond or more, as it compares all names. After this number of
# unknown names there are no more "did you mean" hints.
_MAX_SEARCHES = 100
UNKNOWN = Variable("?", None)  # placeholder of an expression with an error


class Expander:
    """Expander of one file. ``run_macro`` evaluates the body of a procedural macro."""

    def __init__(self, run_macro: RunMacro) -> None:
        self.run_macro = run_macro
        self.diagnostics: list[Diagnostic] = []
        self.record_names: set[str] = set()
        self.found_records: set[str] = set()  # record names of the form being scanned
        self.expansions = 0
        self.expanded = 0
        self.searches = 0  # number of searches for similar names
        self.recovers = True  # whether an expression with an error is replaced by a placeholder
        self.template_scope: Scope | None = None  # set while a define-macro's body is expanded or run
        self.template_aliases: dict[Symbol, Symbol] = {}
        self.uses: list[Use] | None = None  # occurrences of identifiers, if an editor requested them

    # --- identifiers -------------------------------------------------------------------------------------------

    def resolve(self, atom: Atom, scope: Scope) -> Any:
        """Return the binding of an identifier; raise ``SceneError`` with a suggestion if it is unbound."""
        binding = scope.lookup(atom.value)
        if binding is None:
            raise self.unbound(atom, scope)
        self.record_use(atom, binding)
        return binding

    def record_use(self, atom: Datum, binding: Any, defines: bool = False) -> None:
        """Record the binding of an identifier of the source text, if requested."""
        if self.uses is not None and atom.span.expansion is None:
            self.uses.append(Use(atom.span, binding, defines))

    def unbound(self, atom: Atom, scope: Scope) -> SceneError:
        """Return the error for an undefined name, with the fix or hint that its spelling suggests."""
        name = base_name(atom.value)
        if name in ABSENT:
            return SceneError("absent", f"`{name}` is not supported", ABSENT[name], atom.span)
        if name in _PLACEMENT_HINTS:
            return SceneError("misplaced", f"misplaced `{name}`", _PLACEMENT_HINTS[name], atom.span)
        if name in self.bound_words():
            return SceneError(
                "unbound", f"`{name}` is a word, not a function", f'to call it, write `(call "{name}")`', atom.span
            )
        if name.removeprefix(STD) in RENAMED:
            return _renamed(atom, RENAMED[name.removeprefix(STD)], scope)
        module = self.importable_from(name)
        near: list[str] = []
        hint: str | None
        if "::" in name:
            hint = "only parameters can have type annotations: `(lambda (x::Type) ...)`"
        elif name.startswith("..."):
            hint = "replace the placeholder `...` with code"
        elif name.startswith("-") and len(name) > 1 and scope.lookup(Symbol(name[1:])) is not None:
            hint = f"the negative of a variable is `(- {name[1:]})`"
            negated = Fix(f"Change to `(- {name[1:]})`", (Edit(atom.span, f"(- {name[1:]})"),), safe=True)
            return SceneError("unbound", f"`{name}` is not defined", hint, atom.span, fixes=(negated,))
        elif (written := _arithmetic(name, scope)) is not None:
            hint = f"`{name}` is one name; write the operator first: `{written}`"
            fix = Fix(f"Change to `{written}`", (Edit(atom.span, written),), safe=True)
            return SceneError("unbound", f"`{name}` is not defined", hint, atom.span, fixes=(fix,))
        elif module is not None:
            hint = f'add `(import "{module}")`'
        else:
            near = self._near(name, scope)
            hint = _local_hint(name, atom.span) or did_you_mean(near)
        fixes = rename_fixes(atom.span, name, near)
        return SceneError("unbound", f"`{name}` is not defined", hint, atom.span, fixes=fixes, near=tuple(near))

    def _near(self, name: str, scope: Scope) -> list[str]:
        """Return names that ``name`` may be a misspelling of.

        The number of searches is limited for texts with many unknown names.
        """
        if name.startswith("make-") and name[5:] in self.record_names:  # the constructor's name in Scheme
            return [name[5:]]
        self.searches += 1
        if self.searches > _MAX_SEARCHES:
            return []
        if name.startswith(STD):
            return [f"{STD}{near}" for near in near_names(name.removeprefix(STD), self.known_names())]
        return near_names(name, {*scope.names(), *self.known_names(), *FORMS})

    def known_names(self) -> Iterable[str]:
        """Return the names of builtins and the prelude, which a misspelled name is compared with.

        There are none without a program; overridden by ``FileExpander``.
        """
        return ()

    def importable_from(self, name: str) -> str | None:
        """Return the library module to import for a name that is not predefined, or None; see ``FileExpander``."""
        return None

    def bound_words(self) -> Iterable[str]:
        """Return the words that the program binds, so that the error for such a name can say to ``call`` the word.

        The result is empty without a program; ``FileExpander`` overrides this with the words of all files read so far.
        """
        return ()

    def declare_record(self, name: str) -> None:
        """Declare the name of a record as a type."""
        self.record_names.add(name)
        self.found_records.add(name)

    def mark_random(self) -> None:
        """Record that a macro drew random numbers, so that the current expansion must not be cached."""

    def binding_of(self, datum: Any, scope: Scope) -> Any:
        """Return the binding of ``datum``, or None if it is not a bound identifier."""
        binding = scope.lookup(datum.value) if is_identifier(datum) else None
        if isinstance(binding, (Special, Macro, PaperForm)):
            self.record_use(datum, binding)
        return binding

    def is_literal(self, datum: Any, name: str, scope: Scope) -> bool:
        """Return whether ``datum`` is the unshadowed identifier ``name``, such as ``else``."""
        return is_identifier(datum) and base_name(datum.value) == name and scope.lookup(datum.value) is None

    def builtin(self, name: str, span: Span, scope: Scope) -> Atom:
        """Return a reference to a builtin, even if its name is shadowed."""
        binding = scope.lookup(Symbol(f"std/{name}"))
        return Atom(binding.variable if isinstance(binding, PaperForm) else binding, span)

    def declare(self, atom: Datum, scope: Scope, *, is_global: bool = False, recursive: bool = False) -> Variable:
        """Bind an identifier to a new variable in ``scope``, and return the variable.

        Parameters
        ----------
        atom
            The identifier.
        is_global
            Whether the variable is defined at top level.
        recursive
            Whether it is visible in its own value, and so may be read before it has one.

        Raises
        ------
        SceneError
            If ``atom`` is not a name, or its name is reserved for a special form.
        """
        if not is_identifier(atom):
            raise self.not_a_name(atom)
        assert isinstance(atom, Atom)
        name = base_name(atom.value)
        existing = scope.lookup(atom.value)
        is_local_name = not is_global and name in ("scene", "param")  # these are forms at top level only
        if isinstance(existing, Special) and name in FORMS and not is_local_name:
            raise SceneError("reserved", f"`{name}` is reserved and cannot be bound", None, atom.span)
        if "::" in name:
            raise SceneError("lambda-list", "only parameters can have type annotations", None, atom.span)
        if isinstance(existing, PaperForm):
            message = (
                f"this definition shadows the paper's macro `{name}`; `({name} ...)` is now an ordinary function call"
            )
            self.diagnostics.append(Diagnostic("shadowed-macro", message, atom.span))
        is_hidden = isinstance(atom.value, Alias) and not atom.value.soft  # introduced by a hygienic macro
        if is_global and not is_hidden:
            variable = self.global_variable(name, atom.span)
        else:
            variable = Variable(name, atom.span, is_global, recursive)
        variable.from_macro = isinstance(atom.value, Alias)
        variable.shadows = isinstance(existing, (Builtin, PaperForm))
        if not is_global:
            variable.hides = existing if isinstance(existing, Variable) else None
        scope.bind(atom.value, variable)
        self.record_use(atom, variable, defines=True)
        return variable

    def global_variable(self, name: str, span: Span) -> Variable:
        """Return the variable of a top-level name."""
        return Variable(name, span, is_global=True, recursive=True)

    def not_a_name(self, datum: Datum) -> SceneError:
        """Return the error for a datum in place of a name."""
        if isinstance(datum, ArrayDatum):
            return SceneError(
                "bracket",
                "expected a name or pattern, found an array",
                "use parentheses instead of square brackets",
                datum.span,
            )
        if isinstance(datum, Atom) and datum.span.text in ("none", "#t", "#f"):
            return SceneError("reserved", f"`{datum.span.text}` is a value and cannot be bound", None, datum.span)
        return SceneError("syntax", "expected a name", None, datum.span)

    def template_alias(self, symbol: Symbol) -> Symbol:
        """Return the alias of a template symbol in the current expansion of a ``define-macro``."""
        alias = self.template_aliases.get(symbol)
        if alias is None:
            assert self.template_scope is not None
            alias = self.template_aliases[symbol] = make_alias(symbol, self.template_scope, soft=True)
        return alias

    # --- patterns ----------------------------------------------------------------------------------------------

    def declare_target(self, datum: Datum, scope: Scope, *, recursive: bool = False, is_global: bool = False) -> Datum:
        """Declare the names of a destructuring pattern; return its core datum, a variable or an opaque pattern."""
        if is_identifier(datum):
            if base_name(datum.value) == "_":
                return opaque("PATTERN", None, datum.span)
            variable = self.declare(datum, scope, recursive=recursive, is_global=is_global)
            return Atom(variable, datum.span)
        pattern = self._pattern(datum, scope, recursive=recursive, is_global=is_global)
        return opaque("PATTERN", pattern, datum.span)

    def _pattern(self, datum: Datum, scope: Scope, *, recursive: bool, is_global: bool) -> Any:
        """Declare the names of a pattern, and return it as data: None for ``_``, a Variable, or ``(items, rest)``.

        The items are patterns. So is the rest, the part after the dot; it is False in a pattern without a dot, because
        None is the pattern ``_``.
        """
        if is_identifier(datum):
            if base_name(datum.value) == "_":
                return None
            return self.declare(datum, scope, recursive=recursive, is_global=is_global)
        if not isinstance(datum, ListDatum):
            raise self.not_a_name(datum)

        def inner(item: Datum) -> Any:
            return self._pattern(item, scope, recursive=recursive, is_global=is_global)

        items = tuple(map(inner, datum.items))
        rest = inner(datum.tail) if datum.tail is not None else False
        return items, rest

    # --- expressions -------------------------------------------------------------------------------------------

    def expand(self, datum: Datum, scope: Scope) -> Datum:
        """Expand an expression into a core datum.

        An error is recorded, and a placeholder replaces the expression, so that everything else is still checked.
        """
        try:
            return self._expand(datum, scope)
        except LimitError:
            raise
        except SceneError as error:
            return self.recover(error, datum.span)

    def recover(self, error: SceneError, span: Span | None) -> Datum:
        """Record an error and return a placeholder; raise it if the expansion will run immediately, as in a macro."""
        location = error.span or span
        if not self.recovers or location is None:
            raise error
        self.diagnostics.append(error.diagnostic)
        return Atom(UNKNOWN, location)

    def _expand(self, datum: Datum, scope: Scope) -> Datum:
        """Expand one expression: macros are expanded until the head is a special form or a function."""
        while True:
            if isinstance(datum, Atom):
                return self._expand_atom(datum, scope)
            if isinstance(datum, ArrayDatum):
                return ArrayDatum(tuple(self.expand_all(datum.items, scope)), datum.span)
            if datum.span.expansion is not None:
                self.expanded += 1
                if self.expanded > MAX_EXPANDED:
                    message = f"macros produced more than {MAX_EXPANDED:,} forms"
                    raise LimitError(
                        "expansion", message, "check whether a macro duplicates its operands", _outermost(datum.span)
                    )
            if datum.tail is not None:
                hint = "to write it as data, quote it: `'(a . b)`"
                raise SceneError("bad-dot", "a dotted pair cannot be evaluated", hint, datum.span)
            if not datum.items:
                message = "`()` cannot be evaluated"
                raise SceneError("empty-application", message, "write the empty list as `'()` or `(list)`", datum.span)
            binding = self.binding_of(datum.items[0], scope)
            if isinstance(binding, Special):
                from scenelang.interpreter.expand.derived import HANDLERS

                return HANDLERS[binding.name](self, datum, scope)
            if isinstance(binding, Macro):
                datum = self.expand_macro(binding, datum, scope)
                continue
            if binding is None and is_identifier(datum.items[0]):
                return self._unbound_call(datum, scope)
            if isinstance(binding, PaperForm):
                return core(binding.terminal, self.expand_all(datum.items[1:], scope), datum.span)
            head = self.expand(datum.items[0], scope)
            operands = self.expand_all(datum.items[1:], scope)
            return ListDatum((head, *operands), None, datum.span)

    def _unbound_call(self, datum: ListDatum, scope: Scope) -> Datum:
        """Report an unbound head.

        The operands are checked as well if it looks like a misspelled function; those of a misspelled special form may
        not be expressions.
        """
        error = self.unbound(datum.items[0], scope)
        if not error.near or any(name in FORMS for name in error.near):
            raise error
        head = self.recover(error, datum.span)
        return ListDatum((head, *self.expand_all(datum.items[1:], scope)), None, datum.span)

    def expand_all(self, datums: Sequence[Datum], scope: Scope) -> list[Datum]:
        """Expand several expressions.

        Each error is recorded in ``diagnostics``, and a placeholder replaces its expression, so that the others are
        expanded and their errors reported, too.
        """
        return self._recovered([lambda datum=datum: self.expand(datum, scope) for datum in datums])  # type: ignore[misc]

    def _recovered(self, steps: Sequence[Callable[[], Datum]]) -> list[Datum]:
        """Run independent steps and return their values, with placeholders for those that fail."""
        values: list[Datum] = []
        for step in steps:
            try:
                values.append(step())
            except LimitError:
                raise
            except SceneError as error:
                values.append(self.recover(error, error.span))
        return values

    def _expand_atom(self, atom: Atom, scope: Scope) -> Datum:
        """Expand an atom: a name is replaced by its binding, other atoms stay."""
        value = atom.value
        if not isinstance(value, Symbol):
            if isinstance(value, Annotated):
                raise SceneError("lambda-list", "only parameters can have type annotations", None, atom.span)
            return Atom(Keyword(value), atom.span) if isinstance(value, TemplateKeyword) else atom
        binding = self.resolve(atom, scope)
        if isinstance(binding, PaperForm):
            return Atom(binding.variable, atom.span)
        if isinstance(binding, ConstantBinding):
            return core("QUOTE", [opaque("DATUM", binding.value, atom.span)], atom.span)
        if isinstance(binding, (Special, Macro)):
            name = base_name(value)
            kind = "a special form" if isinstance(binding, Special) else "a macro"
            raise SceneError(
                "misplaced", f"`{name}` is {kind}, so it can only be used at the head of a form", None, atom.span
            )
        return Atom(binding, atom.span)

    def expand_macro(self, macro: Macro, datum: ListDatum, scope: Scope) -> Datum:
        """Expand one macro use and return its replacement."""
        self.expansions += 1
        expansion = datum.span.expansion
        depth = 0
        while expansion is not None:
            depth += 1
            expansion = expansion.outer
        if self.expansions > MAX_EXPANSIONS or depth > MAX_MACRO_DEPTH:
            hint = "check whether the macro expands to itself"
            notes = (Note("macro defined here", macro.span),)
            raise LimitError(
                "expansion",
                f"expansion limit exceeded in the macro `{macro.name}`",
                hint,
                _outermost(datum.span),
                notes,
            )
        replacement: Datum = macro.transform(datum, scope)
        return replacement

    # --- bodies ------------------------------------------------------------------------------------------------

    def expand_body(self, datums: Sequence[Datum], scope: Scope, span: Span, new_scope: bool = True) -> Datum:
        """Expand a body: definitions and expressions in any order, with all definitions visible throughout.

        A body that ends in a definition returns ``none``. R7RS makes that an error, which gets in the way while a
        program is being written.

        Parameters
        ----------
        datums
            Forms of the body.
        scope
            Scope around the body.
        span
            Location of the body, for errors.
        new_scope
            Whether the definitions have a scope of their own; otherwise they are added to ``scope``.

        Raises
        ------
        SceneError
            "syntax" for an empty body.
        """
        inner = Scope(scope) if new_scope else scope
        pending: list[Pending] = []
        for datum in datums:
            self.scan(datum, inner, pending)
        if not pending:
            raise SceneError("syntax", "empty body", None, span)
        items = self._recovered([item.finish for item in pending])
        if pending[-1].defines:
            items.append(Atom(None, span))
        return items[0] if len(items) == 1 else core("BODY", items, span)

    def scan(self, datum: Datum, scope: Scope, pending: list[Pending]) -> None:
        """Add a form of a body to ``pending``, and declare the names that it defines in ``scope``.

        Macros at its head are expanded, and the forms of a ``begin`` are added one by one. Values are expanded later,
        when all names are declared.
        """

        while isinstance(datum, ListDatum) and datum.items and datum.tail is None:
            binding = self.binding_of(datum.items[0], scope)
            if isinstance(binding, Macro):
                datum = self.expand_macro(binding, datum, scope)
                continue
            if isinstance(binding, Special):
                if binding.name == "begin":
                    for item in datum.items[1:]:
                        self.scan(item, scope, pending)
                    return
                scanner = SCANNERS.get(binding.name)
                if scanner is not None:
                    scanner(self, datum, scope, pending)
                    return
            break
        form = datum
        pending.append(Pending(lambda: self.expand(form, scope), False, form))

    # --- functions ---------------------------------------------------------------------------------------------

    def expand_lambda(
        self, parameters: Datum, body: Sequence[Datum], scope: Scope, span: Span, name: str = "lambda"
    ) -> Datum:
        """Expand a function with parameters of all kinds and a body."""
        inner = Scope(scope)
        plain, defaults = self._lambda_list(parameters, inner)
        usage = _usage(parameters)
        opaque_parameters = opaque("PARAMETERS", (name, tuple(plain), usage), parameters.span)
        default_list = ListDatum(tuple(defaults), None, span)
        body_datum = self.expand_body(body, inner, span)
        return core("LAMBDA", [opaque_parameters, default_list, body_datum], span)

    def _lambda_list(self, datum: Datum, scope: Scope) -> tuple[list[ast.Parameter], list[Datum]]:
        """Return the parameters of a function and the defaults of its optional and keyword parameters, in order.

        An invalid parameter is reported and its names are declared, so that the body is still checked.
        """
        if is_identifier(datum):
            items: tuple[Datum, ...] = ()
            tail: Datum | None = datum
        elif isinstance(datum, ListDatum):
            items, tail = datum.items, datum.tail
        elif isinstance(datum, ArrayDatum):
            raise bracket_error("parameters", datum)
        else:
            raise SceneError("lambda-list", "expected a parameter list", None, datum.span)
        plain: list[ast.Parameter] = []
        defaults: list[Datum] = []
        is_broken = False
        position = 0
        while position < len(items):
            item, start = items[position], position
            try:
                if is_identifier(item) and base_name(item.value) == "&keys":
                    if position + 1 >= len(items):
                        raise SceneError("lambda-list", "expected a name after `&keys`", None, item.span)
                    position += 1
                    self._add(plain, self._parameter(items[position], scope, "keys"), items[position].span)
                elif is_identifier(item) and base_name(item.value) in _MARKERS:
                    error, position = _marker_error(items, position), len(items) - 1
                    raise error
                else:
                    self._one_parameter(item, scope, plain, defaults)
            except LimitError:
                raise
            except SceneError as error:
                self.recover(_default_outside(error, items, start), item.span)
                for invalid in items[start : position + 1]:
                    self._declare_names(invalid, scope)
                if plain and plain[-1].kind == "keyword":
                    plain.pop()  # the item may be its default
                is_broken = True
            position += 1
        if tail is not None:
            self._add(plain, self._parameter(tail, scope, "rest"), tail.span)
        elif is_broken:  # the other parameters are unknown, so calls of the function are not checked
            plain += (ast.Parameter(None, "_", "keys"), ast.Parameter(None, "_", "rest"))
        return plain, defaults

    def _declare_names(self, item: Datum, scope: Scope) -> None:
        """Declare the names in an invalid parameter, so that their uses are not reported too."""
        for datum in item.items if isinstance(item, ListDatum) else (item,):
            if is_identifier(datum) or (isinstance(datum, Atom) and isinstance(datum.value, Annotated)):
                name, _ = self._annotation(datum)
                if scope.bindings.get(name) is None:
                    self.declare(Atom(name, datum.span), scope)

    def _one_parameter(self, item: Datum, scope: Scope, plain: list[ast.Parameter], defaults: list[Datum]) -> None:
        """Add one parameter: ``name``, ``:name``, ``(name default)`` or ``(:name default)``."""
        if isinstance(item, ListDatum):
            if len(item.items) != 2 or item.tail is not None:
                hint = "write an optional parameter as `(name default)` or `(:name default)`"
                raise SceneError("lambda-list", "invalid parameter", hint, item.span)
            default = self.expand(item.items[1], scope)
            kind = "keyword" if _is_keyword(item.items[0]) else "optional"
            parameter = self._parameter(item.items[0], scope, kind)
            defaults.append(default)
            self._add(plain, replace(parameter, default=ast.Constant(None, item.span)), item.span)
            return
        kind = "keyword" if _is_keyword(item) else "required"
        self._add(plain, self._parameter(item, scope, kind), item.span)

    def _add(self, plain: list[ast.Parameter], parameter: ast.Parameter, span: Span) -> None:
        """Add a parameter, after a check of its order and name."""
        if parameter.kind == "required" and any(p.kind == "optional" for p in plain):
            hint = "move optional parameters after the required ones"
            raise SceneError("lambda-list", f"required parameter `{parameter.name}` after an optional one", hint, span)
        if parameter.name != "_" and any(p.name == parameter.name and p.target == parameter.target for p in plain):
            raise SceneError("duplicate", f"duplicate parameter `{parameter.name}`", None, span)
        plain.append(parameter)

    def _parameter(self, datum: Datum, scope: Scope, kind: str) -> ast.Parameter:
        """Declare a parameter and return it with its type."""
        name, annotation = self._annotation(datum)
        spelled = base_name(name)
        kind_type = None
        if annotation is not None:
            try:
                kind_type = self.annotated_type(annotation, datum.span)
            except SceneError as error:
                self.recover(error, datum.span)
        if spelled == "_":
            return ast.Parameter(None, "_", kind, kind_type)
        if scope.bindings.get(name) is not None:
            raise SceneError("duplicate", f"duplicate parameter `{spelled}`", None, datum.span)
        variable = self.declare(Atom(name, datum.span), scope)
        return ast.Parameter(variable, spelled, kind, kind_type)

    def value_of(self, parameter: Datum, scope: Scope) -> Datum:
        """Return a reference to a parameter, or none for one without a name."""
        name, _ = self._annotation(parameter)
        return none(parameter.span) if base_name(name) == "_" else self.expand(Atom(name, parameter.span), scope)

    def _annotation(self, datum: Datum) -> tuple[Symbol, str | None]:
        """Return the name and the type annotation of a parameter ``name::Type``."""
        value = datum.value if isinstance(datum, Atom) else None
        if isinstance(value, Annotated):
            return value.name, value.type
        if isinstance(value, TemplateKeyword):
            return value.alias, None
        if isinstance(value, (Symbol, Keyword)):
            text = base_name(value) if isinstance(value, Symbol) else str(value)
            name, sign, annotation = text.partition("::")
            if not sign:
                return (value if isinstance(value, Symbol) else Symbol(name)), None
            if name and annotation:
                return Symbol(name), annotation
        if isinstance(datum, ArrayDatum):
            raise SceneError(
                "bracket",
                "expected a parameter, found an array",
                "use parentheses instead of square brackets",
                datum.span,
            )
        raise SceneError(
            "lambda-list", "invalid parameter", "write a parameter as `name`, `(name default)` or `:name`", datum.span
        )

    def annotated_type(self, text: str, span: Span) -> Type:
        """Return the type named by an annotation."""
        if text in self.record_names:
            return record_type(text)
        try:
            return parse_type(text)
        except KeyError as unknown:
            name = str(unknown.args[0])
            hint = suggest(name, {*BASE_TYPES, *self.record_names})
            raise SceneError("type-name", f"unknown type `{name}`", hint, span) from None


# Markers in parameter lists of Common Lisp and Clojure, with the notation here of the parameters after them.
_MARKERS = {"&optional": "({} none)", "&key": "(:{} none)", "&rest": ". {}", "&body": ". {}", "&": ". {}"}


def _marker_error(items: Sequence[Datum], position: int) -> SceneError:
    """Return the error for ``&optional`` and other markers, with a fix that rewrites the parameters after it."""
    marker = items[position]
    assert is_identifier(marker)
    name = base_name(marker.value)
    names: list[str] = []
    end = marker.span.end
    following = items[position + 1] if position + 1 < len(items) else None
    if name == "&optional" and isinstance(following, ListDatum) and marker.span.expansion is None:
        edit = Edit(Span(marker.span.source, marker.span.start, following.span.start), "")
        return SceneError(
            "lambda-list", f"`{name}` is not used in parameter lists", f"write `{following.span.text}` alone",
            marker.span, fixes=(Fix("Remove it", (edit,), safe=True),),
        )  # fmt: skip
    for item in items[position + 1 :]:
        if not is_identifier(item) or base_name(item.value) in _MARKERS:
            break
        names.append(item.span.text)
        end = item.span.end
    template = _MARKERS[name]
    names = names[:1] if template.startswith(".") else names
    written = " ".join(template.format(parameter) for parameter in names or ("name",))
    fixes: tuple[Fix, ...] = ()
    if names and marker.span.expansion is None and len(names) == len(items) - position - 1:
        edit = Edit(Span(marker.span.source, marker.span.start, end), written)
        fixes = (Fix(f"Write `{written[:_MAX_SHOWN]}`", (edit,), safe=True),)
    message = f"`{name}` is not used in parameter lists"
    return SceneError("lambda-list", message, f"write `{written}`", marker.span, fixes=fixes)


def _default_outside(error: SceneError, items: Sequence[Datum], position: int) -> SceneError:
    """Return the error for a default that follows its keyword parameter, as in ``(lambda (:height 1) ...)``."""
    item, before = items[position], items[position - 1] if position else None
    is_value = isinstance(item, ArrayDatum) or (isinstance(item, Atom) and not is_identifier(item))
    if error.name not in ("lambda-list", "bracket") or before is None or not _is_keyword(before) or not is_value:
        return error
    text = f"({before.span.text} {item.span.text})"
    edit = Edit(Span(item.span.source, before.span.start, item.span.end), text)
    hint = f"write a default in parentheses: `{text}`"
    fixes = (Fix("Put the default in parentheses", (edit,), safe=True),) if item.span.expansion is None else ()
    return SceneError("lambda-list", "the default is not in parentheses", hint, item.span, fixes=fixes)


def _is_keyword(datum: Datum) -> bool:
    """Return whether a datum is a keyword parameter, with or without a type."""
    value = datum.value if isinstance(datum, Atom) else None
    return isinstance(value, Keyword) or (isinstance(value, Annotated) and value.keyword)


def _usage(parameters: Datum) -> str:
    """Return a parameter list for error messages, if it is in the source text and short."""
    text = " ".join(parameters.span.text.split())
    return text if parameters.span.expansion is None and len(text) < _MAX_USAGE else "see its definition"


def _outermost(span: Span) -> Span:
    """Return the span of the outermost macro use, without its expansion."""
    return Span(span.source, span.start, span.end)


# --- scanners of the forms that define names in a body or at top level; they run before anything is expanded ---------


Scanner = Callable[[Expander, ListDatum, Scope, list[Pending]], None]
SCANNERS: dict[str, Scanner] = {}


def scans(name: str) -> Callable[[Scanner], Scanner]:
    """Register a scanner of a form."""

    def register(scanner: Scanner) -> Scanner:
        SCANNERS[name] = scanner
        return scanner

    return register


def _definition(target: Datum, value: Callable[[], Datum], datum: Datum) -> Pending:
    """Return the pending definition of a declared target."""
    return Pending(lambda: core("DEFINE", [target, value()], datum.span), True, datum)


def _is_global(scope: Scope) -> bool:
    """Return whether a scope is that of a file's top level, whose parent resolves the builtins."""
    return scope.parent is not None and scope.parent.fallback is not None


@scans("define")
def scan_define(expander: Expander, datum: ListDatum, scope: Scope, pending: list[Pending]) -> None:
    """Scan ``define`` of a variable or a function."""
    items = datum.items
    if len(items) < 2:
        raise syntax_error("define", "`define` expects a name and a value", datum.span)
    head = items[1]
    if isinstance(head, ListDatum) and head.items:
        if len(items) < 3:
            raise syntax_error("define", "missing function body", datum.span)
        name = head.items[0]
        if not is_identifier(name):
            raise expander.not_a_name(name)
        target = _target(expander, name, scope)
        rest = head.items[1:]
        if rest or head.tail is None:
            parameters: Datum = ListDatum(rest, head.tail, head.span)
        else:
            parameters = head.tail
        spelled = base_name(name.value)

        def value() -> Datum:
            return expander.expand_lambda(parameters, items[2:], scope, datum.span, spelled)

    else:
        if len(items) != 3:
            problem = "missing value of `define`" if len(items) == 2 else "`define` has more than one value"
            names = [item.span.text for item in items[1:-1] if is_identifier(item)]
            is_function = len(items) > 3 and len(names) == len(items) - 2 and isinstance(items[-1], ListDatum)
            hint = f"a function with parameters is `(define ({' '.join(names)}) ...)`" if is_function else None
            raise syntax_error("define", problem, datum.span, hint)
        if not is_identifier(head):
            error = expander.not_a_name(head)
            raise error if error.name == "reserved" else syntax_error("define", "`define` expects a name", head.span)
        target = _target(expander, head, scope)
        spelled = base_name(head.value)

        def value() -> Datum:
            return expand_named(expander, items[2], scope, spelled)

    pending.append(_definition(target, value, datum))


def expand_named(expander: Expander, datum: Datum, scope: Scope, name: str) -> Datum:
    """Expand the value of a definition; if it is a ``lambda`` form, ``name`` becomes its name in error messages."""
    if isinstance(datum, ListDatum) and len(datum.items) > 2 and datum.tail is None:
        binding = expander.binding_of(datum.items[0], scope)
        if getattr(binding, "name", None) == "lambda":
            return expander.expand_lambda(datum.items[1], datum.items[2:], scope, datum.span, name)
    return expander.expand(datum, scope)


def _target(expander: Expander, name: Datum, scope: Scope) -> Datum:
    """Declare the name or pattern of a definition, which is visible in the whole body."""
    return expander.declare_target(name, scope, recursive=True, is_global=_is_global(scope))


@scans("define-values")
def scan_define_values(expander: Expander, datum: ListDatum, scope: Scope, pending: list[Pending]) -> None:
    """Scan ``define-values``."""
    if len(datum.items) != 3:
        raise syntax_error("define-values", "`define-values` expects names and one value", datum.span)
    target = _target(expander, datum.items[1], scope)
    pending.append(_definition(target, lambda: expander.expand(datum.items[2], scope), datum))


@scans("define-syntax")
def scan_define_syntax(expander: Expander, datum: ListDatum, scope: Scope, pending: list[Pending]) -> None:
    """Scan ``define-syntax``; an invalid macro is bound to a placeholder, so that its uses are not reported too."""
    if len(datum.items) != 3 or not is_identifier(datum.items[1]):
        raise syntax_error("define-syntax", "`define-syntax` expects a name and `syntax-rules`", datum.span)
    name = datum.items[1]
    _check_not_reserved(expander, name, scope)
    try:
        macro = macros.syntax_rules(expander, datum.items[2], scope, base_name(name.value), datum.span)
    except SceneError:
        scope.bind(name.value, macros.broken(base_name(name.value), datum.span))
        raise
    scope.bind(name.value, macro)
    expander.record_use(name, macro, defines=True)


@scans("define-macro")
def scan_define_macro(expander: Expander, datum: ListDatum, scope: Scope, pending: list[Pending]) -> None:
    """Scan ``define-macro``; an invalid macro is bound to a placeholder, so that its uses are not reported too."""
    head = datum.items[1] if len(datum.items) > 2 else None
    if not isinstance(head, ListDatum) or not head.items or not is_identifier(head.items[0]):
        raise syntax_error("define-macro", "`define-macro` expects (name parameter ...) and a body", datum.span)
    name = head.items[0]
    _check_not_reserved(expander, name, scope)
    parameters: Datum = ListDatum(head.items[1:], head.tail, head.span)
    if len(head.items) == 1 and head.tail is not None:
        parameters = head.tail
    try:
        macro = macros.procedural(expander, base_name(name.value), parameters, datum.items[2:], scope, datum.span)
    except SceneError:
        scope.bind(name.value, macros.broken(base_name(name.value), datum.span))
        raise
    scope.bind(name.value, macro)
    expander.record_use(name, macro, defines=True)


def _check_not_reserved(expander: Expander, name: Datum, scope: Scope) -> None:
    """Check a macro's name like that of a variable, by declaring it in a temporary scope."""
    uses, expander.uses = expander.uses, None
    expander.declare(name, Scope(scope))
    expander.uses = uses


@scans("define-record")
def scan_define_record(expander: Expander, datum: ListDatum, scope: Scope, pending: list[Pending]) -> None:
    """Scan ``define-record``, which defines the procedures of a record type.

    The default of a field is a function of the fields before it.
    """
    if len(datum.items) < 2 or not is_identifier(datum.items[1]):
        raise syntax_error("define-record", "`define-record` expects a name and fields", datum.span)
    name = datum.items[1]
    spelled = base_name(name.value)
    expander.declare_record(spelled)
    fields, types, defaults = _fields(datum)
    names = record_procedure_names(spelled, fields)
    targets = [name, *(Atom(Symbol(text), name.span) for text in names[1:])]
    target = expander.declare_target(
        ListDatum(tuple(targets), None, name.span), scope, recursive=True, is_global=_is_global(scope)
    )

    def value() -> Datum:
        def default_function(index: int) -> Datum:
            default = defaults[index]
            if default is None:
                return Atom(False, datum.span)
            earlier = ListDatum(tuple(Atom(Symbol(f), datum.span) for f in fields[:index]), None, datum.span)
            return expander.expand_lambda(earlier, [default], scope, default.span, f"{spelled}-{fields[index]}")

        declared = tuple(expander.annotated_type(t, datum.span) if t else None for t in types)
        definition = core("QUOTE", [opaque("DATUM", (spelled, tuple(fields), declared), datum.span)], datum.span)
        operands = [default_function(index) for index in range(len(fields))]
        return ListDatum((Atom(MAKE_RECORD, datum.span), definition, *operands), None, datum.span)

    pending.append(_definition(target, value, datum))


def _fields(datum: ListDatum) -> tuple[list[str], list[str], list[Datum | None]]:
    """Return the names, type annotations and defaults of the fields of a record."""
    fields: list[str] = []
    types: list[str] = []
    defaults: list[Datum | None] = []
    for item in datum.items[2:]:
        default: Datum | None = None
        if isinstance(item, ListDatum) and len(item.items) == 2 and item.tail is None:
            item, default = item.items
        if not is_identifier(item):
            hint = "write a field as `name` or `(name default)`"
            raise syntax_error("define-record", "invalid field", item.span, hint)
        name, _, annotation = base_name(item.value).partition("::")
        if name in fields:
            raise SceneError("duplicate", f"duplicate field `{name}`", None, item.span)
        if default is None and any(defaults):
            raise syntax_error("define-record", f"field `{name}` without a default after a field with one", item.span)
        fields.append(name)
        types.append(annotation)
        defaults.append(default)
    return fields, types, defaults


@scans("let-syntax")
@scans("letrec-syntax")
def scan_let_syntax(expander: Expander, datum: ListDatum, scope: Scope, pending: list[Pending]) -> None:
    """Add a ``let-syntax`` or ``letrec-syntax`` form to ``pending``; its macros are visible in its body only."""
    if len(datum.items) < 3 or not isinstance(datum.items[1], ListDatum):
        raise syntax_error("let-syntax", "`let-syntax` expects ((name (syntax-rules ...)) ...) and a body", datum.span)
    inner = Scope(scope)
    for binding in datum.items[1].items:
        if not isinstance(binding, ListDatum) or len(binding.items) != 2 or not is_identifier(binding.items[0]):
            raise syntax_error("let-syntax", "invalid macro binding", binding.span)
        name, rules = binding.items
        inner.bind(name.value, macros.syntax_rules(expander, rules, inner, base_name(name.value), binding.span))
    pending.append(Pending(lambda: expander.expand_body(datum.items[2:], inner, datum.span), False, datum))


# --- quasiquote (R7RS, section 4.2.8) ---------------------------------------------------------------------------------
#
# A template is lowered to calls of ``cons`` and ``append``; constant parts become constants.
#
# Inside a ``define-macro`` body, the symbols of a template become aliases, one set per expansion, so that they refer to
# the bindings where the macro is defined (see ``scope.Alias``).


_UNQUOTES = ("unquote", "unquote-splicing")


def expand_template(expander: Expander, datum: Datum, scope: Scope) -> Datum:
    """Return the core datum that builds the value of a quasiquoted template."""
    return _Template(expander, scope).build(datum, 1)


def _written_as(text: str, function: Atom) -> Atom:
    """Return a builtin that a template calls, whose messages name the syntax of the template instead of the builtin."""
    builtin = function.value
    assert isinstance(builtin, Builtin)

    def call(rt: Any, *operands: Any) -> Any:
        try:
            return builtin.function(rt, *operands)
        except SceneError as error:
            error.message = error.message.replace(f"`{builtin.name}`", text)
            raise

    return Atom(replace(builtin, function=call), function.span)


class _Template:
    """Builder of the code of one template."""

    def __init__(self, expander: Expander, scope: Scope) -> None:
        self.expander = expander
        self.scope = scope

    def build(self, datum: Datum, level: int) -> Datum:
        """Return the code of a template at a nesting level of quasiquotes; at level 1, unquoted parts are expanded."""
        if self._is_constant(datum):
            return core("QUOTE", [opaque("DATUM", quoted_value(datum), datum.span)], datum.span)
        if isinstance(datum, Atom):
            return self._alias(datum)
        if isinstance(datum, ArrayDatum):
            return self._array(datum, level)
        head = self._keyword(datum)
        if head == "unquote" and level == 1:
            return self.expander.expand(datum.items[1], self.scope)
        if head == "unquote-splicing" and level == 1:
            raise syntax_error("quasiquote", "`,@` is only allowed inside a list", datum.span)
        if head is not None:
            level += 1 if head == "quasiquote" else -1
        return self._list(datum.items, datum.tail, datum.span, level)

    def _list(self, items: tuple[Datum, ...], tail: Datum | None, span: Span, level: int) -> Datum:
        """Return the code of a list, built from its end by ``cons``, and by ``append`` for spliced parts."""
        ending = items[-2] if tail is None and len(items) > 2 else None
        name = base_name(ending.value) if ending is not None and is_identifier(ending) else ""
        if name == "unquote-splicing" and level == 1:  # (a . ,@b) reads as (a unquote-splicing b)
            raise syntax_error("quasiquote", "`,@` cannot stand behind the dot of a list", items[-1].span)
        if name == "unquote":  # (a . ,b) reads as (a unquote b)
            result = self.build(ListDatum(items[-2:], None, span), level)
            items = items[:-2]
        else:
            empty = core("QUOTE", [opaque("DATUM", quoted_value(ListDatum((), None, span)), span)], span)
            result = self.build(tail, level) if tail is not None else empty
        for item in reversed(items):
            if isinstance(item, ListDatum) and self._keyword(item) == "unquote-splicing" and level == 1:
                function = _written_as("`,@`", self.expander.builtin("append", span, self.scope))
                spliced = self.expander.expand(item.items[1], self.scope)
                result = ListDatum((function, spliced, result), None, item.span)
            else:
                result = self._call("cons", span, self.build(item, level), result)
        return result

    def _array(self, datum: ArrayDatum, level: int) -> Datum:
        """Return the code of an array; in a macro, code that returns it as data."""
        if self.expander.template_scope is not None:
            mark = core("QUOTE", [opaque("DATUM", BRACKETS, datum.span)], datum.span)
            return self._call("cons", datum.span, mark, self._list(datum.items, None, datum.span, level))
        splices = any(isinstance(i, ListDatum) and self._keyword(i) == "unquote-splicing" for i in datum.items)
        if splices:
            function = _written_as("an array", self.expander.builtin("array", datum.span, self.scope))
            return ListDatum((function, self._list(datum.items, None, datum.span, level)), None, datum.span)
        return ArrayDatum(tuple([self.build(item, level) for item in datum.items]), datum.span)

    def _call(self, name: str, span: Span, *operands: Datum) -> Datum:
        """Return a call of a builtin."""
        return ListDatum((self.expander.builtin(name, span, self.scope), *operands), None, span)

    def _alias(self, atom: Atom) -> Datum:
        """Return code that looks up the alias of a template symbol in the current expansion."""
        symbol = atom.value

        def alias(rt: Any) -> Any:
            return self.expander.template_alias(symbol)

        maker = Builtin("template-symbol", "", "Symbol", alias, "A template's symbol.", None, "macros")
        return ListDatum((Atom(maker, atom.span),), None, atom.span)

    @staticmethod
    def _keyword(datum: ListDatum) -> str | None:
        """Return ``unquote``, ``unquote-splicing`` or ``quasiquote`` if the datum is such a form, else None."""
        if len(datum.items) == 2 and datum.tail is None and is_identifier(datum.items[0]):
            name = base_name(datum.items[0].value)
            if name in _UNQUOTES or name == "quasiquote":
                return name
        return None

    def _is_constant(self, datum: Datum) -> bool:
        """Return whether a template contains no unquotes and, in a macro's template, no symbols that need an alias."""
        aliased = self.expander.template_scope is not None
        stack = [datum]
        while stack:
            item = stack.pop()
            if isinstance(item, Atom):
                if aliased and isinstance(item.value, Symbol):
                    return False
                continue
            if isinstance(item, ListDatum):
                if self._keyword(item) is not None or (
                    any(is_identifier(i) and base_name(i.value) in _UNQUOTES for i in item.items)
                ):
                    return False
                if item.tail is not None:
                    stack.append(item.tail)
            elif aliased:
                return False
            stack.extend(item.items)
        return True
