"""Scenes from words and pictures: a language model proposes, the grammar and the interpreter dispose (the paper,
section 5, "Inference via Pre-Trained Language Models")."""
