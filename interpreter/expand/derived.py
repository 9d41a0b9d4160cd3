"""Special forms in expressions: checking their syntax and lowering them to core forms.

The derived forms follow R7RS, section 4.2, unless a docstring says otherwise. A handler takes the expander, the form
and the scope, and returns a core datum.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from scenelang.grammar.ast import Head
from scenelang.grammar.datum import ArrayDatum, Atom, Datum, Keyword, ListDatum, Span, Symbol
from scenelang.grammar.diagnostics import Edit, Fix, SceneError, suggest
from scenelang.interpreter.expand import expand
from scenelang.interpreter.expand.expand import Expander, bracket_error, core, is_identifier, none, opaque, syntax_error
from scenelang.interpreter.expand.forms import FORMS
from scenelang.interpreter.expand.macros import check_proper, quoted_value
from scenelang.interpreter.expand.scope import Scope, Variable, base_name
from scenelang.interpreter.scene.declarations import FLAGS, RELATIONS, Relation, relation_hint

_MAX_SHOWN = 40  # characters of source text in a hint
_MAX_ASSERTION = 200  # characters of a failed test in its message

Handler = Callable[[Expander, ListDatum, Scope], Datum]
HANDLERS: dict[str, Handler] = {}


def handles(*names: str) -> Callable[[Handler], Handler]:
    """Register a handler of forms."""

    def register(handler: Handler) -> Handler:
        HANDLERS.update(dict.fromkeys(names, handler))
        return handler

    return register


def _misplaced(expander: Expander, datum: ListDatum, scope: Scope) -> Datum:
    """Report a definition or a top-level form in place of an expression."""
    name = base_name(datum.items[0].value)
    where = {"scene": "at the top level of the main file", "param": "at top level", "import": "at top level"}
    hint = f"`{name}` is only allowed {where.get(name, 'in a body or at top level')}"
    if name == "param" and len(datum.items) > 1 and is_identifier(datum.items[1]):
        hint = f"`param` stands at top level: move `{' '.join(datum.span.text.split())[:60]}` out of the form around it"
    raise SceneError("misplaced", f"expected an expression, found `{name}`", hint, datum.span)


HANDLERS.update(
    dict.fromkeys(
        ("define", "define-values", "define-record", "define-syntax", "define-macro", "import", "scene", "param",
         "syntax-rules"),
        _misplaced,
    )
)  # fmt: skip


@handles("let-syntax", "letrec-syntax")
def expand_let_syntax(expander: Expander, datum: ListDatum, scope: Scope) -> Datum:
    """Expand local macros and their body (``scan_let_syntax``)."""
    return expander.expand_body([datum], scope, datum.span)


def _count(datum: ListDatum, minimum: int, maximum: int | None = None) -> None:
    """Raise a syntax error if the number of operands of a form is not between ``minimum`` and ``maximum``."""
    count = len(datum.items) - 1
    name = base_name(datum.items[0].value)
    if count < minimum:
        raise syntax_error(name, f"incomplete `{name}` form", datum.span)
    if maximum is not None and count > maximum:
        raise syntax_error(name, f"unexpected operand of `{name}`", datum.items[maximum + 1].span)


@handles("quote")
def expand_quote(expander: Expander, datum: ListDatum, scope: Scope) -> Datum:
    """Expand ``quote``. A quoted handle has no data of file Z, because constants are created before Z is loaded."""
    _count(datum, 1, 1)
    return core("QUOTE", [opaque("DATUM", quoted_value(datum.items[1]), datum.span)], datum.span)


@handles("quasiquote")
def expand_quasiquote(expander: Expander, datum: ListDatum, scope: Scope) -> Datum:
    """Expand ``quasiquote``."""
    _count(datum, 1, 1)
    return expand.expand_template(expander, datum.items[1], scope)


@handles("if", "and", "or", "set!")
def expand_plain(expander: Expander, datum: ListDatum, scope: Scope) -> Datum:
    """Expand core forms whose operands are all expressions; the core grammar checks their number."""
    head = base_name(datum.items[0].value)
    if head == "set!":
        _check_operator(datum)
    operands = expander.expand_all(datum.items[1:], scope)
    if head == "set!":
        _check_assignment(datum, operands)
    terminal = {"if": "IF", "and": "AND", "or": "OR", "set!": "SET"}[head]
    return ListDatum((Atom(Head(terminal), datum.items[0].span), *operands), None, datum.span)


def _check_operator(datum: ListDatum) -> None:
    """Raise the error about ``(set! y += .5)``, an assignment of Python."""
    texts = [item.span.text for item in datum.items[1:]]
    if len(texts) == 3 and texts[1] in ("+=", "-=", "*=", "/=", "="):
        operator = texts[1][:-1]
        value = f"({operator} {texts[0]} {texts[2]})" if operator else texts[2]
        raise syntax_error(
            "set!", f"`{texts[1]}` is no operator", datum.items[2].span, f"write `(set! {texts[0]} {value})`"
        )


def _check_assignment(datum: ListDatum, operands: Sequence[Datum]) -> None:
    """Check that the target of ``set!`` is a variable, and mark it as assigned."""
    _count(datum, 2, 2)
    target = operands[0]
    variable = target.value if isinstance(target, Atom) else None
    if not isinstance(variable, Variable):
        if is_identifier(datum.items[1]):
            name = base_name(datum.items[1].value)
            raise syntax_error(
                "set!",
                f"cannot assign to the builtin `{name}`",
                datum.items[1].span,
                "define a variable with `define` or `let`",
            )
        hint = "to change an item of a list or table, write `(set-ref! xs i value)`"
        raise syntax_error("set!", "the target of `set!` must be a variable", datum.items[1].span, hint)
    variable.assigned = True


@handles("lambda")
def expand_lambda(expander: Expander, datum: ListDatum, scope: Scope) -> Datum:
    """Expand ``lambda``."""
    _count(datum, 2)
    return expander.expand_lambda(datum.items[1], datum.items[2:], scope, datum.span)


@handles("begin")
def expand_begin(expander: Expander, datum: ListDatum, scope: Scope) -> Datum:
    """Expand ``begin``."""
    _count(datum, 1)
    items = [expander.expand(item, scope) for item in datum.items[1:]]
    return items[0] if len(items) == 1 else core("BODY", items, datum.span)


@handles("begin0")
def expand_begin0(expander: Expander, datum: ListDatum, scope: Scope) -> Datum:
    """Expand ``begin0``, whose value is that of its first expression (Racket)."""
    _count(datum, 1)
    return core("FIRST", [expander.expand(item, scope) for item in datum.items[1:]], datum.span)


@handles("bind")
def expand_bind(expander: Expander, datum: ListDatum, scope: Scope) -> Datum:
    """Expand ``bind``; a function gets the word in quotes as its name for error messages."""
    _count(datum, 2, 2)
    literal = datum.items[1]
    if is_identifier(literal) and scope.lookup(literal.value) is None:
        hint = f'write it in quotes: `(bind "{base_name(literal.value)}" ...)`'
        raise SceneError("word", "a word must be a string", hint, literal.span)
    if _is_signature(literal, scope):
        raise _signature_error(literal)
    word = expander.expand(literal, scope)
    spelled = literal.value if isinstance(literal, Atom) and type(literal.value) is str else "entity function"
    function = expand.expand_named(expander, datum.items[2], scope, f'"{spelled}"')
    return core("BIND", [word, function], datum.span)


def _is_signature(target: Datum, scope: Scope) -> bool:
    """Return whether the target of a ``bind`` is ``(name parameter ...)``, as in Scheme's ``define``, and no call."""
    if not isinstance(target, ListDatum) or not target.items or not all(map(is_identifier, target.items)):
        return False
    head, *parameters = (scope.lookup(item.value) for item in target.items)
    return not isinstance(head, Variable) and all(each is None for each in parameters)


