"""Gaussian splatting (docs/splatting.md).

``gaussians`` contains the model and its projection, ``initial`` covers primitives with Gaussians and lights them, the
``rasterise`` modules render (torch, numba, gsplat), ``files`` reads and writes, ``backend`` is the quality "splats".
The package does not depend on how Gaussians are optimized.
"""
