"""From the analysed Python to the program: expressions, statements, names, comments, text."""
