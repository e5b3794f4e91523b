"""What every test shares: no usage data, and the same generated inputs on every machine."""

import os

from hypothesis import settings

os.environ.setdefault("CI", "1")  # Rerun sends no usage data from CI

settings.register_profile("slipctl", deadline=None, derandomize=True, max_examples=50)
settings.load_profile("slipctl")
