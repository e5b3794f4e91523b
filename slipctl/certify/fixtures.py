"""Every fixture, in the order in which they are shown."""

from __future__ import annotations

from slipctl.certify import body, grip, laws, numerics, slide

FIXTURES = (*body.FIXTURES, *slide.FIXTURES, *grip.FIXTURES, *laws.FIXTURES, *numerics.FIXTURES)
