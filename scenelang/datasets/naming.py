"""What the programs of a spec name: their params, their words and the classes; unknown names of a spec are told."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from scenelang.backends.labels import object_labels as labels
from scenelang.datasets.spec import CODE, Distribution, Spec
from scenelang.files.toml_places import KeyPath, parsed, shown
from scenelang.grammar.datum import Atom, Source
from scenelang.grammar.diagnostics import Diagnostic, SceneError, near_names, suggest
from scenelang.grammar.reader import read
from scenelang.interpreter.checker.program import Param
from scenelang.interpreter.scene.entity import descendants
from scenelang.interpreter.scene.primitives import geometric_words
from scenelang.interpreter.scene.primitives import words as primitive_words
from scenelang.interpreter.scene.primitives.base import COLOR, MATERIALS
from scenelang.session.session import Session

_CALLED = re.compile(r'\(call\s+("(?:[^"\\]|\\.)*")', re.DOTALL)
_COUNTED = re.compile(r"\{count:([^{}]+)\}")
_COMPUTED = re.compile(r'(?<![\w-])(?:call|bind)(?![\w-])(?!\s+")')  # a word that is no literal
_MOST_LISTED = 12
_DEVIATIONS = 6.0  # of a normal distribution, beyond which nothing is drawn in practice


@dataclass(frozen=True, slots=True)
class SpecNames:
    """Params and words of all programs of a spec, and the params of each by its name; ``is_sure`` tells whether there
    can be no further words."""

    programs: Mapping[str, tuple[Param, ...]]
    params: frozenset[str]
    words: frozenset[str]
    is_sure: bool


@lru_cache(maxsize=256)
def named_program(path: str, bound: tuple[str, ...]) -> tuple[Source, tuple[Param, ...], tuple[str, ...], bool]:
    """Return a program with further bindings, its params, the words that its text names, and whether its text names all
    of its words."""
    session = Session()
    source = session.source(path)
    if bound:
        source = Source(source.name, "\n".join([source.text.rstrip("\n"), *bound, ""]))
    if path.endswith(".json"):
        result = session.evaluate(source)
        words = {e.word for e in descendants(*result.scene.frames)} if result.scene is not None else set()
        return source, (), tuple(sorted(words)), result.scene is not None
    program = session.check(source).program
    if program is None:
        return source, (), (), False
    called = {word for each in program.sources for word in called_words(each.text)}
    params = tuple(program.params)
    is_sure = path.endswith(".scene") and not any(_COMPUTED.search(each.text) for each in program.sources)
    return source, params, tuple(sorted({*program.all_words, *called})), is_sure


def called_words(text: str) -> Iterator[str]:
    """Yield the words that a text calls by a literal.

    Examples
    --------
    >>> list(called_words('(call "cube") (call "\\\\x63;ube")'))
    ['cube', 'cube']
    """
    for literal in _CALLED.findall(text):
        found = read(Source("word", literal))
        if not found.diagnostics and isinstance(found.forms[0], Atom):
            yield str(found.forms[0].value)


def _named_programs(spec: Spec) -> Iterator[tuple[str, tuple[Param, ...], tuple[str, ...], bool]]:
    """Yield the name of each program with what ``named_program`` returns of it; raises SceneError("dataset") for a
    program that cannot be read."""
    for path in spec.programs:
        try:
            _, params, words, is_sure = named_program(path, ())
        except SceneError as error:
            raise _error(spec, ("programs",), f"`programs`: {error.message}", error.hint) from error
        yield spec.program_name(path), params, words, is_sure


def names_of(spec: Spec) -> SpecNames:
    """Return what the programs of a spec name, with the words of its own expressions."""
    found = list(_named_programs(spec))
    params = {param.name for _, own, _, _ in found for param in own}
    words = {word for _, _, own, _ in found for word in own}
    texts = [text for change in spec.words.values() if change.bind is not None for text in change.bind.values]
    words.update(word for text in texts for word in called_words(text))
    is_sure = all(sure for *_, sure in found) and not any(map(_COMPUTED.search, texts))
    return SpecNames({name: own for name, own, _, _ in found}, frozenset(params), frozenset(words), is_sure)


def classes_of(spec: Spec) -> dict[str, int]:
    """Return the number of each class, from 1: the words of the spec, or else all that its programs name but those of
    primitives.

    Raises SceneError("dataset"), with the place in the spec, for params and words that no program has.
    """
    names = names_of(spec)
    _check_params(spec, names)
    unknown = list(_unknown_words(spec, names))
    if names.is_sure and unknown:
        raise _error(spec, *unknown[0])
    chosen = spec.labels.words or sorted({*names.words, *spec.words} - {*primitive_words()})
    if len(chosen) > labels.OTHER - 1:
        raise SceneError(CODE, f"{len(chosen):,} words are more than the {labels.OTHER - 1:,} classes of a map")
    return {word: number for number, word in enumerate(chosen, start=1)}


def warnings_of(spec: Spec) -> list[Diagnostic]:
    """Return warnings for words that no program names, if programs compute words, and for looks out of range."""
    names = names_of(spec)
    found = [] if names.is_sure else [_error(spec, *each) for each in _unknown_words(spec, names)]
    looks = [_error(spec, *each) for each in _extreme_looks(spec)]
    return [
        *(Diagnostic("near-word", each.message, each.span, each.hint) for each in found),
        *(Diagnostic("out-of-range", each.message, each.span, each.hint) for each in looks),
    ]


def _extreme_looks(spec: Spec) -> Iterator[tuple[KeyPath, str, str | None]]:
    """Yield the place, a message and a hint for each look that an attribute should not have, as `check` tells."""
    attributes = {each.name: each for each in (COLOR, *MATERIALS)}
    for word, change in spec.words.items():
        for name, look in change.looks.items():
            low, high = attributes[name].low, attributes[name].high
            values = [each for value in extremes_of(look) for each in (value if isinstance(value, tuple) else (value,))]
            wrong = [each for each in values if not isinstance(each, str) and not (low or 0.0) <= each <= high]
            if wrong:
                limits = "not be negative" if high == math.inf else f"be {low or 0.0:g} to {high:g}"
                message = f'the attribute `:{name}` of "{word}" should {limits}, got {wrong[0]:g}'
                yield ("words", word, name), message, attributes[name].doc


def extremes_of(quantity: Distribution) -> tuple[Any, ...]:
    """Return the choices of a distribution, or the least and the greatest number that it draws in practice."""
    if quantity.kind == "choice":
        shares = quantity.weights or (1.0,) * len(quantity.values)
        return tuple(value for value, share in zip(quantity.values, shares, strict=True) if share > 0)
    first, second = quantity.values
    if quantity.kind == "normal":
        first, second = first - _DEVIATIONS * second, first + _DEVIATIONS * second
    return (first, second) if quantity.kind == "integer" else tuple(quantity.clipped(x) for x in (first, second))


def _check_params(spec: Spec, names: SpecNames) -> None:
    for name in spec.params:
        if name not in names.params:
            raise _error(spec, ("params", name), f"no program has the param `{name[:60]}`", _near(name, names.params))
    for program, params in names.programs.items():
        for param in params:
            if param.name in spec.params:
                _check_bounds(spec, program, param)
        if spec.splits is not None and spec.splits.by not in ("scene", "program", *(param.name for param in params)):
            message = f"`by`: `{program}` has no param `{spec.splits.by[:60]}`, so its samples would be in every split"
            raise _error(spec, ("splits", "by"), message, 'leave the program out, or write by = "scene"')


def _check_bounds(spec: Spec, program: str, param: Param) -> None:
    """Raise an error for values that the program does not accept."""
    low, high = param.minimum, param.maximum
    if low is None and high is None:
        return
    least, most = (-math.inf if low is None else low), (math.inf if high is None else high)
    limits = f"at least {low:g}" if high is None else f"at most {high:g}" if low is None else f"{low:g} to {high:g}"
    for value in extremes_of(spec.params[param.name]):
        if isinstance(value, bool) or not isinstance(value, int | float):
            message, hint = f"`{param.name}`: `{program}` accepts numbers only, got {shown(value)}", None
        elif not least <= value <= most:
            message = f"`{param.name}`: `{program}` accepts {limits}, but {value:g} may be drawn"
            hint = "`min` and `max` bound a distribution"
        else:
            continue
        raise _error(spec, ("params", param.name), message, hint)


def _unknown_words(spec: Spec, names: SpecNames) -> Iterable[tuple[KeyPath, str, str | None]]:
    """Yield the place, a message and a hint for each word of the spec that no program names."""
    labelled = spec.labels
    given: list[tuple[KeyPath, Sequence[str]]] = [(("root",), [spec.root] if spec.root is not None else [])]
    given += [(("words", word), [word]) for word in spec.words]
    given += [(("labels", "words"), labelled.words), (("labels", "keypoints"), labelled.keypoints)]
    given += [(("filters", "visible", word), [word]) for word in spec.filters.visible]
    templates = enumerate(labelled.captions)
    given += [(("captions", "templates", str(number)), _COUNTED.findall(text)) for number, text in templates]
    for path, words in given:
        for word in words:
            if word not in names.words and word not in geometric_words():
                yield path, f"no program has the word `{word[:60]}`", _near(word, names.words)


def _near(name: str, known: frozenset[str]) -> str | None:
    if near_names(name, known) or not known:
        return suggest(name, known)
    listed = sorted(known)
    return f"known are {', '.join(listed[:_MOST_LISTED])}{', ...' if len(listed) > _MOST_LISTED else ''}"


def _error(spec: Spec, path: KeyPath, message: str, hint: str | None) -> SceneError:
    """Return an error at a place in the text of the spec."""
    try:
        parsed(Source(spec.name, spec.text), CODE).document.fail(path, message, hint)
    except SceneError as error:
        return error
