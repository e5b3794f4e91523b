"""What is said of very many worlds: every number says of how many runs it is."""

from __future__ import annotations

import pyarrow as pa

from slipctl.report import many


def test_shares_are_of_the_runs_that_completed():
    errors = [0.001 * (index + 1) for index in range(20)]
    table = pa.table(
        {
            "world": list(range(23)),
            "controller": ["a"] * 23,
            "status": ["completed"] * 20 + ["tipped", "failed", "failed"],
            "rms_position_error": pa.array([*errors, 9.0, None, None], pa.float64()),
            "max_position_error": pa.array([*([0.001] * 4), *([1.0] * 16), 9.0, None, None], pa.float64()),
        }
    )
    first, second, *worst = many.lines(table, ())
    assert first == "a: 20 of 23 runs completed, 2 failed, 1 tipped"
    assert second == (
        "  of 20 completed: RMS error 10.5 mm in the middle, 19.1 mm at most in 95 % of them, "
        "20.0 mm at worst; 4 stay within 100 mm"
    )
    assert worst[0] == "largest errors:"
    assert worst[1].startswith("  world 20, a: ")
    assert worst[1].endswith(" mm (tipped)")
    assert len(worst) == 1 + many.WORST
