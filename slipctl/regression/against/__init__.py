"""``slipctl check --against``: another git revision or a run folder, in place of the baseline."""
