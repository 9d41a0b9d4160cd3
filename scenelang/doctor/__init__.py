"""What is installed, what works and what is missing: the checks behind the command doctor."""
