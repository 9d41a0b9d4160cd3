"""Data model of a surface grammar: rules over literals and terminals, and the patterns of the terminals."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from importlib import resources
from types import MappingProxyType
from typing import TypeAlias

from scenelang.grammar.ast import STRICT_HEADS, STRICT_MEASURES, STRICT_OPERATORS
from scenelang.grammar.lazy_patterns import lazy_pattern


@dataclass(frozen=True, slots=True)
class Literal:
    """Literal text: a bracket, a prefix, or the word of a form."""

    text: str


@dataclass(frozen=True, slots=True)
class Terminal:
    """Reference to a terminal, by its name in upper case."""

    name: str


@dataclass(frozen=True, slots=True)
class Ref:
    """Reference to another rule, by its name in lower case."""

    name: str


@dataclass(frozen=True, slots=True)
class Sequence:
    """Concatenation of expressions."""

    items: tuple[Expression, ...]


@dataclass(frozen=True, slots=True)
class Choice:
    """Alternative expressions."""

    options: tuple[Expression, ...]


@dataclass(frozen=True, slots=True)
class Repeat:
    """Repetition of ``item``, at least ``minimum`` times, and at most once if ``once`` is set."""

    item: Expression
    minimum: int
    once: bool = False


Leaf: TypeAlias = Literal | Terminal | Ref
Expression: TypeAlias = Leaf | Sequence | Choice | Repeat


def written(expression: Expression, leaf: Callable[[Leaf], str], several: tuple[type, ...] = ()) -> str:
    """Write an expression in the notation shared by all formats: juxtaposition, ``|``, ``? * +`` and parentheses.

    Parameters
    ----------
    expression
        Expression to write.
    leaf
        Function that writes literals, terminals and references.
    several
        Leaf types that are written as more than one token, so that they need parentheses when repeated.
    """

    def grouped(item: Expression, *kinds: type) -> str:
        """Write a part, in parentheses if it is of one of the kinds."""
        text = written(item, leaf, several)
        return f"({text})" if isinstance(item, kinds) else text

    if isinstance(expression, Sequence):
        return " ".join(grouped(item, Choice) for item in expression.items)
    if isinstance(expression, Choice):
        return " | ".join(written(option, leaf, several) for option in expression.options)
    if isinstance(expression, Repeat):
        sign = "?" if expression.once else "+" if expression.minimum else "*"
        return grouped(expression.item, Choice, Sequence, *several) + sign
    return leaf(expression)


OPENERS = frozenset({"(", "[", "'", "`", ",", ",@", "#;"})  # the next token needs no white space before it
CLOSERS = frozenset({")", "]"})


# --- patterns of tokens --------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Chars:
    """Character class: one character of ``ranges`` (pairs of first and last code point), or others if ``negated``."""

    ranges: tuple[tuple[int, int], ...]
    negated: bool = False


@dataclass(frozen=True, slots=True)
class Text:
    """Literal characters."""

    text: str


@dataclass(frozen=True, slots=True)
class Joined:
    """Concatenation of patterns."""

    parts: tuple[Pattern, ...]


@dataclass(frozen=True, slots=True)
class Either:
    """Alternative patterns."""

    options: tuple[Pattern, ...]


@dataclass(frozen=True, slots=True)
class Many:
    """Repetition of ``part``, ``minimum`` to ``maximum`` times; None means unbounded."""

    part: Pattern
    minimum: int = 0
    maximum: int | None = None


@dataclass(frozen=True, slots=True)
class RuleUse:
    """Reference to the pattern of another token, by its name."""

    token: str


Pattern: TypeAlias = Chars | Text | Joined | Either | Many | RuleUse


@dataclass(frozen=True, slots=True)
class TerminalToken:
    """Definition of a terminal: it matches ``pattern``, except the words in ``excluded``.

    ``is_word`` means that white space must separate it from other words. ``title`` is a description for people.
    """

    pattern: Pattern
    title: str
    excluded: frozenset[str] = frozenset()
    is_word: bool = True


@dataclass(frozen=True, slots=True)
class Grammar:
    """Grammar: rules by name, including the ``start`` rule, and the tokens they use."""

    start: str
    rules: Mapping[str, Expression]
    tokens: Mapping[str, TerminalToken]
    title: str


def is_punctuation(text: str) -> bool:
    """Return whether a literal needs no white space around it."""
    return text in OPENERS or text in CLOSERS


def parts(expression: Expression) -> Iterator[Expression]:
    """Iterate over an expression and all its subexpressions."""
    yield expression
    if isinstance(expression, Sequence):
        below: tuple[Expression, ...] = expression.items
    elif isinstance(expression, Choice):
        below = expression.options
    else:
        below = (expression.item,) if isinstance(expression, Repeat) else ()
    for item in below:
        yield from parts(item)


def literals(rules: Mapping[str, Expression]) -> frozenset[str]:
    """Return the literal words of the rules, excluding brackets and prefixes."""
    nodes = (part for expression in rules.values() for part in parts(expression))
    return frozenset(part.text for part in nodes if isinstance(part, Literal) and not is_punctuation(part.text))


def used_terminals(rules: Mapping[str, Expression]) -> frozenset[str]:
    """Return the names of the terminals that occur in the rules."""
    nodes = (part for expression in rules.values() for part in parts(expression))
    return frozenset(part.name for part in nodes if isinstance(part, Terminal))


def sequence(*items: Expression) -> Expression:
    """Return the concatenation of ``items``, flattening nested sequences."""
    flat: list[Expression] = []
    for item in items:
        flat.extend(item.items if isinstance(item, Sequence) else (item,))
    return flat[0] if len(flat) == 1 else Sequence(tuple(flat))


def choice(*options: Expression) -> Expression:
    """Return the alternatives ``options``, flattening nested choices."""
    flat: list[Expression] = []
    for option in options:
        flat.extend(option.options if isinstance(option, Choice) else (option,))
    return flat[0] if len(flat) == 1 else Choice(tuple(flat))


# Parsing rules in Lark's notation: literals in quotes, ``*``, ``+``, ``?``, ``[optional]``, ``|``.


_TOKEN = lazy_pattern(r'"((?:[^"\\]|\\.)+)"|([A-Z][A-Z0-9_]*)|([a-z][a-z0-9_]*)|([()\[\]|*+?])|(\s+)')
_RULE = lazy_pattern(r"^\??([a-z][a-z0-9_]*)\s*:(.*(?:\n[ \t]+\|.*)*)", re.M)


def parse_rules(text: str) -> dict[str, Expression]:
    """Parse ``name: alternatives`` lines. An alternative may be on a separate line that starts with `|`."""
    return {name: parse_expression(body) for name, body in _RULE.findall(text)}


def parse_expression(text: str) -> Expression:
    """Parse one right-hand side; raise ``ValueError`` if it is malformed."""
    return _Parser(text).whole()


class _Parser:
    """Recursive-descent parser of a right-hand side."""

    def __init__(self, text: str) -> None:
        """Split ``text`` into tokens; raise ``ValueError`` where there is none."""
        self._tokens: list[tuple[str, str]] = []
        position = 0
        for match in _TOKEN.finditer(text):
            if match.start() != position:
                break
            position = match.end()
            if match.lastindex != 5:
                kind = ("literal", "terminal", "rule", "sign")[(match.lastindex or 1) - 1]
                self._tokens.append((kind, match[match.lastindex or 1]))
        if position != len(text):
            raise ValueError(f"malformed rule: {text[position:]!r}")

    def _peek(self) -> str:
        """Return the next token if it is a sign, else an empty string."""
        return self._tokens[0][1] if self._tokens and self._tokens[0][0] == "sign" else ""

    def whole(self) -> Expression:
        """Parse all tokens as one expression."""
        expression = self._choice()
        if self._tokens:
            raise ValueError(f"malformed rule at {self._tokens[0][1]!r}")
        return expression

    def _choice(self) -> Expression:
        options = [self._sequence()]
        while self._peek() == "|":
            self._tokens.pop(0)
            options.append(self._sequence())
        return choice(*options)

    def _sequence(self) -> Expression:
        items = []
        while self._tokens and self._peek() not in ("|", ")", "]"):
            items.append(self._repeated())
        if not items:
            raise ValueError("empty alternative")
        return sequence(*items)

    def _repeated(self) -> Expression:
        item = self._item()
        while self._peek() in ("*", "+", "?") and self._peek():
            sign = self._tokens.pop(0)[1]
            item = Repeat(item, 1 if sign == "+" else 0, once=sign == "?")
        return item

    def _item(self) -> Expression:
        """Parse a leaf or a group; ``[a]`` is Lark's other spelling of ``(a)?``."""
        kind, text = self._tokens.pop(0)
        if kind == "literal":
            return Literal(text.replace('\\"', '"').replace("\\\\", "\\"))
        if kind == "terminal":
            return Terminal(text)
        if kind == "rule":
            return Ref(text)
        inner = self._choice()
        closing = {"(": ")", "[": "]"}.get(text)
        if closing is None or not self._tokens or self._tokens.pop(0) != ("sign", closing):
            raise ValueError(f"malformed rule at {text!r}")
        return Repeat(inner, 0, once=True) if text == "[" else inner


