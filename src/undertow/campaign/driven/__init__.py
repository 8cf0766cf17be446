"""Campaigns of driven bodies: from a config with a measured input to an equation, its page, and its predictions."""
