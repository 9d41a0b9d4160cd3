"""Versions of the game, and what its files call them."""

from __future__ import annotations

from dataclasses import dataclass

from scenelang.grammar.diagnostics import SceneError, suggest

# Data versions are those of npm's minecraft-data 3.117 (common/protocolVersions.json), formats of data packs those of
# the table at https://minecraft.wiki/w/Pack_format; the game counts minor formats since 1.21.9.
_RELEASES = """
1.13 1519 4, 1.13.1 1628 4, 1.13.2 1631 4, 1.14 1952 4, 1.14.1 1957 4, 1.14.2 1963 4, 1.14.3 1968 4, 1.14.4 1976 4,
1.15 2225 5, 1.15.1 2227 5, 1.15.2 2230 5, 1.16 2566 5, 1.16.1 2567 5, 1.16.2 2578 6, 1.16.3 2580 6, 1.16.4 2584 6,
1.16.5 2586 6, 1.17 2724 7, 1.17.1 2730 7, 1.18 2860 8, 1.18.1 2865 8, 1.18.2 2975 9, 1.19 3105 10, 1.19.1 3117 10,
1.19.2 3120 10, 1.19.3 3218 10, 1.19.4 3337 12, 1.20 3463 15, 1.20.1 3465 15, 1.20.2 3578 18, 1.20.3 3698 26,
1.20.4 3700 26, 1.20.5 3837 41, 1.20.6 3839 41, 1.21 3953 48, 1.21.1 3955 48, 1.21.2 4080 57, 1.21.3 4082 57,
1.21.4 4189 61, 1.21.5 4325 71, 1.21.6 4435 80, 1.21.7 4438 81, 1.21.8 4440 81, 1.21.9 4554 88.0, 1.21.10 4556 88.0,
1.21.11 4671 94.1, 26.1 4786 101.1, 26.1.1 4788 101.1, 26.1.2 4790 101.1
"""
DEFAULT = "26.1"  # the version of the table of blocks


@dataclass(frozen=True, slots=True)
class GameVersion:
    """A release of the game. ``data_version`` is its number in files; ``pack_format`` the major and minor format of
    data packs, the minor one None for versions that have none."""

    name: str
    data_version: int
    pack_format: tuple[int, int | None]

    def is_before(self, name: str) -> bool:
        """True for versions older than the release ``name``."""
        return self.data_version < _VERSIONS[name].data_version


def game_version(text: str = DEFAULT) -> GameVersion:
    """The release that people call ``text``, from 1.13 to 26.1.2; raises SceneError("value") for others."""
    name = text.strip().lower().removeprefix("v")
    if name in _VERSIONS:
        return _VERSIONS[name]
    message = (
        f"the version `{text[:30]}` of Minecraft is not known; releases from 1.13 to {next(reversed(_VERSIONS))} are"
    )
    raise SceneError("value", message, hint=suggest(name[:30], _VERSIONS))


def _release(text: str) -> GameVersion:
    name, data_version, pack_format = text.split()
    major, _, minor = pack_format.partition(".")
    return GameVersion(name, int(data_version), (int(major), int(minor) if minor else None))


_VERSIONS = {release.name: release for release in map(_release, _RELEASES.split(","))}
