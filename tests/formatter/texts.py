"""Generated texts for the formatter: programs with comments and white space in every place."""

from __future__ import annotations

from random import Random

from scenelang.interpreter.expand.forms import FORMS

INDENTS = {name: form.indent for name, form in FORMS.items()}

_HEADS = [*INDENTS, "call", "table", "transform", "union", "list", "+", "f", "a-rather-long-name", "@", "mine"]
_ATOMS = [
    *("x", "y", ":key", ":p0", ":p1", "...", "=>", "else", "_", "@x", "1", "1e-3", ".50", "+7", "#t", "#true", "none"),
    *("<z1>", "<=", "xs::List[Tuple[A, B]]", ":c::Vector", '"text"', '"two\n  lines"', '"; no comment"', '"#| no |#"'),
    *('"crlf\r\n  inside"', "an-atom-of-some-length", "0.1234567890123"),
]
_LINE_COMMENTS = [";", "; why", ";;; loud  ", ";; two", ";a #| b", '; "', "; fmt: skip", "; fmt: off", "; fmt: on"]
_BLOCKS = ["#| block |#", "#| of\n   two lines |#", "#| nested #| more |# |#", '#| " |#', "#|;|#"]
_BLANKS = [" ", " ", " ", "\n", "\n", "\n  ", "\n\n", "  \n\t\n \n", "\t", "\f", "\r\n", "\r\n\r\n  "]


class Writer:
    """Writes a random text. ``odd``: how often a gap holds comments; ``off``: whether comments may turn formatting
    off."""

    def __init__(self, random: Random, odd: float, off: bool) -> None:
        self.random, self.odd = random, odd
        self.comments = _LINE_COMMENTS if off else _LINE_COMMENTS[:-3]

    def text(self) -> str:
        forms = self.random.randint(0, 4)
        return "".join(self.gap(2) + self.datum(self.random.randint(0, 5)) for _ in range(forms)) + self.gap(2)

    def gap(self, depth: int) -> str:
        """White space that keeps tokens apart, perhaps with comments in it."""
        choose = self.random.choice
        if self.random.random() > self.odd:
            return choose(_BLANKS)
        found = [choose(_BLANKS)]
        for _ in range(self.random.randint(1, 3)):
            kind = self.random.randint(0, 4)
            if kind < 2:
                found.append(choose(self.comments) + choose(["\n", "\n\n", "\r\n  "]))
            elif kind < 4:
                found.append(choose(_BLOCKS))
            else:
                found.append("#;" + (self.gap(0) if self.random.random() < 0.1 else "") + self.datum(min(depth, 2)))
            found.append(choose([" ", "", "\n", *_BLANKS]))
        return "".join(found) + " "

    def datum(self, depth: int) -> str:
        choose, chance = self.random.choice, self.random.random
        if depth <= 0 or chance() < 0.2:
            return choose(_ATOMS)
        if chance() < 0.1:
            return choose(["'", "`", ",", ",@"]) + (self.gap(0) if chance() < 0.1 else "") + self.datum(depth - 1)
        head = choose(_HEADS) if chance() < 0.8 else ""
        items = "".join(self.gap(depth - 1) + self.datum(depth - 1) for _ in range(self.random.randint(0, 5)))
        last = self.gap(depth - 1) if chance() < 0.3 else ""
        if items and chance() < 0.05:
            return f"({items}{self.gap(0)}. {self.datum(depth - 1)}{last})"
        return f"[{items}{last}]" if chance() < 0.1 else f"({head}{items}{last})"


def text_of(seed: int) -> str:
    """A random text, the same for the same seed; without or with a few or many comments."""
    random = Random(seed)
    return Writer(random, random.choice([0, 0.03, 0.1, 0.4]), random.random() < 0.3).text()
