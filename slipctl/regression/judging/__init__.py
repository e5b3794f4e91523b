"""Numbers of now against numbers of then: what became of each, and which tolerance was due."""
