"""Translation of a response of a language model to a program: parse, analyse, generate, choose names, lay out."""

from __future__ import annotations

import ast
import copy
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial, reduce
from operator import or_
from typing import TYPE_CHECKING, Literal

from scenelang.grammar.datum import Atom, Datum, Source, Span, Symbol, walk
from scenelang.grammar.diagnostics import Diagnostic
from scenelang.grammar.python_helpers import HELPERS
from scenelang.interpreter.runtime.modelling_helpers import ASSERT_THAT, relation_helpers, scene_helpers
from scenelang.interpreter.transpile.analysis.collect import find_collections
from scenelang.interpreter.transpile.analysis.infer import Departures, infer
from scenelang.interpreter.transpile.analysis.inference import NONE, RECORD, UNKNOWN, TypeFacts
from scenelang.interpreter.transpile.analysis.inheritance import Dispatch
from scenelang.interpreter.transpile.analysis.inlining import with_generators_in_place
from scenelang.interpreter.transpile.analysis.liveness import Liveness
from scenelang.interpreter.transpile.analysis.lowering import (
    MOST_PASSES,
    OperatorMethods,
    has_classes,
    lowered,
    without_unused_methods,
)
from scenelang.interpreter.transpile.analysis.operator_cases import KnownTests
from scenelang.interpreter.transpile.analysis.python_text import PythonText, parse_python, walk_tree
from scenelang.interpreter.transpile.analysis.scopes import (
    Class,
    Function,
    LibraryPaths,
    PythonNames,
    find_root,
    registered_words,
    resolve,
)
from scenelang.interpreter.transpile.analysis.value_classes import values_of
from scenelang.interpreter.transpile.writing.code import Code, Finish, Namer, Output, prose
from scenelang.interpreter.transpile.writing.expressions import write_expression
from scenelang.interpreter.transpile.writing.statements import header_texts, write_program, write_statement
from scenelang.interpreter.transpile.writing.writer import Analysed, Writer

if TYPE_CHECKING:
    from scenelang.interpreter.transpile.evaluation.evaluator import StepBudget

_MAX_FOLDINGS = 3  # evaluations of the parts with errors: what remains may have errors in other parts
_MISTAKES = ("python-name", "python-call")  # these errors say more than where the evaluation ends
# Characters of a response before the code, and after it, that become comments: models append whole essays, and users
# want the program.
_MAX_PROSE = 1200


@dataclass(frozen=True, slots=True, eq=False)
class Translation:
    """Program translated from Python.

    Attributes
    ----------
    forms
        The program's forms, with their spans in the Python; empty if there are errors.
    text
        Text of the program.
    diagnostics
        Errors and warnings.
    partial
        If there are errors, the forms with ``(void)`` in place of what was not translated, for further checks.
    way
        How it was made: by translation, from a program with data in place of what computes it, or with functions
        evaluated.
    """

    forms: tuple[Datum, ...]
    text: str
    diagnostics: tuple[Diagnostic, ...]
    partial: tuple[Datum, ...] = ()
    way: Literal["translated", "rewritten", "tabulated", "evaluated"] = "translated"

    def with_diagnostics(self, diagnostics: tuple[Diagnostic, ...]) -> Translation:
        """Return the translation with the diagnostics of the checker, without a program if one of them is an error."""
        translation = replace(self, diagnostics=diagnostics)
        return translation if translation.ok else Translation((), "", diagnostics)

    @property
    def ok(self) -> bool:
        return not any(d.is_error for d in self.diagnostics)

    @property
    def changes_data(self) -> bool:
        """Whether the program changes lists, tables or arrays in place, so that a mistake shows only when it runs."""
        names = (
            str(datum.value) for datum in walk(*self.forms) if isinstance(datum, Atom) and type(datum.value) is Symbol
        )
        return any(name.endswith("!") and name != "set!" for name in names)


