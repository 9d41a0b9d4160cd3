"""The Scene Language for Python: scenes as programs, words and embeddings (docs/python.md).

>>> import scenelang as sl
>>> scene = sl.evaluate('(bind "dot" (lambda () (call "sphere" :radius 2)))')
>>> scene.bounds.tolist()
[[-2.0, -2.0, -2.0], [2.0, 2.0, 2.0]]
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from scenelang.api import check as check
    from scenelang.api import diff as diff
    from scenelang.api import evaluate as evaluate
    from scenelang.api import format as format
    from scenelang.api import load as load
    from scenelang.api import parse as parse
    from scenelang.api import transpile as transpile
    from scenelang.backends.neural.distillation.learning import DistillationSettings as DistillationSettings
    from scenelang.backends.neural.inversion import InversionSettings as InversionSettings
    from scenelang.backends.neural.sentences import Granularity as Granularity
    from scenelang.backends.neural.weights import Models as Models
    from scenelang.embeddings import Embeddings as Embeddings
    from scenelang.grammar.datum import Datum as Datum
    from scenelang.grammar.datum import Source as Source
    from scenelang.grammar.diagnostics import Diagnostic as Diagnostic
    from scenelang.grammar.diagnostics import SceneError as SceneError
    from scenelang.grammar.reader import ReadResult as ReadResult
    from scenelang.interpreter.runtime.limits import Limits as Limits
    from scenelang.interpreter.scene.entity import Entity as Entity
    from scenelang.inversion import InversionModels as InversionModels
    from scenelang.inversion import PictureSubject as PictureSubject
    from scenelang.inversion import RunFolder as RunFolder
    from scenelang.inversion import invert as invert
    from scenelang.inversion import learn_style as learn_style
    from scenelang.neural import DistillationModels as DistillationModels
    from scenelang.neural import ImagineSettings as ImagineSettings
    from scenelang.neural import distill as distill
    from scenelang.neural import imagine as imagine
    from scenelang.neural import imagine_layout as imagine_layout
    from scenelang.scene import Camera as Camera
    from scenelang.scene import Film as Film
    from scenelang.scene import Image as Image
    from scenelang.scene import Maps as Maps
    from scenelang.scene import Primitives as Primitives
    from scenelang.scene import Scene as Scene
    from scenelang.session import Checked as Checked
    from scenelang.session import Evaluated as Evaluated
    from scenelang.session import Options as Options
    from scenelang.session import Session as Session

# In a checkout the other folders lie beside this one; found here, they work from the repository's root too.
if not (Path(__file__).parent / "grammar").is_dir():
    __path__.append(str(Path(__file__).parent.parent))

# Where each public name lives: it is imported when it is first used, so that a part costs only what it needs.
_HOMES = {
    "check": "api", "diff": "api", "evaluate": "api", "format": "api", "load": "api", "parse": "api",
    "transpile": "api",
    "Datum": "grammar.datum", "Source": "grammar.datum",
    "Diagnostic": "grammar.diagnostics", "SceneError": "grammar.diagnostics", "ReadResult": "grammar.reader",
    "Entity": "interpreter.scene.entity", "Limits": "interpreter.runtime.limits",
    "Camera": "scene", "Film": "scene", "Image": "scene", "Maps": "scene", "Primitives": "scene", "Scene": "scene",
    "Embeddings": "embeddings", "Granularity": "backends.neural.sentences", "Models": "backends.neural.weights",
    "InversionModels": "inversion", "InversionSettings": "backends.neural.inversion", "PictureSubject": "inversion",
    "RunFolder": "inversion", "invert": "inversion", "learn_style": "inversion",
    "DistillationModels": "neural", "DistillationSettings": "backends.neural.distillation.learning",
    "ImagineSettings": "neural", "distill": "neural", "imagine": "neural", "imagine_layout": "neural",
    "Checked": "session", "Evaluated": "session", "Options": "session", "Session": "session",
}  # fmt: skip
__all__ = sorted(_HOMES)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'scenelang' has no attribute {name!r}")
    return getattr(import_module(f"scenelang.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return [*__all__, *(name for name in globals() if name.startswith("__"))]
