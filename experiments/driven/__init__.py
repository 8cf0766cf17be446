"""Driven benchmarks on their training parts: validation on the last fifth, the table of docs/driven_measured.md."""
