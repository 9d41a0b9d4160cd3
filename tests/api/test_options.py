"""Whatever a command can do, the Python API can do: every option is a parameter of the API, or is named below."""

from __future__ import annotations

import argparse
import inspect
from collections.abc import Callable, Iterator
from functools import cache
from importlib import import_module
from typing import Any

import pytest

import scenelang as sl
from scenelang.backends import base
from scenelang.cli.main import build_parser

# Options of the terminal: how a result is shown, where it is written, and what only a process has.
TERMINAL = {
    "quiet": "warnings are values", "verbose": "warnings are values", "json": "results are values",
    "no_color": "results are values", "output": "results are values, or have `save`", "file": "a text, or `load`",
    "files": "texts, or `load`", "max_memory": "`Limits.memory`, within the process", "no_browser": "no browser is opened",
    "port": "there is no server", "print": "results are values", "list": "`benchmark` has the names", "prompt": "a prompt",
    "plain": "a prompt", "check": "compare the texts", "diff": "compare the texts",
}  # fmt: skip

# Commands that are servers, shells, or lists of what is installed.
WITHOUT_API = frozenset({"repl", "lsp", "mcp", "completion", "studio"})

# What a command calls, and under another name: parameters of these or other functions, or nothing but a call.
CALLS: dict[str, tuple[str, ...]] = {
    "check": ("check", "Options", "Scene.physics"), "run": ("evaluate",), "fmt": ("format",), "explain": ("explain",),
    "diff": ("diff",), "expand": ("expand",), "transpile": ("transpile",), "simplify": ("simplify",), "import": ("import_build",),
    "render": ("Scene.render", "Scene.film", "Film.save", "Figure"), "sheet": ("Scene.sheet", "Scene.comparison", "Figure"),
    "view": ("Scene.html",), "labels": ("Scene.maps", "Maps.save"),
    "dataset": ("dataset", "preview_dataset", "merge_datasets", "verify_dataset", "dataset_sample"),
    "graph": ("Scene.save_graph",), "tree": ("Scene.tree",), "count": ("Scene.count",), "bounds": ("Scene.bounds_of",),
    "measure": ("Scene.measure",), "simulate": ("Scene.simulate", "Scene.film"), "settle": ("Scene.settle",),
    "repair": ("repair",), "flatten": ("Scene.flatten",), "export": ("Scene.export",), "backends": ("list_backends",),
    "generate": ("generate", "InferenceSettings", "Models"), "edit": ("edit", "InferenceSettings"),
    "build": ("build", "InferenceSettings"),
    "bench": ("benchmark", "InferenceSettings"), "runs": ("runs",), "embeddings": ("Embeddings.export",),
    "embed": ("Embeddings.words_of", "InferenceSettings"),
    "imagine": ("imagine", "imagine_layout", "ImagineSettings", "Granularity", "Models"),
    "invert": ("invert", "InversionSettings", "InversionModels", "PictureSubject", "Models", "RunFolder"),
    "style": ("learn_style", "InversionSettings", "InversionModels", "PictureSubject", "Models", "RunFolder"),
    "distill": ("distill", "DistillationSettings.of", "DistillationModels", "Granularity", "Models", "RunFolder"),
    "eval": ("evaluate_metrics", "MetricOptions", "Models"), "search": ("search",), "grammar": ("grammar_text",),
    "doctor": ("check_installation",),
}  # fmt: skip
ALWAYS = ("load", "Limits", "Options")
RENAMED: dict[str, dict[str, str]] = {
    "*": {"define": "load:defines", "no_images": "InferenceSettings:sends_images",
          "z": "load:embeddings", "models_dir": "Models:folder", "entity": "Granularity:named"},
    "check": {"run": "evaluate", "that": "Scene.violations:declarations", "geometry": "Session.check_geometry",
              "physics": "Scene.physics", "fix": "Session.autofix", "picture": "backends.pictures.exhibit.save_marked:path"},
    "explain": {"codes": "explain:code"}, "diff": {"a": "diff:a", "b": "diff:b"}, "search": {"words": "search:query"},
    "render": {"part": "Scene.part:path", "backend": "Scene.render:quality", "no_labels": "Scene.render:labels"},
    "sheet": {"compare": "Scene.comparison", "no_labels": "Scene.sheet:labels"}, "view": {"html": "Scene.html"}, "labels": {"views": "Camera.random:count"},
    "dataset": {"words": "dataset:spec", "preview": "preview_dataset:path", "shown": "preview_dataset:count"},
    "tree": {"all": "Scene.tree:every"}, "simulate": {"velocity": "Scene.simulate:velocities"},
    "repair": {"that": "repair:declarations", "only_declarations": "repair:geometry"},
    "generate": {"animate": "generate:kind", "minecraft": "generate:kind", "dsl": "generate:notation",
                 "image": "generate:images", "render": "Generated", "invert": "invert", "ablate": "generate:ablation",
                 "dry_run": "estimate", "resume": "resume:name", "repair": "InferenceSettings:repairs",
                 "critique": "InferenceSettings:critiques", "no_cache": "InferenceSettings:uses_replies",
                 "jobs": "InferenceSettings:side_by_side", "batch": "InferenceSettings:is_batch"},
    "build": {"animate": "build:kind", "minecraft": "build:kind", "dsl": "build:notation", "image": "build:images",
              "render": "Generated", "ask": "build:task", "ablate": "generate:ablation", "dry_run": "estimate",
              "resume": "resume:name", "repair": "InferenceSettings:repairs", "turns": "InferenceSettings:revisions",
              "no_cache": "InferenceSettings:uses_replies", "jobs": "InferenceSettings:side_by_side",
              "batch": "InferenceSettings:is_batch"},
    "edit": {"apply": "Edited.save", "limit": "Edited", "picture": "Scene.render", "ablate": "edit:ablation", "dry_run": "estimate",
             "resume": "resume:name", "repair": "InferenceSettings:repairs", "critique": "InferenceSettings:critiques",
             "no_cache": "InferenceSettings:uses_replies", "jobs": "InferenceSettings:side_by_side",
             "batch": "InferenceSettings:is_batch"},
    "bench": {"mode": "benchmark:modes", "task": "benchmark:tasks", "group": "benchmark:groups",
              "tasks": "benchmark:task_folder", "physics": "benchmark:simulates", "mistakes": "measure_diagnostics",
              "report": "benchmark_report:folder", "compare": "compare_benchmarks", "repair": "InferenceSettings:repairs",
              "no_cache": "InferenceSettings:uses_replies", "jobs": "InferenceSettings:side_by_side"},
    "runs": {"run_name": "resume:name", "runs": "runs:folder"}, "embeddings": {"action": "Embeddings"},
    "embed": {"model": "Embeddings.words_of:describe"},
    "imagine": {"layout_only": "imagine_layout", "prompt": "imagine:prompt"},
    "invert": {"from": "invert:pictures", "entity": "invert:entities", "no_segment": "PictureSubject:whole",
               "rate": "InversionSettings:learning_rate", "batch": "InversionSettings:batch_size"},
    "style": {"from": "learn_style:picture", "rate": "InversionSettings:learning_rate",
              "batch": "InversionSettings:batch_size"},
    "distill": {"film": "Scene.film", "no_scene_term": "DistillationModels:scene_term"},
    "eval": {"metric": "MetricOptions:metrics", "backend": "MetricOptions:backends", "markdown": "MetricReport.tables",
             "latex": "MetricReport.tables", "study": "MetricReport.tables", "study_results": "evaluate_metrics:answers"},
    "grammar": {"format": "grammar_text:form"},
}  # fmt: skip


