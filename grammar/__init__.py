"""Syntax of the Scene Language: reading, printing and formatting text, independent of what programs mean.

``datum`` defines sources, spans and datums, ``reader`` parses text, ``ast`` parses core forms by ``core.lark``, both with
the tables of ``lalr``; ``concrete``, ``layout`` and ``formatter`` print; ``diagnostics`` defines all error codes and their
rendering; ``settings`` declares command-line options. There are no dependencies; only making the tables needs lark.
"""
