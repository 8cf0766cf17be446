"""Counts of verdicts that were right on sealed campaigns, by kind of verdict."""
