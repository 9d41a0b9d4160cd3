"""Execution of a single run of a program.

``values`` and ``types`` define runtime values, ``procedures`` callable values, ``runtime`` the state of a run,
``limits`` resource limits, ``show`` printing, ``evaluate`` the entry point. Calls with equal arguments may share a
result; see ``runtime``. Nothing here depends on a builtin or a backend.
"""
