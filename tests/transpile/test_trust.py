"""Nothing of the Python becomes code that it was not, and what the language does not have is not silently different."""

from __future__ import annotations

import contextlib
import io

import numpy as np
import pytest

from scenelang.grammar.datum import Source
from scenelang.grammar.diagnostics import Diagnostic
from scenelang.grammar.reader import read
from scenelang.interpreter.scene.flatten import flatten
from scenelang.interpreter.transpile.analysis.python_text import find_code
from scenelang.interpreter.transpile.translate import Translation, translate
from scenelang.interpreter.transpile.writing.code import misread
from scenelang.session.session import Session
from transpile.cases import told

CUBE = "primitive_call('cube', shape_kwargs={'scale': 1})"


def scene(*lines: str, result: str = CUBE) -> str:
    body = "".join(f"    {line}\n" for text in lines for line in text.split("\n"))
    return f"from helper import *\n@register()\ndef scene() -> Shape:\n{body}    return {result}\n"


def written(code: str) -> Translation:
    return translate(Source("<response>", code))


def errors(code: str) -> list[Diagnostic]:
    return [d for d in written(code).diagnostics if d.is_error]


def heads(code: str) -> list[str]:
    """The heads of the forms that a translation reads as; it must read."""
    translation = written(code)
    assert translation.text, told(translation.diagnostics)
    result = read(Source("<translation>", translation.text))
    assert not result.diagnostics
    return [form.items[0].value for form in result.forms]


# --- text that stays text ------------------------------------------------------------------------------------------

INJECTED = 'x 1) (print "INJECTED") (call "cube" :y'


@pytest.mark.parametrize("key", [INJECTED, "", "a b", "a:b", "a::b", "a|b", "a\nb", "a;b", "#t)", "a\u202eb", "a{b"])
def test_names_of_attributes_are_one_word(key: str) -> None:
    code = scene(result=f"primitive_call('cube', shape_kwargs={{'scale': 1, {key!r}: 1}})")
    (problem,) = errors(code)
    assert problem.name == "python-call"
    assert problem.span is not None
    assert problem.span.text == repr(key)


@pytest.mark.parametrize("key", ["a_b", "λ", "t", "none", "my-key", "1x"])
def test_other_names_of_attributes_are_written(key: str) -> None:
    code = scene(result=f"primitive_call('cube', shape_kwargs={{'scale': 1, {key!r}: 1}})")
    assert heads(code) == ["bind", "scene"]


ODD = "(print 1)|#\\r(print 2)\\x00 #|\\u2028(print 3)\\x0b(print 4)\\x85(print 5)\\u202e\\ud800"


@pytest.mark.parametrize(
    "code",
    [
        scene(f'"""{ODD}"""'),
        scene(f'"""first\\n{ODD}"""').replace("register()", f"register('{ODD}')"),
        f'"""{ODD}"""\n' + scene(),
        f"# {'(print 1)|# ;; #|'}\x0b(print 2)\x1c(print 3)\n" + scene("x = 1  # a\x0c(print 4)"),
        f"(print 0)\r(print 1)\u2028(print 2)\x00 #|\n```python\n{scene()}```\n|# (print 3)\x85(print 4)\n",
    ],
    ids=["docstring", "registration", "opening", "comments", "prose"],
)
def test_texts_never_leave_their_comments(code: str) -> None:
    assert heads(code) == ["bind", "scene"]
    text = written(code).text
    assert text.splitlines() == text.split("\n")[:-1]  # nothing else ends a line anywhere
    text.encode()


def test_numbers_that_the_language_cannot_read_are_refused() -> None:
    (problem,) = errors(scene(f"x = 0x{'f' * 15_000}\nprint(x)"))
    assert problem.name == "python-unsupported"
    assert problem.message == "this number has too many digits"


def test_endless_numbers_are_no_variables() -> None:
    code = scene("inf = 3\nx = 1_0e4_00\nprint(x > 10, -x < 10, inf)")
    assert log(code) == ["True True 3"]