def translate(source: Source, with_text: bool = True, finish: Finish | None = None) -> Translation:
    """Translate the Python code of a response or file. Errors in the code are returned as diagnostics, never raised.

    ``finish`` lifts the program whose text is returned; the forms are the literal translation.
    """
    text = parse_python(source)
    if text.response.ignored:
        span = Span(source, text.response.end, text.response.end)
        number = text.response.ignored
        which = f"{number} more Python code blocks" if number > 1 else "another Python code block"
        message = f"{which} of the response {'are' if number > 1 else 'is'} ignored"
        text.diagnostics.append(Diagnostic("ignored-block", message, span))
    analysed = analyse(text)
    translation = _translation(text, analysed, finish, with_text=with_text)
    if translation.ok or any(d.is_error for d in text.diagnostics):
        return translation if analysed.text.tree is text.tree else replace(translation, way="rewritten")
    from scenelang.interpreter.transpile.evaluation.evaluator import StepBudget

    in_place = _with_generators_in_place(text, translation.diagnostics)
    if in_place is not None:
        second = _translation(in_place, analyse(in_place), finish, with_text=with_text)
        if second.ok:
            return replace(second, way="rewritten")
        if analysed.root is not None:
            errors = [d for d in second.diagnostics if d.is_error]
            with_tables = _with_tables(in_place, analysed.root.name, errors, StepBudget(), finish, with_text=with_text)
            if with_tables is not None:
                return with_tables
    return _with_evaluated_parts(text, analysed, translation, translation.diagnostics, finish, with_text=with_text)


def obstacles(source: Source) -> list[Diagnostic]:
    """Return what keeps a program from being translated without any evaluation."""
    text = parse_python(source)
    return [d for d in _translation(text, analyse(text), None, with_text=False).diagnostics if d.is_error]


def _with_generators_in_place(text: PythonText, diagnostics: Sequence[Diagnostic]) -> PythonText | None:
    """Return the program in which generators are written where they are used, because they are no lists there."""
    spans = {d.span for d in diagnostics if d.is_error and "generator" in d.message}
    tree = with_generators_in_place(text.tree, lambda node: text.span(node) in spans)
    return replace(text, tree=tree) if tree is not None else None


def with_evaluated_parts(
    source: Source,
    translation: Translation,
    errors: Sequence[Diagnostic],
    with_text: bool = True,
    finish: Finish | None = None,
) -> Translation:
    """Translate again, with the parts evaluated in which the checker, or a run, has found errors.

    Those that make no shapes are evaluated to data, unless they have been. Loops are written out otherwise: what
    remains of a loop would fail as the translation has.
    """
    text = parse_python(source)
    analysed = analyse(text)
    diagnostics = [*_translation(text, analysed, None, with_text=False).diagnostics, *errors]
    if translation.way != "tabulated" and analysed.root is not None:
        from scenelang.interpreter.transpile.evaluation.evaluator import StepBudget

        known = [d for d in diagnostics if d.is_error]
        with_tables = _with_tables(text, analysed.root.name, known, StepBudget(), finish, with_text=with_text)
        if with_tables is not None:
            return with_tables
    return _with_evaluated_parts(
        text, analysed, translation, diagnostics, finish, ("unrolled", "drawn"), with_text=with_text
    )


