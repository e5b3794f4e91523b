"""A law with a random part: nothing is recorded that no later run could repeat."""

import dataclasses

import numpy as np
import pytest

from slipctl.control.nominal_kinematic import NominalKinematic
from slipctl.regression import CannotJudge
from slipctl.regression.own_law.check import check_law, record_law
from slipctl.scenario import load
from slipctl.theory.robust import chain_gains
from tests.fakes import SHORT_SCENARIO


@pytest.fixture
def scenario(tmp_path):
    (tmp_path / "short.toml").write_text(SHORT_SCENARIO, encoding="utf-8")
    return load(tmp_path / "short.toml")


def misled_by(noise):
    """The nominal law, told a position that is off by up to a tenth of a millimetre."""

    class Misled(NominalKinematic):
        def update(self, memory, reference, motion, tick):
            off = 1e-4 * noise(motion.position)
            return super().update(
                memory, reference, dataclasses.replace(motion, position=motion.position + off), tick
            )

    return lambda robot: Misled(robot.speed_drive(), chain_gains(np.full(robot.worlds, -1.0), 2))


def test_noise_without_a_seed_is_refused(scenario, tmp_path):
    generator = np.random.default_rng()
    law = misled_by(lambda position: generator.uniform(-1.0, 1.0, position.shape))
    path = tmp_path / "baselines" / "short.noisy.json"
    with pytest.raises(CannotJudge, match="short: noisy is not repeatable") as caught:
        record_law(scenario, "noisy", law, path, "in vain")
    assert "\n" not in str(caught.value)
    assert not path.exists()


def test_an_error_that_repeats_is_recorded_and_judged_the_same(scenario, tmp_path):
    law = misled_by(lambda position: np.sin(1e3 * position))
    path = tmp_path / "baselines" / "short.steady.json"
    record_law(scenario, "steady", law, path, "a test")
    findings = check_law(scenario, "steady", law, path).findings
    assert {str(finding.verdict) for finding in findings} == {"same"}
    assert len(findings) == 8
