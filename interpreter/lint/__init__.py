"""Lints: warnings about programs without errors, found by static analysis.

``rules`` has the lints of a single top-level form, ``lint`` those of the whole program, fixes and suppression comments.
Lints of the geometry of a scene are in ``backends.geometry.lint``.
"""
