"""Score distillation: Gaussians and poses optimised under a diffusion model."""