def _with_evaluated_parts(
    text: PythonText,
    analysed: Analysed,
    translation: Translation,
    diagnostics: Sequence[Diagnostic],
    finish: Finish | None,
    ways: Sequence[str] = ("loops", "unrolled", "drawn"),
    *,
    with_text: bool,
) -> Translation:
    from scenelang.interpreter.transpile.evaluation.evaluator import StepBudget
    from scenelang.interpreter.transpile.evaluation.folding import fold

    budget = StepBudget()
    root = analysed.root.name if analysed.root is not None else None
    errors = [d for d in diagnostics if d.is_error]
    if "loops" in ways:  # else a run of the translation has failed
        with_tables = _with_tables(text, root, errors, budget, finish, with_text=with_text)
        if with_tables is not None:
            return with_tables
    for _ in range(_MAX_FOLDINGS):
        more: list[Diagnostic] = []
        for way in ways:
            remaining = fold(text, root, errors, way, budget)
            if isinstance(remaining.text, Diagnostic) and way == ways[0]:
                return _refused(remaining.text, diagnostics, translation)
            for folded in (remaining.with_originals, remaining.text):
                if isinstance(folded, PythonText):
                    second = _translation(folded, analyse(folded), finish, with_text=with_text)
                    if second.ok:
                        return replace(second, way="evaluated")
                    if way == ways[0] and folded is remaining.text:
                        more += [d for d in second.diagnostics if d.is_error]
        if not more:
            break
        errors += more
    return translation


def _with_tables(
    text: PythonText,
    root: str | None,
    errors: Sequence[Diagnostic],
    budget: StepBudget,
    finish: Finish | None,
    *,
    with_text: bool,
) -> Translation | None:
    """Return the program in which data is computed that the translation does not know how to; None if that fails."""
    from scenelang.interpreter.transpile.evaluation.tabulation import tabulated

    known = [d for d in errors if d.span is not None]
    while root is not None and known:
        folded = tabulated(text, root, known, budget)
        if folded is None:
            return None
        second = _translation(folded, analyse(folded), finish, with_text=with_text)
        if second.ok:
            return replace(second, way="tabulated")
        seen = {(each.name, each.span) for each in known}
        more = [d for d in second.diagnostics if d.is_error and (d.name, d.span) not in seen]
        if not more:
            return None
        known += more
    return None


def _refused(folded: Diagnostic, diagnostics: Sequence[Diagnostic], translation: Translation) -> Translation:
    """Return the errors of a program that can neither be translated nor evaluated: where its evaluation ends, and why.

    What the translation takes for a mistake may follow from what it does not support, as the methods of a class of
    which it does not know the base. In a program with such parts only a mistake at the place where Python raises an
    exception is one; where all is supported, one that is confirmed confirms the others, and the evaluation that ends
    without an exception refutes none. What is forbidden is forbidden wherever it stands.
    """
    place = folded.span
    errors = tuple(d for d in diagnostics if d.is_error)
    if folded.name == "python-forbidden":
        return Translation((), "", tuple(d for d in errors if d.name == folded.name) or (folded,))
    mistakes = tuple(d for d in errors if d.name in _MISTAKES)
    confirmed = tuple(d for d in mistakes if d.span and place and d.span.overlaps(place))
    is_supported = not any(d.name == "python-unsupported" for d in errors)
    if is_supported and (confirmed or (mistakes and folded.name == "python-unsupported")):
        return Translation((), "", errors, translation.partial)  # in which the checker may find more
    return Translation((), "", confirmed if confirmed and folded.name == "python-exception" else (folded,))


def _translation(text: PythonText, analysed: Analysed, finish: Finish | None, *, with_text: bool) -> Translation:
    source = text.source
    writer = Writer(analysed, write_expression, write_statement)
    header = header_texts(writer)
    forms = write_program(writer)
    for node, what in Departures(analysed.names, analysed.paths, analysed.facts).find():
        writer.diagnostics.append(writer.unsupported(what, node).diagnostic)
    diagnostics = _sorted([*text.diagnostics, *writer.diagnostics])
    if not any(d.is_error for d in diagnostics) and analysed.root is None:
        span = Span(source, text.response.start, text.response.start)
        hint = "decorate the function of the scene with `@register()`"
        diagnostics.append(Diagnostic("no-root", "the Python code registers no function", span, hint))
    if any(d.is_error for d in diagnostics):
        partial = _generate(text, writer, forms, header, diagnostics, None, with_text=False)
        return Translation((), "", tuple(diagnostics), partial.forms)
    return _generate(text, writer, forms, header, diagnostics, finish, with_text=with_text)


