"""Lints of a program, with their fixes and suppression comments."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import islice
from typing import Any

from scenelang.grammar import ast
from scenelang.grammar.datum import Atom, ListDatum, Source, Span, dataclass, replace, with_edits
from scenelang.grammar.diagnostics import CODES, Diagnostic, Edit, Fix, SceneError, also_in, close_matches, is_typo
from scenelang.grammar.lazy_patterns import lazy_pattern
from scenelang.grammar.reader import piece_at, read, read_comments
from scenelang.interpreter.checker.book import KindBook, findings, reached_forms
from scenelang.interpreter.checker.common import infix_fix
from scenelang.interpreter.checker.program import Program
from scenelang.interpreter.checker.rules import (
    FactCache,
    FormFacts,
    is_removable,
    is_user_written,
    preserves_root,
    remove,
    with_spacing,
)
from scenelang.interpreter.compile.analyze import walk
from scenelang.interpreter.expand.scope import Variable
from scenelang.interpreter.runtime.types import STD, call_hint
from scenelang.interpreter.scene.primitives import is_word, words

# --- words of a program: the root, and words that are probably mistakes ----------------------------------------------


# Similarities of words that count as a misspelling: difflib's ratio, 2 M / T for M equal letters of T in both words.
# 0.84 is a wrong letter in seven or more (1 - 1/7 = 0.857), or a missing one of four or more (6/7). Of the 336 pairs of
# words that a program of the examples or the corpus binds none is as similar; the nearest, "cradle_base" and
# "cradle_frame", have 0.78.
_SIMILARITY = 0.84
# A bound word that nothing else mentions is suggested from a wrong letter in four (0.75) or two in seven (0.714): it is
# probably the one that was meant. Of the 336 pairs 3 are as similar, whose words are all mentioned.
_NEAR_UNUSED = 0.7


_MAX_UNITED = 4  # words that a hint unites


def find_root(program: Program) -> tuple[str, list[Diagnostic]]:
    """Return the root word (docs/language.md, "Which word is the root") and warnings.

    Raises
    ------
    SceneError
        "no-root" if the program binds no word, "word" if the operand of ``scene`` is not a string.
    """
    if program.scene is not None:
        word = program.scene.word
        if type(word) is ast.Constant and type(word.value) is str:
            return word.value, []
        hint = None
        if type(word) is ast.Call and type(word.word) is ast.Constant and word.span.expansion is None:
            hint = f"write `(scene {word.span.text.removeprefix('(call').removesuffix(')').strip()})`"
        raise SceneError("word", "`scene` expects a string as the root word", hint, program.scene.span)
    words = program.words or program.all_words
    if not words:
        hint = 'bind a word, such as `(bind "word" (lambda () (call "cube")))`'
        nested = next((node for facts in program.facts for node in walk(facts.form) if type(node) is ast.Bind), None)
        if nested is not None:
            hint = "this `bind` stands inside another form: move it to the top level"
        message = "the program binds no word, so there is nothing to evaluate"
        if not program.forms:
            size = len(program.main.text.encode())
            what = "empty (0 bytes)" if not size else f"empty: its {size:,} bytes have no code"
            message = f"{program.main.name} is {what}, so there is nothing to evaluate"
        raise SceneError("no-root", message, hint, nested.span if nested is not None else None)
    used = {text for facts in program.facts for text in facts.strings}
    candidates = [word for word in words if word not in used]
    if not candidates:
        candidates = [word for word in program.all_words if word not in used]
    if not candidates:
        return list(words)[-1], []
    root = candidates[-1]
    if len(candidates) == 1:
        return root, []
    listed = ", ".join(f'"{word}"' for word in candidates)
    message = f'several words could be the scene: {listed}; only the last one, "{root}", is drawn'
    hint = f'for one, write `(scene "{root}")`'
    if len(candidates) <= _MAX_UNITED:
        parts = " ".join(f'(call "{word}")' for word in candidates)
        hint = f'for all, write `(bind "all" (lambda () (union {parts})))`; {hint}'
    return root, [Diagnostic("ambiguous-root", message, program.all_words.get(root), hint)]


def word_warnings(program: Program) -> list[Diagnostic]:
    """Return warnings about misspelled words, calls before a ``bind``, and unused parameters and attributes."""
    warnings: list[Diagnostic] = []
    bound: set[str] = set()
    near: dict[str, str | None] = {}
    calls = Counter(word for facts in program.facts for word, _ in facts.word_calls)
    functions = {
        variable.name: facts.form.value
        for facts in program.facts
        if type(facts.form) is ast.Define and type(facts.form.value) is ast.Lambda
        for variable in facts.defined
    }
    for facts in program.facts:
        warnings += _early_calls(program, facts, bound)
        if facts.word is not None:
            bound.add(facts.word)
        for word, span in facts.word_calls:
            if word in functions and word not in program.all_words and not is_word(word):
                message = f'"{word}" is never bound, so it is drawn as a labeled box; `{word}` is a function'
                hint = call_hint(f"`{word}`", functions[word].usage)
                warnings.append(Diagnostic("near-word", message, span, hint))
            elif word not in program.all_words and not is_word(word):
                if word not in near:
                    near[word] = (
                        _near_word(word, _callable_words(program, facts))
                        or _near_primitive(word)
                        or _near_unused(word, program, facts)
                        or _repeated_word(word, calls)
                    )
                if near[word]:
                    warnings.append(_misspelled(word, str(near[word]), span))
        warnings += facts.unpassed
    return [*warnings, *unread_attributes(program)]


def misspellings(program: Program) -> list[Diagnostic]:
    """Return warnings about misspelled words and attributes of a program with errors.

    Malformed forms may bind words too, so a string after the head of a top-level form is not reported.
    """
    written = {match[1] for match in _SECOND.finditer(program.main.text)}
    warnings = [d for d in word_warnings(program) if d.name in ("near-word", "idle-attribute")]
    return [d for d in warnings if d.span is None or d.span.text.strip('"') not in written]


# The string after the head of a top-level form, which may bind it as a word.
_SECOND = lazy_pattern(r'^\([^\s()\[\]"]+\s+"([^"]+)"', re.M)


def unread_attributes(program: Program) -> list[Diagnostic]:
    """Return warnings about attributes in calls of primitives that the primitive does not read."""
    return [d for facts in program.facts for word, d in facts.idle_attributes if word not in program.all_words]


def _early_calls(program: Program, facts: FormFacts, bound: set[str]) -> Iterator[Diagnostic]:
    """Report words that a top-level expression calls before their ``bind``; bodies of functions run later."""
    for word, span in facts.early_calls:
        if word in program.all_words and word not in bound:
            yield Diagnostic("undefined-word", f'"{word}" is called before it is bound', span)


def _callable_words(program: Program, facts: FormFacts) -> list[str]:
    """Return the words that a misspelled word in a form may mean.

    A function without parameters that calls itself never ends, so its own word is excluded: "scone" in the function of
    "scene" is another word.
    """
    form = facts.form
    recurs = type(form) is not ast.Bind or type(form.function) is not ast.Lambda or bool(form.function.parameters)
    return [word for word in program.all_words if recurs or word != facts.word]


def _near_word(word: str, known: Sequence[str]) -> str | None:
    """Return the known word that ``word`` probably misspells, or None.

    The two differ by a typing error (see ``is_typo``), by the order of their letters, or have a similar spelling.
    Typing errors depend on the keyboard: "cune" is "cube", whose differing letters are adjacent keys, but "tube" is a
    word of its own.
    """
    slips = [other for other in known if is_typo(word, other)]
    near = (
        slips
        or [other for other in known if sorted(other.lower()) == sorted(word.lower())]
        or close_matches(word, known, 1, _SIMILARITY)
    )
    return near[0] if near else None


# All words of an English dictionary (133,618 entries) that differ from a primitive's name by a typing error.
_NOUNS = frozenset({"capsful", "capulet", "cine", "come", "conf", "cons", "cubs", "done", "horus", "sone", "tours"})
_MIN_LETTERS = 6  # of a primitive's name whose similar words are misspellings; too many nouns resemble shorter ones


def _near_primitive(word: str) -> str | None:
    """Return the primitive that an unbound word probably means, or None.

    The word is the primitive's name in capital letters, differs from it by a typing error (see ``is_typo``), or is
    similar to a long name without being its plural or participle. Similarity alone is not enough, because programs use
    nouns as words too: "cub", "scone" and "seats" are closer to a primitive than many misspellings.
    """
    word = word.lower()
    if word in _NOUNS:
        return None
    if is_word(word):  # only the case differs
        return word
    return next((name for name in words() if is_typo(word, name) or _is_misspelled(word, name)), None)


def _is_misspelled(word: str, name: str) -> bool:
    """Return whether a word is a misspelling of a long name of a primitive."""
    if len(name) < _MIN_LETTERS or word[:1] != name[0] or word.startswith(name) or abs(len(word) - len(name)) > 1:
        return False
    return sorted(word) == sorted(name) or bool(close_matches(name, [word], 1, _SIMILARITY))


def _repeated_word(word: str, calls: Mapping[str, int]) -> str | None:
    """Return the word that ``word`` probably misspells, if it is called once, and another, bound or not, repeatedly."""
    often = (other for other, count in calls.items() if count > 1 and is_typo(word, other))
    return next(often, None) if calls[word] == 1 else None


def _near_unused(word: str, program: Program, facts: FormFacts) -> str | None:
    """Return a bound word that nothing mentions and that resembles ``word``, which is not bound, or None."""
    used = {text for form in program.facts for text in form.strings}
    near = close_matches(
        word,
        [other for other in _callable_words(program, facts) if other in program.words and other not in used],
        1,
        _NEAR_UNUSED,
    )
    return near[0] if near else None


def _misspelled(word: str, near: str, span: Span) -> Diagnostic:
    """Return the warning about a misspelled word."""
    message = f'"{word}" is never bound, so it is drawn as a labeled box'
    fix = Fix(f'Change to "{near}"', (Edit(span, f'"{near}"'),))
    return Diagnostic("near-word", message, span, f'did you mean "{near}"?', fixes=(fix,), near=(near,))


def unreachable_words(program: Program) -> Iterator[Diagnostic]:
    """Report words of the main file that are not reachable from the root named by ``(scene ...)``."""
    if program.scene is None or type(program.scene.word) is not ast.Constant:
        return
    root = program.scene.word.value
    if root not in program.words or any(facts.computes_strings for facts in program.facts):
        return  # a word may be computed
    evaluated = reached_forms(program.facts, root) or ()
    reached = {root}.union(*(form.strings | {form.word} for form in program.facts if id(form) in evaluated))
    functions = {facts.word for facts in program.facts if facts.word and type(facts.form.function) is ast.Lambda}
    for word, span in program.words.items():
        # A word that is bound to the function of another word is an alias for importers.
        if word in functions and word not in reached:
            message = f'the word "{word}" is not reachable from the root "{root}"'
            yield Diagnostic("unreachable-word", message, span)


def lint(program: Program, is_scene: Callable[[], bool]) -> list[Diagnostic]:
    """Return the warnings about a program without errors.

    ``is_scene()`` returns whether the program is certainly a scene rather than a library of definitions, which other
    files may import; it is only called if there are unused definitions.
    """
    written = [facts for facts in program.facts if not _is_library(facts.form)]
    warnings = word_warnings(program)
    for facts in written:
        warnings += [_with_safe_fixes(diagnostic, program) for diagnostic in facts.warnings]
    warnings += unreachable_words(program)
    unused = list(_unused_globals(program, written))
    return [*warnings, *unused] if unused and is_scene() else warnings


def lint_forms(program: Program) -> list[Diagnostic]:
    """Return the warnings about single forms of a program with errors in others."""
    valid_forms = (
        facts for facts in program.facts if not _is_library(facts.form) and id(facts.form) not in program.broken
    )
    local = (warning for facts in valid_forms for warning in facts.warnings)
    return [*(_with_safe_fixes(warning, program) for warning in local), *misspellings(program)]


def _with_safe_fixes(diagnostic: Diagnostic, program: Program) -> Diagnostic:
    """Mark fixes as unsafe if they could change the root."""
    if all(not fix.safe or preserves_root(fix, program) for fix in diagnostic.fixes):
        return diagnostic
    fixes = (replace(fix, safe=fix.safe and preserves_root(fix, program)) for fix in diagnostic.fixes)
    return replace(diagnostic, fixes=tuple(fixes))


def _is_library(form: Any) -> bool:
    """Return whether a form belongs to the standard library."""
    return str(form.span.source.name).startswith(STD)


def _unused_globals(program: Program, written: Sequence[FormFacts]) -> Iterator[Diagnostic]:
    """Report top-level definitions of the main file that no other form or macro refers to."""
    params = {param.span for param in program.params}
    users: dict[Any, set[int]] = {}  # ids of the forms that refer to each variable
    for facts in program.facts:
        for variable in facts.used:
            users.setdefault(variable, set()).add(id(facts))
    longest = max((len(variable.name) for facts in written for variable in facts.defined), default=0)
    mentions: Counter[str] | None = None  # computed when needed, because it reads the whole text
    for facts in written:
        if facts.form.span.source.name != program.main.name or facts.form.span in params:
            continue
        if len(facts.defined) != 1:  # the names of a pattern or a record belong together: one of them may be used
            continue
        (variable,) = facts.defined
        is_used = bool(users.get(variable, set()) - {id(facts)})
        if is_used or not is_user_written(variable) or variable.name.startswith("_"):
            continue
        if mentions is None:
            mentions = _mentions(program.main.text, longest)
        if mentions[variable.name] <= 1:  # only its definition; macros and quoted code mention names without a use
            # The fix is not safe, because other files may import the name.
            fixes = (remove(facts.form, safe=False),) if is_removable(facts.form) else ()
            yield Diagnostic("unused", f"`{variable.name}` is never used", variable.span, fixes=fixes)


def _mentions(text: str, longest: int) -> Counter[str]:
    """Count the names in a text, wherever they occur, for example in a macro or after a quote.

    ``longest`` is the length of the longest name that matters.
    """
    counts: Counter[str] = Counter()
    for word in _WORD.findall(text):
        end = word[-longest - 1 :]
        counts[word] += 1
        counts.update(end[match.end() :] for match in _QUOTE.finditer(end))
    return counts


_WORD = lazy_pattern(r"[^\s()\[\]]+")
_QUOTE = lazy_pattern(r"['`,@]")


# --- forms that are added to a session -------------------------------------------------------------------------------


# Lints that require a whole program, and therefore do not apply to single forms of a session.
WHOLE_FILE = frozenset(("unused", "bound-twice", "undefined-word", "unreachable-word"))


class LintCache:
    """Facts and kinds of the forms of a file, for reuse in its next version."""

    def __init__(self) -> None:
        self.facts = FactCache()
        self.kinds = KindBook({})


def new_form_warnings(
    main: Source,
    forms: tuple[Any, ...],
    words: Mapping[str, Span],
    all_words: Mapping[str, Span],
    cache: LintCache,
) -> list[Diagnostic]:
    """Return the warnings about forms that are added to a session.

    Parameters
    ----------
    main
        Text of the forms.
    forms
        The core forms.
    words, all_words
        Location of each word that the main file binds, and that the session binds.
    cache
        Facts and kinds of the session's forms.
    """
    program = Program(main, (), forms, None, words, all_words, (), (), cache.facts, cache.kinds)
    kinds = [d for d in findings(program, None) if not d.is_error]  # an error is reported when the form runs
    return [*(d for facts in program.facts for d in facts.warnings), *word_warnings(program), *kinds]


# --- consequential findings, which are reported only because of another mistake --------------------------------------


_DEFINES = lazy_pattern(r"\(\s*([^\s()\[\]]+)\s+\(?([^\s()\[\]]+)")
_NAMES = lazy_pattern(r"\s*\(([^()\[\]]*)\)")
_DEFINING = frozenset(("define", "define-values", "define-record", "define-syntax", "define-macro", "param"))


def without_consequences(diagnostics: Sequence[Diagnostic], program: Program | None = None) -> list[Diagnostic]:
    """Return the diagnostics without those that are consequences of another one."""
    remaining = list(diagnostics)
    if any(d.name == "unclosed" and "string" in d.message for d in remaining):
        remaining = [d for d in remaining if d.name not in ("bad-atom", "bad-string")]  # strings and code are exchanged
    unread = {(d.span.source, d.span.start) for d in remaining if d.code.startswith("E1") and d.span is not None}
    remaining = [
        d for d in remaining if d.code.startswith("E1") or d.span is None or (d.span.source, d.span.start) not in unread
    ]
    defined = {name for d in remaining if d.name == "unbound" for name in _defined_by(d)}
    remaining = [d for d in remaining if not (d.name == "unbound" and d.span is not None and d.span.text in defined)]
    remaining = [d for d in remaining if not (d.name == "unbound" and _is_defined_wrongly(d, remaining))]
    remaining = [d for d in remaining if not (d.name == "dropped-value" and _is_followed(d, remaining))]
    remaining = _without_details(_without_resolved(remaining))
    remaining = _once_for_each_word(remaining)
    return _misspelled_parameters(remaining, program) if program is not None else remaining


def _without_resolved(diagnostics: list[Diagnostic]) -> list[Diagnostic]:
    """Remove warnings about a name that the fix of a construct of another language uses: it is unused, or a word."""
    foreign = [d for d in diagnostics if d.name in ("foreign-syntax", "undefined-yet") and d.fixes]
    texts = [edit.text for d in foreign for edit in d.fixes[0].edits]
    texts += [d.span.text for d in foreign if d.name == "undefined-yet" and d.span is not None]
    text = " ".join(texts)
    used = set(_NAMES_IN_CODE.findall(text)) if foreign else set()
    return [
        d
        for d in diagnostics
        if d.name not in ("unused", "near-word") or d.span is None or d.span.text.strip('"') not in used
    ]


_NAMES_IN_CODE = lazy_pattern(r"[^\s()\[\]\"';`,:]+")


def _without_details(diagnostics: list[Diagnostic]) -> list[Diagnostic]:
    """Remove the diagnostics that are details of a larger mistake.

    These are an unused variable or a constant test in a body without a value, and the undefined index of a loop whose
    body lacks its ``lambda``.
    """
    empty = [
        d.span
        for d in diagnostics
        if d.name in ("parts", "conditional-failure") and d.found == "`none`" and d.span is not None
    ]
    bodies = [d.span for d in diagnostics if d.name == "not-a-procedure" and d.span is not None and _binds_index(d)]
    return [
        d
        for d in diagnostics
        if d.span is None
        or (
            not (d.name in ("unused", "constant-condition", "dropped-value") and _is_inside(d.span, empty))
            and not (d.name == "unbound" and d.span.text == "i" and _is_inside(d.span, bodies))
        )
    ]


def _binds_index(diagnostic: Diagnostic) -> bool:
    """Return whether a fix adds the function of a loop's index."""
    return any(edit.text.startswith("(lambda (i)") for fix in diagnostic.fixes for edit in fix.edits)


