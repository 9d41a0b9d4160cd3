"""What a public repository has beside its code: citation, workflow, templates, and one version in all of them."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

yaml = pytest.importorskip("yaml")

ROOT = Path(__file__).parents[2]
GITHUB = ROOT / ".github"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
CHANGELOG = (ROOT / "CHANGELOG.md").read_text("utf-8")
RELEASES = re.findall(r"^## \[(\d+\.\d+\.\d+)\] - (\d{4}-\d\d-\d\d)$", CHANGELOG, re.M)


def read(path: Path) -> Any:
    return yaml.safe_load(path.read_text("utf-8"))


# --- versions --------------------------------------------------------------------------------------------------------


def test_releases_are_in_order() -> None:
    versions = [tuple(map(int, version.split("."))) for version, _ in RELEASES]
    assert len(versions) >= 5
    assert versions == sorted(set(versions), reverse=True)
    assert [date for _, date in RELEASES] == sorted((date for _, date in RELEASES), reverse=True)
    assert CHANGELOG.index("## [Unreleased]") < CHANGELOG.index(f"## [{RELEASES[0][0]}]")


def test_every_release_has_entries() -> None:
    for section in re.split(r"^## ", CHANGELOG, flags=re.M)[2:]:
        assert re.search(r"^### (Added|Changed|Fixed|Removed)\n\n- ", section, re.M), section[:40]


def test_the_version_is_the_same_everywhere() -> None:
    citation = read(ROOT / "CITATION.cff")
    extension = json.loads((ROOT / "editors/vscode/package.json").read_text("utf-8"))
    newest, date = RELEASES[0]
    assert (PROJECT["version"], citation["version"], extension["version"]) == (newest, newest, newest)
    assert citation["date-released"] == date


# --- citation --------------------------------------------------------------------------------------------------------


def test_the_citation_is_complete() -> None:
    citation = read(ROOT / "CITATION.cff")
    assert {"cff-version", "message", "title", "authors", "license", "preferred-citation"} <= set(citation)
    assert citation["cff-version"] == "1.2.0"
    assert citation["license"] == PROJECT["license"]
    assert [each["name"] for each in citation["authors"]] == [each["name"] for each in PROJECT["authors"]]


def test_the_paper_is_cited_as_it_names_itself() -> None:
    paper = read(ROOT / "CITATION.cff")["preferred-citation"]
    assert paper["type"] == "conference-paper"
    assert paper["title"] == "The Scene Language: Representing Scenes with Programs, Words, and Embeddings"
    assert [each["family-names"] for each in paper["authors"]] == ["Zhang", "Li", "Zhou", "Wu", "Wu"]
    assert paper["year"] == 2025
    assert paper["url"] == PROJECT["urls"]["Paper"]
    assert paper["url"] in (ROOT / "docs/index.md").read_text("utf-8")


# --- workflow --------------------------------------------------------------------------------------------------------


def test_the_workflow_runs_the_commands_of_the_readme() -> None:
    (job,) = read(GITHUB / "workflows/test.yml")["jobs"].values()
    install = (ROOT / "README.md").read_text("utf-8").partition("## Install")[2]
    (block,) = re.findall(r"^```sh\n(.*?)^```$", install, re.M | re.S)[:1]
    wanted = [line.partition("#")[0].strip() for line in block.splitlines()]
    assert len(wanted) == 2
    assert [step["run"] for step in job["steps"] if "run" in step] == wanted


def test_the_workflow_runs_on_every_python_of_the_metadata() -> None:
    (job,) = read(GITHUB / "workflows/test.yml")["jobs"].values()
    named = [re.fullmatch(r"Programming Language :: Python :: (3\.\d+)", each) for each in PROJECT["classifiers"]]
    assert job["strategy"]["matrix"]["python"] == [match[1] for match in named if match]
    (setup,) = (step for step in job["steps"] if "setup-python" in step.get("uses", ""))
    assert setup["with"]["python-version"] == "${{ matrix.python }}"


def test_the_workflow_may_only_read() -> None:
    assert read(GITHUB / "workflows/test.yml")["permissions"] == {"contents": "read"}


# --- templates -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["bug", "feature"])
def test_a_form_of_issues_is_valid(name: str) -> None:
    form = read(GITHUB / f"ISSUE_TEMPLATE/{name}.yml")
    assert {"name", "description", "body"} <= set(form)
    ids = [field["id"] for field in form["body"]]
    assert len(ids) == len(set(ids))
    assert all(field["type"] == "textarea" and field["attributes"]["label"] for field in form["body"])
    assert any(field.get("validations", {}).get("required") for field in form["body"])


def test_bugs_come_with_a_program_and_the_doctor() -> None:
    form = read(GITHUB / "ISSUE_TEMPLATE/bug.yml")
    required = {field["id"] for field in form["body"] if field.get("validations", {}).get("required")}
    assert {"program", "commands", "doctor"} <= required


def test_issues_are_written_in_forms_only() -> None:
    assert read(GITHUB / "ISSUE_TEMPLATE/config.yml") == {"blank_issues_enabled": False}


def test_commands_of_the_template_of_pull_requests_exist() -> None:
    text = (GITHUB / "pull_request_template.md").read_text("utf-8")
    makefile = (ROOT / "Makefile").read_text("utf-8")
    named = re.findall(r"`make ([\w-]+)`", text)
    assert {"check", "docs"} <= set(named)
    assert all(re.search(rf"^{target}:", makefile, re.M) for target in named)


def test_what_the_readers_of_the_repository_look_for_is_there() -> None:
    for name in ("LICENSE", "CONTRIBUTING.md", "CODE_OF_CONDUCT.md", "SECURITY.md"):
        assert len((ROOT / name).read_text("utf-8")) > 500, name
    assert "CODE_OF_CONDUCT.md" in (ROOT / "CONTRIBUTING.md").read_text("utf-8")
