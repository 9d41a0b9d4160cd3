"""Playground: the interpreter in a browser by Pyodide, without packages (docs/playground.md).

``in_browser`` answers the page inside a web worker, ``archive`` packs the modules that it needs. ``numpy`` and
``manifold3d`` stand for the packages of these names, which Pyodide's own files do not contain: they are on the module
path in the browser only. The page is made from ``backends/viewer/source`` by ``make playground``.
"""
