"""Scene generation from text and images: a language model proposes programs, grammar and interpreter validate them.

See section 5 of the paper. ``brief`` contains the prompts, ``steps`` evaluates answers, ``conductor`` sends requests,
repairs and selects, ``records`` stores runs, ``listing`` converts scenes to flat lists, ``generation`` implements
``generate`` and ``edit``. The package is independent of the provider.
"""
