"""Recovery studies: plant an equation, see it through ordinary sensors, get it back; with the bound beside."""
