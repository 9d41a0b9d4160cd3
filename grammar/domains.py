"""The domains of the package, by their folders: what a message calls a part that an installation lacks.

No domain is imported for it. docs/architecture.md has the same table, with the needs of each domain.
"""

from __future__ import annotations

DOMAINS = {
    "backends/pictures": "pictures",
    "backends/exports": "exports",
    "backends/mitsuba_export": "Mitsuba export",
    "backends/labels": "labels",
    "backends/viewer": "viewer",
    "scenelang/viewer": "viewer",
    "scenelang/playground": "playground",
    "backends/geometry": "geometry checks",
    "backends/physics": "physics",
    "backends/minecraft": "Minecraft",
    "backends/deepslate": "Minecraft pages",
    "backends/openscad": "OpenSCAD",
    "backends/blender": "Blender",
    "scenelang/blender": "Blender",
    "interpreter/transpile": "Python",
    "interpreter/lift": "Python",
    "scenelang/translation": "Python",
    "scenelang/repairs": "repair",
    "backends/neural": "neural",
    "scenelang/learning": "neural",
    "scenelang/evaluation": "neural",
    "scenelang/datasets": "datasets",
    "scenelang/inference": "inference",
    "backends/language_models": "inference",
    "scenelang/bench": "bench",
    "scenelang/repl": "REPL",
    "scenelang/lsp": "LSP",
    "scenelang/mcp": "MCP",
    "scenelang/notebook": "notebook",
}


def domain_of_module(module: str) -> str | None:
    """Return the name of the domain that a module of ours belongs to; None in the kernel and for other packages.

    Examples
    --------
    >>> domain_of_module("scenelang.backends.physics.verdicts")
    'physics'
    """
    parts = module.split(".")
    if parts[0] != "scenelang":
        return None
    path = "/".join(parts[1:] if parts[1:2] in (["backends"], ["interpreter"]) else parts)
    return next((name for folder, name in DOMAINS.items() if f"{path}/".startswith(f"{folder}/")), None)
