"""Python that tries to do something: nothing of it is ever executed, and nothing runs for ever.

Each program would leave a mark: a file, a variable of the environment, a module, a change of a builtin. Python's audit
events are watched meanwhile: none may come from the program's text.
"""

from __future__ import annotations

import builtins
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import CodeType
from typing import Any

import copies
import pytest

import scenelang.interpreter.transpile.evaluation.folding  # noqa: F401  loaded before anything is watched
from scenelang.cli.main import main

MARK = "left_by_the_program"
MODULE = "antigravity"  # nothing here imports it
COMMANDS = ("transpile", "check", "run", "flatten")

TOUCH = f"open('{MARK}', 'w').write('x')"
SYSTEM = f"touch {MARK}"


def car(line: str = "pass") -> str:
    """A program whose one word begins with ``line``."""
    start = "@register()\ndef car() -> Shape:\n"
    return f"{start}    {line}\n    return primitive_call('cube', shape_kwargs={{'scale': 1}})\n"


CAR = car()

IN_A_FUNCTION = (
    # what there is for it in Python
    TOUCH,
    f"with open('{MARK}', 'w') as f: f.write('x')",
    f"print('x', file=open('{MARK}', 'w'))",
    f"import os; os.system('{SYSTEM}')",
    f"from os import system; system('{SYSTEM}')",
    f"import os as o; o.makedirs('{MARK}')",
    f"import os.path; os.mkdir('{MARK}')",
    f"import os; os.environ['{MARK}'] = '1'",
    f"import os; os.putenv('{MARK}', '1')",
    f"import os; os.environ.update({MARK}='1')",
    f"import subprocess; subprocess.run(['touch', '{MARK}'])",
    f"from pathlib import Path; Path('{MARK}').touch()",
    f"import pathlib; pathlib.Path('{MARK}').write_text('x')",
    f"import {MODULE}",
    f"from {MODULE} import *",
    f"import {MODULE} as np",
    f"import numpy.{MODULE}",
    "import socket; socket.create_connection(('localhost', 1))",
    "import urllib.request; urllib.request.urlopen('http://localhost:1')",
    f"np.save('{MARK}', np.array([1]))",
    f"np.savetxt('{MARK}', [1])",
    f"np.array([1]).tofile('{MARK}')",
    f"np.array([1]).dump('{MARK}')",
    f"np.memmap('{MARK}', mode='w+', shape=(1,))",
    f"np.lib.npyio.DataSource().open('{MARK}')",
    f"np.f2py.os.system('{SYSTEM}')",
    f"np.load('{MARK}', allow_pickle=True)",
    # code as text
    f"eval(\"{TOUCH}\")",
    f"exec(\"{TOUCH}\")",
    f"exec(compile(\"{TOUCH}\", '', 'exec'))",
    f"compile(\"{TOUCH}\", '', 'exec')",
    f"e = eval; e(\"{TOUCH}\")",
    f"[eval, exec][0](\"{TOUCH}\")",
    f"list(map(eval, [\"{TOUCH}\"]))",
    f"sorted([\"{TOUCH}\"], key=eval)",
    f"loop(1, lambda i: eval(\"{TOUCH}\"))",
    f"(lambda f: f(\"{TOUCH}\"))(eval)",
    f"__builtins__['eval'](\"{TOUCH}\")",
    f"__builtins__.eval(\"{TOUCH}\")",
    f"__builtins__['ev' + 'al'](\"{TOUCH}\")",
    f"import builtins; builtins.exec(\"{TOUCH}\")",
    f"getattr(__builtins__, 'exec')(\"{TOUCH}\")",
    f"globals()['__builtins__']['exec'](\"{TOUCH}\")",
    f"vars()['x'] = locals()['__builtins__'].exec(\"{TOUCH}\")",
    f"import code; code.InteractiveInterpreter().runsource(\"{TOUCH}\")",
    f"import timeit; timeit.timeit(\"{TOUCH}\", number=1)",
    # imports without a statement
    f"__import__('{MODULE}')",
    f"__import__('os').system('{SYSTEM}')",
    f"import importlib; importlib.import_module('{MODULE}')",
    f"i = __import__; i('{MODULE}')",
    f"import pickle; pickle.loads(b'c{MODULE}\\nfly\\n.')",
    f"import sys; sys.modules['os'].system('{SYSTEM}')",
    f"math.__loader__.load_module('{MODULE}')",
    f"np.__builtins__['__import__']('{MODULE}')",
    f"random._os.system('{SYSTEM}')",
    f"random.os.system('{SYSTEM}')",
    f"math.__spec__.loader.load_module('{MODULE}')",
    # attributes
    "x = ().__class__.__base__.__subclasses__()",
    "x = ''.__class__.__mro__[1].__subclasses__()[100].__init__.__globals__",
    "x = (lambda: 0).__globals__['__builtins__']",
    f"car.__globals__['__builtins__']['open']('{MARK}', 'w')",
    f"car.__code__ = compile(\"{TOUCH}\", '', 'exec')",
    "car.__defaults__ = (1,)",
    "x = (i for i in ()).gi_frame.f_back.f_globals",
    "x = getattr(car, '__glo' + 'bals__')",
    "setattr(math, 'pi', 3)",
    "math.pi = 3",
    "math.sin = math.cos",
    "np.array = list",
    "random.seed = print",
    "delattr(math, 'pi')",
    "del math.pi",
    "object.__setattr__(math, 'pi', 3)",
    "list.append = None",
    "type('X', (), {'__init__': print})()",
    "x = [].append.__self__.__class__",
    "math.__dict__['pi'] = 3",
    "vars(math)['pi'] = 3",
    "x = primitive_call.__wrapped__",
    "help(); input(); breakpoint(); exit()",
    "raise SystemExit(7)",
    "import sys; sys.exit(7)",
    "quit(7)",
    # texts that look into values
    "x = '{0.__class__}'.format(1)",
    "x = '{0.__class__.__init__.__globals__}'.format(car)",
    "x = '{0[__builtins__]}'.format(car)",
    "x = '{a.b.c}'.format(a=math)",
    "x = '{0.__globals__[os].environ}'.format(car)",
    "x = ('{0.__' + 'class__}').format(1)",
    "t = '{' + '0.__class__' + '}'; x = t.format(1)",
    "x = '{:{}}'.format(1, '{0.__class__}')",
    "x = format(1, '{0.__class__}')",
    "x = str.format('{0.__class__}', 1)",
    "x = '{0.__class__}'.format_map({'0': 1})",
    "x = '%(__class__)s' % {'__class__': 1}",
    f"x = f\"{{__import__('{MODULE}')}}\"",
    f"x = f\"{{open('{MARK}', 'w')}}\"",
    "x = f\"{eval('{}')}\"",
    # where a translation might work values out by itself
    f"x = [0][{TOUCH}]",
    f"x: {TOUCH} = 1",
    f"x = lambda a={TOUCH}: a",
    f"assert {TOUCH}",
    f"def inner(a: {TOUCH} = {TOUCH}) -> {TOUCH}: pass",
    f"class Inner({TOUCH}): pass",
    f"class Inner: a = {TOUCH}",
    f"class Inner: __init_subclass__ = {TOUCH}",
    f"match {TOUCH}:\n        case _: pass",
    f"try: 1 / 0\n    except {TOUCH}: pass",
    f"async def inner(): await {TOUCH}",
    f"global __builtins__; __builtins__ = {TOUCH}",
    f"library_call({TOUCH})",
    f"library_call('{MARK}', **__builtins__)",
    f"primitive_call('mesh', shape_kwargs={{'file': '{MARK}'}})",
    f"primitive_call('cube', shape_kwargs={{'scale': {TOUCH}}})",
    f"np.vectorize(eval)([\"{TOUCH}\"])",
    f"np.fromfunction(lambda i: {TOUCH}, (1,))",
    f"np.frompyfunc(eval, 1, 1)([\"{TOUCH}\"])",
    f"functools.reduce(eval, [\"{TOUCH}\", {{}}])",
    f"import functools; functools.partial(eval, \"{TOUCH}\")()",
    f"import operator; operator.attrgetter('__class__')(1); operator.methodcaller('system', '{SYSTEM}')(os)",
    f"import atexit; atexit.register(eval, \"{TOUCH}\")",
    f"import threading; threading.Thread(target=eval, args=(\"{TOUCH}\",)).start()",
    f"import ctypes; ctypes.CDLL(None).system(b'{SYSTEM}')",
    f"import shutil; shutil.copy('car.py', '{MARK}')",
    f"import tempfile; tempfile.mkdtemp('{MARK}')",
    f"import logging; logging.FileHandler('{MARK}')",
    f"import sqlite3; sqlite3.connect('{MARK}')",
    f"from helper import os; os.system('{SYSTEM}')",
    f"from math import __loader__; __loader__.load_module('{MODULE}')",
    f"from numpy import save; save('{MARK}', [1])",
    f"from numpy import *; save('{MARK}', [1])",
)  # fmt: skip

