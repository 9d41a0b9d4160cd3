"""Pictures of Gaussian splats.

``backend`` draws primitives as splats and the results of distillation, and writes .ply and .splat files. The splats
themselves are those of ``neural.splats``.
"""
