"""Score distillation: optimization of Gaussians and poses under diffusion models (docs/distillation.md).

``theta`` contains the parameters, ``sds`` the gradient, ``training`` the optimization, ``run`` the training loop,
checkpoints and rendering. The package does not depend on the program from which the entities come.
"""