def analyse(text: PythonText) -> Analysed:
    """Run all analyses that code generation depends on."""
    tree = lowered(text.tree)
    analysed = _analysed(replace(text, tree=tree))
    if tree is not text.tree and has_classes(tree):
        dispatch = Dispatch({each.id for each in walk_tree(tree) if isinstance(each, ast.Name)})
        for _ in range(MOST_PASSES):
            operators = OperatorMethods(
                partial(_instances, analysed),
                partial(_kinds, analysed),
                partial(_kinds_of_keys, analysed),
                partial(_classes_of_items, analysed),
                dispatch,
            )
            tree = operators.visit(tree)
            if not operators.count:
                tests = KnownTests(partial(_kinds, analysed), partial(_instances, analysed))
                tree = tests.visit(tree)
                if not tests.count:
                    break
            analysed = _analysed(replace(text, tree=tree))
    used = without_unused_methods(tree) if has_classes(tree) else tree
    if used is not tree:
        tree, analysed = used, _analysed(replace(text, tree=used))
    if has_classes(tree) and (values := values_of(tree, analysed.facts)) is not None:
        if tree is text.tree:
            tree = copy.deepcopy(tree)
            values = values_of(tree, _analysed(replace(text, tree=tree)).facts)
        if values is not None:
            analysed = _analysed(replace(text, tree=values.visit(tree)))
    return analysed


def _instances(analysed: Analysed, node: ast.expr) -> list[Class]:
    """Return the classes of which an expression is an instance; none for a name of a class."""
    if isinstance(node, ast.Name) and any(
        c.variable is analysed.names.variables.get(node) for c in analysed.names.classes.values()
    ):
        return []
    inferred = analysed.facts.type(node)
    return inferred.classes if not inferred.kinds & ~(RECORD | NONE | UNKNOWN) else []


def _kinds(analysed: Analysed, node: ast.expr) -> int:
    """Return the kinds of values that an expression may have."""
    return analysed.facts.type(node).kinds


def _kinds_of_keys(analysed: Analysed, node: ast.expr) -> int:
    """Return the kinds of the keys of a table; 0 if it is not known which table it is."""
    kinds = [site.key.kinds for site in analysed.facts.type(node).sites]
    return reduce(or_, kinds, 0) if all(kinds) else 0


def _classes_of_items(analysed: Analysed, node: ast.expr) -> list[Class]:
    """Return the classes of the items of a sequence, if all of them are instances of classes."""
    sites = analysed.facts.type(node).sites
    if not sites or any(site.element.kinds & ~RECORD or not site.element.kinds for site in sites):
        return []
    return list(dict.fromkeys(cls for site in sites for cls in site.element.classes))


def _analysed(text: PythonText) -> Analysed:
    names = resolve(text.tree)
    paths = LibraryPaths(names)
    liveness = Liveness(names)
    words = registered_words(names)
    root = find_root(names, paths, words)
    collections = find_collections(names, liveness)
    facts = infer(names, paths, words, root, collections.additions)
    spread = _analyse_calls(names, facts) | _spread_primitive_keys(text.tree)
    return Analysed(text, names, paths, liveness, collections, facts, words, root, spread)


def _spread_primitive_keys(tree: ast.Module) -> set[str]:
    """Return the parameter names that ``primitive_call(word, **table)`` takes from a table."""
    calls = (node for node in walk_tree(tree) if isinstance(node, ast.Call))
    is_spread = any(
        isinstance(c.func, ast.Name) and c.func.id == "primitive_call" and any(k.arg is None for k in c.keywords)
        for c in calls
    )
    return {"shape_kwargs"} if is_spread else set()