@pytest.mark.parametrize(
    "text", ["", '(bind "a" b)', '(bind "a" [1])', '(bind "a" (1 . 2))', '(bind "a" (1', "(x) (y)"]
)
def test_the_net_finds_what_reads_differently(text: str) -> None:
    forms = read(Source("<a>", '(bind "a" (1 2))')).forms
    span = forms[0].span
    assert misread(forms, '(bind "a"\n (1 2)) ; same', span) is None
    assert misread(forms, text, span) is not None


def test_fields_of_named_tuples_are_names() -> None:
    code = "from collections import namedtuple\nP = namedtuple('P', 'x y)(print 1')\n" + scene("print(P(1, 2))")
    assert errors(code)


# --- a whole file of Python ----------------------------------------------------------------------------------------

FENCED = scene() + '"""\nYou can call it:\n\n```python\nspider = library_call(\'scene\')\n```\n"""\n'


def test_a_text_that_is_python_is_not_prose() -> None:
    found = find_code(FENCED)
    assert (found.start, found.end, found.before, found.after) == (0, len(FENCED), "", "")
    assert not errors(FENCED)
    indented = "\n".join("    " + line if line else "" for line in FENCED.split("\n"))
    assert find_code(indented).ignored == 0
    assert find_code(indented).start == 0


@pytest.mark.parametrize("around", ["Here:\n\n{}\nDone.", '"""\n{}\n"""', "{}"])
def test_a_response_is_read_by_its_fence(around: str) -> None:
    text = around.format(f"```python\n{scene()}```\n")
    found = find_code(text)
    assert text[found.start : found.end] == scene()


# --- matrices ------------------------------------------------------------------------------------------------------

R, T = "rotation_matrix(0.5, (0, 1, 0), (0, 0, 0))", "translation_matrix((1, 2, 3))"
ROTATION = np.array([[np.cos(0.5), 0, np.sin(0.5)], [0, 1, 0], [-np.sin(0.5), 0, np.cos(0.5)]])
MOVE = np.array([1.0, 2, 3])


@pytest.mark.parametrize(
    ("pose", "linear", "offset"),
    [
        ("np.concatenate([r[:3], t[3:]])", ROTATION, [0, 0, 0]),
        ("np.concatenate((r[:, :3], t[:, 3:]), axis=1)", ROTATION, MOVE),
        ("np.vstack([r[:3], [0, 0, 0, 1]])", ROTATION, [0, 0, 0]),
        ("np.vstack([r[0:2], t[2:4]])", np.vstack([ROTATION[:2], [0, 0, 1]]), [0, 0, 3]),
        ("np.vstack([np.hstack([r[:3, :3], t[:3, 3:]]), [[0, 0, 0, 1]]])", ROTATION, MOVE),
        ("concat_shapes(t, r)", np.eye(3), MOVE),
        ("concat_shapes(*[t, r])", np.eye(3), MOVE),
        ("np.concatenate([t, r])", np.eye(3), MOVE),
        ("np.vstack((r, t))", ROTATION, [0, 0, 0]),
    ],
)
def test_matrices_that_are_put_together(pose: str, linear: np.ndarray, offset: list[float]) -> None:
    code = scene(f"r = {R}", f"t = {T}", f"p = {pose}" if "concat_s" not in pose else "p = None", result="X")
    code = code.replace("return X", f"return transform_shape({CUBE}, {pose})").replace("    p = None\n", "")
    result = Session().evaluate(Source("<a>.py", code))
    assert result.scene is not None, told(result.diagnostics)
    (matrix,) = flatten(result.scene).frames[0].matrices
    assert np.allclose(np.asarray(matrix)[:3, :3], linear)
    assert np.allclose(np.asarray(matrix)[:3, 3], offset)


def test_matrices_that_have_no_effect_are_warned_about() -> None:
    code = scene(result=f"transform_shape({CUBE}, concat_shapes({T}, {R}))")
    assert [d.name for d in written(code).diagnostics] == ["python-ignored"]


# --- the same as CPython -------------------------------------------------------------------------------------------


def log(code: str) -> list[str]:
    result = Session().evaluate(Source("<a>.py", code))
    assert result.scene is not None, told(result.diagnostics)
    return [line for text in result.log for line in text.splitlines()]


