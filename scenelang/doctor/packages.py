"""Packages: the versions of those that are needed, and what the extras lack."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Sequence
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path

from scenelang.doctor.check import Check, State

_REQUIREMENT = re.compile(r"([A-Za-z0-9][A-Za-z0-9._-]*)[^;]*(?:;(.*))?")
_EXTRA = re.compile(r"""extra\s*==\s*['"]([^'"]+)['"]""")
_FOR_DEVELOPMENT = ("dev", "blender", "all")


def version_of(package: str) -> str | None:
    """The version of an installed distribution, None for one that is not installed."""
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def in_pipx() -> bool:
    """Whether pipx made the environment that runs this: pip does not reach it from outside."""
    return (Path(sys.prefix) / "pipx_metadata.json").exists()


def package_checks() -> Iterator[Check]:
    """What the package needs, then each extra."""
    try:
        stated = requires("scenelang") or []
    except PackageNotFoundError:
        yield Check("packages", "scenelang", State.NOTE, "runs from its sources, so its needs are not known")
        return
    extras: dict[str, list[str]] = {}
    for line in stated:
        match = _REQUIREMENT.match(line)
        if match is None:
            continue
        name, marker = match[1], match[2] or ""
        extra = _EXTRA.search(marker)
        if extra is None:
            yield _needed(name, bool(marker.strip()))
        else:
            extras.setdefault(extra[1], []).append(name)
    for extra_name, packages in extras.items():
        if extra_name not in _FOR_DEVELOPMENT:
            yield _extra(extra_name, packages)


def _needed(package: str, only_sometimes: bool) -> Check:
    found = version_of(package)
    if found is not None:
        return Check("packages", package, State.OK, found)
    if only_sometimes:
        return Check("packages", package, State.NOTE, "not installed; not every platform has it")
    return Check("packages", package, State.BROKEN, "not installed", f"pip install {package}")


def _extra(name: str, packages: Sequence[str]) -> Check:
    """An extra with the versions of its packages, or with those that it lacks."""
    versions = {package: version_of(package) for package in packages}
    lacking = [package for package, found in versions.items() if found is None]
    if lacking:
        remedy = f"pipx inject scenelang {' '.join(lacking)}" if in_pipx() else f"pip install 'scenelang[{name}]'"
        return Check("extras", name, State.MISSING, f"not installed: {', '.join(lacking)}", remedy)
    return Check("extras", name, State.OK, ", ".join(f"{package} {found}" for package, found in versions.items()))
