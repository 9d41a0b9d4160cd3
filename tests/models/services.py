"""What tests of the client need: an environment without anything of this machine, requests, connected providers."""

from __future__ import annotations

from pathlib import Path

import pytest

from scenelang.backends.language_models.catalogue import Request, TextContent, text_message
from scenelang.backends.language_models.provider import Provider, connect
from scenelang.grammar.diagnostics import SceneError

KEY = "sk-ant-planted-0123456789abcdef"
FOREIGN = (
    "ANTHROPIC_AUTH_TOKEN", "ANTHROPIC_CUSTOM_HEADERS", "ANTHROPIC_LOG", "ANTHROPIC_PROFILE", "OPENAI_API_KEY",
    "OPENAI_BASE_URL", "OPENAI_LOG", "OPENAI_ORG_ID", "OPENAI_PROJECT_ID", "OPENAI_ADMIN_KEY", "SCENELANG_RUNS",
    "http_proxy", "https_proxy", "all_proxy", "HTTP_PROXY", "HTTPS_PROXY", "ALL_PROXY",
)  # fmt: skip


def set_apart(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    """An environment with folders of its own, a planted key, and an address where nobody answers."""
    for name in FOREIGN:
        monkeypatch.delenv(name, raising=False)
    for name in ("STATE", "CACHE", "CONFIG"):
        monkeypatch.setenv(f"XDG_{name}_HOME", str(folder / name.lower()))
    monkeypatch.setenv("ANTHROPIC_API_KEY", KEY)
    monkeypatch.setenv("ANTHROPIC_BASE_URL", "http://127.0.0.1:9")
    trust_nobody(monkeypatch, folder)


def trust_nobody(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    """Certificates are looked for in ``folder``: each client would read all of this machine, which take a while."""
    monkeypatch.delenv("SSL_CERT_FILE", raising=False)
    monkeypatch.setenv("SSL_CERT_DIR", str(folder))


def hurry(monkeypatch: pytest.MonkeyPatch) -> None:
    """The packages wait before they try again after a lost connection; here they need not."""
    for package in ("anthropic", "openai"):
        monkeypatch.setattr(f"{package}._base_client.INITIAL_RETRY_DELAY", 0.01)


def configure(folder: Path, text: str, mode: int = 0o600) -> Path:
    """Write the configuration."""
    path = folder / "config" / "scenelang" / "config.toml"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    path.chmod(mode)
    return path


def anthropic_at(url: str, monkeypatch: pytest.MonkeyPatch) -> Provider:
    monkeypatch.setenv("ANTHROPIC_BASE_URL", url)
    return connect("anthropic")


def openai_at(url: str, monkeypatch: pytest.MonkeyPatch) -> Provider:
    monkeypatch.setenv("OPENAI_BASE_URL", url)
    return connect("openai")


def request(text: str = "a cube", max_tokens: int = 1000, model: str = "claude-opus-5-5") -> Request:
    return Request(model, TextContent("rules", is_cacheable=True), (text_message("user", text),), max_tokens)


def one_line(error: SceneError) -> str:
    """An error's message and hint, which must be one line each and without the key."""
    shown = f"{error.message} | {error.hint or ''}"
    assert "\n" not in shown
    assert KEY not in shown
    assert "Traceback" not in shown
    return shown
