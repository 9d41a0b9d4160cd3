"""What becomes of a folder of Python programs: `python benchmarks/modern_python.py FOLDER`.

Each program is translated, and its scene compared with what CPython builds (`tests/transpile/reference_model.py`,
which executes the programs: give it only those that you trust). A second folder gets the translations.

With `--arguments`, every word whose parameters all have defaults is called with one number changed at a time, to three
other values, in the translation and in CPython; values for which the Python raises an exception do not count.

A line for each program tells

- *equal*, *different* or *refused*, with the first difference or error;
- *evaluated* where a function that makes shapes was evaluated, and its loops and arguments are not those of the Python;
- the datums of the program, against the tokens of the Python; the seconds of CPU;
- what does not translate first, with its line, where data or functions are evaluated.
"""

from __future__ import annotations

import ast
import contextlib
import io
import re
import sys
import time
import tokenize
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))

from transpile.cases import first_difference, flattened
from transpile.reference_model import flatten

from scenelang.grammar.datum import Source, walk
from scenelang.grammar.diagnostics import Diagnostic
from scenelang.grammar.reader import read
from scenelang.interpreter.transpile.analysis.python_text import without_type_parameters
from scenelang.interpreter.transpile.translate import obstacles
from scenelang.session.session import Session

_LAYOUT = (
    tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENCODING,
    tokenize.ENDMARKER,
)  # fmt: skip
NOTE = "Evaluated from Python"


@dataclass(frozen=True, slots=True)
class Outcome:
    """What becomes of one program; ``detail`` is the first difference, or the error with its line."""

    name: str
    verdict: str
    detail: str = ""
    is_evaluated: bool = False
    obstacle: str = ""
    length: float = 0.0
    seconds: float = 0.0

    def line(self) -> str:
        flag = "evaluated" if self.is_evaluated else ""
        told = " | ".join(filter(None, (self.detail, self.obstacle)))
        return f"{self.name:36} {self.verdict:9} {flag:9} {self.length:6.2f} {self.seconds:6.2f}  {told}"


def outcome(path: Path, texts: Path | None = None) -> Outcome:
    """Translate a program and compare it with CPython; the translation is left in the folder ``texts``."""
    code = path.read_text("utf-8")
    session = Session()
    begin = time.process_time()
    translation = session.transpile(Source(str(path), code))
    seconds = time.process_time() - begin
    if not translation.ok:
        return Outcome(path.stem, "refused", _first(translation.diagnostics), seconds=seconds)
    if texts is not None:
        texts.mkdir(exist_ok=True)
        (texts / f"{path.stem}.scene").write_text(translation.text, "utf-8")
    result = session.evaluate(Source(f"{path.stem}.scene", translation.text))
    difference = _first(result.diagnostics) if result.scene is None else first_difference(
        flattened(result.scene), _expected(code)
    )  # fmt: skip
    verdict = "different" if difference else "equal"
    length = datums_in(translation.text) / tokens_in(code)
    obstacle = _first(tuple(obstacles(Source(str(path), code))))
    return Outcome(path.stem, verdict, difference or "", NOTE in translation.text, obstacle, length, seconds)


def _expected(code: str) -> object:
    code = _for_this_python(code)
    with contextlib.redirect_stdout(io.StringIO()):
        return flatten(code)


def _for_this_python(code: str) -> str:
    """Return a program without the type parameters of Python 3.12 where CPython is older."""
    lines = code.splitlines()
    plain = lines if sys.version_info >= (3, 12) else without_type_parameters(lines)
    return code if plain == lines else "\n".join(["from __future__ import annotations", *plain, ""])


def _first(diagnostics: tuple[Diagnostic, ...]) -> str:
    problem = next((d for d in diagnostics if d.is_error), None)
    if problem is None:
        return ""
    line = problem.span.source.text.count("\n", 0, problem.span.start) + 1 if problem.span is not None else 0
    return f"{line}: {problem.message}"


def datums_in(text: str) -> int:
    """Return the number of the datums of a program."""
    return sum(1 for _ in walk(*read(Source("<program>", text)).forms))


