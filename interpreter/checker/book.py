"""Kinds of a whole program: forms in the order of their dependencies, with results reused from version to version.

The kinds of a form depend on the answers that it got about the rest of the program. The book records these, and
infers a form again only when one of them has changed.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from scenelang.grammar import ast
from scenelang.grammar.datum import Source, Span, dataclass, field, replace
from scenelang.grammar.diagnostics import Diagnostic, Edit, Fix, Note, near_names
from scenelang.interpreter.checker.common import (
    A_PART,
    MAX_SHOWN,
    accepts,
    arity_of,
    infix_fix,
    number_of,
    plural,
    shown,
    triple_fix,
)
from scenelang.interpreter.checker.infer import FormKinds, Need, Passed, infer_form, value_of
from scenelang.interpreter.checker.scene_forms import keyword_fixes
from scenelang.interpreter.compile.kinds import ANY, ARRAYS, ENTITY, FRAMES, LIST, PART, PARTS, Kind, describe, join
from scenelang.interpreter.expand.scope import Variable
from scenelang.interpreter.runtime.types import STD, call_hint, default_hint
from scenelang.interpreter.scene.primitives import is_word

if TYPE_CHECKING:
    from scenelang.interpreter.checker.program import Program
    from scenelang.interpreter.checker.rules import FormFacts

# Kinds of results of library functions that do not return parts.
_LIBRARY_RESULTS = {"stack": join(LIST, ARRAYS), "call": ANY, "union": LIST, "union-loop": LIST, "transform": ANY}


@dataclass(slots=True)
class _Entry:
    """Result of one form, with the answers about the rest of the program on which it depends."""

    form: Any
    result: FormKinds
    variables: dict[Variable, Kind] = field(default_factory=dict)
    functions: dict[str, ast.Lambda | None] = field(default_factory=dict)
    bound: dict[str, bool] = field(default_factory=dict)
    later: dict[Variable, bool] = field(default_factory=dict)
    assigned: dict[Variable, bool] = field(default_factory=dict)
    numbers: dict[Variable, float | None] = field(default_factory=dict)
    arrays: dict[Variable, ast.ArrayLiteral | None] = field(default_factory=dict)


class _View:
    """World of one form; records what the form reads."""

    __slots__ = ("_version", "entry", "group", "index")

    def __init__(self, version: _Version, entry: _Entry, group: int, index: int) -> None:
        self._version, self.entry, self.group, self.index = version, entry, group, index

    def kind_of(self, variable: Variable) -> Kind:
        """Return the kind of a global variable, and record the answer."""
        kind = self.entry.variables.get(variable)
        if kind is None:
            kind = self.entry.variables[variable] = self._version.kind_of(variable, self.group)
        return kind

    def word_function(self, word: str) -> ast.Lambda | None:
        """Return the function of a word that is certain, and record the answer."""
        function = self.entry.functions[word] = self._version.functions.get(word)
        return function

    def may_be_bound(self, word: str) -> bool:
        """Return whether the program may bind a word, and record the answer."""
        is_bound = self.entry.bound[word] = self._version.may_be_bound(word)
        return is_bound

    def is_assigned(self, variable: Variable) -> bool:
        """Return whether ``set!`` changes a variable, and record the answer."""
        is_assigned = self.entry.assigned[variable] = self._version.is_assigned(variable)
        return is_assigned

    def is_later(self, variable: Variable) -> bool:
        """Return whether a variable is defined after this form, and record the answer."""
        is_later = self.entry.later[variable] = self._version.is_later(variable, self.index)
        return is_later

    def constant_of(self, variable: Variable) -> float | None:
        """Return the number that a variable always has, and record the answer."""
        number = self.entry.numbers[variable] = self._version.constant_of(variable)
        return number

    def array_of(self, variable: Variable) -> ast.ArrayLiteral | None:
        """Return the array that a variable always has, and record the answer."""
        array = self.entry.arrays[variable] = self._version.array_of(variable)
        return array


def _is_input(source: Source) -> bool:
    """Return whether a text is an input of the REPL, which later inputs continue."""
    return source.name.startswith("<repl")


class _Version:
    """One version of a program: where its variables and words are defined."""

    def __init__(self, program: Program, library: Mapping[Variable, Any]) -> None:
        """Collect where a program defines its variables and binds its words.

        ``library`` are the definitions of the library.
        """
        self._library = library
        self.facts: Sequence[FormFacts] = program.facts
        self.homes = {variable: index for index, facts in enumerate(self.facts) for variable in facts.defined}
        # `Variable.assigned` remains set after the form with `set!` is removed, so the forms decide; a variable of the
        # REPL may be changed by a later input.
        self._assigned = frozenset(variable for facts in self.facts for variable in facts.assigned)
        self._is_open = _is_input(program.main)
        backwards = reversed([*enumerate(self.facts)])
        self._first = {variable: index for index, facts in backwards for variable in facts.defined}
        self.groups = [0] * len(self.facts)
        self.kinds: dict[Variable, Kind] = {}
        self.functions, self._bound, self._any_word = _word_functions(program)

    def may_be_bound(self, word: str) -> bool:
        """Return whether a ``bind`` of the program has this word, or has a computed one, which may be any word."""
        return self._any_word or word in self._bound

    def is_assigned(self, variable: Variable) -> bool:
        """Return whether the program may change a variable by ``set!``."""
        return variable.assigned and (self._is_open or variable in self._assigned)

    def is_later(self, variable: Variable, index: int) -> bool:
        """Return whether the first definition of a variable is the form ``index`` or a later one."""
        return self._first.get(variable, -1) >= index

    def constant_of(self, variable: Variable) -> float | None:
        """Return the number that a global variable always has, if its definition shows it."""
        value = self._value_of(variable)
        return number_of(value) if value is not None else None

    def array_of(self, variable: Variable) -> ast.ArrayLiteral | None:
        """Return the array that a global variable always has, if its definition shows it."""
        value = self._value_of(variable)
        return value if type(value) is ast.ArrayLiteral else None

    def _value_of(self, variable: Variable) -> Any:
        """Return the expression that defines a global variable which is never changed, or None."""
        home = self.homes.get(variable)
        if home is None or self.is_assigned(variable) or self._first[variable] != home:
            return None
        form = self.facts[home].form
        return form.value if type(form.target) is Variable else None

    def kind_of(self, variable: Variable, group: int) -> Kind:
        """Return the kind of a global variable as seen by the forms of a group."""
        if self.is_assigned(variable):
            return ANY
        home = self.homes.get(variable)
        if home is None:
            return self._of_library(variable)
        if self.groups[home] == group:  # forms that depend on each other know only each other's functions
            form = self.facts[home].form
            return Kind("Function", None, ANY, form.value) if type(form.value) is ast.Lambda else ANY
        return self.kinds.get(variable, ANY)

    def _of_library(self, variable: Variable) -> Kind:
        """Return the kind of a library definition; combinators return parts unless ``_LIBRARY_RESULTS`` differs."""
        definition = self._library.get(variable)
        if definition is None or type(definition.value) is not ast.Lambda:
            return ANY
        return Kind("Function", None, _LIBRARY_RESULTS.get(variable.name, PARTS), definition.value)


def _word_functions(program: Program) -> tuple[dict[str, ast.Lambda | None], set[str], bool]:
    """Return which words a program binds, and to which functions.

    Returns
    -------
    functions, bound, any_word
        Functions of the words that are bound once (None for others), all words that may be bound, and whether a
        ``bind`` has a computed word, which may be any.
    """
    functions: dict[str, ast.Lambda | None] = {}
    bound, any_word = set(program.all_words), False
    for facts in program.facts:
        for word, function in facts.binds:
            if word is None:
                any_word = True
                continue
            bound.add(word)
            is_first = word not in functions
            functions[word] = function if is_first and type(function) is ast.Lambda else None
    if any_word:
        functions = dict.fromkeys(functions)
    return functions, bound, any_word


class KindBook:
    """Kinds of the forms of a program.

    The result of a form is reused by the next version while everything that it read is the same.
    """

    def __init__(self, library: Mapping[Variable, Any]) -> None:
        self._library = library
        self._entries: dict[int, _Entry] = {}
        self.scene: FormKinds | None = None  # of the form `(scene "word" ...)`, as a call of the root

    def of(self, program: Program) -> list[FormKinds]:
        """Return the kinds of every form of a program, in the order of its forms."""
        version = _Version(program, self._library)
        entries: dict[int, _Entry] = {}
        for number, group in enumerate(_groups(version)):
            for index in group:
                version.groups[index] = number + 1
            for index in sorted(group):
                form = version.facts[index].form
                entry = self._entries.get(id(form))
                if entry is None or not _is_valid(entry, version, number + 1, index):
                    entry = _Entry(form, FormKinds())
                    entry.result = infer_form(_View(version, entry, number + 1, index), form)
                entries[id(form)] = entry
            for index in group:
                version.kinds.update(entries[id(version.facts[index].form)].result.defined)
        self._entries = entries
        self.scene = None
        if program.scene is not None:
            view = _View(version, _Entry(program.scene, FormKinds()), 0, len(version.facts))
            self.scene = infer_form(view, program.scene)
        return [entries[id(facts.form)].result for facts in version.facts]


def _is_valid(entry: _Entry, version: _Version, group: int, index: int) -> bool:
    """Return whether a version gives all answers that an entry recorded."""
    return (
        all(version.kind_of(variable, group) == kind for variable, kind in entry.variables.items())
        and all(version.functions.get(word) is function for word, function in entry.functions.items())
        and all(version.may_be_bound(word) == bound for word, bound in entry.bound.items())
        and all(version.is_assigned(variable) == assigned for variable, assigned in entry.assigned.items())
        and all(version.is_later(variable, index) == later for variable, later in entry.later.items())
        and all(version.constant_of(variable) == number for variable, number in entry.numbers.items())
        and all(version.array_of(variable) is array for variable, array in entry.arrays.items())
    )


def _groups(version: _Version) -> list[list[int]]:
    """Return the strongly connected components of the forms' references, each after those it refers to.

    Tarjan's algorithm (SIAM Journal on Computing 1, 1972) without recursion.
    """
    homes, facts = version.homes, version.facts
    order: dict[int, int] = {}
    low: dict[int, int] = {}
    stack: list[int] = []
    on_stack: set[int] = set()
    groups: list[list[int]] = []
    for root in range(len(facts)):
        if root in order:
            continue
        work: list[tuple[int, Iterator[int]]] = []
        node: int | None = root
        while node is not None or work:
            if node is not None:
                order[node] = low[node] = len(order)
                stack.append(node)
                on_stack.add(node)
                references = [homes[variable] for variable in facts[node].used if variable in homes]
                work.append((node, iter(references)))
                node = None
            current, pending = work[-1]
            for other in pending:
                if other not in order:
                    node = other
                    break
                if other in on_stack:
                    low[current] = min(low[current], order[other])
            if node is not None:
                continue
            work.pop()
            if work:
                low[work[-1][0]] = min(low[work[-1][0]], low[current])
            if low[current] == order[current]:
                group = []
                while True:
                    other = stack.pop()
                    on_stack.discard(other)
                    group.append(other)
                    if other == current:
                        break
                groups.append(group)
    return groups


def findings(program: Program, root: str | None, is_written: bool = True) -> list[Diagnostic]:
    """Return the mistakes that the kinds of a program show.

    An error in a form that ``root`` never reaches is a warning, since it is not evaluated. Of programs that were
    translated from Python (``is_written`` False), only errors, values out of range and infinite recursion are reported:
    others may be due to the translation.
    """
    results = program.kinds.of(program)
    reached = reached_forms(program.facts, root) if root is not None else None
    diagnostics: list[Diagnostic] = []
    needs = needs_of(results)
    for facts, result in zip(program.facts, results):
        form_diagnostics = [
            d for d in (*result.findings, *(d for _, d in misuses(result, needs))) if not _is_library(d)
        ]
        if reached is not None and id(facts) not in reached:
            form_diagnostics = [
                _unreached(d) for d in form_diagnostics if d.found != "`none`"
            ]  # a word may be a stub until it is used
        diagnostics += form_diagnostics
        diagnostics += _inner_frames(facts, result, root)
    if root is not None and _scene_word(program) == root and program.kinds.scene is not None:
        scene = program.kinds.scene
        diagnostics += [*scene.findings, *(d for _, d in misuses(scene, needs))]
    shadowing = {variable.name for facts in program.facts for variable in facts.defined if variable.shadows}
    diagnostics += endless_recursions(results, shadowing)
    diagnostics += _unbound_root(program, root)
    if program.ok and not any(d.is_error for d in diagnostics):
        for facts, result in zip(program.facts, results):
            diagnostics += _unbound_parts(facts, result, root)
    if not is_written:
        diagnostics = [
            d for d in diagnostics if d.is_error or d.name in ("out-of-range", "endless-recursion", "elementwise-poses")
        ]
    functions = [facts.form.function for facts in program.facts if type(facts.form) is ast.Bind]
    return _with_parameters(diagnostics, functions)


def _unbound_parts(facts: FormFacts, result: FormKinds, root: str | None) -> Iterator[Diagnostic]:
    """Report an entity at the top level of a program, other than a call of its root, which is drawn anyway."""
    form = facts.form
    kind = result.kinds.get(form, ANY)
    is_called = type(form) in (ast.Application, ast.Call, ast.Transform, ast.Union, ast.UnionLoop)
    if _is_input(form.span.source) or not (
        is_called and (kind is ENTITY or kind is PART or kind == PARTS) and form.span.expansion is None
    ):
        return
    called = form.word.value if type(form) is ast.Call and type(form.word) is ast.Constant else None
    if root is not None and called == root:
        return
    if type(called) is str and root is not None and not form.arguments:
        hint = f"name the word that is drawn: `(scene {form.word.span.text})`"
    else:
        is_short = len(form.span.text) <= MAX_SHOWN
        hint = f'bind it to a word: `(bind "scene" (lambda () {form.span.text if is_short else "..."}))`'
    drawn = "a program draws the words that it binds" if root is None else f'"{root}" is drawn'
    yield Diagnostic("dropped-value", f"this entity is not used: {drawn}", form.span, hint)


def _scene_word(program: Program) -> str | None:
    """Return the word of ``(scene "word")``."""
    word = program.scene.word if program.scene is not None else None
    return word.value if type(word) is ast.Constant and type(word.value) is str else None


def _inner_frames(facts: FormFacts, result: FormKinds, root: str | None) -> Iterator[Diagnostic]:
    """Report a word other than the root whose value is certainly frames."""
    form = facts.form
    if type(form) is not ast.Bind or type(form.function) is not ast.Lambda or facts.word is None:
        return
    kind = result.kinds.get(form.function, ANY)
    if root is None or facts.word == root or kind.item is not FRAMES:
        return
    body = value_of(form.function.body)
    message = f'the value of "{facts.word}" cannot be frames, because it is not the root'
    yield Diagnostic(
        "frames", message, body.span, f'the root is "{root}": call `frames` there',
        expected=A_PART, found="frames",
    )  # fmt: skip


def _unbound_root(program: Program, root: str | None) -> Iterator[Diagnostic]:
    """Report ``(scene "word")`` for a word that nothing binds."""
    form, word = program.scene, _scene_word(program)
    if form is None or word is None or word != root or word in program.all_words:
        return  # another root may be named by an option
    _, bound, any_word = _word_functions(program)
    if any_word or word in bound:
        return
    near = near_names(word, bound)
    fixes = tuple(Fix(f'Change to "{other}"', (Edit(form.word.span, f'"{other}"'),), len(near) == 1) for other in near)
    hint = f'did you mean "{near[0]}"?' if near else 'bind it with `(bind "word" (lambda () ...))`'
    yield Diagnostic("root", f'the root "{word}" is not bound', form.span, hint, fixes=fixes, near=tuple(near))


def _unreached(finding: Diagnostic) -> Diagnostic:
    """Return an error of a form that is not evaluated as a warning (W401).

    Unfinished words are normal while a scene is being written.
    """
    return replace(finding, name="conditional-failure") if finding.is_error else finding


def _is_function(form: Any) -> bool:
    """Return whether a form defines a function."""
    return type(form) is ast.Define and type(form.value) is ast.Lambda


def _runs_at_once(facts: FormFacts) -> bool:
    """Return whether a form at top level does more than define a function."""
    form = facts.form
    if facts.word is not None:
        return type(form) is ast.Bind and type(form.function) is not ast.Lambda
    return not _is_function(form)


def reached_forms(facts: Sequence[FormFacts], root: str) -> set[int] | None:
    """Return the ids of the facts of all forms that may be evaluated, or None if no form binds the root.

    These are the expressions at top level, the root's function, and what they mention, directly or through others.
    Computed words are not included.
    """
    by_word = {form.word: form for form in facts if form.word is not None}
    if root not in by_word:
        return None
    by_name = {variable: form for form in facts for variable in form.defined}
    reached: set[int] = set()
    stack = [form for form in facts if _runs_at_once(form)] + [by_word[root]]
    while stack:
        form = stack.pop()
        if id(form) not in reached:
            reached.add(id(form))
            stack += [by_word[text] for text in form.strings if text in by_word]
            stack += [by_name[variable] for variable in form.used if variable in by_name]
    return reached


def _with_parameters(diagnostics: Sequence[Diagnostic], functions: Sequence[Any]) -> list[Diagnostic]:
    """Replace errors about a positional parameter that holds the embedding of a word by one for each parameter.

    Its fix makes the parameter a keyword parameter.
    """
    explained: dict[tuple[Any, str], Diagnostic] = {}
    rest: list[Diagnostic] = []
    for finding in diagnostics:
        span = finding.span
        parameter = _parameter_at(span, functions) if finding.found == "an Embedding" and span is not None else None
        if parameter is None:
            rest.append(finding)
            continue
        function, name = parameter
        if (function, name) not in explained:
            target = next(p for p in function.parameters if p.name == name)
            hint = f"a keyword parameter has a colon: `(lambda (:{name}) ...)`"
            owner = function.name or "this function"
            message = f"`{name}` is the first positional parameter of {owner}, which holds its embedding, no number"
            by_name = [d.span for d in diagnostics if d.name == "plain-parameter" and d.span is not None]
            notes = tuple(Note("it is passed by name here", at) for at in by_name if at.text == f":{name}")[:1]
            if notes:
                message = f"`{name}` is positional in {owner}, but the calls pass it by name, as `:{name}`"
            explained[function, name] = replace(
                finding, message=message, hint=hint, notes=notes, fixes=keyword_fixes(target, function)
            )
    names = {name for _, name in explained}
    rest = [d for d in rest if not (d.name == "plain-parameter" and d.span is not None and d.span.text[1:] in names)]
    return [*rest, *explained.values()]


def _parameter_at(span: Span, functions: Sequence[Any]) -> tuple[ast.Lambda, str] | None:
    """Return the function and the name of its positional parameter that the text at ``span`` names."""
    for function in functions:
        if type(function) is ast.Lambda and function.span.source is span.source:
            if function.span.start <= span.start < function.span.end:
                text = span.text
                if any(p.name == text and p.kind == "required" for p in function.parameters):
                    return function, text
    return None


def _is_library(finding: Diagnostic) -> bool:
    """Return whether a finding is in the standard library."""
    return finding.span is not None and str(finding.span.source.name).startswith(STD)


# --- arguments that a function of the program cannot use --------------------------------------------------------------


Needs = Mapping[Variable, Sequence[Need]]


def needs_of(results: Sequence[FormKinds]) -> Needs:
    """Return the uses of the parameters of a program's functions."""
    return {variable: uses for result in results for variable, uses in result.needs.items()}


