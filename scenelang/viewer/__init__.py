"""`scenelang view`: a local server that shows programs, watches their files and writes params back."""
