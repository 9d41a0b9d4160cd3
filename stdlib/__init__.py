"""Builtins of the language, one module per topic, and modules written in the language (``*.scene``).

A builtin is registered once, with its signature, types, doc and example. ``library`` collects the topics, ``reference``
generates documentation and grammars from them, ``operands`` has the helpers that topics share. The package does no
rendering and writes no files.
"""
