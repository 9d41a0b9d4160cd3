"""Embeddings and neural models of scenes in the Python API.

``embeddings`` are lists and changes of vectors, ``inversion`` learns them from images, ``neural`` makes images and
optimizes scenes. The models are in ``backends.neural``.
"""