def misuses(result: FormKinds, needs: Needs) -> Iterator[tuple[Passed, Diagnostic]]:
    """Iterate over the arguments in a form that fail in the function to which they are passed, with the findings."""
    for passed in result.passed:
        use = _unmet(passed, needs)
        if use is not None:
            yield passed, _misuse(passed, use)


def _unmet(passed: Passed, needs: Needs) -> Need | None:
    """Return the first use of a parameter, or of one that it is passed on to, that fails for an argument."""
    pending, visited = [passed.parameter], {passed.parameter}
    while pending:
        for need in needs.get(pending.pop(), ()):
            if not _is_met(need, passed):
                return need
            if need.passed is not None and need.passed not in visited:
                visited.add(need.passed)
                pending.append(need.passed)
    return None


def _is_met(need: Need, passed: Passed) -> bool:
    """Return whether a use of a parameter may succeed with an argument."""
    kind, number = passed.kind, passed.number
    if need.types and not any(accepts(type_, kind) for type_ in need.types):
        return False
    if need.rejects and {option.tag for option in kind.options} <= need.rejects:
        return False
    if need.fails is not None and number is not None and need.fails(number):
        return False
    return need.count is None or _takes(kind, need.count)


def _takes(kind: Kind, count: int) -> bool:
    """Return whether a function may be called with ``count`` positional arguments."""
    low, high, _, _ = arity_of(kind.code) if kind.tag == "Function" else (None, 0.0, "", "")
    return low is None or low <= count <= high