NUMBERS = [f"{i:03}" for i in range(len(IN_A_FUNCTION))]  # names that hold no mark

# Passed over: an import that nothing uses, an annotation, the class of an exception. None has a meaning here.
PASSED_OVER = (
    f"import {MODULE}",
    f"import {MODULE} as np",
    f"import numpy.{MODULE}",
    f"x: {TOUCH} = 1",
    f"try: 1 / 0\n    except {TOUCH}: pass",
)

AT_TOP = {
    "a decorator": f"@{TOUCH}\n@register()\ndef car(): return primitive_call('cube')\n",
    "a decorator that is a lambda": f"@(lambda f: {TOUCH})\n@register()\ndef car(): return primitive_call('cube')\n",
    "an argument of register": f"@register({TOUCH})\ndef car(): return primitive_call('cube')\n",
    "another decorator": "@atexit.register\n@register()\ndef car(): return primitive_call('cube')\n",
    "a decorator of its own": f"def mark(f):\n    {TOUCH}\n    return f\n@mark\n@register()\ndef car(): return primitive_call('cube')\n",
    "a default": f"@register()\ndef car(x={TOUCH}): return primitive_call('cube')\n",
    "an annotation": f"@register()\ndef car(x: {TOUCH}) -> {TOUCH}: return primitive_call('cube')\n",
    "an annotation as text": f"@register()\ndef car(x: \"{TOUCH}\" = 1) -> \"{TOUCH}\": return primitive_call('cube')\n",
    "a metaclass": f"class M(type):\n    def __new__(*a): {TOUCH}\nclass C(metaclass=M): pass\n" + CAR,
    "a class body": f"class C:\n    {TOUCH}\n" + car("C()"),
    "special methods": f"class C:\n    def __getattr__(self, n): {TOUCH}\n    def __del__(self): {TOUCH}\n" + car("C().x"),
    "a main block": CAR + f"if __name__ == '__main__':\n    {TOUCH}\n    __import__('{MODULE}')\n",
    "a coding line": f"# -*- coding: {MODULE} -*-\n" + CAR,
    "a future": f"from __future__ import {MODULE}\n" + CAR,
    "a shadowed helper": f"def primitive_call(*a, **k): {TOUCH}\n" + CAR,
    "a builtin replaced": "import builtins\nbuiltins.len = lambda x: 0\nlen = builtins.len\n" + CAR,
    "a word as a path": f"@register('../{MARK}')\ndef car(): return primitive_call('../../{MARK}')\n",
    "a program of the language": f"@register('a\") (import \"{MARK}.scene\") (\"')\ndef car(): return primitive_call('cube')\n",
    "a name of the language": f"import_ = 1\ndef define_macro(): return {TOUCH}\n" + car("define_macro()"),
    "a docstring that ends the comment": f'"""x\n(import "{MARK}.scene")\n"""\n# y\r(import "{MARK}.scene")\n' + CAR,
    "line ends in a comment": f'# y\x0b(import "{MARK}.scene")\x0c(import "{MARK}.scene")\x85(import "{MARK}.scene")\u2028(import "{MARK}.scene")\n'
    + CAR,
    "an asset": "@register()\ndef car(): return primitive_call('mesh', shape_kwargs={'file': '/etc/passwd'})\n",
}  # fmt: skip

