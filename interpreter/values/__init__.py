"""Values of programs and the limits of a run: what everything else is made of.

``values`` defines the runtime values, ``limits`` counts steps, time and memory. Nothing here knows entities or forms.
"""