def _is_inside(span: Span, others: Sequence[Span]) -> bool:
    """Return whether a span begins inside one of others."""
    return any(other.source.name == span.source.name and other.start <= span.start < other.end for other in others)


def _is_followed(dropped: Diagnostic, diagnostics: Sequence[Diagnostic]) -> bool:
    """Return whether a value is unused only because code of another language follows it on its line."""
    span = dropped.span
    if span is None:
        return False
    end = span.source.text.find("\n", span.end)
    line = range(span.end, end if end >= 0 else len(span.source.text))
    return any(d.name == "foreign-syntax" and d.span is not None and d.span.start in line for d in diagnostics)


_MAX_DEFINITIONS = 20  # of one name that are searched for errors; each is read to its end


def _is_defined_wrongly(unbound: Diagnostic, diagnostics: Sequence[Diagnostic]) -> bool:
    """Return whether a top-level form with another error defines an undefined name."""
    span = unbound.span
    if span is None:
        return False
    text = span.source.text
    errors = [d.span.start for d in diagnostics if d.is_error and d.span is not None and d.span.text != span.text]
    if not errors:
        return False
    matches = islice(re.finditer(rf"\((?:define|param)\s+\(?{re.escape(span.text)}(?=[\s)])", text), _MAX_DEFINITIONS)
    pieces = ((match.start(), *piece_at(text, match.start())) for match in matches)
    return any(definition == start <= error < end for definition, start, end in pieces for error in errors)


