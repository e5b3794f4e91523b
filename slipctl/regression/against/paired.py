"""How far a controller moved on average: differences paired world by world, with an interval."""

from __future__ import annotations

from collections.abc import Sequence

from slipctl.regression.baseline.gated import LARGER_IS_BETTER
from slipctl.regression.claims.bootstrap import mean, mean_difference
from slipctl.regression.judging.findings import Finding, Verdict


def paired_differences(findings: Sequence[Finding]) -> list[Finding]:
    """Compare the means over all worlds and seeds, controller by controller and metric by metric.

    Parameters
    ----------
    findings
        Of single runs, as `slipctl.regression.judge` gives them. Chaotic numbers that moved, and
        what could not be judged, are left out.

    Returns
    -------
    list of Finding
        One per controller and metric that at least two runs have a number for: the two means, the mean of the
        tolerances, and the interval of the mean difference. It is worse, or better, only where the whole
        interval lies beyond the tolerance.
    """
    groups: dict[tuple[str, str], list[Finding]] = {}
    for finding in findings:
        is_number = isinstance(finding.baseline, float) and isinstance(finding.current, float)
        counts = finding.verdict.judged and finding.verdict is not Verdict.CHAOTIC
        if finding.controller and finding.metric and is_number and counts:
            groups.setdefault((finding.controller, finding.metric), []).append(finding)
    return [_over_runs(group) for group in groups.values() if len(group) > 1]


def _over_runs(group: Sequence[Finding]) -> Finding:
    first = group[0]
    before = [float(finding.baseline or 0.0) for finding in group]
    after = [float(finding.current or 0.0) for finding in group]
    tolerance = mean([finding.tolerance or 0.0 for finding in group]).value
    change = mean_difference(after, before)
    assert change.interval is not None, "there are at least two"
    low, high = change.interval
    less_is_better = first.metric not in LARGER_IS_BETTER
    verdict = Verdict.SAME
    if low > tolerance:
        verdict = Verdict.WORSE if less_is_better else Verdict.BETTER
    elif high < -tolerance:
        verdict = Verdict.BETTER if less_is_better else Verdict.WORSE
    return Finding(
        first.scenario,
        first.controller,
        {},
        None,
        first.metric,
        mean(before).value,
        mean(after).value,
        tolerance,
        verdict,
        f"mean of {len(group)} runs, with the interval of the difference",
        interval=(low, high),
        unit=first.unit,
    )