def _signature_error(target: ListDatum) -> SceneError:
    name, *parameters = (base_name(item.value) for item in target.items)
    written = f'(bind "{name}" (lambda ({" ".join(parameters)}) ...))'
    hint = f"write `{written}`; a function that is no word is defined by `define`"
    return SceneError("word", "a word must be a string", hint, target.span)


# --- local names ---------------------------------------------------------------------------------------------------


def _bindings(datum: ListDatum, operand: Datum, form: str) -> list[tuple[Datum, Datum]]:
    """Parse the bindings ``((target value) ...)`` of a ``let``."""
    if isinstance(operand, ArrayDatum):
        raise bracket_error(f"the bindings of `{form}`", operand)
    if not isinstance(operand, ListDatum) or operand.tail is not None:
        raise syntax_error(form, f"`{form}` expects bindings ((name value) ...)", operand.span)
    pairs = []
    for binding in operand.items:
        if isinstance(binding, ArrayDatum):
            raise bracket_error("a binding", binding)
        if not isinstance(binding, ListDatum) or len(binding.items) != 2 or binding.tail is not None:
            hint = "each binding is `(name value)`, and all of them stand in a pair of parentheses of their own"
            raise _with_parentheses(syntax_error(form, "invalid binding", binding.span, hint), operand)
        pairs.append((binding.items[0], binding.items[1]))
    return pairs


