"""Keys and addresses: where they come from, what is refused, and that nothing secret is shown."""

from __future__ import annotations

import json
import os
from base64 import b64encode
from pathlib import Path

import pytest

from models.server import Said, serving
from models.services import KEY, anthropic_at, configure, one_line, request, set_apart
from scenelang.backends.language_models.catalogue import Account, load_account
from scenelang.backends.language_models.provider import connect, find_family, offline_provider
from scenelang.grammar.diagnostics import SceneError

OTHER = "sk-ant-from-the-configuration"


@pytest.fixture(autouse=True)
def _apart(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    set_apart(monkeypatch, tmp_path)


def found(name: str = "anthropic") -> Account:
    of = find_family(name)
    return load_account(of.name, of.key_variables, of.address_variable, of.default_address, of.needs_key)


def refused(name: str = "anthropic") -> SceneError:
    with pytest.raises(SceneError) as caught:
        found(name)
    one_line(caught.value)
    return caught.value


# --- where they come from ------------------------------------------------------------------------------------------------


def test_the_environment_comes_before_the_configuration(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    configure(tmp_path, f'[anthropic]\napi_key = "{OTHER}"\nbase_url = "https://configured.example.com/"\n')
    assert (found().key, found().address) == (KEY, "http://127.0.0.1:9")
    monkeypatch.delenv("ANTHROPIC_API_KEY")
    assert (found().key, found().address) == (OTHER, "http://127.0.0.1:9")
    monkeypatch.delenv("ANTHROPIC_BASE_URL")
    assert (found().key, found().address) == (OTHER, "https://configured.example.com")


def test_an_empty_variable_counts_as_none(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    configure(tmp_path, f'[anthropic]\napi_key = "{OTHER}"\n')
    monkeypatch.setenv("ANTHROPIC_API_KEY", "")
    monkeypatch.setenv("ANTHROPIC_BASE_URL", "")
    assert (found().key, found().address) == (OTHER, "https://api.anthropic.com")


def test_the_key_and_address_are_those_that_are_used(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("ANTHROPIC_API_KEY")
    monkeypatch.delenv("ANTHROPIC_BASE_URL")
    with serving([Said("yes")]) as server:
        configure(tmp_path, f'[anthropic]\napi_key = "{OTHER}"\nbase_url = "{server.url}/"\n')
        assert connect("anthropic").send(request(), str).text == "yes"
    assert server.headers[0]["authorization"] == f"Bearer {OTHER}"


def test_without_a_key_it_says_where_one_goes(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("ANTHROPIC_API_KEY")
    error = refused()
    assert error.name == "model-key"
    assert "ANTHROPIC_API_KEY" in (error.hint or "")
    assert str(tmp_path / "config" / "scenelang" / "config.toml") in error.message


def test_what_is_not_sent_needs_no_key(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ANTHROPIC_API_KEY")
    assert offline_provider("anthropic").payload(request())["model"] == "claude-opus-5-5"
    assert found("openai").key is None


def test_the_key_of_a_run_that_sends_nothing_is_not_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    assert offline_provider("anthropic").redact(KEY) == KEY


# --- keys that are none --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("key", [f"{KEY}\n", f"  {KEY}\t", f"\r\n{KEY}\r\n"])
def test_white_space_around_a_key_is_left_out(key: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ANTHROPIC_API_KEY", key)
    assert found().key == KEY


@pytest.mark.parametrize(
    "key",
    [
        "  ",
        f"{KEY}\n{KEY}",
        f"{KEY}\r\nx-other: 1",
        f"{KEY} {KEY}",
        "schlüssel-1234",
        "\x1b[31mkey",
        'k"ey-12345',
        "k\\ey",
    ],
)
def test_what_is_no_key_is_refused(key: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ANTHROPIC_API_KEY", key)
    error = refused()
    assert error.name == "model-key"
    assert key.strip() not in error.message or not key.strip()


@pytest.mark.parametrize("written", ["5", '["a"]', '""', '{ x = "y" }', "true"])
def test_what_is_no_key_in_the_configuration_is_refused(
    written: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.delenv("ANTHROPIC_API_KEY")
    configure(tmp_path, f"[anthropic]\napi_key = {written}\n")
    assert refused().name == "model-key"


# --- the configuration ---------------------------------------------------------------------------------------------------


@pytest.mark.skipif(os.name != "posix", reason="permissions of POSIX")
@pytest.mark.parametrize("mode", [0o640, 0o604, 0o644, 0o660, 0o622, 0o601])
def test_a_key_that_others_may_read_is_refused(mode: int, tmp_path: Path) -> None:
    path = configure(tmp_path, f'[anthropic]\napi_key = "{OTHER}"\n', mode)
    error = refused()
    assert (error.name, error.hint) == ("model-key", f"run `chmod 600 {path}`")
    assert OTHER not in error.message
    path.chmod(0o600)
    assert found().key == KEY


def test_a_configuration_without_a_key_may_be_read(tmp_path: Path) -> None:
    configure(tmp_path, '[anthropic]\nbase_url = "https://other.example.com"\n', 0o644)
    assert found().key == KEY


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[anthropic\n", "is not valid TOML"),
        (f'[anthropic]\napi_key = "{KEY}\n', "is not valid TOML"),
        (f"[anthropic]\napi_key = {KEY}\n", "is not valid TOML"),
        ("x = " + "[" * 100_000, ""),
        ("anthropic = 5\n", "expected `anthropic` to be a TOML table"),
        ("# " + "x" * 1_000_000, "is larger than 1,000,000 bytes"),
    ],
)
def test_a_malformed_configuration(text: str, said: str, tmp_path: Path) -> None:
    path = configure(tmp_path, text)
    error = refused()
    assert error.name == "file"
    assert str(path) in error.message
    assert said in error.message


def test_a_configuration_that_is_no_text(tmp_path: Path) -> None:
    configure(tmp_path, "").write_bytes(b"\xff\xfe\x00")
    assert "not UTF-8" in refused().message


def test_a_configuration_that_is_a_folder(tmp_path: Path) -> None:
    (tmp_path / "config" / "scenelang" / "config.toml").mkdir(parents=True)
    assert "cannot read" in refused().message


# --- addresses -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "address",
    ["example.com", "ftp://example.com", "http://", "https:///v1", "http://[::1", "http://host:99999", "http://host:x",
     "http://a\tb.example.com", "file:///etc/passwd", " "],
)  # fmt: skip
def test_what_is_no_address_is_refused(address: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ANTHROPIC_BASE_URL", address)
    error = refused()
    assert (error.name, error.hint) == ("value", "use a URL that starts with http:// or https://")


def test_an_address_is_a_text(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("ANTHROPIC_BASE_URL")
    configure(tmp_path, "[anthropic]\nbase_url = 5\n")
    assert "invalid base URL for `anthropic`" in refused().message


def test_a_new_line_after_an_address_is_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    with serving([Said("yes")]) as server:
        assert anthropic_at(f" {server.url}/\n", monkeypatch).send(request(), str).text == "yes"


@pytest.mark.parametrize(
    ("address", "shown"),
    [
        ("https://user:pa55word@example.com:8443/v1/?token=abcdefgh#x", "https://example.com:8443/v1/"),
        ("http://[::1]:8000/v1", "http://[::1]:8000/v1"),
        ("https://example.com", "https://example.com"),
    ],
)
def test_an_address_is_shown_without_secrets(address: str, shown: str) -> None:
    assert Account(None, address).public_address == shown


# --- secrets -------------------------------------------------------------------------------------------------------------


def test_everything_secret_is_blotted_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ANTHROPIC_BASE_URL", "https://somebody:p%40ss-word-1@example.com/v1?token=query-secret")
    monkeypatch.setenv("ANTHROPIC_CUSTOM_HEADERS", "X-One:tight-secret-1\nX-Two: Bearer loose-secret-2\nno header\n")
    login = b64encode(b"somebody:p@ss-word-1").decode()
    secrets = [KEY, "p%40ss-word-1", "p@ss-word-1", login, "token=query-secret", "tight-secret-1", "loose-secret-2"]
    shown = found().redact(" ".join(secrets))
    assert shown == " ".join(["[key]"] * len(secrets))
    assert found().redact("X-One: X-Two: Bearer no header") == "X-One: X-Two: Bearer no header"


def test_a_token_in_place_of_a_user_is_secret(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ANTHROPIC_BASE_URL", "https://token-0123456789@example.com")
    assert found().redact("at token-0123456789") == "at [key]"
    assert found().public_address == "https://example.com"


def test_a_secret_within_another_leaves_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ANTHROPIC_CUSTOM_HEADERS", f"X-Long: {KEY}-and-more")
    assert found().redact(f"{KEY}-and-more, {KEY}") == "[key], [key]"


def test_a_key_is_blotted_out_of_json(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every character that a key may have stands for itself in JSON."""
    key = "".join(chr(code) for code in range(33, 127) if chr(code) not in '"\\')
    monkeypatch.setenv("ANTHROPIC_API_KEY", key)
    assert found().redact(json.dumps({"said": key})) == '{"said": "[key]"}'


def test_a_short_key_does_not_blot_out_words(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ANTHROPIC_API_KEY", "a")
    assert found().key == "a"
    assert found().redact("a banana") == "a banana"


def test_nothing_secret_in_what_python_shows(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ANTHROPIC_BASE_URL", "https://somebody:pa55word@example.com")
    assert KEY not in repr(found())
    assert "pa55word" not in repr(found())


def test_a_password_that_a_server_repeats_is_not_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    with serving([Said("bad pa55word-123", status=400)]) as server:
        address = server.url.replace("http://", "http://me:pa55word-123@")
        provider = anthropic_at(address, monkeypatch)
        with pytest.raises(SceneError) as caught:
            provider.send(request(), str)
    assert "bad [key]" in one_line(caught.value)
    assert provider.address == server.url
