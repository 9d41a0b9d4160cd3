"""Things found in photographs by words, and cut out of them: GroundingDINO, SAM, and what the paper makes of the part
that they find (appendix "Textual Inversion Optimization")."""
