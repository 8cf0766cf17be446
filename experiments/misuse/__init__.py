"""Ordinary mistakes through the command, and campaigns that are in order: what is said of each."""
