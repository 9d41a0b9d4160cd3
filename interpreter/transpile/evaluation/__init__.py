"""Evaluation of Python during the translation, by an interpreter of its syntax tree that never executes Python.

What the translation proper does not support is evaluated here (``folding``); the rest of the program stays as it is.
"""
