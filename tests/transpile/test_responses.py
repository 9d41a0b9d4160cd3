"""What is read of a response or a notebook, and what is said when its program fails."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from scenelang.grammar.datum import Source
from scenelang.interpreter.transpile.analysis.python_text import code_of, find_code
from scenelang.session.session import Session
from transpile.cases import first_difference, flattened, told
from transpile.reference_model import flatten

SESSION = Session()
LEG = "@register()\ndef leg(h=1):\n    return primitive_call('cube', shape_kwargs={'scale': (1, h, 1)})\n"
TABLE = "@register()\ndef table():\n    return concat_shapes(library_call('leg', h=2), library_call('leg', h=3))\n"
SEAT = "@register()\ndef seat():\n    return primitive_call('sphere', shape_kwargs={'radius': 1})\n"
WHOLE = LEG + TABLE


def response(*blocks: str) -> str:
    return "Here it is.\n" + "\nNow:\n".join(f"\n```python\n{block}```\n" for block in blocks) + "\nEnjoy!\n"


def count(text: str) -> int:
    result = SESSION.evaluate(Source("answer.txt", text))
    assert result.scene is not None, told(result.diagnostics)
    return sum(1 for _ in _primitives(result.scene))


def _primitives(scene: object) -> list[object]:
    from scenelang.interpreter.scene.flatten import flatten

    frame = flatten(scene).frames[0]
    return list(range(len(frame)))


JOINED = {
    "helpers first": (
        ["import math\nH = 2\ndef twice(x):\n    return 2 * x\n", LEG.replace("(1, h, 1)", "(1, twice(H), 1)")],
        1,
    ),
    "part by part": ([LEG, TABLE], 2),
    "the root first": ([TABLE, LEG], 2),
    "three parts": ([LEG, SEAT, TABLE.replace("library_call('leg', h=2)", "library_call('seat')")], 2),
    "a function anew": ([WHOLE, LEG.replace("return ", "return 2 * ")], 4),
    "more that uses it": (
        [WHOLE, "@register()\ndef room():\n    return loop(3, lambda i: library_call('table'))\n"],
        6,
    ),
}
APART = {
    "another version": ([WHOLE, (LEG + TABLE).replace("concat_shapes(", "concat_shapes(library_call('leg'), ")], 2),
    "an example of its use": ([WHOLE, "scene = library_call('table')\n"], 2),
    "another program": ([WHOLE, SEAT.replace("seat", "ball")], 2),
    "no Python": ([WHOLE, "$ pip install scene\n"], 2),
}


@pytest.mark.parametrize("name", JOINED)
def test_blocks_that_are_one_program_are_joined(name: str) -> None:
    blocks, number = JOINED[name]
    text = response(*blocks)
    assert count(text) == number
    assert find_code(text).ignored == 0
    assert "Now:" not in code_of(text)


@pytest.mark.parametrize("name", APART)
def test_other_blocks_are_ignored_with_a_warning(name: str) -> None:
    blocks, number = APART[name]
    text = response(*blocks)
    assert count(text) == number
    assert "another Python code block of the response is ignored" in told(
        SESSION.check(Source("a.txt", text)).diagnostics
    )


def test_errors_in_later_blocks_have_their_places() -> None:
    result = SESSION.check(Source("a.txt", response(LEG, TABLE.replace("library_call('leg', h=3)", "undefined_name"))))
    (problem,) = [d for d in result.diagnostics if d.is_error]
    assert problem.span is not None
    assert problem.span.text == "undefined_name"


def test_a_notebook_is_its_code_cells(tmp_path: Path) -> None:
    cells = [
        {"cell_type": "markdown", "source": ["# A table\n", "with legs"]},
        {"cell_type": "code", "source": ["%matplotlib inline\n", "!pip install numpy\n", LEG]},
        {"cell_type": "code", "source": "%%bash\nrm -rf /\n"},
        {"cell_type": "code", "source": "%%time\n" + TABLE},
    ]
    path = tmp_path / "table.ipynb"
    path.write_text(json.dumps({"cells": cells, "nbformat": 4}), "utf-8")
    source = SESSION.source(str(path))
    assert "pip" not in source.text
    assert "rm -rf" not in source.text
    result = SESSION.evaluate(source)
    assert result.scene is not None, told(result.diagnostics)
    text = SESSION.transpile(source).text
    assert "; # A table\n; with legs" in text or "A table" in text
    (tmp_path / "broken.ipynb").write_text("[1, 2]", "utf-8")
    with pytest.raises(Exception, match="not a notebook"):
        SESSION.source(str(tmp_path / "broken.ipynb"))


def test_lines_for_ipython_are_left_out_of_a_response() -> None:
    assert count(response("!pip install numpy\n%matplotlib inline\n" + WHOLE)) == 2


FAILURES = {
    "xs = [1, 2]\n    y = xs[N]": "IndexError: list index out of range",
    "y = 1 / (N - 5)": "ZeroDivisionError: division by zero",
    "y = {'a': 1}['b' * N]": "KeyError: 'bbbbb'",
    "y = int('x' * N)": "ValueError: invalid literal for int() with base 10: 'xxxxx'",
    "y = math.sqrt(-N)": "ValueError: math domain error",
    "y = 'a' + N": "TypeError",
    "print([N].index(3))": "ValueError: 3 is not in list",
    "print('abc'.index('z'))": "ValueError: substring not found",
    "a, b = [N] * 3": "ValueError: too many values to unpack (expected 2)",
    "y = [].pop()": "IndexError: pop from empty list",
    "y = max([x for x in range(N) if x > 9])": "ValueError: max() arg is an empty sequence",
    "assert N < 3, 'too large'": "AssertionError: too large",
    "y = np.zeros(2)[N]": "IndexError: index 5 is out of bounds for axis 0 with size 2",
    "raise ValueError(f'bad {N}')": "ValueError: bad 5",
}


@pytest.mark.parametrize("line", FAILURES)
def test_an_error_while_it_runs_is_told_in_the_words_of_python(line: str) -> None:
    code = f"from helper import *\nimport math\nN = 5\n@register()\ndef scene():\n    {line}\n    print(N)\n    return primitive_call('cube')\n"
    result = SESSION.evaluate(Source("a.py", code))
    assert result.scene is None
    problem = next(d for d in result.diagnostics if d.is_error)
    assert FAILURES[line] in problem.message
    assert problem.span is not None
    assert problem.span.text.strip() in line


def test_what_fails_in_the_language_only_is_evaluated() -> None:
    code = "from helper import *\n@register()\ndef scene():\n    x = float(len('ab') > 1) + len([*range(3), *'ab'])\n"
    code += "    return primitive_call('cube', shape_kwargs={'scale': x})\n"
    assert count(code) == 1


def test_a_program_that_would_fail_is_evaluated() -> None:
    """The static translation inserts beyond the end of a list, which Python allows."""
    code = """from helper import *
@register()
def root() -> Shape:
    places = [1, 2]
    places.insert(100, 8)
    return concat_shapes(*[transform_shape(primitive_call('cube'), translation_matrix((x, 0, 0))) for x in places])
"""
    translation = Session().transpile(Source("insert.py", code))
    scene = Session().evaluate(Source("insert.scene", translation.text)).scene
    assert scene is not None
    assert first_difference(flattened(scene), flatten(code)) is None


def test_a_program_that_fails_either_way_is_translated() -> None:
    """Python raises an exception: the program is written as it is, and running it tells so."""
    code = """from helper import *
@register()
def root() -> Shape:
    places = [1]
    places.insert(0, 2)
    return concat_shapes(*[primitive_call('cube', shape_kwargs={'scale': places[i]}) for i in range(3)])
"""
    translation = Session().transpile(Source("index.py", code))
    assert translation.ok
    assert '(bind "root"' in translation.text
    (problem,) = Session().evaluate(Source("index.py", code)).diagnostics
    assert problem.message == "Python: IndexError: list index out of range"
