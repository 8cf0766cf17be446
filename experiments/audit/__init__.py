"""Studies of the audit of published tables."""
