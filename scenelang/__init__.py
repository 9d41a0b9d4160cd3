"""Python API of the Scene Language: scenes as programs, words and embeddings (docs/python.md).

>>> import scenelang as sl
>>> scene = sl.evaluate('(bind "dot" (lambda () (call "sphere" :radius 2)))')
>>> scene.bounds.tolist()
[[-2.0, -2.0, -2.0], [2.0, 2.0, 2.0]]
"""

from __future__ import annotations

import os

TYPE_CHECKING = False  # as in ``typing``, whose import takes as long as the rest of this file
if TYPE_CHECKING:
    from typing import Any

    from scenelang.api import build as build
    from scenelang.api import check as check
    from scenelang.api import check_installation as check_installation
    from scenelang.api import diff as diff
    from scenelang.api import edit as edit
    from scenelang.api import edit_instance as edit_instance
    from scenelang.api import evaluate as evaluate
    from scenelang.api import expand as expand
    from scenelang.api import explain as explain
    from scenelang.api import format as format
    from scenelang.api import generate as generate
    from scenelang.api import grammar_text as grammar_text
    from scenelang.api import import_build as import_build
    from scenelang.api import list_backends as list_backends
    from scenelang.api import load as load
    from scenelang.api import parse as parse
    from scenelang.api import primer as primer
    from scenelang.api import repair as repair
    from scenelang.api import resume as resume
    from scenelang.api import search as search
    from scenelang.api import simplify as simplify
    from scenelang.api import transpile as transpile
    from scenelang.backends.labels.maps import Maps as Maps
    from scenelang.backends.neural.distillation.training import DistillationSettings as DistillationSettings
    from scenelang.backends.neural.inversion import InversionSettings as InversionSettings
    from scenelang.backends.neural.prompts import Granularity as Granularity
    from scenelang.backends.neural.weights import Models as Models
    from scenelang.backends.pictures.figures import Figure as Figure
    from scenelang.backends.pictures.images import Camera as Camera
    from scenelang.backends.pictures.images import Film as Film
    from scenelang.backends.pictures.images import Image as Image
    from scenelang.bench.benchmark import BenchReport as BenchReport
    from scenelang.bench.benchmark import benchmark as benchmark
    from scenelang.bench.benchmark import benchmark_report as benchmark_report
    from scenelang.bench.benchmark import compare_benchmarks as compare_benchmarks
    from scenelang.bench.benchmark import measure_diagnostics as measure_diagnostics
    from scenelang.datasets.describing import preview_dataset as preview_dataset
    from scenelang.datasets.running import DatasetProgress as DatasetProgress
    from scenelang.datasets.running import DatasetReport as DatasetReport
    from scenelang.datasets.running import dataset as dataset
    from scenelang.datasets.running import dataset_sample as dataset_sample
    from scenelang.datasets.running import dataset_status as dataset_status
    from scenelang.datasets.running import merge_datasets as merge_datasets
    from scenelang.datasets.running import verify_dataset as verify_dataset
    from scenelang.evaluation.subjects import MetricOptions as MetricOptions
    from scenelang.evaluation.subjects import MetricReport as MetricReport
    from scenelang.evaluation.subjects import evaluate_metrics as evaluate_metrics
    from scenelang.grammar.datum import Datum as Datum
    from scenelang.grammar.datum import Source as Source
    from scenelang.grammar.diagnostics import Diagnostic as Diagnostic
    from scenelang.grammar.diagnostics import SceneError as SceneError
    from scenelang.grammar.diagnostics import UsageError as UsageError
    from scenelang.grammar.reader import ReadResult as ReadResult
    from scenelang.inference.generation import Edited as Edited
    from scenelang.inference.generation import Estimate as Estimate
    from scenelang.inference.generation import Generated as Generated
    from scenelang.inference.generation import estimate as estimate
    from scenelang.inference.generation import runs as runs
    from scenelang.inference.records import InferenceSettings as InferenceSettings
    from scenelang.inference.records import Run as Run
    from scenelang.interpreter.scene.entity import Entity as Entity
    from scenelang.interpreter.values.limits import Limits as Limits
    from scenelang.learning.embeddings import Embeddings as Embeddings
    from scenelang.learning.inversion import InversionModels as InversionModels
    from scenelang.learning.inversion import PictureSubject as PictureSubject
    from scenelang.learning.inversion import RunFolder as RunFolder
    from scenelang.learning.inversion import invert as invert
    from scenelang.learning.inversion import learn_style as learn_style
    from scenelang.learning.neural import DistillationModels as DistillationModels
    from scenelang.learning.neural import ImagineSettings as ImagineSettings
    from scenelang.learning.neural import distill as distill
    from scenelang.learning.neural import imagine as imagine
    from scenelang.learning.neural import imagine_layout as imagine_layout
    from scenelang.repairs.repairing import Repair as Repair
    from scenelang.scene import Scene as Scene
    from scenelang.session.loaded import Primitives as Primitives
    from scenelang.session.session import Checked as Checked
    from scenelang.session.session import Evaluated as Evaluated
    from scenelang.session.session import Options as Options
    from scenelang.session.session import Session as Session