def _with_parentheses(error: SceneError, operand: ListDatum) -> SceneError:
    """Add the fix for a single binding or clause ``(name value)`` without the parentheses around all of them."""
    if len(operand.items) == 2 and is_identifier(operand.items[0]) and operand.span.expansion is None:
        text = f"({operand.span.text})"
        error.hint = f"write `{text}`" if len(text) < _MAX_SHOWN else error.hint
        error.fixes = (Fix("Add parentheses", (Edit(operand.span, text),), safe=True),)
    return error


def _check_distinct(pairs: Sequence[tuple[Datum, Datum]]) -> None:
    """Raise an error if two bindings have the same name."""
    names = set()
    for target, _ in pairs:
        if is_identifier(target) and base_name(target.value) != "_":
            if target.value in names:
                raise SceneError("duplicate", f"duplicate binding of `{base_name(target.value)}`", None, target.span)
            names.add(target.value)


def _named_value(expander: Expander, target: Datum, value: Datum, scope: Scope) -> Datum:
    """Expand the value of a binding; a function gets the name of the target."""
    name = base_name(target.value) if is_identifier(target) else "lambda"
    return expand.expand_named(expander, value, scope, name)


@handles("let", "let-values")
def expand_let(expander: Expander, datum: ListDatum, scope: Scope) -> Datum:
    """Expand ``let``: all values are evaluated before the variables are bound."""
    _count(datum, 2)
    if is_identifier(datum.items[1]):
        return _named_let(expander, datum, scope)
    pairs = _bindings(datum, datum.items[1], base_name(datum.items[0].value))
    _check_distinct(pairs)
    values = [_named_value(expander, target, value, scope) for target, value in pairs]
    inner = Scope(scope)
    items = []
    for (target, _), value in zip(pairs, values):
        items.append(core("DEFINE", [expander.declare_target(target, inner), value], target.span))
    body = expander.expand_body(datum.items[2:], inner, datum.span)
    return core("BODY", [*items, body], datum.span) if items else body


@handles("let*", "let*-values")
def expand_let_star(expander: Expander, datum: ListDatum, scope: Scope) -> Datum:
    """Expand ``let*``: each value sees the variables before it."""
    _count(datum, 2)
    items = []
    for target, value in _bindings(datum, datum.items[1], base_name(datum.items[0].value)):
        expanded = _named_value(expander, target, value, scope)
        scope = Scope(scope)
        items.append(core("DEFINE", [expander.declare_target(target, scope), expanded], target.span))
    body = expander.expand_body(datum.items[2:], scope, datum.span)
    return core("BODY", [*items, body], datum.span) if items else body


@handles("letrec", "letrec*")
def expand_letrec(expander: Expander, datum: ListDatum, scope: Scope) -> Datum:
    """Expand ``letrec`` and ``letrec*``: all variables are visible in all values."""
    _count(datum, 2)
    pairs = _bindings(datum, datum.items[1], base_name(datum.items[0].value))
    _check_distinct(pairs)
    inner = Scope(scope)
    targets = [expander.declare_target(target, inner, recursive=True) for target, _ in pairs]
    items = [
        core("DEFINE", [target, _named_value(expander, name, value, inner)], name.span)
        for target, (name, value) in zip(targets, pairs)
    ]
    body = expander.expand_body(datum.items[2:], inner, datum.span)
    return core("BODY", [*items, body], datum.span) if items else body


