"""Gaussian splatting (docs/splatting.md).

``gaussians`` is the model and its projection, ``initial`` covers primitives with Gaussians and lights them, the
``rasterise`` files draw (torch, numba, gsplat), ``files`` reads and writes, ``backend`` is the quality "splats". It
does not know how Gaussians are learned.
"""