def tokens_in(code: str) -> int:
    """Return the number of the tokens of a program that are no comments, docstrings or layout."""
    docs = sum(
        isinstance(n, ast.Expr) and isinstance(n.value, ast.Constant) and isinstance(n.value.value, str)
        for n in ast.walk(ast.parse(_for_this_python(code)))
    )
    code = _for_this_python(code)
    return sum(t.type not in _LAYOUT for t in tokenize.generate_tokens(io.StringIO(code).readline)) - docs


def changed_arguments(path: Path) -> Counter[str]:
    """Call the words of a program with other numbers; returns how often the result is equal, different or an error."""
    code = _for_this_python(path.read_text("utf-8"))
    translation = Session().transpile(Source(str(path), code))
    found: Counter[str] = Counter()
    root = re.search(r'^\(scene "([^"]+)"\)', translation.text, re.M) if translation.ok else None
    for function in ast.parse(code).body:
        is_word = isinstance(function, ast.FunctionDef) and f'(bind "{function.name}"' in translation.text
        if root is None or not is_word or not isinstance(function, ast.FunctionDef):
            continue
        for name, value in _numbers_in(function):
            for other in (
                (value + 1, value + 2, max(value - 1, 1))
                if type(value) is int
                else (value * 1.25, value * 0.8, value * 1.5)
            ):
                if other != value:
                    text, is_root = translation.text.replace(root[0], ""), function.name == root[1]
                    verdict = _verdict(code, text, function.name, {name: other}, is_root=is_root)
                    found[verdict] += 1
                    if verdict in ("different", "error"):
                        print(f"    {path.stem}: {function.name}({name}={other:g}) {verdict}")
    print(f"{path.stem}: {dict(found)}", flush=True)
    return found


def _numbers_in(function: ast.FunctionDef) -> list[tuple[str, int | float]]:
    """Return the parameters of a function that have numbers as defaults; none if one has no default."""
    given = function.args
    positional = [*given.posonlyargs, *given.args]
    pairs = [*zip(positional, given.defaults), *zip(given.kwonlyargs, given.kw_defaults)]
    if len(given.defaults) < len(positional) or None in given.kw_defaults:
        return []
    defaults = [(a.arg, d.value) for a, d in pairs if isinstance(d, ast.Constant)]
    return [(name, value) for name, value in defaults if type(value) in (int, float)]


def _verdict(code: str, text: str, word: str, arguments: dict[str, int | float], *, is_root: bool) -> str:
    try:
        with contextlib.redirect_stdout(io.StringIO()):
            expected = flatten(code, call=(word, arguments))
    except Exception:
        return "skipped"
    keywords = ""
    for name, value in ((name.replace("_", "-"), value) for name, value in arguments.items()):
        old = rf"^\(param {name} [^\s)]+"
        text, count = re.subn(old, f"(param {name} {value!r}", text, flags=re.M) if is_root else (text, 0)
        keywords += "" if count else f" :{name} {value!r}"  # the root's parameters are params of the program
    result = Session().evaluate(Source("changed.scene", f'{text}\n(scene "{word}"{keywords})\n'))
    if result.scene is None:
        return "error"
    return "different" if first_difference(flattened(result.scene), expected) else "equal"


def main() -> int:
    if "--arguments" in sys.argv:
        paths = sorted(Path(sys.argv[1]).glob("*.py"))
        total = sum((changed_arguments(path) for path in paths), Counter[str]())
        print(", ".join(f"{number} {verdict}" for verdict, number in sorted(total.items())))
        return 0
    folder = Path(sys.argv[1])
    texts = Path(sys.argv[2]) if len(sys.argv) > 2 else None
    found = []
    for path in sorted(folder.glob("*.py")):
        found.append(outcome(path, texts))
        print(found[-1].line(), flush=True)
    equal = [each for each in found if each.verdict == "equal"]
    lengths = sorted(each.length for each in equal)
    for obstacle, number in Counter(each.obstacle.partition(": ")[2] for each in found).most_common():
        print(f"{number:4} {obstacle or 'nothing'}")
    print(
        f"{len(found)} programs: {len(equal)} equal, {sum(e.verdict == 'refused' for e in found)} refused, "
        f"{sum(e.verdict == 'different' for e in found)} different; {sum(e.is_evaluated for e in equal)} evaluated; "
        f"median length {lengths[len(lengths) // 2] if lengths else 0:.2f}, {sum(x > 3 for x in lengths)} above 3; "
        f"{sum(e.seconds for e in found):.0f} s"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