def substitute(expression: Expression, replacements: Mapping[str, Expression]) -> Expression:
    """Replace terminals in ``expression`` by the entries of ``replacements`` with their names."""
    if isinstance(expression, Terminal):
        return replacements.get(expression.name, expression)
    if isinstance(expression, Sequence):
        return sequence(*(substitute(item, replacements) for item in expression.items))
    if isinstance(expression, Choice):
        return choice(*(substitute(option, replacements) for option in expression.options))
    if isinstance(expression, Repeat):
        return Repeat(substitute(expression.item, replacements), expression.minimum, expression.once)
    return expression


# Patterns of tokens as regular expressions that are valid in both Python and Rust.


_SPECIAL = frozenset(r".^$*+?{}[]\|()/-&~#")
_NAMED = {"\n": r"\n", "\t": r"\t", "\r": r"\r"}


def regex(pattern: Pattern, uses: Mapping[str, str] = MappingProxyType({})) -> str:
    """Return a pattern as a regular expression; `/` is escaped because Lark delimits regular expressions with it.

    ``uses`` maps the tokens that the pattern refers to to their regular expressions.
    """
    if isinstance(pattern, Chars):
        return _class(pattern)
    if isinstance(pattern, Text):
        return "".join(_character(c) for c in pattern.text)
    if isinstance(pattern, Joined):
        return "".join(_part(part, uses) for part in pattern.parts)
    if isinstance(pattern, Either):
        return "|".join(regex(option, uses) for option in pattern.options)
    if isinstance(pattern, RuleUse):
        return uses[pattern.token]
    return _part(pattern.part, uses, is_repeated=True) + _times(pattern)