def _options() -> Iterator[tuple[str, str]]:
    """Every command with each of its options and arguments."""
    commands = next(a for a in build_parser()._actions if isinstance(a, argparse._SubParsersAction))
    for command, parser in commands.choices.items():
        for action in parser._actions:
            if command not in WITHOUT_API and not isinstance(action, argparse._HelpAction):
                name = max(action.option_strings, key=len) if action.option_strings else action.dest
                yield command, name.lstrip("-").replace("-", "_")


@cache
def _named(path: str) -> Any:
    owner, _, member = path.partition(".")
    if owner in sl.__all__:
        found = getattr(sl, owner)
        return getattr(found, member) if member else found
    module, _, name = path.rpartition(".")
    return getattr(import_module(f"scenelang.{module}"), name)


@cache
def _parameters(path: str) -> frozenset[str]:
    return frozenset(inspect.signature(inspect.unwrap(_named(path))).parameters)


@cache
def _settings() -> frozenset[str]:
    """The settings of backends, which the API takes as a mapping."""
    return frozenset(option.name.replace("-", "_") for backend in base.all_backends() for option in backend.options)


def _has(command: str, option: str) -> bool:
    calls: Callable[[str], bool] = lambda name: any(name in _parameters(call) for call in (*CALLS[command], *ALWAYS))
    takes_settings = any("settings" in _parameters(call) for call in CALLS[command])
    limit = option.removeprefix("max_")
    return calls(option) or calls(limit) or (takes_settings and option in _settings())


@pytest.mark.parametrize(("command", "option"), list(_options()))
def test_an_option_is_a_parameter_of_the_api(command: str, option: str) -> None:
    renamed = RENAMED.get(command, {}).get(option) or RENAMED["*"].get(option)
    if renamed is not None:
        path, _, parameter = renamed.partition(":")
        assert not parameter or parameter in _parameters(path), f"`{path}` has no parameter `{parameter}`"
        assert _named(path) is not None
        return
    assert option in TERMINAL or _has(command, option), f"the API has no `{option}` of `{command}`"


def test_nothing_is_named_that_is_no_option() -> None:
    options = set(_options())
    commands = {command for command, _ in options}
    assert set(CALLS) == commands
    named = {(command, option) for command, rows in RENAMED.items() if command != "*" for option in rows}
    assert named <= options
    assert {*TERMINAL, *RENAMED["*"]} <= {option for _, option in options} | {"plain", "prompt"}
