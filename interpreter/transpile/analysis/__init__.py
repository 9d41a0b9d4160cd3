"""What the Python means, found out before a word is written: names, liveness, types, effects, the root."""