def _analyse_calls(names: PythonNames, facts: TypeFacts) -> set[str]:
    """Mark parameters passed by keyword, and registered functions that are also called directly.

    Returns the names of parameters that may come from a table, passed with ``**``.
    """
    spread: set[str] = set()
    for function in names.ordered:
        if function.is_registered:
            for parameter in function.parameters:
                parameter.variable.is_keyword = parameter.kind in ("plain", "keyword")
        for parameter in function.parameters:
            if parameter.kind == "keyword":
                parameter.variable.is_keyword = True
    callees = set()
    for call, targets in facts.targets.items():
        is_library = isinstance(call.func, ast.Name) and call.func.id == "library_call"
        named = {k.arg for k in call.keywords if k.arg is not None}
        callees.add(call.func)
        for target in targets:
            if not is_library:
                target.is_called_directly = True
            has_table = any(k.arg is None for k in call.keywords)
            _mark_keyword_parameters(target, named, has_table=has_table)
            if has_table:
                spread |= {p.variable.name for p in target.parameters}
    _analyse_constructors(names, facts)
    for node, variable in names.variables.items():
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load) and node not in callees:
            for function in variable.functions:
                function.is_used_as_value = True
    return spread


def _analyse_constructors(names: PythonNames, facts: TypeFacts) -> None:
    """Mark the parameters of ``__init__`` that calls of the class pass by keyword."""
    if not names.classes:
        return
    for call in walk_tree(names.module.node):
        if isinstance(call, ast.Call):
            named = {k.arg for k in call.keywords if k.arg is not None}
            for record in facts.type(call.func).classes:
                constructor = record.methods.get("__init__")
                if constructor is not None and named:
                    _mark_keyword_parameters(constructor, named, has_table=False)


def _mark_keyword_parameters(target: Function, named: set[str], *, has_table: bool) -> None:
    for parameter in target.parameters:
        if parameter.kind == "plain" and (parameter.variable.name in named or has_table):
            parameter.variable.is_keyword = True


def _generate(
    text: PythonText, writer: Writer, forms: list[Code], texts: list[str], diagnostics: list[Diagnostic],
    finish: Finish | None, *, with_text: bool,
) -> Translation:  # fmt: skip
    """Choose names, and create the datums and the text of the program."""
    namer = Namer(forms, writer.analysed.spread)
    namer.choose()
    output = Output(namer, Span(text.source, text.response.start, text.response.start))
    datums = tuple(output.datum(form) for form in forms)
    if not with_text:
        return Translation(datums, "", tuple(diagnostics))
    header = prose(text.response.before[:_MAX_PROSE])
    if header and texts:
        header.append("")
    header += texts
    footer = [*writer.pending_texts, *writer.comments.take_until(len(text.lines) + 1)]
    after = prose(text.response.after[:_MAX_PROSE])
    ending: list[str | None] = [*footer, *([None] if after else []), *after]
    written = output.text(datums, header, ending, finish)
    if isinstance(written, Diagnostic):
        return Translation((), "", tuple(_sorted([*diagnostics, written])))
    return Translation(datums, written, tuple(_sorted(diagnostics)))


def _sorted(diagnostics: list[Diagnostic]) -> list[Diagnostic]:
    unique = {(d.name, d.message, d.span): d for d in diagnostics}
    return sorted(unique.values(), key=lambda d: d.span.start if d.span is not None else 0)


# Diagnostics of the checker in the words of Python. The checker knows the forms that were written; their places are in
# the Python, and their messages name what the language calls it.