def _named_let(expander: Expander, datum: ListDatum, scope: Scope) -> Datum:
    """Expand ``(let loop ((name value) ...) body ...)`` to a local function and its first call."""
    _count(datum, 3)
    name = datum.items[1]
    pairs = _bindings(datum, datum.items[2], "let")
    values = [expander.expand(value, scope) for _, value in pairs]
    inner = Scope(scope)
    loop = expander.declare(name, inner, recursive=True)
    parameters = _loop_variables("let", [target for target, _ in pairs], datum.items[2])
    function = expander.expand_lambda(parameters, datum.items[3:], inner, datum.span, base_name(name.value))
    return _loop(loop, function, values, datum.span)


def _loop_variables(form: str, variables: Sequence[Datum], specs: Datum) -> ListDatum:
    """Return the parameters of a loop's function, after a check that each is a name with or without a type."""
    for variable in variables:
        is_list = isinstance(variable, ListDatum)
        if is_list or (isinstance(variable, Atom) and isinstance(variable.value, Keyword)):
            hint = "take a value apart in the body: `(define-values (a b) pair)`" if is_list else None
            raise syntax_error(form, "expected a name as the variable of a loop", variable.span, hint)
    return ListDatum(tuple(variables), None, specs.span)


def _loop(loop: Variable, function: Datum, values: Sequence[Datum], span: Span) -> Datum:
    """Return a local function and its first call; ``analyze`` recognizes it as a loop."""
    definition = core("DEFINE", [Atom(loop, span), function], span)
    start = ListDatum((Atom(loop, span), *values), None, span)
    return core("BODY", [definition, start], span)


@handles("do")
def expand_do(expander: Expander, datum: ListDatum, scope: Scope) -> Datum:
    """Expand ``do`` (R7RS, section 4.2.4) to a loop."""
    _count(datum, 2)
    specs, ending = datum.items[1], datum.items[2]
    if not isinstance(specs, ListDatum) or not isinstance(ending, ListDatum) or not ending.items:
        raise syntax_error("do", "`do` expects ((name init step) ...) and (test result ...)", datum.span)
    for spec in specs.items:
        if not isinstance(spec, ListDatum) or len(spec.items) not in (2, 3):
            raise syntax_error("do", "invalid variable of `do`", spec.span)
    check_proper(specs, ending, *specs.items)
    span = datum.span
    inits = [expander.expand(spec.items[1], scope) for spec in specs.items]
    outer = Scope(scope)
    loop = expander.declare(Atom(Symbol("do"), span), Scope(None), recursive=True)
    inner = Scope(outer)
    parameters, _ = expander._lambda_list(_loop_variables("do", [spec.items[0] for spec in specs.items], specs), inner)
    test = expander.expand(ending.items[0], inner)
    result = expander.expand_body(ending.items[1:], inner, span) if len(ending.items) > 1 else none(span)
    steps = [
        expander.expand(spec.items[2], inner) if len(spec.items) == 3 else expander.value_of(spec.items[0], inner)
        for spec in specs.items
    ]
    turn: Datum = ListDatum((Atom(loop, span), *steps), None, span)
    if len(datum.items) > 3:
        turn = core("BODY", [expander.expand_body(datum.items[3:], inner, span), turn], span)
    head = opaque("PARAMETERS", ("do", tuple(parameters), "the variables of the loop"), specs.span)
    function = core("LAMBDA", [head, ListDatum((), None, span), core("IF", [test, result, turn], span)], span)
    return _loop(loop, function, inits, span)


# --- choices ---------------------------------------------------------------------------------------------------