def _defined_by(diagnostic: Diagnostic) -> Iterator[str]:
    """Iterate over the names that a form with a misspelled head, such as ``(defien x 1)``, was meant to define."""
    span = diagnostic.span
    assert span is not None
    match = _DEFINES.match(span.source.text, max(0, span.start - 1))
    if match is not None and match.start(1) == span.start:
        meant = close_matches(match[1].lower().replace("_", "-"), _DEFINING, 1, 0.7)
        names = _NAMES.match(span.source.text, match.end(1)) if meant == ["define-values"] else None
        yield from names[1].split() if names is not None else (match[2],) if meant else ()


def _once_for_each_word(diagnostics: list[Diagnostic]) -> list[Diagnostic]:
    """Report each misspelled word once, and no doubts about the root that result from it."""
    of_words: dict[str, list[Diagnostic]] = {}
    for d in diagnostics:
        if d.name == "near-word" and d.span is not None:
            of_words.setdefault(d.span.text, []).append(d)
    firsts = {id(min(same, key=_start)): same for same in of_words.values()}
    remaining = [
        _with_places(d, firsts.get(id(d), ())) for d in diagnostics if d.name != "near-word" or id(d) in firsts
    ]
    near = {near for d in remaining if d.name == "near-word" for near in d.near}
    about_roots = ("ambiguous-root", "unreachable-word")
    return [d for d in remaining if not (d.name in about_roots and any(f'"{word}"' in d.message for word in near))]


