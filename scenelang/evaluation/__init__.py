"""Metrics of scenes in the layout of the paper's tables, and its user study (docs/evaluation.md).

``subjects`` defines what is measured and how it is rendered, ``running`` measures and stores results, ``tables``
formats them, ``study`` creates the questionnaire. The metrics are implemented in ``backends.neural.metrics``.
"""
