"""What the format names but this release lacks is refused by name."""

import pytest

from slipctl.scenario.later import LATER_VALUES
from tests.scenario.documents import PAPER, changed, refused


def later(document):
    return {problem.key: problem for problem in refused(document) if problem.later}


@pytest.mark.parametrize(
    ("key", "value"), [(key, value) for key, values in LATER_VALUES.items() for value in values]
)
def test_kinds_and_sources_that_come_later(key, value):
    key = key.replace("controller.", "controller.1.")
    problems = later(changed(PAPER, {key: value}))
    assert len(problems) == 1
    text = str(*problems.values())
    assert f'found "{value}", which comes with a later release of slipctl; available now: ' in text