def _start(diagnostic: Diagnostic) -> int:
    """Return where a diagnostic begins."""
    return diagnostic.span.start if diagnostic.span is not None else -1


def _with_places(diagnostic: Diagnostic, same: Sequence[Diagnostic]) -> Diagnostic:
    """Return a diagnostic with a note of the other lines in which it occurs."""
    spans = [d.span for d in same if d is not diagnostic and d.span is not None]
    note = also_in([span.source.position(span.start)[0] for span in spans])
    return diagnostic if note is None else replace(diagnostic, notes=(*diagnostic.notes, note))


def _misspelled_parameters(diagnostics: list[Diagnostic], program: Program) -> list[Diagnostic]:
    """Replace findings about calls by one at the declaration of a keyword parameter whose name is misspelled there.

    This is so if the function reads another name, and its callers pass that one.
    """
    calls = [d for d in diagnostics if d.found is not None and d.found.startswith(":") and len(d.near) == 1]
    for call in {(d.found, d.near[0]): d for d in calls}.values():
        passed, spelled = str(call.found)[1:], call.near[0][1:]
        parameter = _unread_parameter(program, spelled, passed)
        if parameter is None:
            continue
        span = parameter.target.span
        function = next(node for node in _functions(program) if parameter in node.parameters)
        message = f"the parameter `:{spelled}` is never used, but `{passed}` is read here and passed as `:{passed}`"
        name_span = span_of_name(span, spelled)
        fix = Fix(f"Change to `{passed}`", (Edit(name_span, passed),), safe=True)
        warning = Diagnostic("keyword", message, span, f"did you mean `:{passed}`?", fixes=(fix,), near=(f":{passed}",),
                         expected=f":{passed}", found=f":{spelled}")  # fmt: skip
        others = (d for d in diagnostics if d not in calls or (d.found, d.near) != (call.found, call.near))
        diagnostics = [d for d in others if not (_inside_function(d, function) and _is_about(d, passed, spelled))]
        diagnostics.append(warning)
    return diagnostics


