"""Benchmark of language models (docs/bench.md).

``tasks`` are data, ``scoring`` judges a program by the declarations of its task, ``answering`` asks a service, a
recording or the mutation model, ``mutations`` plants mistakes (``mistake_kinds``) and repairs them, ``trials`` runs
tasks in modes and saves what came of them, ``results`` makes tables and comparisons, ``benchmark`` has the public
functions. Nothing here knows the command line.
"""