@handles("when", "unless")
def expand_when(expander: Expander, datum: ListDatum, scope: Scope) -> Datum:
    """Expand ``when`` and ``unless``, whose value is ``none`` if the body does not run."""
    _count(datum, 2)
    test = expander.expand(datum.items[1], scope)
    body = expander.expand_body(datum.items[2:], scope, datum.span)
    if base_name(datum.items[0].value) == "unless":
        return core("IF", [test, none(datum.span), body], datum.span)
    return core("IF", [test, body], datum.span)


@handles("cond")
def expand_cond(expander: Expander, datum: ListDatum, scope: Scope) -> Datum:
    """Expand ``cond``, whose value is ``none`` if no clause applies."""
    _count(datum, 1)
    return _cond_clauses(expander, datum.items[1:], scope, datum.span, none(datum.span))


def _cond_clauses(expander: Expander, clauses: Sequence[Datum], scope: Scope, span: Span, otherwise: Datum) -> Datum:
    """Lower clauses to nested conditionals, starting from the last clause."""
    result = otherwise
    arrays = [clause for clause in clauses if isinstance(clause, ArrayDatum)]
    if arrays:
        raise bracket_error("a clause", *arrays)
    for index in range(len(clauses) - 1, -1, -1):
        clause = clauses[index]
        if not isinstance(clause, ListDatum) or not clause.items or clause.tail is not None:
            raise syntax_error("cond", "invalid clause", clause.span)
        if expander.is_literal(clause.items[0], "else", scope):
            if index != len(clauses) - 1:
                raise syntax_error("cond", "`else` must be the last clause", clause.span)
            result = expander.expand_body(clause.items[1:], scope, clause.span)
            continue
        result = _cond_clause(expander, clause, scope, result)
    return result


def _cond_clause(expander: Expander, clause: ListDatum, scope: Scope, otherwise: Datum) -> Datum:
    """Return the conditional of a ``cond`` clause: ``(test)``, ``(test => function)`` or ``(test body ...)``."""
    span = clause.span
    test = expander.expand(clause.items[0], scope)
    if len(clause.items) == 1:
        return core("OR", [test, otherwise], span)
    if expander.is_literal(clause.items[1], "=>", scope):
        if len(clause.items) != 3:
            raise syntax_error("cond", "`=>` must be followed by exactly one function", span)
        receiver = expander.expand(clause.items[2], scope)
        value = Variable("value", span)
        chosen = ListDatum((receiver, Atom(value, span)), None, span)
        definition = core("DEFINE", [Atom(value, span), test], span)
        return core("BODY", [definition, core("IF", [Atom(value, span), chosen, otherwise], span)], span)
    return core("IF", [test, expander.expand_body(clause.items[1:], scope, span), otherwise], span)


@handles("case")
def expand_case(expander: Expander, datum: ListDatum, scope: Scope) -> Datum:
    """Expand ``case``, which compares by ``equal?``.

    R7RS specifies ``eqv?``, which never matches lists; constants that are lists are useful. Both distinguish 1 from
    1.0.
    """
    _count(datum, 2)
    span = datum.span
    key = Variable("key", span)
    member, equal = (expander.builtin(name, span, scope) for name in ("member", "equal?"))
    result: Datum = none(span)
    for index in range(len(datum.items) - 1, 1, -1):
        clause = datum.items[index]
        if not isinstance(clause, ListDatum) or len(clause.items) < 2:
            raise syntax_error("case", "invalid clause", clause.span)
        check_proper(clause, clause.items[0])
        if expander.is_literal(clause.items[0], "else", scope) and index == len(datum.items) - 1:
            result = _case_body(expander, clause, scope, key)
            continue
        if not isinstance(clause.items[0], ListDatum):
            raise syntax_error("case", "expected a list of constants at the start of a clause", clause.items[0].span)
        constants = core("QUOTE", [opaque("DATUM", quoted_value(clause.items[0]), span)], span)
        test = ListDatum((member, Atom(key, span), constants, equal), None, clause.span)
        result = core("IF", [test, _case_body(expander, clause, scope, key), result], clause.span)
    definition = core("DEFINE", [Atom(key, span), expander.expand(datum.items[1], scope)], span)
    return core("BODY", [definition, result], span)


