"""Words for what numbers say: colours, surfaces and proportions as a person would name them (paper, section 5)."""