# --- watching ------------------------------------------------------------------------------------------------------

_FORBIDDEN = ("os.system", "os.exec", "os.spawn", "os.fork", "os.posix_spawn", "os.putenv", "os.mkdir", "os.remove",
              "os.rename", "subprocess.Popen", "socket.connect", "socket.__new__", "ctypes.dlopen", "pickle.find_class",
              "urllib.Request", "shutil.copyfile", "shutil.rmtree", "sqlite3.connect", "tempfile.mkdtemp")  # fmt: skip
PARSED = ("<unknown>", "<python>")  # what `ast.parse` says, which runs nothing; to run it would be an event "exec"
_watching: list[str] | None = None
_hooked = False


def _hook(event: str, arguments: tuple[Any, ...]) -> None:
    if _watching is None:
        return
    if event.startswith(_FORBIDDEN):
        _watching.append(f"{event} {arguments!r}"[:200])
    elif event == "exec" and _mentions(arguments[0]):
        _watching.append(f"exec {arguments[0]!r}")
    elif event == "import" and arguments[0] == MODULE:
        _watching.append(f"import {arguments[0]}")
    elif event == "open" and (MARK in str(arguments[0]) or _writes(arguments)):
        _watching.append(f"open {arguments!r}"[:200])
    elif event == "compile" and arguments[1] not in PARSED and MARK in str(arguments[0]):
        _watching.append(f"compile {arguments!r}"[:200])


