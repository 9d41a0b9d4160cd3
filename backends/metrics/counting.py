"""Counting accuracy: whether a scene has as many of a thing as the text of its task asks for."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from scenelang.backends.wording.readable import spaced
from scenelang.interpreter.entity import Scene, count_words


def _listed(words: str) -> list[str]:
    return words.split()


_UNITS = _listed(
    "zero one two three four five six seven eight nine ten eleven twelve thirteen fourteen fifteen sixteen seventeen "
    "eighteen nineteen"
)
_TENS = _listed("twenty thirty forty fifty sixty seventy eighty ninety")
_NUMBERS = {word: n for n, word in enumerate(_UNITS)} | {word: 10 * n for n, word in enumerate(_TENS, 2)}
_TIMES = {"pair": 2, "couple": 2, "dozen": 12, "hundred": 100}
_ENDS = _listed(
    "in on at by with of and or from to into onto over under around beside between that which who are is was were each "
    "per for as the a an"
)
_MEASURES = _listed(
    "m cm mm km metre meter centimetre centimeter foot inch degree percent second minute hour year time way side row "
    "column layer level story storey floor d x"
)
_TOKEN = re.compile(r"\d+(?:\.\d+)?|[a-z]+(?:['’-][a-z]+)*|[^\sa-z\d]", re.I)
_LONGEST = 4  # words after a number that may name the things
_MOST_TEXT = 10_000  # characters of a task that are read
_IRREGULAR = {"men": "man", "women": "woman", "people": "person", "children": "child", "mice": "mouse",
              "geese": "goose", "feet": "foot", "teeth": "tooth", "leaves": "leaf", "knives": "knife",
              "shelves": "shelf", "loaves": "loaf", "dice": "die", "movies": "movie", "cookies": "cookie",
              "buses": "bus", "shoes": "shoe", "toes": "toe", "pies": "pie"}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Asked:
    """That there be ``count`` of what ``words``, one after the other and in the singular, name or begin to name."""

    count: int
    words: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Counted:
    """What was asked for and what there is: ``words`` are the program's, none where it has none of the name."""

    asked: Asked
    words: tuple[str, ...]
    found: int

    @property
    def is_right(self) -> bool:
        return self.found == self.asked.count


def asked_in(text: str) -> tuple[Asked, ...]:
    """The numbers of things that a text asks for: "15 coke cans on a table" asks for 15. Sizes ("8 x 8", "two
    metres"), fractions and articles ask for nothing."""
    tokens = [token.lower() for token in _TOKEN.findall(text[:_MOST_TEXT])]
    found: list[Asked] = []
    at = 0
    while at < len(tokens):
        count, after = _number(tokens, at)
        if count is None:
            at += 1
            continue
        words = _words(tokens, after)
        if words and words[0] not in _MEASURES and not _is_size(tokens, at, after):
            found.append(Asked(count, words))
        at = after + len(words)
    return tuple(found)


def asked_of(counts: Mapping[str, int]) -> tuple[Asked, ...]:
    """What a table of numbers by word asks for."""
    return tuple(Asked(count, _normal(word)) for word, count in counts.items())


def counted(scene: Scene, asked: Sequence[Asked]) -> tuple[Counted, ...]:
    """How many of each there are in the first frame, by the words of its entities."""
    counts = count_words(scene.frames[0])
    return tuple(_counted(counts, one) for one in asked)


def is_accurate(found: Sequence[Counted]) -> bool:
    """The paper's: a scene is right or it is not."""
    return all(one.is_right for one in found)


# --- texts -----------------------------------------------------------------------------------------------------------


def _number(tokens: Sequence[str], at: int) -> tuple[int | None, int]:
    """The number that begins at a token, None where none does, and the place after it."""
    token = tokens[at]
    if token in ("a", "an") and at + 1 < len(tokens) and tokens[at + 1] in _TIMES:
        value, after = 1, at + 1
    elif token.isdecimal() and len(token) < 10:
        value, after = int(token), at + 1
    elif (read := _worded(token)) is not None:
        value, after = read, at + 1
    else:
        return None, at + 1
    if after < len(tokens) and tokens[after] in _TIMES:
        value, after = value * _TIMES[tokens[after]], after + 1
        after += after < len(tokens) and tokens[after] == "of"
    return value, after


def _worded(token: str) -> int | None:
    tens, _, unit = token.partition("-")
    if tens in _TENS and 0 < _NUMBERS.get(unit, 0) < 10:
        return _NUMBERS[tens] + _NUMBERS[unit]
    return _NUMBERS.get(token)


def _words(tokens: Sequence[str], after: int) -> tuple[str, ...]:
    words: list[str] = []
    for token in tokens[after : after + _LONGEST]:
        if token in _ENDS or not token[0].isalpha() or _worded(token) is not None:
            break
        words.append(singular(token))
    return tuple(words)


def _is_size(tokens: Sequence[str], at: int, after: int) -> bool:
    """Whether a number is a side of something: "8 x 8 chessboard", "5 by 5 grid"."""
    return (at > 0 and tokens[at - 1] in ("x", "by", "×")) or (after < len(tokens) and tokens[after] in ("x", "×"))


def singular(word: str) -> str:
    """An English noun without its plural's ending, as far as rules tell."""
    if word in _IRREGULAR:
        return _IRREGULAR[word]
    if word.endswith("ies") and len(word) > 4:
        return word[:-3] + "y"
    if re.search(r"(ch|sh|ss|x|z|o)es\Z", word):
        return word[:-2]
    if word.endswith("s") and not word.endswith(("ss", "us", "is")) and len(word) > 2:
        return word[:-1]
    return word


# --- scenes ----------------------------------------------------------------------------------------------------------


def _normal(word: str) -> tuple[str, ...]:
    return tuple(singular(part) for part in spaced(word).lower().split())


def _counted(counts: Mapping[str, int], asked: Asked) -> Counted:
    """The longest of the words asked for that name something. Else whatever ends as these do: soda cans are cans."""
    names = {word: _normal(word) for word in counts}
    for wanted in _parts(asked.words):
        found = [word for word, name in names.items() if name == wanted]
        if found:
            return _sum(asked, _singulars(found), counts)
    for wanted in _parts(asked.words):
        found = [word for word, name in names.items() if name[-1:] == wanted]
        if found:
            return _sum(asked, _singulars(found), counts)
    return Counted(asked, (), 0)


def _singulars(words: Sequence[str]) -> list[str]:
    """Of names and their plurals the names, since `"cans"` makes many of `"can"`."""
    return [word for word in words if " ".join(_normal(word)) == spaced(word).lower()] or list(words)


def _sum(asked: Asked, words: Sequence[str], counts: Mapping[str, int]) -> Counted:
    return Counted(asked, tuple(words), sum(counts[word] for word in words))


def _parts(words: tuple[str, ...]) -> list[tuple[str, ...]]:
    """All pieces of a phrase, the longest first, of equals the first."""
    return [words[i : i + size] for size in range(len(words), 0, -1) for i in range(len(words) - size + 1)]
