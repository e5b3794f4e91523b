"""The fixture `slipctl_check`: a law of one's own, gated in one's own test suite.

>>> def test_my_controller(slipctl_check):
...     slipctl_check("wet-slope", controller=MyLaw())

Loaded by pytest wherever slipctl is installed, so nothing heavy is imported before a check runs.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from slipctl.experiment.own import OwnLaw, OwnLaws
    from slipctl.regression.own_law.check import OwnLawReport
    from slipctl.scenario import Scenario

RECORD = "--slipctl-record"
ARTEFACTS = "--slipctl-artefacts"
NONE = "none"
"""In place of a folder: no recordings."""

PROPERTY = "slipctl"
"""Name under which a test's report carries the lines of its checks, also from pytest-xdist's workers."""

NEVER_CALLED = "asked for slipctl_check and never called it: nothing was checked"

_CALLED = pytest.StashKey[bool]()
"""Whether a test has called the fixture that it asked for."""

_PASSED = pytest.StashKey[bool]()
"""Whether a test itself passed."""

_SCENARIOS = pytest.StashKey[dict[Path, str]]()
"""Which scenario a baseline was used for in this session, by the baseline's path."""


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options."""
    group = parser.getgroup("slipctl", "slipctl: tracking error of one's own laws")
    group.addoption(
        RECORD,
        metavar="REASON",
        default=None,
        help="write the baselines of the checks that run, instead of judging by them; REASON is kept in them",
    )
    group.addoption(
        ARTEFACTS,
        metavar="DIR|none",
        default="runs/check",
        help="folder for Rerun recordings of what fails, now and beside the baseline (default: %(default)s)",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Refuse to record without a reason.

    Raises
    ------
    pytest.UsageError
        The reason is empty.
    """
    config.stash[_SCENARIOS] = {}
    reason = config.getoption(RECORD)
    if reason is not None and not reason.strip():
        raise pytest.UsageError(f"{RECORD} needs a reason: say why the numbers may change")


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]) -> None:
    """Note how a test ended, for the fixture that is taken down after it; the report is made by others."""
    if call.when == "call":
        item.stash[_PASSED] = call.excinfo is None


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Print one line per check."""
    reports = [report for found in terminalreporter.stats.values() for report in found]
    lines = [
        value
        for report in reports
        if getattr(report, "when", None) == "call"
        for name, value in getattr(report, "user_properties", ())
        if name == PROPERTY
    ]
    if lines:
        terminalreporter.section("slipctl")
        for line in lines:
            terminalreporter.write_line(line)


@dataclass(frozen=True)
class SlipctlCheck:
    """What the fixture gives: call it once per scenario and law.

    Attributes
    ----------
    request : pytest.FixtureRequest
        Of the test that checks.
    """

    request: pytest.FixtureRequest

    def __call__(
        self,
        scenario: str | Path | Scenario,
        *,
        controller: OwnLaw,
        label: str | None = None,
        better_than: str | None = None,
        factor: float | None = None,
        expect: Sequence[Mapping[str, Any]] = (),
        overrides: Mapping[str, Any] | None = None,
        threads: int | None = None,
    ) -> OwnLawReport:
        """Run a law beside the listed controllers; the test fails where it is worse than its baseline.

        Parameters
        ----------
        scenario : str, path or Scenario
            A shipped scenario's name, a path (looked for beside the test file first), or a scenario.
        controller : Controller, or callable
            The law, or what makes one from a `slipctl.experiment.own.KnownRobot` (its class will do).
        label : str, optional
            What it is called; by default the name of its class, as in ``my_law``.
        better_than : str, optional
            Label of a listed controller that it must beat in `rms_position_error`.
        factor : float, optional
            By which factor, 1 or more.
        expect : sequence of mapping, optional
            Further claims, each as an ``[[expect]]`` of a scenario file; `controller` is the law by default.
        overrides : mapping, optional
            Values of the scenario's keys: a number, a list of them, or a text as after ``--over``.
        threads : int, optional
            For MuJoCo.

        Returns
        -------
        OwnLawReport
            Findings and results, for what else the test wants to assert.
        """
        __tracebackhide__ = True
        from slipctl.experiment.checked import OwnLawError
        from slipctl.experiment.folder import OutputError
        from slipctl.experiment.own import check_labels
        from slipctl.regression import CannotJudge
        from slipctl.regression.own_law.check import check_law, read_claims, record_law
        from slipctl.scenario import ScenarioError

        self.request.node.stash[_CALLED] = True
        label = label or _label(controller)
        reason = self.request.config.getoption(RECORD)
        try:
            chosen = self._scenario(scenario, overrides or {})
            check_labels({label: controller}, [listed.label for listed in chosen.controller])
            claims = read_claims(chosen, label, [*_better(better_than, factor), *expect])
            path = self._baseline(chosen, label)
            if reason is None:
                report = check_law(chosen, label, controller, path, claims, threads, self._record())
            else:
                report = record_law(chosen, label, controller, path, reason.strip(), claims, threads)
        except (ScenarioError, CannotJudge, OutputError, OSError) as error:
            self._say(f"{_called(scenario)}, {label}: not judged")
            raise pytest.fail.Exception(str(error), pytrace=False) from None
        except OwnLawError as error:
            self._say(f"{_called(scenario)}, {label}: not judged: {error}")
            # what the law raised is shown, the way there through slipctl is not
            raise OwnLawError(str(error)) from error.__cause__
        self._tell(report)
        if not report.passed:
            more = [*self._recordings(chosen, report, {label: controller}, threads), *self._meant(report)]
            pytest.fail("\n".join([report.text(), *more]), pytrace=False)
        return report

    @property
    def _folder(self) -> Path:
        return self.request.path.parent

    def _scenario(self, source: str | Path | Scenario, overrides: Mapping[str, Any]) -> Scenario:
        from slipctl.scenario import Scenario, load, override

        if not isinstance(source, Scenario):
            beside = self._folder / source
            source = load(beside if beside.is_file() else source)
        if not overrides:
            return source
        return override(
            source,
            {key: [value] if isinstance(value, int | float) else value for key, value in overrides.items()},
        )

    def _baseline(self, scenario: Scenario, label: str) -> Path:
        from slipctl.regression import CannotJudge
        from slipctl.scenario import scenario_id

        path = self._folder / "baselines" / f"{scenario.name}.{label}.json"
        identity = scenario_id(scenario)
        if self.request.config.stash[_SCENARIOS].setdefault(path, identity) != identity:
            raise CannotJudge(
                f"two checks share {path.name} but not the scenario: give one of them another label"
            )
        return path

    def _say(self, line: str, *more: str) -> None:
        for text in (line, *(f"  {below}" for below in more)):
            self.request.node.user_properties.append((PROPERTY, text))

    def _tell(self, report: OwnLawReport) -> None:
        """Say in the terminal summary what came of a check."""
        if report.recorded:
            reason = report.baseline.reason
            self._say(
                f"{report.name}: recorded in {_short(report.path)}: {reason}",
                report.recorded_text(),
                *report.change_lines(),
            )
            return
        self._say(f"{report.name}: {report.count_text()}", *report.better_lines(), *report.notes)
        if report.better and report.passed:
            self._say(f"  record it: {self._record()}")

    def _record(self) -> str:
        return f'pytest "{self.request.node.nodeid}" {RECORD} "reason"'

    def _meant(self, report: OwnLawReport) -> list[str]:
        return [f"if this is meant: {self._record()}"] if report.recordable else []

    def _recordings(
        self, scenario: Scenario, report: OwnLawReport, laws: OwnLaws, threads: int | None
    ) -> list[str]:
        """Record the worlds that failed; say how to look at them, or why that cannot be."""
        place = str(self.request.config.getoption(ARTEFACTS))
        if place == NONE:
            return []
        from slipctl.experiment.folder import OutputError
        from slipctl.regression import record_failing
        from slipctl.view import RecordingError

        out = self.request.config.invocation_params.dir / place
        try:
            made = record_failing(
                scenario,
                report.findings,
                out,
                report.path,
                laws,
                threads,
                option=ARTEFACTS,
                update=self._record(),
            )
        except (OutputError, RecordingError, OSError) as error:
            return [f"no recordings: {error}"]
        return [] if made is None else [*made.notes, f"look at what failed: {made.command}"]


@pytest.fixture
def slipctl_check(request: pytest.FixtureRequest) -> Iterator[SlipctlCheck]:
    """Check a law of one's own: ``slipctl_check("wet-slope", controller=MyLaw())``.

    A test that passes without having called it fails: a gate that is not there would stay open unseen.
    """
    stash = request.node.stash
    stash[_CALLED] = stash[_PASSED] = False  # some plugins run a test several times
    yield SlipctlCheck(request)
    if stash[_PASSED] and not stash[_CALLED]:
        pytest.fail(NEVER_CALLED, pytrace=False)


def _called(scenario: str | Path | Scenario) -> str:
    return str(scenario) if isinstance(scenario, str | Path) else scenario.name


def _short(path: Path) -> str:
    """Return a path as seen from here, where it is below."""
    here = Path.cwd()
    return path.relative_to(here).as_posix() if path.is_relative_to(here) else str(path)


def _better(than: str | None, factor: float | None) -> list[dict[str, Any]]:
    if than is None:
        if factor is not None:
            pytest.fail("factor goes with better_than, the label of a listed controller", pytrace=False)
        return []
    return [{"kind": "better", "than": than, "factor": 1.0 if factor is None else float(factor)}]


def _label(controller: Any) -> str:
    """Return the name of a law's class or function as a label: ``MyLaw`` is ``my_law``."""
    controller = getattr(controller, "func", controller)  # of a functools.partial
    name = getattr(controller, "__name__", None) or type(controller).__name__
    label = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()
    if re.fullmatch(r"[a-z0-9_-]+", label) is None:
        pytest.fail(f'{name!r} is no label: say label="…", in a-z, 0-9, _ and -', pytrace=False)
    return label
