"""Files beside programs.

``zfile`` reads and writes embeddings, ``toml_places`` settings in TOML with the places of their values. Nothing here
evaluates.
"""
