"""A law of one's own, as pytest checks it: beside the listed controllers, and against its own baseline."""
