"""Language models' Python -> the Scene Language. The Python is parsed and never executed."""
