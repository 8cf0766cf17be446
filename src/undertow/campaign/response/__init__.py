"""Campaigns of harmonic sets: from a config with amplitudes by frequency to an equation, its page, its predictions."""
