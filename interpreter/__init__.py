"""Meaning: expansion, analysis, compilation and evaluation of programs; the entity DAG and its geometry."""
