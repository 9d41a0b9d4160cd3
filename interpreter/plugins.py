"""Registries of what packages add through entry points: primitives, backends, qualities, filters, providers, services.

A service is a function or a module that a domain offers to the kernel and to other domains, which work without it too
(docs/architecture.md): Python's front end, cubes for Minecraft blocks, checks of geometry and physics.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Generic, TypeVar

from scenelang.grammar.datum import dataclass
from scenelang.grammar.diagnostics import MissingPart, SceneError, suggest
from scenelang.interpreter.loading import entry_points_of

Plugin = TypeVar("Plugin")


@dataclass(frozen=True, slots=True)
class PluginRegistry(Generic[Plugin]):
    """Plug-ins of one kind, registered by packages in the entry-point group ``group``.

    ``kind`` is the noun used in messages, ``cls`` the required class, ``error`` the code of the error for an unknown
    name.
    """

    group: str
    kind: str
    cls: type[Plugin]
    error: str = "backend"

    def names(self) -> list[str]:
        """Return the sorted names of all plug-ins without loading them."""
        return sorted(self._points())

    def get(self, name: str) -> Plugin | None:
        """Return the plug-in ``name``, or None if it does not exist; raises SceneError if it cannot be loaded."""
        point = self._points().get(name)
        return None if point is None else self._load(point)

    def find(self, name: str) -> Plugin:
        """Return the plug-in ``name``; raises SceneError if it does not exist or cannot be loaded."""
        plugin = self.get(name)
        if plugin is not None:
            return plugin
        known = self.names()
        listed = f"available: {', '.join(known)}" if known else "none installed: `pip install scenelang`"
        raise SceneError(self.error, f"unknown {self.kind} `{name}` ({listed})", hint=suggest(name, known))

    def optional(self, name: str) -> Plugin | None:
        """Return the plug-in ``name``, or None if this installation lacks it or a module that it needs."""
        try:
            return self.get(name)
        except SceneError as error:
            if isinstance(error.__cause__, ModuleNotFoundError):
                return None
            raise

    def all(self) -> list[Plugin]:
        """Return all plug-ins that load, sorted by name; ``find`` reports why the others fail."""
        listed = []
        for _, point in sorted(self._points().items()):
            try:
                listed.append(self._listed(point))
            except SceneError:
                continue
        return listed

    def _listed(self, point: Any) -> Plugin:
        """Return the plug-in for a list, which need not be able to run."""
        return self._load(point)

    def _points(self) -> Mapping[str, Any]:
        return entry_points_of(self.group)

    def _load(self, point: Any) -> Plugin:
        try:
            plugin = point.load()
        except MissingPart:
            raise
        except Exception as error:  # importing third-party code may raise any exception
            raise SceneError("backend", f"the {self.kind} `{point.name}` cannot be loaded: {error}") from error
        if not isinstance(plugin, self.cls):
            message = f"the entry point `{point.name}` is not a {self.cls.__name__} ({point.value})"
            raise SceneError("backend", message)
        return plugin


SERVICES: PluginRegistry[Any] = PluginRegistry("scenelang.services", "feature", object)
