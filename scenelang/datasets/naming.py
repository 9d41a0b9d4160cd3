"""Params, words and classes of a spec's programs; unknown names of a spec are reported."""

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
_COMPUTED = re.compile(r'(?<![\w-])(?:call|bind)(?![\w-])(?!\s+")')  # a word that is not a literal
_MAX_LISTED_NAMES = 12  # names in a hint
_MAX_DEVIATIONS = 6.0  # of a normal distribution, beyond which practically nothing is drawn (2 in a billion)


@dataclass(frozen=True, slots=True)
class SpecNames:
    """Params and words of all programs of a spec, and the params of each program.

    ``is_sure`` if the programs can have no further words.
    """

    programs: Mapping[str, tuple[Param, ...]]
    params: frozenset[str]
    words: frozenset[str]
    is_sure: bool


@lru_cache(maxsize=256)
def named_program(path: str, bound: tuple[str, ...]) -> tuple[Source, tuple[Param, ...], tuple[str, ...], bool]:
    """Return a program with further bindings, its params, its words, and whether these are all of its words."""
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
    called = {word for imported in program.sources for word in called_words(imported.text)}
    params = tuple(program.params)
    is_sure = path.endswith(".scene") and not any(_COMPUTED.search(imported.text) for imported in program.sources)
    return source, params, tuple(sorted({*program.all_words, *called})), is_sure


def called_words(text: str) -> Iterator[str]:
    """Yield the words that a text calls by a literal.

    Examples
    --------
    >>> list(called_words('(call "cube") (call "\\\\x63;ube")'))
    ['cube', 'cube']
    """
    for literal in _CALLED.findall(text):
        document = read(Source("word", literal))
        if not document.diagnostics and isinstance(document.forms[0], Atom):
            yield str(document.forms[0].value)


def _named_programs(spec: Spec) -> Iterator[tuple[str, tuple[Param, ...], tuple[str, ...], bool]]:
    """Yield the name of each program, and the result of ``named_program`` without its source.

    Raises SceneError("dataset") for a program that cannot be read.
    """
    for path in spec.programs:
        try:
            _, params, words, is_sure = named_program(path, ())
        except SceneError as error:
            raise _error(spec, ("programs",), f"`programs`: {error.message}", error.hint) from error
        yield spec.program_name(path), params, words, is_sure


def names_of(spec: Spec) -> SpecNames:
    """Return the params and words of a spec's programs, and the words of its own expressions."""
    programs = list(_named_programs(spec))
    params = {param.name for _, program_params, _, _ in programs for param in program_params}
    words = {word for _, _, program_words, _ in programs for word in program_words}
    texts = [text for change in spec.words.values() if change.bind is not None for text in change.bind.values]
    words.update(word for text in texts for word in called_words(text))
    is_sure = all(sure for *_, sure in programs) and not any(map(_COMPUTED.search, texts))
    return SpecNames(
        {name: program_params for name, program_params, _, _ in programs}, frozenset(params), frozenset(words), is_sure
    )


def classes_of(spec: Spec) -> dict[str, int]:
    """Return the number of each class, from 1.

    Classes are the words of the spec, or else all words of its programs without those of primitives. Raises
    SceneError("dataset"), located in the spec, for params and words that no program has.
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
    unknown = [] if names.is_sure else [_error(spec, *problem) for problem in _unknown_words(spec, names)]
    looks = [_error(spec, *problem) for problem in _extreme_looks(spec)]
    return [
        *(Diagnostic("near-word", error.message, error.span, error.hint) for error in unknown),
        *(Diagnostic("out-of-range", error.message, error.span, error.hint) for error in looks),
    ]


def _extreme_looks(spec: Spec) -> Iterator[tuple[KeyPath, str, str | None]]:
    """Yield the path, a message and a hint for each look out of its attribute's range, as `check` reports."""
    attributes = {attribute.name: attribute for attribute in (COLOR, *MATERIALS)}
    for word, change in spec.words.items():
        for name, look in change.looks.items():
            low, high = attributes[name].low, attributes[name].high
            values = [x for value in extremes_of(look) for x in (value if isinstance(value, tuple) else (value,))]
            wrong = [x for x in values if not isinstance(x, str) and not (low or 0.0) <= x <= high]
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
        first, second = first - _MAX_DEVIATIONS * second, first + _MAX_DEVIATIONS * second
    return (first, second) if quantity.kind == "integer" else tuple(quantity.clipped(x) for x in (first, second))


def _check_params(spec: Spec, names: SpecNames) -> None:
    """Raise SceneError for params that no program has, or whose values a program does not accept."""
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
    """Yield the path, a message and a hint for each word of the spec that no program has."""
    labeled = spec.labels
    named_words: list[tuple[KeyPath, Sequence[str]]] = [(("root",), [spec.root] if spec.root is not None else [])]
    named_words += [(("words", word), [word]) for word in spec.words]
    named_words += [(("labels", "words"), labeled.words), (("labels", "keypoints"), labeled.keypoints)]
    named_words += [(("filters", "visible", word), [word]) for word in spec.filters.visible]
    templates = enumerate(labeled.captions)
    named_words += [(("captions", "templates", str(number)), _COUNTED.findall(text)) for number, text in templates]
    for path, words in named_words:
        for word in words:
            if word not in names.words and word not in geometric_words():
                yield path, f"no program has the word `{word[:60]}`", _near(word, names.words)


def _near(name: str, known: frozenset[str]) -> str | None:
    """Return the closest names as a hint, or a list of the known ones."""
    if near_names(name, known) or not known:
        return suggest(name, known)
    listed = sorted(known)
    return f"known are {', '.join(listed[:_MAX_LISTED_NAMES])}{', ...' if len(listed) > _MAX_LISTED_NAMES else ''}"


def _error(spec: Spec, path: KeyPath, message: str, hint: str | None) -> SceneError:
    """Return an error at a place in the text of the spec."""
    try:
        parsed(Source(spec.name, spec.text), CODE).document.fail(path, message, hint)
    except SceneError as error:
        return error
