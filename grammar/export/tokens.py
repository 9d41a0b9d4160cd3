"""What the language's tokens look like, as patterns that every format can write. `reader.py` decides; tests compare."""

from __future__ import annotations

from collections.abc import Iterable

from scenelang.grammar.export.model import Chars, Either, Joined, Many, Pattern, Text, Token, Use

# Letters and signs beyond ASCII that are assigned, printable and no white space in every version of Unicode in use.
_FOREIGN = (
    (0xC0, 0x24F), (0x391, 0x3A1), (0x3A3, 0x3FF), (0x400, 0x52F), (0x2190, 0x21FF), (0x2200, 0x22FF),
    (0x3041, 0x3096), (0x30A1, 0x30FA), (0x4E00, 0x9FA5),
)  # fmt: skip


def _chars(text: str, *ranges: tuple[int, int]) -> Chars:
    """The class of the characters of ``text`` (``a-z`` for a range) and of ``ranges``."""
    found = list(ranges)
    position = 0
    while position < len(text):
        if text[position + 1 : position + 2] == "-" and position + 2 < len(text):
            found.append((ord(text[position]), ord(text[position + 2])))
            position += 3
        else:
            found.append((ord(text[position]), ord(text[position])))
            position += 1
    return Chars(tuple(sorted(found)))


def _but(text: str) -> Chars:
    return Chars(_chars(text).ranges, negated=True)


_LETTER = _chars("a-zA-Z")
_DIGIT = _chars("0-9")
NAME_START = _chars("a-zA-Z!$%&*/=>?^_~", *_FOREIGN)  # no sign, comparison or handle; `,@` is a prefix
NAME_REST = _chars("a-zA-Z0-9!$%&*/=>?@^_~<+.-", *_FOREIGN)
_AFTER_SIGN = _chars("a-zA-Z!$%&*/=>?@^_~<+-", *_FOREIGN)  # not the beginning of a number
_AFTER_LESS = _chars("0-9!$%&*/=>?@^_~<+.-")  # not the beginning of a handle
_rest = Many(NAME_REST)


def _optional(part: Pattern) -> Pattern:
    return Many(part, 0, 1)


_NAME = Either((
    Joined((NAME_START, _rest)),
    Joined((_chars("+-"), _optional(Joined((_AFTER_SIGN, _rest))))),
    Joined((Text("<"), _optional(Joined((_AFTER_LESS, _rest))))),
))  # fmt: skip

_DIGITS = Many(_DIGIT, 1)
_NUMBER = Joined((
    _optional(_chars("+-")),
    Either((Joined((_DIGITS, _optional(Joined((Text("."), Many(_DIGIT)))))), Joined((Text("."), _DIGITS)))),
    _optional(Joined((_chars("eE"), _optional(_chars("+-")), _DIGITS))),
))  # fmt: skip

_HEX = _chars("0-9A-Fa-f")


def _hex(least: int, most: int | None = None) -> Pattern:
    return Many(_HEX, least, most or least)


_FOUR = (  # hexadecimal digits of a code point that is no surrogate
    Joined((_chars("0-9A-CE-Fa-ce-f"), _hex(3))),
    Joined((_chars("Dd"), _chars("0-7"), _hex(2))),
)
_ESCAPE = Joined((
    Text("\\"),
    Either((
        _chars('ntrab0"\\'),
        Joined((Text("u"), Either(_FOUR))),
        Joined((Text("x"), Either((_hex(1, 3), *_FOUR, Joined((_chars("1-9A-Fa-f"), _hex(4))),
                                   Joined((Text("10"), _hex(4))))), Text(";"))),
        Joined((Many(_chars(" \t")), _optional(Text("\r")), Text("\n"), Many(_chars(" \t")))),
    )),
))  # fmt: skip
_STRING = Joined((Text('"'), Many(Either((_but('"\\'), _ESCAPE))), Text('"')))

_KEYWORD = Joined((Text(":"), Many(_chars("a-zA-Z0-9!$%&*/=>?@^_~<+.-", *_FOREIGN), 1)))
_HANDLE = Joined((Text("<"), _LETTER, Many(_chars("a-zA-Z0-9_-")), _optional(Text("*")), Text(">")))


def _type(depth: int) -> Pattern:
    """A type of an annotation, ``Word`` or ``List[Embedding]``, nested as deep as an atom may be."""
    name = Joined((_LETTER, Many(_chars("a-zA-Z0-9_-"))))
    if depth == 0:
        return name
    inner = _type(depth - 1)
    spaces = Many(_chars(" "))
    more = Many(Joined((Text(","), spaces, inner)))
    return Joined((name, _optional(Joined((Text("["), inner, more, Text("]"))))))


_PARAMETER = Either((Use("NAME"), Text("_")))
ANNOTATION = Joined((Text("::"), _type(2)))


def words(texts: Iterable[str]) -> Pattern:
    """One of several words, longest first."""
    return Either(tuple(Text(text) for text in sorted(texts, key=lambda text: (-len(text), text))))


def tokens(reserved: frozenset[str]) -> dict[str, Token]:
    """Every token by the name that rules know it by; ``reserved`` are the words that no name may be."""
    taken = reserved | {"none"}
    plain = reserved_names(taken)
    symbol = Either((_NAME, Text("@"), Text("...")))
    return {
        "NAME": Token(_NAME, "a name that is not reserved", plain),
        "ANNOTATED": Token(Joined((_PARAMETER, ANNOTATION)), "a name with its type, name::Type"),
        "SYMBOL": Token(symbol, "any symbol, as data", frozenset({"none"})),
        "TEMPLATE_SYMBOL": Token(symbol, "a symbol of a quasiquoted template", _TEMPLATE_WORDS | {"none"}),
        "PATTERN_SYMBOL": Token(
            Either((_NAME, Text("@"))), "a symbol of a macro's pattern", frozenset({"none", "..."})
        ),
        "NUMBER": Token(_NUMBER, "an integer or a float"),
        "STRING": Token(_STRING, "a string", is_word=False),
        "BOOLEAN": Token(words(("#t", "#f", "#true", "#false")), "a boolean"),
        "NONE": Token(Text("none"), "the value of nothing"),
        "KEYWORD": Token(_KEYWORD, "a keyword"),
        "ANNOTATED_KEYWORD": Token(
            Joined((Text(":"), Use("NAME"), ANNOTATION)), "a keyword with its type, :name::Type"
        ),
        "HANDLE": Token(_HANDLE, "an embedding handle"),
    }


_TEMPLATE_WORDS = frozenset({"quasiquote", "unquote", "unquote-splicing"})


def reserved_names(texts: Iterable[str]) -> frozenset[str]:
    """Those of ``texts`` that have the form of a name: keywords and dots are none anyway."""
    return frozenset(text for text in texts if text[0] not in ":.")
