"""The analytic ray caster: what rays see of posed solids."""
