"""A hardening body under a stepped sine, as a laboratory would measure it: data/harmonic_set."""
