"""The grammar as text for other programs: decoders of language models, parser generators, editors, people."""