# In a checkout the other packages are siblings of this folder; extend the path to import them from here.
if not os.path.isdir(os.path.join(os.path.dirname(__file__), "grammar")):
    __path__.append(os.path.dirname(os.path.dirname(__file__)))

# Module of each public name, imported lazily on first access to keep startup fast.
_HOMES = {
    "check": "api", "check_installation": "api", "diff": "api", "edit_instance": "api", "evaluate": "api",
    "expand": "api", "explain": "api", "format": "api", "grammar_text": "api", "import_build": "api", "simplify": "api",
    "list_backends": "api", "load": "api", "parse": "api", "repair": "api", "search": "api", "transpile": "api",
    "DistillationSettings": "backends.neural.distillation.training",
    "InversionSettings": "backends.neural.inversion", "Granularity": "backends.neural.prompts",
    "BenchReport": "bench.benchmark", "benchmark": "bench.benchmark", "benchmark_report": "bench.benchmark",
    "compare_benchmarks": "bench.benchmark", "measure_diagnostics": "bench.benchmark",
    "DatasetProgress": "datasets.running", "DatasetReport": "datasets.running", "dataset": "datasets.running",
    "dataset_sample": "datasets.running", "dataset_status": "datasets.running", "merge_datasets": "datasets.running",
    "preview_dataset": "datasets.describing", "verify_dataset": "datasets.running", "Models": "backends.neural.weights",
    "Embeddings": "learning.embeddings", "MetricOptions": "evaluation.subjects", "MetricReport": "evaluation.subjects",
    "evaluate_metrics": "evaluation.subjects", "Datum": "grammar.datum", "Source": "grammar.datum",
    "Diagnostic": "grammar.diagnostics", "SceneError": "grammar.diagnostics", "UsageError": "grammar.diagnostics",
    "ReadResult": "grammar.reader", "Edited": "inference.generation", "Estimate": "inference.generation",
    "Generated": "inference.generation", "edit": "api", "estimate": "inference.generation",
    "build": "api", "generate": "api", "primer": "api", "resume": "api", "runs": "inference.generation",
    "InferenceSettings": "inference.records", "Run": "inference.records", "Limits": "interpreter.values.limits",
    "Entity": "interpreter.scene.entity", "InversionModels": "learning.inversion",
    "PictureSubject": "learning.inversion",
    "RunFolder": "learning.inversion", "invert": "learning.inversion", "learn_style": "learning.inversion",
    "DistillationModels": "learning.neural",
    "ImagineSettings": "learning.neural", "distill": "learning.neural", "imagine": "learning.neural",
    "imagine_layout": "learning.neural",
    "Camera": "backends.pictures.images", "Film": "backends.pictures.images", "Image": "backends.pictures.images",
    "Figure": "backends.pictures.figures",
    "Maps": "backends.labels.maps", "Primitives": "session.loaded",
    "Repair": "repairs.repairing",
    "Scene": "scene", "Checked": "session.session",
    "Evaluated": "session.session", "Options": "session.session", "Session": "session.session",
}  # fmt: skip


def __getattr__(name: str) -> Any:
    if name == "__all__":
        return _present_names()
    if name not in _HOMES:
        raise AttributeError(f"module 'scenelang' has no attribute {name!r}")
    return _imported(f"scenelang.{_HOMES[name]}", name)


def _imported(module: str, name: str) -> Any:
    """Return an object of a module; raises SceneError if this installation lacks the module."""
    from importlib import import_module

    try:
        return getattr(import_module(module), name)
    except ModuleNotFoundError as error:
        from scenelang.grammar.diagnostics import missing_part

        part = missing_part(error)
        if part is None:
            raise
        raise part from error


def _present_names() -> list[str]:
    """Return the sorted public names whose modules this installation has."""
    from scenelang.interpreter.loading import is_present

    present = {home for home in set(_HOMES.values()) if is_present(f"scenelang.{home}")}
    return sorted(name for name, home in _HOMES.items() if home in present)


def load_ipython_extension(shell: Any) -> None:
    """Register the cell magic ``%%scene``; called by ``%load_ext scenelang``."""
    from scenelang.scene import Scene

    _imported("scenelang.notebook.magic", "register")(shell, Scene)


def __dir__() -> list[str]:
    return [*_present_names(), *(name for name in globals() if name.startswith("__"))]
