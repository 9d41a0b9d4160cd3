"""Sessions with programs in other languages: a language model's Python, which is translated and never executed.

Above ``session``, which finds it through the registry of services and works without it; it knows nothing of backends.
"""
