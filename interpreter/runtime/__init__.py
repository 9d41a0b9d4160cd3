"""Values, types, procedures, the state of one run, limits, random streams and printing."""