def span_of_name(span: Span, name: str) -> Span:
    """Return the span of a parameter's name without its colon and type."""
    start = span.start + (1 if span.text.startswith(":") else 0)
    return Span(span.source, start, start + len(name))


def _functions(program: Program) -> Iterator[ast.Lambda]:
    """Iterate over all functions in a program."""
    for facts in program.facts:
        for node in walk(facts.form):
            if type(node) is ast.Lambda:
                yield node


def _unread_parameter(program: Program, spelled: str, passed: str) -> Any:
    """Return the keyword parameter ``spelled`` of a function that mentions ``passed`` instead of it, or None."""
    for function in _functions(program):
        for parameter in function.parameters:
            if parameter.kind == "keyword" and parameter.name == spelled and isinstance(parameter.target, Variable):
                nodes = list(walk(function.body))
                is_read = any(type(n) is ast.Reference and n.target is parameter.target for n in nodes)
                if not is_read and re.search(rf"(?<![\w-]){re.escape(passed)}(?![\w-])", function.span.text):
                    return parameter
    return None


def _inside_function(diagnostic: Diagnostic, function: ast.Lambda) -> bool:
    """Return whether a diagnostic is located in a function."""
    span, around = diagnostic.span, function.span
    return span is not None and span.source is around.source and around.start <= span.start <= span.end <= around.end


def _is_about(diagnostic: Diagnostic, passed: str, spelled: str) -> bool:
    """Return whether a diagnostic is a consequence of a misspelled parameter.

    It is about the name that is read instead, or says that the parameter is unused.
    """
    assert diagnostic.span is not None
    if diagnostic.name == "unused":
        return f"`{spelled}`" in diagnostic.message
    return re.search(rf"(?<![\w-]){re.escape(passed)}(?![\w-])", diagnostic.span.text) is not None


