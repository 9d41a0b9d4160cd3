"""A language model's Python as a program of the language; the Python is parsed and never executed.

``python_text`` finds the code and parses it, ``analysis`` finds out what it means, ``writing`` writes the program,
``translate`` is all of it (docs/transpiler.md). It knows the helper API by its table, not by running it.
"""