def _case_body(expander: Expander, clause: ListDatum, scope: Scope, key: Variable) -> Datum:
    """Expand the body of a ``case`` clause; ``=> function`` calls the function with the key."""
    if expander.is_literal(clause.items[1], "=>", scope) and len(clause.items) == 3:
        return ListDatum((expander.expand(clause.items[2], scope), Atom(key, clause.span)), None, clause.span)
    return expander.expand_body(clause.items[1:], scope, clause.span)


# --- control -------------------------------------------------------------------------------------------------------


@handles("while")
def expand_while(expander: Expander, datum: ListDatum, scope: Scope) -> Datum:
    """Expand ``while``."""
    _count(datum, 1)
    test = expander.expand(datum.items[1], scope)
    body = expander.expand_body(datum.items[2:], scope, datum.span) if len(datum.items) > 2 else none(datum.span)
    return core("WHILE", [test, body], datum.span)


@handles("let/ec")
def expand_let_escape(expander: Expander, datum: ListDatum, scope: Scope) -> Datum:
    """Expand ``let/ec``, an escape procedure that is valid in its body only (Racket)."""
    _count(datum, 2)
    inner = Scope(scope)
    variable = expander.declare(datum.items[1], inner)
    body = expander.expand_body(datum.items[2:], inner, datum.span)
    return core("LET_ESCAPE", [Atom(variable, datum.items[1].span), body], datum.span)


@handles("guard")
def expand_guard(expander: Expander, datum: ListDatum, scope: Scope) -> Datum:
    """Expand ``guard`` (R7RS, section 4.2.7): an error that no clause handles is raised again."""
    _count(datum, 2)
    clauses = datum.items[1]
    if not isinstance(clauses, ListDatum) or not clauses.items or not is_identifier(clauses.items[0]):
        raise syntax_error("guard", "`guard` expects (name clause ...) as its first operand", datum.span)
    inner = Scope(scope)
    variable = expander.declare(clauses.items[0], inner)
    span = datum.span
    reraise = ListDatum((expander.builtin("raise", span, scope), Atom(variable, span)), None, span)
    handler = _cond_clauses(expander, clauses.items[1:], inner, span, reraise)
    body = expander.expand_body(datum.items[2:], scope, span)
    return core("GUARD", [Atom(variable, clauses.items[0].span), body, handler], span)


def _is_text(datum: Datum) -> bool:
    """Return whether a datum is a string."""
    return isinstance(datum, Atom) and type(datum.value) is str


def _swapped_assert(datum: ListDatum) -> SceneError:
    """Return the error for a message before the test: the message would be a test that is always true."""
    error = syntax_error("assert", "the test comes before the message", datum.items[1].span)
    first, second = datum.items[1].span, datum.items[2].span
    if first.expansion is None and second.expansion is None:
        edits = (Edit(first, second.text), Edit(second, first.text))
        error.fixes = (Fix("Swap them", edits, safe=True),)
    return error


@handles("assert")
def expand_assert(expander: Expander, datum: ListDatum, scope: Scope) -> Datum:
    """Expand ``assert`` to a test and a call of ``assertion-failed``; the default message is the text of the test."""
    _count(datum, 1, 2)
    span = datum.span
    if len(datum.items) > 2 and _is_text(datum.items[1]) and not _is_text(datum.items[2]):
        raise _swapped_assert(datum)
    test = expander.expand(datum.items[1], scope)
    if len(datum.items) > 2:
        message = expander.expand(datum.items[2], scope)
    else:
        message = Atom(f"assertion failed: {' '.join(datum.items[1].span.text.split())[:_MAX_ASSERTION]}", span)
    failed = ListDatum((expander.builtin("assertion-failed", span, scope), message), None, span)
    return core("IF", [test, none(span), failed], span)


@handles("assert-that")
def expand_assert_that(expander: Expander, datum: ListDatum, scope: Scope) -> Datum:
    """Expand ``assert-that`` to one call of ``declare-that`` for each relation."""
    _count(datum, 1)
    statements = list(datum.items[1:])
    message = statements.pop() if len(statements) > 1 and _is_text(statements[-1]) else None
    calls = [_declaration(expander, statement, scope, message) for statement in statements]
    return calls[0] if len(calls) == 1 else core("BODY", calls, datum.span)