def _part(pattern: Pattern, uses: Mapping[str, str], *, is_repeated: bool = False) -> str:
    """Return a pattern as a part of a longer one, in parentheses if necessary."""
    text = regex(pattern, uses)
    simple = isinstance(pattern, Chars) or (isinstance(pattern, Text) and len(pattern.text) == 1)
    if isinstance(pattern, (Either, RuleUse)) or (is_repeated and not simple):
        return f"(?:{text})"
    return text


def _times(pattern: Many) -> str:
    """Return the quantifier of a repetition."""
    minimum, maximum = pattern.minimum, pattern.maximum
    if maximum is None:
        return {0: "*", 1: "+"}.get(minimum, f"{{{minimum},}}")
    if (minimum, maximum) == (0, 1):
        return "?"
    return f"{{{minimum}}}" if minimum == maximum else f"{{{minimum},{maximum}}}"


def _class(chars: Chars) -> str:
    """Return a character class; one of a single character needs no brackets."""
    ranges = [
        _character(chr(first)) + ("" if first == last else f"-{_character(chr(last))}") for first, last in chars.ranges
    ]
    if len(ranges) == 1 and not chars.negated and chars.ranges[0][0] == chars.ranges[0][1]:
        return ranges[0]
    return f"[{'^' if chars.negated else ''}{''.join(ranges)}]"


def _character(character: str) -> str:
    """Return a character as a regular expression, in ASCII."""
    if character in _NAMED:
        return _NAMED[character]
    if ord(character) > 126:
        return f"\\u{ord(character):04x}"
    return f"\\{character}" if character in _SPECIAL else character


# The paper's grammar over text, from the strict rules of ``core.lark``.


_BRACKETS = {"LPAR": "(", "RPAR": ")", "LSQB": "[", "RSQB": "]"}


def strict_rules() -> dict[str, Expression]:
    """Return the rules of the strict language by name, as a grammar over text.

    ``core.lark`` is a grammar over datums: its terminals are the classes of datums. Each terminal is replaced by what a
    program has in its place: a word, a bracket, or a rule for a class of words.
    """
    grammar = resources.files("scenelang.grammar").joinpath("core.lark").read_text(encoding="utf-8")
    rules = parse_rules(grammar[grammar.index("strict_start:") :])  # they come last in the file
    rules["start"] = rules.pop("strict_start")
    spellings = {terminal: head for head, terminal in STRICT_HEADS.items()} | _BRACKETS
    replacements: dict[str, Expression] = {terminal: Literal(spelling) for terminal, spelling in spellings.items()}
    # Each of these terminals stands for several words, which are the options of a rule.
    replacements |= {"OPERATOR": Ref("operator"), "MEASURE": Ref("measure"), "PARAMETER": Ref("parameter")}
    value = rules.pop("strict_value")
    rules = {name: substitute(expression, replacements) for name, expression in rules.items()}
    untyped = {**replacements, "PARAMETER": Terminal("NAME")}  # only parameters of functions have type annotations
    rules["strict_value"] = substitute(value, untyped)
    rules["operator"] = choice(*(Literal(word) for word in sorted(STRICT_OPERATORS)))
    rules["measure"] = choice(*(Literal(word) for word in sorted(STRICT_MEASURES)))
    rules["parameter"] = parse_expression("NAME | ANNOTATED")
    return rules