# --- fixes that follow from the location of a diagnostic, and their application to a text ----------------------------


_FRACTION = lazy_pattern(r"([+-]?\d+)/(\d+)\Z")
_TOKENS = lazy_pattern(r"""(?:"(?:[^"\\]|\\.)*"|;[^\n]*|#\|.*?\|#|[()\[\]'`,]|[^\s()\[\]";'`,]+)""", re.S)
_NAME = lazy_pattern(r"[^\s()\[\]\";'`,“”„]+\Z")


def with_fixes(diagnostic: Diagnostic) -> Diagnostic:
    """Return a diagnostic with its fixes, or with those that its name and the text at its location suggest.

    The location must refer to the whole text of a file.
    """
    span = diagnostic.span
    if diagnostic.name == "foreign-syntax":
        return replace(diagnostic, fixes=tuple(map(_narrowed, diagnostic.fixes)))
    if diagnostic.fixes:
        return replace(diagnostic, fixes=tuple(_checked_for_comments(_removing_lines(fix)) for fix in diagnostic.fixes))
    if span is None or span.expansion is not None:
        return diagnostic
    text, fix = span.text, None
    if diagnostic.name == "bracket" and text.startswith("[") and text.endswith("]"):
        fix = Fix("Replace brackets with parentheses", (Edit(span, f"({text[1:-1]})"),), safe=True)
    elif diagnostic.name == "word" and _NAME.match(text):
        fix = Fix("Add quotes", (Edit(span, f'"{text}"'),), safe=True)
    elif diagnostic.name == "bad-atom" and (match := _FRACTION.match(text)):
        fix = Fix("Replace with a division", (Edit(span, f"(/ {match[1]} {match[2]})"),), safe=not _is_quoted(span))
    elif diagnostic.name == "index":
        fix = _index_fix(span)
    elif diagnostic.name == "syntax" and diagnostic.message.startswith("unexpected operand"):
        fix = Fix(
            "Leave it out", (Edit(Span(span.source, len(span.source.text[: span.start].rstrip()), span.end), ""),)
        )
    elif diagnostic.name == "not-a-procedure":
        fix = infix_fix(span)
    elif match := _SYMBOL.search(diagnostic.message):
        fix = _quotes_fix(span, match[1])
    elif diagnostic.name == "keyword" and (match := _UNKNOWN.search(diagnostic.message)):
        fix = _keyword_fix(span, match[1], diagnostic.hint or "")
    elif diagnostic.name == "extra-close" and text in (")", "]") and "unmatched" in diagnostic.message:
        fix = Fix("Remove the bracket", (Edit(span, ""),), safe=True)
    return replace(diagnostic, fixes=(fix,)) if fix is not None else diagnostic


_SYMBOL = lazy_pattern(r"expects a (?:Word|String|string)\b.*, got a symbol: '?([^\s']+)\Z")


def _quotes_fix(span: Span, name: str) -> Fix | None:
    """Return the fix for a string in single quotes, which reads as a quoted symbol and another quote."""
    text = span.source.text[: span.end + 1]
    at = text.find(f"'{name}'", span.start)
    if at < 0:
        return None
    return Fix("Write double quotes", (Edit(Span(span.source, at, at + len(name) + 2), f'"{name}"'),), safe=True)


_UNKNOWN = lazy_pattern(r"has no parameter `:([^`]+)`")
_MEANT = lazy_pattern(r"did you mean `:?([^`]+)`")


def _keyword_fix(call: Span, name: str, hint: str) -> Fix | None:
    """Return the fix for an unknown keyword in a call that failed in a run: the name that its hint suggests."""
    meant = _MEANT.match(hint)
    forms = read(Source("<call>", call.text)).forms if meant is not None else ()
    if meant is None or len(forms) != 1 or not isinstance(forms[0], ListDatum):
        return None
    written = [item for item in forms[0].items if item.span.text in (f":{name}", f"&{name}")]
    if len(written) != 1:
        return None
    keyword_span = written[0].span
    edit = Edit(Span(call.source, call.start + keyword_span.start, call.start + keyword_span.end), f":{meant[1]}")
    return Fix(f"Change to `:{meant[1]}`", (edit,))


def _index_fix(span: Span) -> Fix | None:
    """Return the fix for an index that counts from 1: one less than the written one."""
    forms = read(Source("<index>", span.text)).forms
    call = forms[0] if len(forms) == 1 and isinstance(forms[0], ListDatum) else None
    if call is None or len(call.items) < 3 or call.items[0].span.text not in ("ref", "list-ref"):
        return None
    index = call.items[2]
    if isinstance(index, Atom) and type(index.value) is int and index.value > 0:
        written = str(index.value - 1)
    elif isinstance(index, ListDatum) and [item.span.text for item in (index.items[0], index.items[-1])] == ["+", "1"]:
        written = index.items[1].span.text
        if len(index.items) != 3:
            return None
    else:
        return None
    at = span.start
    edit = Edit(Span(span.source, at + index.span.start, at + index.span.end), written)
    return Fix(f"Change to `{written}`", (edit,))


