"""Embeddings in the text space of OpenCLIP: the paper's g_CLIP (section 4)."""
