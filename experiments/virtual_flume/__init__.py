"""The virtual flume: an independent numerical truth for the method; it imports nothing of undertow.

Here: geometry, a Laplace solver, its frequency-domain answer, a time march with the structure, and the
recordings made with them. Not here: any identification, and any number fitted to the physical test's
published results.
"""