_FUNCTIONS = {
    **{helper.counterpart: name for name, helper in HELPERS.items() if helper.counterpart},
    **{helper.counterpart: name for name, helper in scene_helpers().items()},
    **{helper.relation.name: name for name, helper in relation_helpers().items()}, "assert-that": ASSERT_THAT,
    "length": "len", "string": "str",
    "string-append": "+", "list": "list", "map": "map", "expt": "**", "modulo": "%", "ceiling": "math.ceil",
    "floor": "math.floor", "sqrt": "math.sqrt", "sin": "math.sin", "cos": "math.cos", "tan": "math.tan",
    "atan": "math.atan2", "hypot": "math.hypot", "deg": "math.radians", "append": "+", "ref": "[]",
    "to-degrees": "math.degrees",
    "set-ref!": "[]=", "push!": "append", "for/union": "a loop of shapes",
}  # fmt: skip
_KINDS = (
    ("a Vector of", "a tuple of"), ("an Entity", "a Shape"), ("a posed entity", "a Shape"),
    ("a List of parts", "a Shape"), ("entities or (entity . matrix) pairs", "shapes"), ("a Matrix", "a 4x4 matrix"),
    ("an Integer", "an int"), ("a Float", "a float"), ("a String", "a str"), ("a Boolean", "a bool"),
    ("`none`", "None"), ("the empty list", "an empty list"), ("a List", "a list"), ("a Function", "a function"),
    ("a table", "a dict"), ("a Sequence", "a sequence"), ("a Vector", "three numbers"), ("a Number", "a number"),
    ("a Point", "three numbers"), ("a mutable list", "a list"), ("a mutable array", "an array"),
)  # fmt: skip
_NAMED = re.compile(r"`([^`\s]+)`")


def in_python(diagnostic: Diagnostic) -> Diagnostic:
    """Return a diagnostic about translated Python in terms of Python, without fixes and signatures of the language."""
    message = _in_python_words(diagnostic.message)
    return replace(
        diagnostic,
        message=message,
        hint=_python_hint(diagnostic),
        fixes=(),
        signature=_python_signature(diagnostic.signature),
        expected=_in_python_words(diagnostic.expected) if diagnostic.expected is not None else None,
        found=_in_python_words(diagnostic.found) if diagnostic.found is not None else None,
    )


def _python_signature(signature: str | None) -> str | None:
    """Return the signature of the helper that corresponds to a function of the language, in Python's notation."""
    name = signature.lstrip("(").split(" ", 1)[0].rstrip(")") if signature is not None else ""
    python = _FUNCTIONS.get(name, "")
    helper, modelling = HELPERS.get(python), scene_helpers().get(python)
    if modelling is not None:
        return modelling.usage
    return f"{helper.name}({helper.signature}) -> {helper.result}" if helper is not None else None


def _in_python_words(text: str) -> str:
    text = _NAMED.sub(lambda match: f"`{_python_name(match[1])}`", text)
    for ours, theirs in _KINDS:
        text = text.replace(ours, theirs)
    return text


def _python_name(name: str) -> str:
    """Return what Python calls an attribute, `:block-type`, or a function."""
    return name[1:].replace("-", "_") if name.startswith(":") else _FUNCTIONS.get(name, name)


_ATTRIBUTE_VALUE = re.compile(r"`:([a-z]\w*) \[([^\]]*)\]`")


def _python_hint(diagnostic: Diagnostic) -> str | None:
    """Return a hint for Python: the table's for what models often write, else one that has no code of the language."""
    hint, span = diagnostic.hint or "", diagnostic.span
    text = span.text if span is not None else ""
    if diagnostic.name == "attribute" and "color" in diagnostic.message and diagnostic.found == "a String":
        return "a color is a tuple of three numbers from 0 to 1: (1.0, 0.0, 0.0) is red"
    if diagnostic.name == "out-of-range" and "color" in diagnostic.message:
        return "the components of a color are from 0 to 1: divide them by 255"
    if diagnostic.name == "out-of-range" and "radians" in diagnostic.message:
        return f"convert degrees: `math.radians({text})`"
    if "wrong order" in hint:
        usage = _python_signature(diagnostic.signature)
        return "the arguments are in the wrong order" + (f": `{usage}`" if usage else "")
    if diagnostic.name == "parts" and diagnostic.found == "`none`":
        return "every path of the function must return a shape"
    if diagnostic.name == "idle-attribute" and (given := _ATTRIBUTE_VALUE.search(hint)) is not None:
        return f'write `"{given[1]}": ({", ".join(given[2].split())})`'
    if "(" in hint:
        return None
    return _in_python_words(hint) or None
