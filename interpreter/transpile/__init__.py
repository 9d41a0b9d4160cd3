"""Transpiler from a language model's Python to a program of the language; the Python is parsed, never executed.

``python_text`` extracts and parses the code, ``analysis`` resolves names and infers types, ``writing`` generates the
program, and ``translate`` runs all of these steps (docs/transpiler.md). The helper API is known from a table; it is not
imported.
"""
