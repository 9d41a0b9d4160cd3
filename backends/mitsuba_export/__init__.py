"""Export to Mitsuba's scene XML: what the quality "final" renders, as a file that Mitsuba reads.

Above ``pictures``, whose conversion to Mitsuba it uses, and ``exports``, whose plan of shared parts it follows.
"""
