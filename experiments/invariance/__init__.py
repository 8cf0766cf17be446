"""The same campaign in other units of time, length and mass must get the same verdicts."""
