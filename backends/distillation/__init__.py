"""Score distillation: the Gaussians of every primitive learned from diffusion models, g_reparam (the paper, appendix
"SDS-Based Renderer")."""
