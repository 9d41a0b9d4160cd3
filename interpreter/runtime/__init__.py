"""One run of a program.

``values`` and ``types`` are what programs compute with, ``procedures`` what is called, ``runtime`` the state of a run,
``limits`` what ends it, ``show`` prints values, ``evaluate`` puts it together. Calls are shared: the docstring of
``runtime`` says when. It knows no builtin and no backend.
"""
