"""Whether posterior draws are calibrated: ranks of the truth among them, and coverage of their intervals."""
