"""The pictures of the documentation: each law's absence, and the tour's."""
