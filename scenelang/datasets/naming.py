"""What the programs of a spec name: their params, their words and the classes; unknown names of a spec are told."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache

from scenelang.backends.labels import things as labels
from scenelang.datasets.spec import CODE, Spec
from scenelang.datasets.toml_places import KeyPath, parsed
from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import Diagnostic, SceneError, near_names, suggest
from scenelang.interpreter.scene.entity import descendants
from scenelang.interpreter.scene.primitives import geometric_words
from scenelang.session import Session

_CALLED = re.compile(r'\(call\s+"((?:[^"\\]|\\.)*)"')
_COMPUTED = re.compile(r'(?<![\w-])(?:call|bind)(?![\w-])(?!\s+")')  # a word that is no literal
_MOST_LISTED = 12


@dataclass(frozen=True, slots=True)
class SpecNames:
    """Params and words of all programs of a spec; ``is_sure`` tells whether there can be no further words."""

    params: frozenset[str]
    words: frozenset[str]
    is_sure: bool


@lru_cache(maxsize=256)
def named_program(path: str, bound: tuple[str, ...]) -> tuple[Source, tuple[str, ...], tuple[str, ...], bool]:
    """Return a program with further bindings, the names of its params, the words that its text names, and whether its
    text names all of its words."""
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
    called = {match for each in program.sources for match in _CALLED.findall(each.text)}
    params = tuple(param.name for param in program.params)
    is_sure = path.endswith(".scene") and not any(_COMPUTED.search(each.text) for each in program.sources)
    return source, params, tuple(sorted({*program.all_words, *called})), is_sure


def names_of(spec: Spec) -> SpecNames:
    """Return what the programs of a spec name, with the words of its own expressions."""
    found = [named_program(path, ()) for path in spec.programs]
    params = {name for _, own, _, _ in found for name in own}
    words = {word for _, _, own, _ in found for word in own}
    texts = [text for change in spec.words.values() if change.bind is not None for text in change.bind.values]
    words.update(word for text in texts for word in _CALLED.findall(text))
    is_sure = all(sure for *_, sure in found) and not any(map(_COMPUTED.search, texts))
    return SpecNames(frozenset(params), frozenset(words), is_sure)


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
    chosen = spec.labels.words or sorted({*names.words, *spec.words} - {*geometric_words()})
    if len(chosen) > labels.OTHER - 1:
        raise SceneError(CODE, f"{len(chosen):,} words are more than the {labels.OTHER - 1:,} classes of a map")
    return {word: number for number, word in enumerate(chosen, start=1)}


def warnings_of(spec: Spec) -> list[Diagnostic]:
    """Return warnings for words that no program names, if programs compute words."""
    names = names_of(spec)
    found = [] if names.is_sure else [_error(spec, *each) for each in _unknown_words(spec, names)]
    return [Diagnostic("near-word", each.message, each.span, each.hint) for each in found]


def _check_params(spec: Spec, names: SpecNames) -> None:
    for name in spec.params:
        if name not in names.params:
            raise _error(spec, ("params", name), f"no program has the param `{name[:60]}`", _near(name, names.params))


def _unknown_words(spec: Spec, names: SpecNames) -> Iterable[tuple[KeyPath, str, str | None]]:
    """Yield the place, a message and a hint for each word of the spec that no program names."""
    labelled = spec.labels
    given: list[tuple[KeyPath, Sequence[str]]] = [(("root",), [spec.root] if spec.root is not None else [])]
    given += [(("words", word), [word]) for word in spec.words]
    given += [(("labels", "words"), labelled.words), (("labels", "keypoints"), labelled.keypoints)]
    given += [(("filters", "visible", word), [word]) for word in spec.filters.visible]
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