def _mentions(code: CodeType) -> bool:
    """Whether a piece of compiled code comes from one of the programs here."""
    if not isinstance(code, CodeType):
        return False
    texts = {*code.co_names, *(c for c in code.co_consts if isinstance(c, str))}
    if any(MARK in text or text in (MODULE, "primitive_call") for text in texts):
        return True
    return any(_mentions(c) for c in code.co_consts)


def _writes(arguments: tuple[Any, ...]) -> bool:
    mode = arguments[1]
    return isinstance(mode, str) and any(c in mode for c in "wax+") and "/dev/" not in str(arguments[0])


@contextmanager
def watching() -> Iterator[list[str]]:
    """Collects what happens that should not."""
    global _watching, _hooked
    if not _hooked:
        sys.addaudithook(_hook)  # for ever: there is no way to take it off
        _hooked = True
    _watching = found = []
    try:
        yield found
    finally:
        _watching = None


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Programs lie and run in a folder of their own."""
    made = tmp_path / "programs"
    made.mkdir()
    monkeypatch.chdir(made)
    return made


def _traces() -> dict[str, Any]:
    import math
    import random

    import numpy

    return {
        "environment": dict(os.environ),
        "folder": os.getcwd(),
        "builtins": dict(vars(builtins)),
        "math": dict(vars(math)),
        "random": {name: value for name, value in vars(random).items() if name != "_inst"},
        "numpy": (numpy.array, numpy.save),
    }


def _try(text: str, name: str, capsys: pytest.CaptureFixture[str], commands: Sequence[str] = COMMANDS) -> None:
    """Run commands on a program and look for traces of it."""
    Path(name).write_text(text, "utf-8", newline="")
    before = _traces()
    for command in commands:
        limits = ["--max-seconds", "10"] if command in ("run", "flatten") else []
        with watching() as found:
            code = main([command, name, *limits])
        said = "".join(capsys.readouterr())
        assert code in (0, 1)
        assert "Traceback" not in said
        assert found == []
    assert _traces() == before
    assert MODULE not in sys.modules
    assert os.listdir() == [name]
    assert os.listdir("..") == ["programs"]


@pytest.fixture(scope="module", autouse=True)
def warm() -> None:
    """Everything that the commands import lazily is imported, so that it is not taken for the programs' doing."""
    import scenelang

    scenelang.evaluate(CAR, "warm.py")


@pytest.mark.parametrize("line", IN_A_FUNCTION, ids=NUMBERS)
def test_nothing_is_executed(line: str, capsys: pytest.CaptureFixture[str]) -> None:
    _try(car(line), "car.py", capsys)


@pytest.mark.parametrize(
    "line",
    [line for line in IN_A_FUNCTION if TOUCH in line or MODULE in line or SYSTEM in line],
    ids=lambda line: line[:50],
)
def test_it_is_rejected(line: str, capsys: pytest.CaptureFixture[str]) -> None:
    """What would reach files, processes or modules is not passed over in silence."""
    Path("car.py").write_text(car(line))
    code = main(["transpile", "car.py"])
    err = capsys.readouterr().err
    assert code == 1 or "warning[W8" in err or line in PASSED_OVER


@pytest.mark.parametrize("at_top", [False, True])
@pytest.mark.parametrize("line", [line for line in IN_A_FUNCTION if "\n" not in line], ids=lambda line: line[:20])
def test_outside_functions_and_in_a_response(line: str, at_top: bool, capsys: pytest.CaptureFixture[str]) -> None:
    code = f"{line}\n{CAR}" if at_top else f"def other():\n    {line}\n{CAR}"
    _try(f"Some words.\n```python\n{code}```\n", "car.txt", capsys, ["run"])


