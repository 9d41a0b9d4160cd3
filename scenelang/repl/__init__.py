"""REPL for the terminal, or driven by another program through plain streams (docs/repl.md).

``loop`` dispatches inputs, ``evaluation`` evaluates them, ``commands`` implements commands, ``display`` formats values;
``console`` is the terminal front end, ``plain`` the stream front end.
"""
