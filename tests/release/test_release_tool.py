"""``.ci/release.py``, which ``make release`` runs: the text of what is published, and what it says is left to do."""

from __future__ import annotations

import importlib.util
import re
import tomllib
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2]
HOME = "https://example.org/scenes"


@pytest.fixture(scope="module")
def tool() -> ModuleType:
    spec = importlib.util.spec_from_file_location("release_tool", ROOT / ".ci/release.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("![a](docs/a.png)", f"![a]({HOME}/raw/v1.2.3/docs/a.png)"),
        ("[a](docs/a.md#part)", f"[a]({HOME}/blob/v1.2.3/docs/a.md#part)"),
        ("[a](#here) [b](https://b.org)", "[a](#here) [b](https://b.org)"),
        ("![a](a.png)<br>[b](b.scene): c", f"![a]({HOME}/raw/v1.2.3/a.png)<br>[b]({HOME}/blob/v1.2.3/b.scene): c"),
    ],
)
def test_links_become_absolute(tool: ModuleType, text: str, wanted: str) -> None:
    assert tool.absolute_links(text, HOME, "1.2.3") == wanted


def test_no_picture_of_the_readme_stays_relative(tool: ModuleType) -> None:
    text = tool.absolute_links((ROOT / "README.md").read_text("utf-8"), HOME, "1.2.3")
    targets = re.findall(r"\]\(([^)\s]+)\)", text)
    assert len(targets) > 50
    assert [target for target in targets if not target.startswith(("https://", "#"))] == []
    for path in re.findall(rf"{HOME}/(?:raw|blob)/v1\.2\.3/([^)#\s]+)", text):
        assert (ROOT / path).exists(), path


def test_addresses_are_added_to_the_metadata(tool: ModuleType) -> None:
    text = (ROOT / "pyproject.toml").read_text("utf-8")
    before = tomllib.loads(text)["project"]["urls"]
    after = tomllib.loads(tool.with_urls(text, HOME))["project"]["urls"]
    assert after == before | {
        "Repository": HOME,
        "Issues": f"{HOME}/issues",
        "Changelog": f"{HOME}/blob/main/CHANGELOG.md",
    }


@pytest.mark.parametrize(("text", "wanted"), [("# none yet\n", ""), (f"# here\n\n{HOME}/\n", HOME), ("", "")])
def test_the_address_is_the_line_that_is_no_comment(tool: ModuleType, text: str, wanted: str) -> None:
    assert tool.repository_of(text) == wanted


def test_a_version_without_a_section_is_not_ready(tool: ModuleType) -> None:
    assert "CHANGELOG.md has no section [99.0.0] at its head" in tool.unready("99.0.0")
    version = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["version"]
    assert not [reason for reason in tool.unready(version) if "no section" in reason]


def test_it_says_what_is_left(tool: ModuleType) -> None:
    files = [Path("dist/scenelang-1.2.3.tar.gz")]
    steps = tool.next_steps("1.2.3", files, [])
    assert "git tag -a v1.2.3" in steps
    assert "twine upload dist/scenelang-1.2.3.tar.gz" in steps
    assert "Before it can be published" not in steps
    assert "  - no address\n" in tool.next_steps("1.2.3", files, ["no address"])
