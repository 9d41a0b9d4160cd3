"""Playground: the interpreter in a browser by Pyodide, without packages (docs/playground.md).

``in_browser`` answers the page inside a web worker, ``archive`` packs the modules that it needs. ``numpy`` and
``manifold3d`` stand for the packages of these names, which Pyodide's own files do not contain: they are on the module
path in the browser only. The page is made from ``backends/viewer/source`` by ``make playground``.
"""

from scenelang.grammar.diagnostics import SceneError

DESKTOP = "use the desktop version, where everything is installed"


class MissingError(SceneError, AttributeError):  # type: ignore[misc]  # both have a `name`
    """What the playground's arrays lack; an AttributeError, as ``import`` and ``hasattr`` expect one."""

    def __init__(self, name: str) -> None:
        SceneError.__init__(self, "unsupported", f"it needs {name}, which the playground does not have", DESKTOP)
