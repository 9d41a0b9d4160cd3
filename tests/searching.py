"""How long random searches look: the profile ``ci`` finds again what was once found and most of what is new in seconds,
``nightly`` searches at random and for long (`make test-nightly`, or `pytest --hypothesis-profile nightly`)."""

from __future__ import annotations

from hypothesis import settings

SHARE = {"ci": 0.1, "nightly": 10.0}
LEAST = 8


def register() -> None:
    """The profiles, and ``ci`` as the one that counts unless the command line says another."""
    settings.register_profile("ci", deadline=None, max_examples=_share(100, "ci"), derandomize=True, print_blob=True)
    settings.register_profile("nightly", deadline=None, max_examples=_share(100, "nightly"), print_blob=True)
    settings.load_profile("ci")


def many(count: int) -> int:
    """How many examples a search makes under the chosen profile that alone would make ``count``."""
    return _share(count, settings.get_current_profile_name())


def places(length: int) -> range:
    """The places of a text or file that a search looks at: every third, all under ``nightly``."""
    return range(0, length, 1 if settings.get_current_profile_name() == "nightly" else 3)


def _share(count: int, profile: str) -> int:
    return max(min(count, LEAST), round(count * SHARE.get(profile, 1.0)))
