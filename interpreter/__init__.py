"""What programs mean: expansion, compilation, evaluation, the entity graph and its geometry.

A program passes through ``program``, ``expand``, ``compile`` and ``runtime``, and leaves as a graph of ``scene``;
``lint`` finds likely mistakes before it runs, ``transpile`` makes programs of a language model's Python. The standard
library comes in through an interface (``runtime.types.Library``): nothing here imports ``stdlib`` or a backend.
"""
