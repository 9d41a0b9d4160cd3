"""Facts of a frame: instances, bodies, ground, contacts, support and statics, computed once for everything that judges
a scene (docs/facts.md).

It knows no checks, messages or simulations, and no nouns: words never decide a fact.
"""
