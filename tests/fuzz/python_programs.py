"""Small random Python programs in the manner of language models, with texts, names and closures in odd places."""

from __future__ import annotations

from random import Random

TEXTS = (
    "a", "b c", "(print 1)", 'say "x"', "tab\there", "two\nlines", "bell\x07", "|# #|", "; no", "\u2028", "\u202eabc",
    "λ", "\\", "{}", "%d", "#|", "\x85x", "nul\x00", "'", "`,@",
)  # fmt: skip
WORDS = ("part", "other_part", "naïve", "λx", "nan", "list", "define", "cube", "x1")
KEYS = ("scale", "radius", "color", "a_b", "λ", "my-key", "t", "none")


class PythonPrograms:
    """Draws programs one after another."""

    def __init__(self, seed: int) -> None:
        self.random = Random(seed)
        self.count = 0

    def program(self) -> str:
        """The text of a response or of a Python file."""
        pick = self.random
        self.count = 0
        lines: list[str] = []
        if pick.random() < 0.3:
            lines.append(self._text(docstring=True))
        lines.append("from helper import *")
        if pick.random() < 0.3:
            lines.append("# " + pick.choice(TEXTS).replace("\n", " ").replace("\x00", " ").replace("\r", " "))
        words = pick.sample(WORDS, pick.randint(1, 2))
        for position, word in enumerate(words):
            lines += self._function(word, words[:position])
        code = "\n".join(lines) + "\n"
        if pick.random() < 0.3:
            return f"Here it is; (really)\n```python\n{code}```\nand that is all #| of it\n"
        return code

    def _name(self) -> str:
        self.count += 1
        return self.random.choice(("x", "y", "size", "λ", "inf", "sum_of", "T")) + str(self.count)

    def _text(self, docstring: bool = False) -> str:
        text = self.random.choice(TEXTS)
        if docstring:
            return '"""' + text.replace("\\", "").replace('"', "").replace("\x00", "") + '\n```python\nx\n```\n"""'
        return repr(text)

    def _function(self, word: str, words: list[str]) -> list[str]:
        pick = self.random
        parameter = pick.choice(("n: int = 2", "n=3", ""))
        names = ["n"] if parameter else []
        lines = [
            "",
            "@register(%s)" % (self._text() if pick.random() < 0.3 else ""),
            f"def {word}({parameter}) -> Shape:",
        ]
        if pick.random() < 0.3:
            lines.append("    " + self._text(docstring=True))
        for _ in range(pick.randint(1, 4)):
            lines += ["    " + line for line in self._statement(names)]
        lines.append(f"    return {self._shape(names, words, 2)}")
        return lines

    def _statement(self, names: list[str]) -> list[str]:
        pick, name = self.random, self._name()
        kind = pick.randrange(9)
        if kind == 0:
            names.append(name)
            return [f"{name} = {self._number(names[:-1], 2)}"]
        if kind == 1:
            return [f"print({self._value(names, 2)}, {self._text()})"]
        if kind == 2:
            body = pick.choice(("lambda: i", "lambda i=i: i", "lambda: (i, 1)", "i * 2", "lambda: [i][0]"))
            call = "f()" if "lambda" in body else "f"
            return [f"{name} = [{body} for i in range(3)]", f"print([{call} for f in {name}])"]
        if kind == 3:
            return [
                f"{name} = []", "for j in range(3):", f"    {name}.append(lambda: j + {self._number(names, 1)})",
                f"print([f() for f in {name}])",
            ]  # fmt: skip
        if kind == 4:
            left, right = pick.choice(("(1, 2)", "[1, 2]", "(1, 2, 3)")), pick.choice(("(1, 2)", "[1, 2]", "[]"))
            return [f"print({left} == {right}, {left} in [{right}], [{left}].count({right}))"]
        if kind == 5:
            return [f"print(f'{{{self._number(names, 1)}}}' + {self._text()})"]
        if kind == 6:
            return [f"if {self._number(names, 1)} > 1:", f"    print({self._text()})", "else:", "    print('less')"]
        if kind == 7:
            key = pick.choice(TEXTS)
            return [f"{name} = {{{key!r}: 1, 'k': {self._number(names, 1)}}}", f"print({name}[{key!r}], len({name}))"]
        return [f"{name} = {self._number(names, 1)}  # {pick.choice(('why', '|#', ') (print 2)'))}", f"print({name})"]

    def _value(self, names: list[str], depth: int) -> str:
        pick = self.random
        if pick.random() < 0.3:
            return self._text()
        return pick.choice((self._number(names, depth), f"[{self._number(names, depth)}]", "None", "True"))

    def _number(self, names: list[str], depth: int) -> str:
        pick = self.random
        if depth <= 0 or pick.random() < 0.4:
            return pick.choice(names) if names and pick.random() < 0.5 else pick.choice(("1", "2", "0.5", "3", "0x10"))
        operator = pick.choice(("+", "*", "-"))
        return f"({self._number(names, depth - 1)} {operator} {self._number(names, depth - 1)})"

    def _shape(self, names: list[str], words: list[str], depth: int) -> str:
        pick = self.random
        if depth <= 0 or pick.random() < 0.3:
            key = pick.choice(KEYS) if pick.random() < 0.3 else "scale"
            value = "(1, 0, 0)" if key == "color" else self._number(names, 1)
            return f"primitive_call('cube', shape_kwargs={{{key!r}: {value}}})"
        down = self._shape(names, words, depth - 1)
        choices = [
            f"concat_shapes({down}, {down})",
            f"transform_shape({down}, translation_matrix((np.random.rand(), {self._number(names, 1)}, 0)))",
            f"loop(2, lambda k: transform_shape({down}, translation_matrix((k, 0, 0))))",
            f"transform_shape({down}, np.vstack([rotation_matrix(1, (0, 1, 0), (0, 0, 0))[:3], np.eye(4)[3:]]))",
        ]
        if words:
            choices.append(f"library_call({pick.choice(words)!r})")
        return pick.choice(choices)
