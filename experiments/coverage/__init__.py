"""Coverage: do the stated intervals hold the truth as often as they say? Synthetic campaigns of few trials."""
