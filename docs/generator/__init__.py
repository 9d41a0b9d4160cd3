"""Writes what of the documentation is generated: ``make docs``. Every page comes from the tables that the program
itself uses, so that it cannot say anything else."""