def cpython(code: str) -> list[str]:
    """What the program prints in CPython; tuples look like lists in the language's log."""
    printed = io.StringIO()
    names = {"register": lambda *_: lambda function: function, "primitive_call": lambda *_, **__: None, "Shape": None}
    with contextlib.redirect_stdout(printed):
        exec(code.replace("from helper import *\n", ""), names)
        names["scene"]()
    return printed.getvalue().splitlines()


def same(code: str) -> None:
    assert [line.translate(_BRACKETS) for line in log(code)] == [line.translate(_BRACKETS) for line in cpython(code)]


_BRACKETS = str.maketrans("()", "[]")


@pytest.mark.parametrize(
    "values",
    [
        "(1, 2) == [1, 2], [1, 2] == (1, 2), (1, 2) != [1, 2], (1, 2) == (1, 2), () == [], [] == []",
        "[(1, 2)] == [[1, 2]], ((1, 2), 3) == ([1, 2], 3), ((1, 2), 3) == ((1, 2), 3)",
        "[1, 1] in [(0, 0), (1, 1)], (1, 1) in [(0, 0), (1, 1)], [0, 0] not in [(0, 0)]",
        "[(0, 0), (1, 1)].count([0, 0]), [(0, 0), (1, 1)].count((0, 0)), [(0, 0), (1, 1)].index((1, 1))",
        "tuple([1]) == (1,), list((1,)) == (1,), sorted((2, 1)) == (1, 2), list(zip([1], [2])) == [[1, 2]]",
        "{(1, 2): 3}[(1, 2)], (1, 2) in {(1, 2): 3}, list({(1, 2): 3}) == [[1, 2]]",
        "[p for p in [(1, 1), (2, 2)] if p == [1, 1]], [p for p in [(1, 1)] if p == (1, 1)]",
    ],
)
def test_tuples_are_no_lists(values: str) -> None:
    same(scene(f"a = (1, 2)\nb = [1, 2]\nprint({values})\nprint(a == b, b == a, a == tuple(b), list(a) == b)"))


def test_the_index_of_a_list_among_tuples() -> None:
    same(scene("try:\n    print([(0, 0)].index([0, 0]))\nexcept ValueError:\n    print('none')"))


LATE = {
    "comprehension": "fs = [lambda: i for i in range(3)]\nprint([f() for f in fs])",
    "with a condition": "fs = [lambda: i for i in range(5) if i % 2 == 0]\nprint([f() for f in fs])",
    "two loops in one": "fs = [lambda: (i, j) for i in range(2) for j in range(i + 1)]\nprint([f() for f in fs])",
    "a pattern": "fs = [lambda: (a, b) for a, b in [(1, 2), (3, 4)]]\nprint([f() for f in fs])",
    "comprehension in another": (
        "fs = [[lambda: (i, j) for j in range(2)] for i in range(2)]\nprint([[f() for f in r] for r in fs])"
    ),
    "table": "d = {k: (lambda: k) for k in range(3)}\nprint([d[k]() for k in range(3)])",
    "collected generator": "print([f() for f in list(lambda: i for i in range(3))])",
    "generator in step": "print([f() for f in (lambda: i for i in range(3))])",
    "defaults stay": "fs = [(lambda: i, lambda i=i: i) for i in range(3)]\nprint([(f(), g()) for f, g in fs])",
    "loop": "fs = []\nfor j in range(3):\n    fs.append(lambda: j)\nprint([f() for f in fs], j)",
    "loop in a loop": (
        "fs = []\nfor a in range(2):\n    for b in range(2):\n        fs.append(lambda: a * 10 + b)\nprint([f() for f in fs])"
    ),
    "by name": "fs = []\nfor j in range(3):\n    f = lambda: j\n    fs.append(f)\nprint([g() for g in fs])",
    "function": "fs = []\nfor j in range(3):\n    def f(k=j):\n        return (k, j)\n    fs.append(f)\nprint([g() for g in fs])",
    "what the turn defines": (
        "fs = []\nfor i in range(3):\n    k = i * 10\n    fs.append(lambda: k + i)\nprint([f() for f in fs])"
    ),
    "after the loop": "f = None\nfor k in range(3):\n    if k == 1:\n        f = lambda: k\nprint(f())",
    "kept by a function": (
        "def keep(fs, f):\n    fs.append(f)\nfs = []\nfor i in range(3):\n    keep(fs, lambda: i)\nprint([f() for f in fs])"
    ),
    "of comprehensions in a loop": (
        "fs = []\nfor i in range(2):\n    fs.extend([lambda: (i, j) for j in range(2)])\nprint([f() for f in fs])"
    ),
    "while": "fs = []\ni = 0\nwhile i < 3:\n    fs.append(lambda: i)\n    i += 1\nprint([f() for f in fs])",
    "generator function": (
        "def make():\n    for i in range(3):\n        yield lambda: i\n"
        "print([f() for f in make()], [f() for f in [*range(0)]])"
    ),
    "collected generator function": (
        "def make():\n    for i in range(3):\n        yield lambda: i\nprint([f() for f in list(make())])"
    ),
    "joined lists": "fs = []\nfor i in range(2):\n    fs = fs + [lambda: i]\nprint([f() for f in fs])",
    "continue and break": (
        "fs = []\nfor i in range(3):\n    for j in range(2):\n        if j == i:\n            break\n"
        "        fs.append(lambda: (i, j))\nprint([f() for f in fs])"
    ),
    "kept by the best": (
        "best = None\nfor i in range(3):\n    f = lambda: i\n    if best is None or f() > 0:\n        best = f\nprint(best())"
    ),
    "same names": "i = 3\nfs = [lambda: i for i in range(i)]\nprint([f() for f in fs], i)",
    "in the same turn": "out = []\nfor i in range(3):\n    f = lambda: i * 2\n    out.append(f())\nprint(out)",
    "sorted at once": "print([sorted([3, 1, 2], key=lambda x: x * s) for s in (1, -1)])",
    "made by a function": ("def make(i):\n    return lambda: i\nprint([f() for f in [make(i) for i in range(3)]])"),
}