def _needs_point(use: Need) -> bool:
    """Return whether a use requires a Vector of three numbers."""
    return any(not isinstance(type_, str) and type_.name == "Point" for type_ in use.types)


def _misuse(passed: Passed, use: Need) -> Diagnostic:
    """Return the finding about an argument, with a note at the use that fails."""
    value = shown(passed.argument, passed.kind)
    message = f"the parameter `{passed.parameter.name}` of {passed.owner} must be {use.expected}, got {value}"
    name = use.error
    infix: Fix | None = None
    if use.count is not None and passed.kind.tag == "Function":
        low, high, function, _ = arity_of(passed.kind.code)
        expected = low if low == high else f"{low} to {high}"
        message = f"{passed.owner} calls {function} with {plural(use.count, 'argument')}, but it expects {expected}"
        name = "arity"
    elif use.error == "type" and passed.kind.tag == "Vector" and _needs_point(use):
        name = "value"  # it is a vector, but of another length
    elif use.error == "not-a-procedure":
        infix = infix_fix(use.span)
        message = f"{passed.owner} calls its parameter `{passed.parameter.name}`, but it is {value}"
    if name != "out-of-range":
        name = name if passed.is_certain else "conditional-failure"
    note = Note(use.place, use.span)
    hint, fixes = triple_fix(passed.argument) if name in ("value", "attribute") else (None, ())
    if infix is not None:
        hint, fixes = f"the operator comes first: `{infix.edits[0].text}`", (infix,)
    usage = (default_hint if name == "type" else call_hint)(passed.owner, passed.usage)
    return Diagnostic(
        name, message, passed.argument.span, hint or usage, (note,), fixes=fixes,
        expected=use.expected, found=describe(passed.kind), signature=passed.usage,
    )  # fmt: skip


