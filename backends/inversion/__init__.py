"""Textual Inversion: token vectors for which a diffusion model takes a sentence for a picture (the paper, appendix
"Textual Inversion Optimization")."""