def _is_quoted(span: Span) -> bool:
    """Return whether a location is inside quoted data, where a list is not a call."""
    quoted = [False]
    last = ""
    for match in _TOKENS.finditer(span.source.text, 0, span.start):
        piece = match.group()
        if piece == "(" or piece == "[":
            quoted.append(quoted[-1] or last in ("'", "`"))
        elif piece in ")]":
            quoted = quoted[:-1] or [False]
        elif last == "(" and piece in ("quote", "quasiquote"):
            quoted[-1] = True
        last = piece
    return quoted[-1] or last in ("'", "`")


def _checked_for_comments(fix: Fix) -> Fix:
    """Mark a fix as unsafe if it would delete comments."""
    for edit in fix.edits:
        comments = read_comments(Source("<edit>", edit.span.text))
        if any(comment.text not in edit.text for comment in comments):
            return replace(fix, safe=False)
    return fix


def _narrowed(fix: Fix) -> Fix:
    """Return a fix whose edits exclude unchanged tokens at their ends, so that other fixes may change these."""
    return replace(fix, edits=tuple(_narrowed_edit(edit) for edit in fix.edits))


def _narrowed_edit(edit: Edit) -> Edit:
    """Return an edit without the tokens at both ends that it keeps."""
    old, new = [[m.span() for m in _TOKENS.finditer(text)] for text in (edit.span.text, edit.text)]
    if len(old) <= 1 or not new:
        return edit
    texts = [[text[start:end] for start, end in ranges] for text, ranges in ((edit.span.text, old), (edit.text, new))]
    common = min(len(old), len(new))
    head = next((i for i in range(common) if texts[0][i] != texts[1][i]), common)
    common -= head
    tail = next((i for i in range(common) if texts[0][-1 - i] != texts[1][-1 - i]), common)
    start, end = _between(old, head, tail, len(edit.span.text))
    first, last = _between(new, head, tail, len(edit.text))
    if (start == end and first == last) or start > end or first > last:
        return edit
    at = edit.span.start
    return Edit(Span(edit.span.source, at + start, at + end), edit.text[first:last])


def _between(tokens: Sequence[tuple[int, int]], head: int, tail: int, length: int) -> tuple[int, int]:
    """Return the range between the end of the first ``head`` tokens and the start of the last ``tail``."""
    start = tokens[head - 1][1] if head else 0
    return start, tokens[-tail][0] if tail else length


def _removing_lines(fix: Fix) -> Fix:
    """Extend the deletions of a fix to the line breaks of lines that become empty."""
    return replace(fix, edits=tuple(_removal(edit.span) if not edit.text else edit for edit in fix.edits))


def _removal(form: Span) -> Edit:
    """Return the edit that deletes a span, with its lines if they become empty."""
    text = form.source.text
    line = text.rfind("\n", 0, form.start) + 1
    after = re.compile(r"[ \t]*\r?\n?").match(text, form.end)
    end = after.end() if after is not None else form.end
    is_alone = not text[line : form.start].strip() and (text[end - 1 : end] == "\n" or end == len(text))
    if is_alone:
        return Edit(Span(form.source, line, end), "")
    return Edit(form, with_spacing(form, "") or "")


def apply_fixes(source: Source, diagnostics: Iterable[Diagnostic]) -> tuple[str, int]:
    """Apply all safe fixes to a text, skipping those that overlap another one.

    Returns
    -------
    tuple of (str, int)
        The new text and the number of applied fixes.
    """
    text, applied, limit = source.text, 0, len(source.text) + 1
    fixes = [fix for d in diagnostics for fix in d.fixes[:1] if fix.safe and _is_within(fix, source)]
    for fix in sorted(fixes, key=lambda fix: -max(edit.span.end for edit in fix.edits)):
        if max(edit.span.end for edit in fix.edits) > limit:
            continue
        text = with_edits(text, fix.text_edits)
        limit = min(edit.span.start for edit in fix.edits)
        applied += 1
    return text, applied


def _is_within(fix: Fix, source: Source) -> bool:
    """Return whether all edits of a fix are in ``source``, outside expansions of macros."""
    return all(edit.span.source.name == source.name and edit.span.expansion is None for edit in fix.edits)


# --- suppression comments: ``; lint: allow unused W304`` --------------------------------------------------------------
#
# At the end of a line, a comment applies to that line; on a separate line, to the form that follows;
# ``; lint: allow-file`` applies to the whole file. Errors cannot be suppressed.


_ALLOW = lazy_pattern(r";+\s*lint:\s*allow(?P<file>-file)?\s+(?P<names>.+)")


