"""Spoilt Python: the translation never fails with anything but a diagnostic that points into the text."""

from __future__ import annotations

import random
import traceback
import zlib
from pathlib import Path

import pytest
from copies import command
from sampling import one_in
from searching import many

from scenelang.grammar.datum import Source, print_datum
from scenelang.grammar.reader import read
from scenelang.interpreter.transpile.translate import Translation
from scenelang.session.session import Session
from transpile.cases import CORPUS, IMITATIONS, Case, told
from transpile.mutants import CHANGES, mutant

PER_PROGRAM = 1 if many(100) < 100 else 25
SESSION = Session()

# Python's own mistakes that only show when a program runs: a name read before it is assigned.
_MAY_BE_FOUND_LATER = {"unbound"}


def _mutants(case: Case, count: int) -> list[str]:
    rng = random.Random(zlib.crc32(case.name.encode()))
    return [mutant(rng, case.code) for _ in range(count)]


def _complaint(code: str) -> str | None:
    """What is wrong with the outcome of the translation; None when nothing is."""
    source = Source("mutant.py", code)
    literal = zlib.crc32(code.encode("utf-8", "surrogatepass")) % 2 == 0  # the other half is lifted
    try:
        translation = SESSION.transpile(source, literal)
    except Exception:
        return traceback.format_exc(limit=-4)
    return _about_program(translation, literal) if translation.ok else _about_errors(translation, source)


def _about_errors(translation: Translation, source: Source) -> str | None:
    if translation.text or translation.forms:
        return "there are errors and a program"
    for diagnostic in translation.diagnostics:
        span = diagnostic.span
        if span is None or span.source is not source or not 0 <= span.start <= span.end <= len(source.text):
            return f"out of place: {diagnostic}"
        is_own = (
            diagnostic.code[:2] in ("E1", "E3", "E4", "E6", "E8", "W4", "W8") or diagnostic.name == "idle-attribute"
        )
        if not diagnostic.message or not is_own:
            return f"not the translation's: {diagnostic}"
    told(translation.diagnostics)
    return None


def _about_program(translation: Translation, literal: bool) -> str | None:
    result = read(Source("<translation>", translation.text))
    if result.diagnostics:
        return f"it does not read: {told(result.diagnostics)}\n{translation.text}"
    if literal and [print_datum(form) for form in result.forms] != [print_datum(form) for form in translation.forms]:
        return f"it reads back otherwise:\n{translation.text}"
    errors = [d for d in SESSION.check(Source("<translation>", translation.text)).diagnostics if d.is_error]
    if any(d.name not in _MAY_BE_FOUND_LATER for d in errors):
        return f"it does not check: {told(errors)}\n{translation.text}"
    return None


@pytest.mark.search
@pytest.mark.parametrize("case", [*CORPUS, *one_in(3, IMITATIONS)], ids=lambda case: case.name)
@pytest.mark.sampled(8)
def test_spoilt_programs(case: Case) -> None:
    for code in _mutants(case, PER_PROGRAM):
        complaint = _complaint(code)
        assert complaint is None, f"{complaint}\n--- the Python:\n{code}"


@pytest.mark.slow
def test_mutants_are_of_both_kinds() -> None:
    """Some of the spoilt programs are still translated, others are not: both are tried."""
    outcomes = [SESSION.transpile(Source("mutant.py", code)).ok for case in CORPUS[:6] for code in _mutants(case, 3)]
    assert 0.1 < sum(outcomes) / len(outcomes) < 0.9


def test_every_change_changes_something() -> None:
    rng = random.Random(1)
    code = CORPUS[0].code
    for change in set(CHANGES):
        assert any(change(rng, code) != code for _ in range(10)), change


# --- found by the tests above, as small as they go -----------------------------------------------------------------