def _declaration(
    expander: Expander, datum: Datum, scope: Scope, message: Datum | None, *, is_negated: bool = False
) -> Datum:
    """Return the call of ``declare-that`` for one relation; operands and values of options are expressions."""
    head = datum.items[0] if isinstance(datum, ListDatum) and datum.items else None
    if not isinstance(datum, ListDatum) or head is None or not is_identifier(head):
        hint = 'write a relation, such as `(on "cup" "table")`'
        raise syntax_error("assert-that", "expected a relation", datum.span, hint)
    check_proper(datum)
    name = base_name(head.value)
    if name == "not" and len(datum.items) == 2:
        return _declaration(expander, datum.items[1], scope, message, is_negated=not is_negated)
    if name == "not":
        problem = f"`not` expects one relation, got {len(datum.items) - 1} operands"
        raise syntax_error("assert-that", problem, datum.span, 'write `(not (on "cup" "table"))`')
    relation = RELATIONS.get(name)
    if relation is None:
        hint = suggest(name, RELATIONS) or relation_hint(name)
        raise syntax_error("assert-that", f"unknown relation `{name}`", head.span, hint)
    operands, options = _relation_operands(relation, datum)
    wrong_count = relation.wrong_count(len(operands))
    if wrong_count is not None:
        raise syntax_error("assert-that", wrong_count, datum.span, f"write `{relation.usage}`")
    span = datum.span
    if message is not None:
        options.append(("message", message))
    if is_negated:
        options.append(("negated", Atom(True, span)))
    objects = ListDatum((expander.builtin("list", span, scope), *expander.expand_all(operands, scope)), None, span)
    named = [part for key, value in options for part in (Atom(Keyword(key), span), expander.expand(value, scope))]
    return ListDatum((expander.builtin("declare-that", span, scope), Atom(name, span), objects, *named), None, span)


def _relation_operands(relation: Relation, datum: ListDatum) -> tuple[list[Datum], list[tuple[str, Datum]]]:
    """Return the operands of a relation, and its options with their values."""
    operands: list[Datum] = []
    options: list[tuple[str, Datum]] = []
    pending = list(reversed(datum.items[1:]))
    while pending:
        item = pending.pop()
        if not (isinstance(item, Atom) and isinstance(item.value, Keyword)):
            operands.append(item)
            continue
        key = str(item.value)
        if key not in relation.keywords:
            takes = ", ".join(f"`:{option}`" for option in relation.keywords)
            hint = suggest(key, relation.keywords) or f"it takes {takes}"
            raise syntax_error("assert-that", f"`{relation.name}` has no option `:{key}`", item.span, hint)
        if any(key == other for other, _ in options):
            raise syntax_error("assert-that", f"`:{key}` is given twice", item.span)
        if key in FLAGS:
            options.append((key, Atom(True, item.span)))
        elif pending:
            options.append((key, pending.pop()))
        else:
            raise syntax_error("assert-that", f"`:{key}` has no value", item.span, f"write `{relation.usage}`")
    return operands, options


# --- comprehensions --------------------------------------------------------------------------------------------


def _for_handler(name: str) -> Handler:
    """Return the handler of a ``for`` form, such as ``for*/list``."""
    is_nested = name.startswith("for*")
    kind = name.partition("/")[2] or "each"

    def handler(expander: Expander, datum: ListDatum, scope: Scope) -> Datum:
        return _expand_for(expander, datum, scope, kind, is_nested=is_nested)

    return handler


HANDLERS.update({name: _for_handler(name) for name in FORMS if name == "for" or name.startswith(("for/", "for*"))})


