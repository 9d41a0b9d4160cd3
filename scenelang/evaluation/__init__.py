"""Metrics of scenes as in the paper, as tables, and a page that asks people (docs/evaluation.md).

``subjects`` are what is measured and how it is drawn, ``running`` measures and keeps, ``tables`` lays out, ``study``
makes the page. The metrics themselves are in ``backends.neural.metrics``.
"""