@pytest.mark.parametrize("name", AT_TOP)
def test_nothing_is_executed_at_top(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    _try(AT_TOP[name], "car.py", capsys)


def test_the_output_holds_no_more_than_the_program(capsys: pytest.CaptureFixture[str]) -> None:
    """Text of comments and words cannot become code of the translation."""
    from scenelang import parse

    for name in ("a docstring that ends the comment", "line ends in a comment", "a program of the language"):
        Path("car.py").write_text(AT_TOP[name], "utf-8", newline="")
        main(["transpile", "car.py"])
        out = capsys.readouterr().out
        assert not any(str(form.items[0]) == "import" for form in parse(out).forms if hasattr(form, "items")), out


def test_the_watch_would_notice(folder: Path) -> None:
    """The same program, executed, is noticed by its file and by the audit events."""
    names = {"register": lambda: lambda f: f, "Shape": list, "primitive_call": lambda *a, **k: []}
    with watching() as found:
        exec(compile(car(TOUCH) + "car()\n", "<program>", "exec"), names)
    assert (folder / MARK).exists()
    assert {event.split()[0] for event in found} >= {"exec", "compile", "open"}


# --- programs without end -------------------------------------------------------------------------------------------

ENDLESS = (
    "while True: pass",
    "while 1: x = 1",
    "for i in range(10 ** 18): pass",
    "x = list(range(10 ** 12))",
    "x = [i for i in range(10 ** 12)]",
    "x = sum(range(10 ** 15))",
    "x = max(i for i in range(10 ** 15))",
    "x = sorted(range(10 ** 12))",
    "x = [0] * 10 ** 12",
    "x = 'x' * 10 ** 12",
    "x = (0,) * 10 ** 12",
    "x = 2 ** 10 ** 9",
    "x = 10 ** 10 ** 10",
    "x = 3 ** 3 ** 3 ** 3",
    "x = pow(3, 10 ** 10)",
    "x = 1 << 10 ** 12",
    "x = int('9' * 10 ** 7)",
    "x = '{:>10000000000}'.format(1)",
    "x = f'{1:>10000000000}'",
    "x = '%10000000000d' % 1",
    "x = f'{1:.10000000000f}'",
    "x = 'x'.ljust(10 ** 12)",
    "x = 'a'.join(['b' * 10 ** 6] * 10 ** 6)",
    "x = 'aa'.replace('a', 'a' * 10 ** 10)",
    "x = np.zeros((10 ** 6, 10 ** 6))",
    "x = np.eye(10 ** 6)",
    "x = np.arange(10 ** 12)",
    "x = np.linspace(0, 1, 10 ** 12)",
    "x = np.ones(10 ** 12)",
    "x = np.random.rand(10 ** 6, 10 ** 6)",
    "x = np.random.uniform(0, 1, 10 ** 12)",
    "x = np.random.permutation(10 ** 12)",
    "x = np.random.choice(10 ** 12, 10 ** 11)",
    "x = np.repeat([1], 10 ** 12)",
    "x = np.tile([1], 10 ** 12)",
    "x = np.meshgrid(range(10 ** 6), range(10 ** 6))",
    "x = math.factorial(10 ** 8)",
    "x = math.comb(10 ** 9, 5 * 10 ** 8)",
    "x = [random.random() for _ in range(10 ** 12)]",
    "x = random.sample(range(10 ** 12), 10 ** 11)",
    "import itertools; x = list(itertools.product(range(10 ** 6), repeat=3))",
    "import itertools; x = list(itertools.permutations(range(100)))",
    "import itertools; x = list(itertools.count())",
    "import itertools\n    for i in itertools.cycle([1]): pass",
    "x = [1]\n    for y in x: x.append(y)",
    "x = [1]\n    while x: x += x",
    "x = 'x'\n    while x: x += x",
    "x = 2\n    while x: x = x * x",
    "def f(n): return f(n + 1)\n    f(0)",
    "def f(n): return f(n + 1) + f(n + 2)\n    f(0)",
    "f = lambda g: g(g)\n    f(f)",
    "x = []\n    x.append(x)\n    print(x)",
    "x = loop(10 ** 12, lambda i: [])",
    "x = loop(10 ** 12, lambda i: primitive_call('cube'))",
    "return concat_shapes(*[primitive_call('cube') for i in range(10 ** 12)])",
    "return library_call('car')",
    "return concat_shapes(library_call('car'), library_call('car'))",
)


@pytest.mark.parametrize("line", ENDLESS)
@pytest.mark.sampled(3)
def test_programs_without_end_are_stopped(line: str, tmp_path: Path) -> None:
    (tmp_path / "car.py").write_text(car(line))
    limits = ("--max-seconds", "1", "--max-steps", "200k", "--max-memory", "1G")
    done = copies.command("run", "car.py", *limits, folder=tmp_path)
    err = done.stderr
    assert "Traceback" not in err
    assert done.returncode in (0, 1)
    if done.returncode:
        assert "error[E" in err
    assert len(done.stdout) < 1_000_000
