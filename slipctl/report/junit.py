"""A JUnit file of what was judged, for CI systems that show such files.

The elements and attributes are those of the schema that Jenkins publishes (junit-10.xsd), which other
systems read as well: a suite per scenario, in it a case per number, status and claim.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from xml.etree import ElementTree

from slipctl.report.findings import sentence, values_text
from slipctl.report.judged import FAILED, NOT_JUDGED, Finding, Judged, run_text

ILLEGAL = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""What no XML file may hold, not even escaped."""


def document(scenarios: Sequence[Judged]) -> bytes:
    """Return the file as UTF-8.

    A case has a ``failure`` where the gate is closed, an ``error`` where it could not be judged, and says
    what is better than recorded, or chaotic, in its ``system-out``.
    """
    suites = [_suite(judged) for judged in scenarios]
    root = ElementTree.Element("testsuites", {"name": "slipctl check", **_sums(suites)})
    root.extend(suites)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="utf-8", xml_declaration=True) + b"\n"


def write(path: Path, scenarios: Sequence[Judged]) -> None:
    """Write the file beside its place and rename it.

    Raises
    ------
    OSError
        The folder cannot be made or written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    beside = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        beside.write_bytes(document(scenarios))
        beside.replace(path)
    finally:
        beside.unlink(missing_ok=True)


def _suite(judged: Judged) -> ElementTree.Element:
    cases = [_case(judged, finding) for finding in judged.findings]
    counts = {
        "tests": str(len(cases)),
        "failures": str(sum(case.find("failure") is not None for case in cases)),
        "errors": str(sum(case.find("error") is not None for case in cases)),
        "skipped": "0",
    }
    suite = ElementTree.Element("testsuite", {"name": _legal(judged.scenario), **counts})
    told = list(_properties(judged))
    if told:
        properties = ElementTree.SubElement(suite, "properties")
        for name, value in told:
            ElementTree.SubElement(properties, "property", name=name, value=_legal(value))
    suite.extend(cases)
    if judged.notes:
        ElementTree.SubElement(suite, "system-out").text = _legal("\n".join(judged.notes))
    if judged.command is not None:
        ElementTree.SubElement(suite, "system-err").text = _legal(f"recordings: {judged.command}")
    return suite


def _properties(judged: Judged) -> Iterator[tuple[str, str]]:
    if judged.file is not None:
        yield "file", judged.file.as_posix()
    if judged.since is not None:
        yield "compared_with", judged.since


def _case(judged: Judged, finding: Finding) -> ElementTree.Element:
    name = _legal(_case_name(finding))
    case = ElementTree.Element("testcase", name=name, classname=_legal(judged.scenario))
    verdict, said = finding["verdict"], _legal(sentence(finding))
    if verdict in FAILED or verdict in NOT_JUDGED:
        kind = "failure" if verdict in FAILED else "error"
        values = values_text(finding) if finding["metric"] is not None else finding["note"]
        inner = ElementTree.SubElement(case, kind, type=verdict, message=_legal(values or verdict))
        since = f"\ncompared with {judged.since}" if judged.since and finding["claim"] is None else ""
        inner.text = said + _legal(since)
    elif verdict != "same":
        ElementTree.SubElement(case, "system-out").text = said
    return case


def _case_name(finding: Finding) -> str:
    what = finding["claim"] if finding["claim"] is not None else finding["metric"]
    parts = [run_text(finding), what or ""]
    return ": ".join(part for part in parts if part) or "the whole scenario"


def _sums(suites: Sequence[ElementTree.Element]) -> dict[str, str]:
    names = ("tests", "failures", "errors")
    return {name: str(sum(int(suite.attrib[name]) for suite in suites)) for name in names}


def _legal(text: str) -> str:
    return ILLEGAL.sub("\N{REPLACEMENT CHARACTER}", text)