@pytest.mark.parametrize("name", LATE)
def test_closures_see_what_a_loop_leaves(name: str) -> None:
    same(scene(LATE[name]))


def test_functions_that_a_turn_calls_stay_readable() -> None:
    code = scene(
        "parts = []", "for i in range(3):",
        "    parts.append(loop(4, lambda j: transform_shape(library_call('leg'), translation_matrix((i, j, 0)))))",
        result="concat_shapes(*parts)",
    ) + f"@register()\ndef leg() -> Shape:\n    return {CUBE}\n"  # fmt: skip
    text = written(code).text
    assert "set!" not in text
    assert "for/union ((i (range 3)))" in text


@pytest.mark.parametrize(
    "lines",
    [
        "f = lambda x, y=(k := 3): x + y + k\nprint(f(1), k)",
        "def g(a=(m := 2)):\n    return a + m\nprint(g(), g(5), m)",
        "a = 1\nf = lambda x: (a := x + 1) + a\nprint(f(3), a)\nprint(list(filter(lambda x: (b := x % 2) and b, [1, 2, 3])))",
        "f = lambda *a: len(a)\nprint(f(), f(1, 2))",
    ],
    ids=[
        "a name in a lambda's default",
        "a name in a function's default",
        "a lambda's own name",
        "nothing but the rest",
    ],
)
def test_parameters(lines: str) -> None:
    same(scene(*lines.splitlines()))


def test_a_word_may_take_any_number_of_arguments() -> None:
    code = f"from helper import *\n@register()\ndef leg(*a) -> Shape:\n    return {CUBE}\n"
    assert log(code) == []


def test_a_shift_by_a_set_is_an_error_of_the_program() -> None:
    code = scene("print(1 << {2})")
    assert [d.code for d in Session().evaluate(Source("<a>.py", code)).diagnostics if d.is_error] == ["E401"]


def test_operators_of_sets() -> None:
    same(scene("a = {1, 2, 3}", "b = {3, 4}", "print(sorted(a - b), sorted(a & b), sorted(a | b), sorted(a ^ b))"))


def test_an_assignment_in_a_class() -> None:
    code = "class A:\n    b = [1, (a := 2)]\n" + scene("print(A.a, A.b)")
    assert log(code) == ["2 [1, 2]"]