def _expand_for(expander: Expander, datum: ListDatum, scope: Scope, kind: str, *, is_nested: bool) -> Datum:
    """Expand a comprehension, as in Racket; ``is_nested`` is set for ``for*``, whose sequences are nested."""
    form = base_name(datum.items[0].value)
    first = 2 if kind == "fold" else 1
    _count(datum, first + 1)
    span = datum.span
    inner = Scope(scope)
    accumulators: list[Datum] = []
    if kind == "fold":
        pairs = _bindings(datum, datum.items[1], form)
        values = [expander.expand(value, scope) for _, value in pairs]
        accumulators = [
            core("DEFINE", [Atom(expander.declare(target, inner), target.span), value], target.span)
            for (target, _), value in zip(pairs, values)
        ]
    clauses, inner = _clauses(expander, datum.items[first], inner, form, is_nested=is_nested)
    body = expander.expand_body(datum.items[first + 1 :], inner, span)
    lists = [ListDatum(tuple(items), None, span) for items in (accumulators, clauses)]
    return core("FOR", [opaque("KIND", kind, span), *lists, body], span)


def _clauses(
    expander: Expander, operand: Datum, scope: Scope, form: str, *, is_nested: bool
) -> tuple[list[Datum], Scope]:
    """Return the core clauses of a loop, and the scope in which all their variables are visible.

    Adjacent sequences form a group that is iterated in parallel, unless ``is_nested``.
    """
    if isinstance(operand, ArrayDatum):
        raise bracket_error(f"the clauses of `{form}`", operand)
    if not isinstance(operand, ListDatum) or operand.tail is not None:
        raise syntax_error(form, f"`{form}` expects clauses ((name sequence) ...)", operand.span)
    clauses: list[Datum] = []
    group: list[tuple[Datum, Datum]] = []
    items = list(operand.items)
    while items or group:
        item = items[0] if items else None
        is_test = isinstance(item, Atom) and isinstance(item.value, Keyword)
        if group and (item is None or is_test or is_nested):
            scope = _close_group(expander, group, clauses, scope)
            group = []
            continue
        if item is None:
            break
        if is_test:
            clauses.append(_test_clause(expander, items, scope, form))
            continue
        group.append(_sequence_clause(items.pop(0), form, operand))
    return clauses, scope


def _sequence_clause(item: Datum, form: str, operand: ListDatum) -> tuple[Datum, Datum]:
    """Parse a clause ``(target sequence)``."""
    if isinstance(item, ArrayDatum):
        raise bracket_error("a clause", item)
    if not isinstance(item, ListDatum) or len(item.items) != 2 or item.tail is not None:
        hint = "write each clause as `(name sequence)`, and put all of them in another pair of parentheses"
        for clause in (operand, item):  # `(i in xs)` and `((i in xs))`
            parts = [part.span.text for part in clause.items] if isinstance(clause, ListDatum) else []
            if len(parts) == 3 and parts[1] in ("in", "of", "from", "<-", ":"):
                hint = f"write `(({parts[0]} {parts[2]}))`, without `{parts[1]}`"
                raise syntax_error(form, "invalid clause", clause.span, hint)
        raise _with_parentheses(syntax_error(form, "invalid clause", item.span, hint), operand)
    return item.items[0], item.items[1]


def _close_group(expander: Expander, group: list[tuple[Datum, Datum]], clauses: list[Datum], scope: Scope) -> Scope:
    """Add the clause of a group of sequences, and return the scope of its variables."""
    _check_distinct(group)
    values = [expander.expand(value, scope) for _, value in group]
    scope = Scope(scope)
    operands: list[Datum] = []
    for (target, _), value in zip(group, values):
        operands += (expander.declare_target(target, scope), value)
    clauses.append(core("CLAUSE", operands, group[0][0].span))
    return scope


def _test_clause(expander: Expander, items: list[Datum], scope: Scope, form: str) -> Datum:
    """Expand a clause ``:when test``, ``:unless test`` or ``:break test``."""
    keyword = items.pop(0)
    assert isinstance(keyword, Atom)
    kind = str(keyword.value)
    if kind not in ("when", "unless", "break"):
        raise syntax_error(
            form, f"unknown clause keyword `:{kind}`", keyword.span, "use `:when`, `:unless` or `:break`"
        )
    if not items:
        raise syntax_error(form, f"expected a test after `:{kind}`", keyword.span)
    test = expander.expand(items.pop(0), scope)
    return ListDatum((opaque("CLAUSE", kind, keyword.span), test), None, keyword.span)
