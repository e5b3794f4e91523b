"""JUnit files: written, held against the shape of junit-10.xsd, and read back."""

from pathlib import Path
from xml.etree import ElementTree

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipctl.report.judged import Judged
from slipctl.report.junit import document, write
from tests.report.findings import EVERY_VERDICT, NO_BASELINE, claim, finding

# of junit-10.xsd: element → (attributes allowed, attributes required, children allowed)
SHAPE = {
    "testsuites": ({"name", "time", "tests", "failures", "disabled", "errors"}, set(), {"testsuite"}),
    "testsuite": (
        {"name", "tests", "failures", "errors", "time", "disabled", "skipped", "timestamp", "hostname", "id"}
        | {"package"},
        {"name", "tests"},
        {"testsuite", "properties", "testcase", "system-out", "system-err"},
    ),
    "properties": (set(), set(), {"property"}),
    "property": ({"name", "value"}, {"name", "value"}, set()),
    "testcase": (
        {"name", "assertions", "time", "classname", "status"},
        {"name"},
        {"skipped", "error", "failure", "system-out", "system-err"},
    ),
    "failure": ({"type", "message"}, set(), set()),
    "error": ({"type", "message"}, set(), set()),
    "system-out": (set(), set(), set()),
    "system-err": (set(), set(), set()),
}


def read(content):
    root = ElementTree.fromstring(content)
    assert root.tag == "testsuites"
    for element in root.iter():
        allowed, required, children = SHAPE[element.tag]
        assert required <= set(element.attrib) <= allowed, element.tag
        assert {child.tag for child in element} <= children, element.tag
        if element.tag in ("testsuites", "testsuite"):
            cases = list(element.iter("testcase"))
            assert int(element.attrib["tests"]) == len(cases)
            assert int(element.attrib["failures"]) == len(list(element.iter("failure")))
            assert int(element.attrib["errors"]) == len(list(element.iter("error")))
    return root


def outcomes(root):
    return [[child.tag for child in case] for case in root.iter("testcase")]


def test_every_verdict_becomes_a_case_of_its_kind():
    root = read(document([Judged("ice", EVERY_VERDICT)]))
    assert outcomes(root) == [
        ["failure"], [], ["system-out"], ["system-out"], ["failure"], ["error"], ["error"], ["error"],
        ["system-out"], ["failure"], ["error"],
    ]  # fmt: skip


def test_names_within_a_suite_are_unique():
    cases = list(read(document([Judged("ice", EVERY_VERDICT[3:])])).iter("testcase"))
    assert len({case.attrib["name"] for case in cases}) == len(cases)


def test_a_failure_says_by_how_much_and_since_when():
    judged = Judged("ice", [finding()], Path("scenarios/ice.toml"), "abc", "2026-11-20")
    root = read(document([judged]))
    (case,) = root.iter("testcase")
    assert case.attrib == {
        "classname": "ice",
        "name": "robust, ground.friction 0.16, seed 1: rms_position_error",
    }
    (failure,) = case
    assert failure.attrib == {"type": "worse", "message": "12.3 → 14.5 mm (+18 %)"}
    assert failure.text is not None
    assert "tolerance 0.010 mm" in failure.text
    assert "compared with commit abc of 2026-11-20" in failure.text
    told = {entry.attrib["name"]: entry.attrib["value"] for entry in root.iter("property")}
    assert told == {"file": "scenarios/ice.toml", "compared_with": "commit abc of 2026-11-20"}


def test_what_could_not_be_judged_says_why():
    (error,) = read(document([Judged("ice", [NO_BASELINE])])).iter("error")
    assert error.attrib == {"type": "unjudged", "message": "no baseline"}
    (error,) = read(document([Judged("ice", [claim("claim_open")])])).iter("error")
    assert error.attrib["message"] == "measured 2.10 (1.90 to 2.30), required 3.00"


def test_a_suite_per_scenario_with_the_command_that_opens_its_recordings():
    first = Judged("ice", [finding()], command="slipctl view runs/check/ice", notes=("one", "two"))
    root = read(document([first, Judged("rain", [])]))
    suites = root.findall("testsuite")
    assert [suite.attrib["name"] for suite in suites] == ["ice", "rain"]
    assert suites[0].findtext("system-out") == "one\ntwo"
    assert suites[0].findtext("system-err") == "recordings: slipctl view runs/check/ice"


@given(st.text(), st.text(), st.text(), st.text())
def test_any_name_gives_a_file_that_can_be_read(scenario, controller, note, claimed):
    entry = finding(scenario=scenario, controller=controller, note=note)
    root = read(document([Judged(scenario, [entry, claim("claim_failed", claim=claimed)], notes=[note])]))
    assert outcomes(root) == [["failure"], ["failure"]]


def test_awkward_names_come_back_as_they_were_and_what_xml_cannot_hold_is_marked():
    name = "a<b>&\"c'\N{GREEK SMALL LETTER MU} \x00\x1b\ud800"
    (suite,) = read(document([Judged(name, [finding()])])).iter("testsuite")
    assert suite.attrib["name"] == "a<b>&\"c'\N{GREEK SMALL LETTER MU} " + 3 * "\N{REPLACEMENT CHARACTER}"


def test_the_file_is_written_whole_or_not_at_all(tmp_path, monkeypatch):
    path = tmp_path / "made" / "report.xml"
    write(path, [Judged("ice", [finding()])])
    assert outcomes(read(path.read_bytes())) == [["failure"]]
    before = path.read_bytes()
    monkeypatch.setattr(Path, "replace", lambda *_: (_ for _ in ()).throw(OSError("no space")))
    with pytest.raises(OSError, match="no space"):
        write(path, [])
    assert path.read_bytes() == before
    assert [entry.name for entry in path.parent.iterdir()] == ["report.xml"]
