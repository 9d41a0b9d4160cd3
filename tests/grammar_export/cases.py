"""Programs that every exported grammar must accept, and those that it must reject."""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).parents[2]
BAD = ROOT / "tests" / "bad"
STRICT = ROOT / "examples" / "strict.scene"
GOOD = sorted([*(ROOT / "examples").rglob("*.scene"), *(ROOT / "stdlib").glob("*.scene"),
               *(ROOT / "tests" / "corpus").glob("*.scene")])  # fmt: skip

# Codes of mistakes in the shape of a program: everything that reading and the special forms refuse.
SHAPE = frozenset({
    "E101", "E102", "E103", "E104", "E105", "E106", "E107", "E201", "E202", "E203", "E204", "E205", "E207", "E209",
    "E211", "E212",
})  # fmt: skip
STRICT_CODE = "E210"

# What a context-free grammar cannot see.
UNSEEN = {
    "E203-else.scene": "`else` in a call is a name like any other",
    "E203-light.scene": "`light` is a function like any other",
    "E205-camera.scene": "two names are compared",
    "E205-let.scene": "two names are compared",
    "E205-parameter.scene": "two names are compared",
    "E207-ellipsis.scene": "a template is right or wrong by the names of its pattern",
    "E207-no-rule.scene": "the rules of a macro are the program's own",
    "E212-word.scene": "the names of functions are the program's own",
    "E201-inside.scene": "a pose that is inside the call is an argument like any other",
    "E212-clock.scene": "`t` is a name like any other",
    "E212-function-word.scene": "the names of functions are the program's own",
    "E212-infix.scene": "`*` is a name like any other",
}


def _by_code(codes: frozenset[str]) -> list[Path]:
    return [path for path in sorted(BAD.glob("E*.scene")) if path.name[:4] in codes and path.name not in UNSEEN]


WRONG = _by_code(SHAPE)
NOT_STRICT = _by_code(frozenset({STRICT_CODE}))
OTHERS = [path for path in sorted(BAD.glob("*.scene")) if path.name[:4] not in SHAPE]