# The language's tokens as patterns that every format can express. `reader.py` is authoritative; tests compare the two.


# Non-ASCII letters and symbols that are assigned, printable and not white space in all versions of Unicode in use.
_FOREIGN = (
    (0xC0, 0x24F), (0x391, 0x3A1), (0x3A3, 0x3FF), (0x400, 0x52F), (0x2190, 0x21FF), (0x2200, 0x22FF),
    (0x3041, 0x3096), (0x30A1, 0x30FA), (0x4E00, 0x9FA5),
)  # fmt: skip


def _chars(text: str, *ranges: tuple[int, int]) -> Chars:
    """Return the class of the characters in ``text`` (``a-z`` for a range) and in ``ranges``."""
    members = list(ranges)
    position = 0
    while position < len(text):
        if text[position + 1 : position + 2] == "-" and position + 2 < len(text):
            members.append((ord(text[position]), ord(text[position + 2])))
            position += 3
        else:
            members.append((ord(text[position]), ord(text[position])))
            position += 1
    return Chars(tuple(sorted(members)))


def _but(text: str) -> Chars:
    """Return the class of all characters except those in ``text``."""
    return Chars(_chars(text).ranges, negated=True)


_LETTER = _chars("a-zA-Z")
_DIGIT = _chars("0-9")
NAME_START = _chars("a-zA-Z!$%&*/=>?^_~", *_FOREIGN)  # excludes signs, `<` and `@`, because `,@` is a prefix
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


def _hex(minimum: int, maximum: int | None = None) -> Pattern:
    return Many(_HEX, minimum, maximum or minimum)


_FOUR = (  # hexadecimal digits of a code point, excluding surrogates
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
    """Return the pattern of an annotation's type, such as ``List[Embedding]``, nested up to ``depth`` levels."""
    name = Joined((_LETTER, Many(_chars("a-zA-Z0-9_-"))))
    if depth == 0:
        return name
    inner = _type(depth - 1)
    spaces = Many(_chars(" "))
    more = Many(Joined((Text(","), spaces, inner)))
    return Joined((name, _optional(Joined((Text("["), inner, more, Text("]"))))))


_PARAMETER = Either((RuleUse("NAME"), Text("_")))
ANNOTATION = Joined((Text("::"), _type(2)))


def words(texts: Iterable[str]) -> Pattern:
    """Return a pattern for one of several words, longest first."""
    return Either(tuple(Text(text) for text in sorted(texts, key=lambda text: (-len(text), text))))


def tokens(reserved: frozenset[str]) -> dict[str, TerminalToken]:
    """Return all tokens by the name used in rules; ``reserved`` are the words that cannot be names."""
    unavailable = reserved | {"none"}
    plain = reserved_names(unavailable)
    symbol = Either((_NAME, Text("@"), Text("...")))
    return {
        "NAME": TerminalToken(_NAME, "a name that is not reserved", plain),
        "ANNOTATED": TerminalToken(Joined((_PARAMETER, ANNOTATION)), "a name with its type, name::Type"),
        "SYMBOL": TerminalToken(symbol, "any symbol, as data", frozenset({"none"})),
        "TEMPLATE_SYMBOL": TerminalToken(symbol, "a symbol of a quasiquoted template", _TEMPLATE_WORDS | {"none"}),
        "PATTERN_SYMBOL": TerminalToken(
            Either((_NAME, Text("@"))), "a symbol of a macro's pattern", frozenset({"none", "..."})
        ),
        "NUMBER": TerminalToken(_NUMBER, "an integer or a float"),
        "STRING": TerminalToken(_STRING, "a string", is_word=False),
        "BOOLEAN": TerminalToken(words(("#t", "#f", "#true", "#false")), "a boolean"),
        "NONE": TerminalToken(Text("none"), "the value none"),
        "KEYWORD": TerminalToken(_KEYWORD, "a keyword"),
        "ANNOTATED_KEYWORD": TerminalToken(
            Joined((Text(":"), RuleUse("NAME"), ANNOTATION)), "a keyword with its type, :name::Type"
        ),
        "HANDLE": TerminalToken(_HANDLE, "an embedding handle"),
    }


_TEMPLATE_WORDS = frozenset({"quasiquote", "unquote", "unquote-splicing"})


def reserved_names(texts: Iterable[str]) -> frozenset[str]:
    """Return the words of ``texts`` that would otherwise be names, unlike keywords and dots."""
    return frozenset(text for text in texts if text[0] not in ":.")
