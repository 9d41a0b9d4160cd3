"""Score distillation: Gaussians and poses optimised under a diffusion model (docs/distillation.md).

``theta`` holds what is learned, ``sds`` is the gradient, ``learning`` makes one step after another, ``run`` keeps and
draws. It does not know which program the entities come from.
"""
