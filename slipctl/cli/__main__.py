"""``python -m slipctl.cli``: the command where the program is not on the path."""

import sys

from slipctl.cli import main

sys.exit(main())
