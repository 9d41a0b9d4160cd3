"""Labeled datasets from programs (docs/datasets.md).

``spec`` reads what varies from a TOML file, ``sampler`` draws one sample of it, ``making`` evaluates and labels that
sample, ``store`` keeps samples in shards, ``running`` runs workers and resumes, ``cluster`` does so on Ray, ``preview``
shows and describes a dataset. Nothing here knows the command line; pixels and labels come from ``backends/labels``.
"""
