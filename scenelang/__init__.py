"""The Scene Language: parse, check, evaluate and load programs that make 3D and 4D scenes.

>>> import scenelang
>>> scene = scenelang.evaluate('(bind "dot" (lambda () (call "sphere" :radius 2)))').scene
>>> scene.word
'dot'
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from scenelang.api import check as check
    from scenelang.api import evaluate as evaluate
    from scenelang.api import load as load
    from scenelang.api import parse as parse
    from scenelang.grammar.datum import Datum as Datum
    from scenelang.grammar.datum import Source as Source
    from scenelang.grammar.diagnostics import Diagnostic as Diagnostic
    from scenelang.grammar.diagnostics import SceneError as SceneError
    from scenelang.grammar.reader import ReadResult as ReadResult
    from scenelang.interpreter.runtime.limits import Limits as Limits
    from scenelang.interpreter.scene.entity import Entity as Entity
    from scenelang.interpreter.scene.entity import Scene as Scene
    from scenelang.session import Checked as Checked
    from scenelang.session import Evaluated as Evaluated
    from scenelang.session import Options as Options
    from scenelang.session import Session as Session

# In a checkout the other rooms lie beside this folder; found here, they work from the repository's root too.
if not (Path(__file__).parent / "grammar").is_dir():
    __path__.append(str(Path(__file__).parent.parent))

# Where each public name lives: it is imported when it is first used, so that a part costs only what it needs.
_HOMES = {
    "check": "api", "evaluate": "api", "load": "api", "parse": "api",
    "Datum": "grammar.datum", "Diagnostic": "grammar.diagnostics", "SceneError": "grammar.diagnostics",
    "ReadResult": "grammar.reader", "Source": "grammar.datum",
    "Entity": "interpreter.scene.entity", "Scene": "interpreter.scene.entity", "Limits": "interpreter.runtime.limits",
    "Checked": "session", "Evaluated": "session", "Options": "session", "Session": "session",
}  # fmt: skip
__all__ = sorted(_HOMES)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'scenelang' has no attribute {name!r}")
    return getattr(import_module(f"scenelang.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return [*__all__, *(name for name in globals() if name.startswith("__"))]
