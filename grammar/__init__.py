"""Syntax of the Scene Language: reading, printing and formatting text, independent of what programs mean.

``datum`` defines sources, spans and datums, ``reader`` parses text and ``ast`` core forms, both with the tables that
``lalr`` has of the grammars; ``concrete``, ``layout`` and ``formatter`` print; ``diagnostics`` defines all error codes
and their rendering; ``settings`` declares command-line options. Nothing is imported but the standard library; only
making the tables needs lark.
"""