CAR = "@register()\ndef car():\n    return primitive_call('cube')\n"
FOUND = {
    "yield outside": "yield\n" + CAR,
    "return outside": "return\n" + CAR,
    "await outside": "await x\n" + CAR,
    "nonlocal of a local": "def f():\n    x = 0\n    nonlocal x\n" + CAR,
    "nonlocal of nothing": "def f():\n    nonlocal x\n" + CAR,
    "nonlocal in a pair": "def f():\n    x, y = 1, 2\n    nonlocal x\n" + CAR,
    "global after use": "def f():\n    x = 0\n    global x\n" + CAR,
    "shuffle of something": "colors = [()]\nself.shuffle(colors)\n" + CAR,
    "an append under if at top": "xs = []\nfor z in ():\n    if .2: xs.append(1)\n    elif 93: xs.append(2)\n" + CAR,
    "a name of an except": "try:\n    x = 1\nexcept:\n    y = [()]\n" + CAR,
    "a name after return": "@register()\ndef car():\n    return (primitive_call('cube'), x)\n    x = ()\n",
    "a word defined in try": "try:\n    @register()\n    def car(): return primitive_call('cube')\nexcept:\n    x = [()]\n",
    "a key of bytes": "@register()\ndef car():\n    return primitive_call('cube', shape_kwargs={b'x': 1})\n",
    "two equal parameters": "@register()\ndef car(width, width): return primitive_call('cube')\n",
    "two equal parameters, by name": "def f(*a, b, c=1, b=2): return a\n" + CAR,
    "two equal rests": "def f(*a, **a): return a\n" + CAR,
    "two equal keywords": "@register()\ndef car(): return primitive_call('cube', color=1, color=2)\n",
    "break outside": "break\n" + CAR,
    "continue in a function": "def f():\n    continue\n" + CAR,
    "a star alone": "x = *y\n" + CAR,
    "two stars": "*a, *b = 1, 2\n" + CAR,
    "del of a call": "def f(): del f()\n" + CAR,
    "assignment to a constant": "None = 1\n" + CAR,
    "a parameter named None": "def f(None): pass\n" + CAR,
    "an annotation alone": "x: int\n" + CAR,
    "read before it is assigned": "@register()\ndef car():\n    x = primitive_call('cube', shape_kwargs={'scale': x})\n    return x\n",
    "np as a variable": "@register()\ndef car():\n    np = 5\n    xs = list()\n    np.random.shuffle(xs)\n    return xs\n",
    "a special form after return": "@register()\ndef car():\n    return (scene, ())\n    scene = 5\n",
    "a name read before it is bound in a branch": "@register()\ndef car():\n    if True:\n        x = primitive_call('cube')\n    return x\n",
    "nul": CAR + "\0\n",
    "surrogate": CAR + "x = '\\ud800'\n",
    "form feed": "\f\n" + CAR,
    "other line ends": CAR.replace("\n", "\r"),
    "unicode line ends": "# a\u2028b\n" + CAR,
    "a name that is not ASCII": "größe = 1\n" + CAR.replace("'cube'", "'cube', shape_kwargs={'scale': größe}"),
    "a name that Python folds": "\ufb01x = 1\nfix = 2\n" + CAR,
    "a line that goes on": "x = 1 + \\\n    2\n" + CAR,
    "a line that goes on at the end": CAR + "x = \\",
    "names with odd signs": "def __(): return 1\n_ = __()\n__x__ = _\n" + CAR,
    "a huge number": "x = 1" + "0" * 5000 + "\n" + CAR,
    "a number out of range": "x = 1e999\ny = -1e999\n" + CAR,
    "a long line": "x = [" + "1, " * 20_000 + "]\n" + CAR,
    "much text": "x = '" + "a" * 200_000 + "'\n" + CAR,
}  # fmt: skip


@pytest.mark.parametrize("name", FOUND)
@pytest.mark.sampled(2)
def test_small_programs(name: str) -> None:
    complaint = _complaint(FOUND[name])
    assert complaint is None, f"{complaint}\n--- the Python:\n{FOUND[name][:500]}"


@pytest.mark.parametrize("depth", [50, 150, 1_000, 20_000])
@pytest.mark.parametrize(
    "nested",
    [
        "({})",
        "[{}]",
        "-{}",
        "not {}",
        "f({})",
        "{} + 1",
        "{}.x",
        "{}[0]",
        "(lambda: {})()",
        "1 if {} else 2",
        "{{1: {}}}",
    ],
)
@pytest.mark.sampled(2)
def test_depth(nested: str, depth: int) -> None:
    """Deep expressions are translated or rejected; nothing overflows."""
    before, _, after = nested.replace("{{", "{").replace("}}", "}").partition("{}")
    complaint = _complaint(f"f = abs\nx = {before * depth}1{after * depth}\n{CAR}")
    assert complaint is None, complaint[:2000]


@pytest.mark.parametrize("depth", [15, 30, 90, 400])
@pytest.mark.parametrize("head", ["if x:", "for i in x:", "while x:", "def f(x):", "try:"])
@pytest.mark.sampled(3)
def test_depth_of_blocks(head: str, depth: int, tmp_path: Path) -> None:
    """In a process of its own. The time must not double with each level."""
    lines = [" " * i + head for i in range(depth)] + [" " * depth + "x = x + 1"]
    if head == "try:":
        lines += [line for i in reversed(range(depth)) for line in (" " * i + "except Exception:", " " * i + " pass")]
    (tmp_path / "deep.py").write_text("x = 1\n" + "\n".join(lines) + "\n" + CAR)
    done = command("transpile", "deep.py", folder=tmp_path)
    assert done.returncode in (0, 1)
    assert "Traceback" not in done.stderr
    assert ("error[E" in done.stderr) == (done.returncode == 1)
