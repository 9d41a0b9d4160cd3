"""A command line of every command that works on small files, and the options of it that take a number."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

from PIL import Image

from scenelang.cli.main import COMMANDS, build_parser
from scenelang.grammar.diagnostics import SceneError
from scenelang.grammar.settings import settings_in
from scenelang.interpreter.values.limits import Limits

SCENE = """; a wooden table
(define height 1)
(bind "木桌" (lambda () (call "cube" :scale [2 height 1])))
(bind "room" (lambda ()
  (begin (print "木")
    (union (call "木桌") (transform (call "木桌") (translate [3 0 0]))))))
"""
PYTHON = '''from helper import *


@register()
def table() -> Shape:
    """木桌"""
    return primitive_call("cube", shape_kwargs={"scale": (1, 1, 1)}, color=(1, 0, 0))
'''
SPEC = """programs = ["a.scene"]
count = 2
size = [32, 32]

[cameras]
kind = "hemisphere"
views = 1
"""
DRAWN = ("--size", "24x24")
LINES: dict[str, tuple[str, ...]] = {
    "check": ("a.scene",), "run": ("a.scene",), "repl": (), "fmt": ("a.scene", "--diff"), "explain": ("E201",),
    "diff": ("a.scene", "b.scene"), "expand": ("a.scene",), "transpile": ("a.py",), "simplify": ("a.scene",),
    "import": ("a.scad",), "render": ("a.scene", "-o", "out.png", *DRAWN), "view": ("a.scene", "--html", "out.html"),
    "sheet": ("a.scene", "-o", "out.png", "--views", "front", *DRAWN),
    "studio": ("a.py", "--no-browser"),
    "labels": ("a.scene", "-o", "out", *DRAWN), "dataset": ("a.toml", "-o", "out"), "graph": ("a.scene", "-o", "out.svg"),
    "tree": ("a.scene",), "count": ("a.scene",), "bounds": ("a.scene",), "measure": ("a.scene",),
    "simulate": ("a.scene", "-o", "out.json", "--seconds", ".1"), "settle": ("a.scene", "-o", "out.json"),
    "repair": ("a.scene",), "flatten": ("a.scene",), "export": ("a.scene", "-o", "out.obj"), "backends": (),
    "build": ("a table", "-o", "out.scene", "--model", "none:none"),
    "generate": ("a table", "-o", "out.scene", "--model", "none:none"), "edit": ("a.scene", "a chair", "--model", "none:none"),
    "bench": ("--list",), "runs": (), "embeddings": ("a.scene", "list"), "embed": ("a.scene", "--print"),
    "imagine": ("a.scene", "-o", "out.png", "--model", "missing"),
    "invert": ("a.scene", "--from", "photo.png", "--model", "missing"), "style": ("a.scene", "z1", "--from", "photo.png", "--model", "missing"),
    "distill": ("a.scene", "-o", "out", "--model", "missing"), "eval": ("a.scene", "--metric", "count"),
    "lsp": (), "mcp": (), "search": ("table",), "grammar": ("--format", "gbnf"), "completion": ("bash",), "doctor": (),
}  # fmt: skip


def prepare(folder: Path) -> Path:
    """Write the files that the command lines name."""
    Image.new("RGB", (16, 16), (200, 10, 10)).save(folder / "photo.png")
    for name in ("a.scene", "b.scene"):
        (folder / name).write_text(SCENE, "utf-8")
    (folder / "a.py").write_text(PYTHON, "utf-8")
    (folder / "a.scad").write_text('cube([1, 2, 3]); // 木\necho("木");\n', "utf-8")
    (folder / "a.toml").write_text(SPEC, "utf-8")
    return folder


def parsers() -> dict[str, argparse.ArgumentParser]:
    """Return the parser of every command."""
    commands = next(each for each in build_parser()._actions if isinstance(each, argparse._SubParsersAction))
    return {name: commands.choices[name] for name in COMMANDS}


def numeric_options() -> list[tuple[str, str]]:
    """Return every pair of a command and an option of it that reads a number, the limits of an evaluation once."""
    shared = {"--seed", *(flag for each in settings_in(Limits).values() for flag in each.flags)}
    return [
        (name, action.option_strings[-1])
        for name, parser in parsers().items()
        for action in parser._actions
        if action.option_strings and action.type not in (None, str) and _reads_numbers(action.type)
        if name == "run" or action.option_strings[-1] not in shared
    ]


def _reads_numbers(read: Callable[[str], Any]) -> bool:
    for text in ("1", "0.5", "8x8"):
        try:
            value = read(text)
        except (ValueError, SceneError, argparse.ArgumentTypeError):
            continue
        if type(value) in (int, float) or text == "8x8":
            return True
    return False