# --- infinite recursion: functions that always call themselves, directly or through others ----------------------------


def endless_recursions(results: Sequence[FormKinds], shadowing: Collection[str] = ()) -> list[Diagnostic]:
    """Return a warning for each cycle of functions that always call the next one, found by depth-first search.

    ``shadowing`` are the names of functions of the program that hide a builtin.
    """
    calls = [call for result in results for call in result.always_calls]
    edges: dict[Any, list[tuple[Any, Any]]] = {}
    for caller, callee, span in sorted(calls, key=lambda call: call[0].name):  # a session's forms are in any order
        edges.setdefault(caller, []).append((callee, span))
    warnings: list[Diagnostic] = []
    done: set[Any] = set()
    for start in edges:
        path: list[Any] = []
        pending: list[Iterator[tuple[Any, Any]]] = []
        node: Any = start
        while node is not None or pending:
            if node is not None:
                path.append(node)
                pending.append(iter(edges.get(node, ())))
            node = None
            for callee, span in pending[-1]:
                if callee in path:
                    warnings.append(_endless(callee, span, shadowing))
                elif callee in edges and callee not in done:
                    node = callee
                    break
            if node is None:
                pending.pop()
                done.add(path.pop())
    return warnings


def _endless(function: ast.Lambda, span: Span, shadowing: Collection[str]) -> Diagnostic:
    """Return the warning about an infinite recursion.

    It is a warning, although the call always fails: a program that the check rejects does not run, and so would show no
    limits, log or call chain.
    """
    name = function.name if function.name.startswith('"') else f"`{function.name}`"
    message = f"infinite recursion: {name} always calls itself"
    hint = "put the call into a branch: `(if test (...) ...)`"
    if function.name.startswith('"') and is_word(function.name.strip('"')):
        hint = f"{name} is bound here, so it is no longer the primitive: give your word another name"
    elif function.name in shadowing:
        hint = f"{name} is defined here and hides the builtin function: call that as `std/{function.name}`"
    return Diagnostic("endless-recursion", message, span, hint)