@dataclass(frozen=True, eq=False)
class Suppressions:
    """Suppression comments of a text: names or codes of warnings, each with a range of offsets."""

    source: Source

    @cached_property
    def _ranges(self) -> Sequence[tuple[int, int, frozenset[str]]]:
        """Ranges of offsets with the names and codes of the warnings that are suppressed in them."""
        if "lint:" not in self.source.text:
            return ()
        ranges = []
        for comment in read_comments(self.source):
            match = _ALLOW.match(comment.text)
            if match is not None:
                names = frozenset(re.split(r"[\s,]+", match["names"].strip()))
                scope = self._scope(comment.start, comment.end, is_whole=bool(match["file"]))
                ranges.append((*scope, names))
        return ranges

    def _scope(self, start: int, end: int, *, is_whole: bool) -> tuple[int, int]:
        """Return the range to which a comment applies: the file, its line, or the form after it."""
        text = self.source.text
        if is_whole:
            return 0, len(text)
        line = text.rfind("\n", 0, start) + 1
        if text[line:start].strip():
            return line, end
        return piece_at(text, end)

    def suppress(self, diagnostic: Diagnostic) -> bool:
        """Return whether a comment suppresses the diagnostic."""
        span = diagnostic.span
        if diagnostic.is_error or span is None or span.source.name != self.source.name:
            return False
        return any(
            start <= span.start < max(end, start + 1) and not names.isdisjoint((diagnostic.name, diagnostic.code))
            for start, end, names in self._ranges
        )


def without_suppressed(diagnostics: Iterable[Diagnostic], sources: Iterable[Source]) -> list[Diagnostic]:
    """Return the diagnostics that no comment in these texts suppresses."""
    suppressions = [Suppressions(source) for source in sources]
    return [d for d in diagnostics if d.is_error or not any(suppression.suppress(d) for suppression in suppressions)]


# --- findings and runs -----------------------------------------------------------------------------------------------


_DRAWN = "declaration-subject"  # of a word that a camera or a light looks at


def confirmed(
    reported: Sequence[Diagnostic], problem: Diagnostic | None, warnings: Sequence[Diagnostic]
) -> list[Diagnostic]:
    """Return the findings of a check together with those of the run after it, each mistake once.

    Errors of the check that did not occur in the run become warnings: the code was guarded, or not evaluated. Words
    that a camera or a light looks at are looked up when an image is drawn, so that a run does not say that they exist.

    Parameters
    ----------
    reported
        Findings of the check.
    problem
        Error that ended the run, if any.
    warnings
        Warnings of the run.
    """
    warnings = [d for d in warnings if not any(_is_reported(finding, d) for finding in reported)]
    if problem is not None and problem.name == "depth" and problem.span is not None:
        name = problem.message.partition(" calls itself")[0]
        known = [d for d in reported if _overlaps(d.span, problem.span) or f"{name} always calls" in d.message]
        reported = [d for d in reported if d.name != "endless-recursion" or d not in known]
        warnings = [d for d in warnings if not CODES[d.name].code.startswith("W6")]  # of values that never end
    if problem is None or CODES[problem.name].code.startswith("E5"):
        reported = [replace(d, name="conditional-failure") if d.is_error and d.name != _DRAWN else d for d in reported]
        return [*reported, problem, *warnings] if problem else [*reported, *warnings]
    candidates = (problem.span, *(span for _, span in problem.chain))
    spans = [span for span in candidates if span is not None]
    cause = next((d for d in reported if _is_cause(d, problem)), None)
    if cause is not None:  # the check says which part of the expression is wrong
        others = [d for d in reported if d is not cause and not (d.is_error and _is_same(d, problem, spans))]
        told = replace(problem, message=cause.message, span=cause.span, hint=cause.hint, fixes=cause.fixes)
        return [*others, told, *warnings]
    is_known = any(_is_same(d, problem, spans) for d in reported if d.is_error)
    return [*reported, *warnings] if is_known else [*reported, problem, *warnings]


def _overlaps(span: Span | None, other: Span) -> bool:
    """Return whether a location is known and overlaps another one."""
    return span is not None and span.overlaps(other)


def _is_cause(finding: Diagnostic, problem: Diagnostic) -> bool:
    """Return whether a warning of the check says what is wrong where a run failed, and more precisely.

    It is about an expression that may fail, or about a name that is not the function that it hides.
    """
    if problem.span is None or not _overlaps(finding.span, problem.span):
        return False
    if finding.name == "shadowed-builtin":
        return problem.name == "not-a-procedure"
    return finding.name == "conditional-failure"


def _is_reported(finding: Diagnostic, warning: Diagnostic) -> bool:
    """Return whether a warning of the run is a finding of the check, whose location is more precise."""
    if finding.name == warning.name == "out-of-range" and finding.found and finding.found in warning.message:
        return True
    return (
        finding.name == warning.name
        and finding.span is not None
        and warning.span is not None
        and finding.span.overlaps(warning.span)
    )


def _is_same(finding: Diagnostic, problem: Diagnostic, call_spans: Sequence[Span]) -> bool:
    """Return whether a finding of the check is the error of the run.

    It overlaps the error, or it has its name and is located on a line of the call chain, or is about the word that was
    called last.
    """
    spans = [span for span in (finding.span, *(note.span for note in finding.notes)) if span is not None]
    if problem.span is not None and any(span.overlaps(problem.span) for span in spans):
        return True
    if finding.name != problem.name:
        return False
    if finding.message == problem.message:
        return True
    if not call_spans or (problem.name == "parts" and problem.chain and problem.chain[0][0] in finding.message):
        return True
    lines = {(call_span.source, call_span.source.position(call_span.start)[0]) for call_span in call_spans}
    return any((span.source, span.source.position(span.start)[0]) in lines for span in spans)
