"""The command `grammar`: what it writes where, and the formats that no decoder reads."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from lark import Lark

from scenelang.cli.main import main
from scenelang.interpreter.expand.forms import FORMS, full_grammar
from scenelang.reference.highlight import files
from scenelang.stdlib.library import build_library
from scenelang.stdlib.reference import PARSED, TEXTMATE, grammar_text

from .cases import BAD, ROOT
from .decoders import acceptor, byte_tokenizer, matcher


@pytest.mark.parametrize("form", [*PARSED, TEXTMATE])
def test_written_to_standard_output_and_to_a_file(
    form: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["grammar", "--format", form]) == 0
    shown = capsys.readouterr().out
    assert main(["grammar", "--format", form, "-o", str(tmp_path / "file")]) == 0
    assert (tmp_path / "file").read_text("utf-8") == shown == grammar_text(form)


def test_strict_differs(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["grammar", "--format", "ebnf", "--strict"]) == 0
    assert "union-loop" in capsys.readouterr().out.split("NAME ::=")[0]


def test_wrong_usage(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["grammar", "--format", "textmate", "--strict"]) == 2
    assert "no strict form" in capsys.readouterr().err
    assert main(["grammar", "--format", "ebnf", "-o", str(tmp_path / "none" / "file")]) == 1
    assert capsys.readouterr().err.count("\n") == 1


def test_ebnf_has_every_rule_once_and_names_only_what_it_has() -> None:
    text = grammar_text("ebnf")
    defined = re.findall(r"^(\w+) ::=", text, re.M)
    assert len(defined) == len(set(defined))
    assert set(defined) == {*full_grammar().rules, *full_grammar().tokens}
    bodies = re.sub(r"/\*.*?\*/|\"[^\"]*\"|'[^']*'|\[[^\]]*\]|#x[0-9A-F]+|^\w+ ::=", " ", text, flags=re.M)
    assert set(re.findall(r"\w+", bodies)) <= set(defined)


def test_gbnf_keeps_to_what_llama_cpp_reads() -> None:
    for line in grammar_text("gbnf").splitlines()[1:]:
        name, body = line.split(" ::= ")
        assert re.fullmatch(r"[a-zA-Z][a-zA-Z0-9-]*", name)
        rest = re.sub(r'"(?:[^"\\]|\\["\\nrt])+"|\[\^?(?:[^\]\\]|\\[\]\[\\nrt])+\]', " ", body)
        assert re.fullmatch(r"[a-zA-Z0-9 ()|*+?{},-]*", rest), rest


def test_lark_loads_with_its_other_parser() -> None:
    parser = Lark(grammar_text("lark"), parser="earley")
    parser.parse('(define (f x::Float) (if x [1 2] "a")) ; end')
    with pytest.raises(Exception, match=r"No terminal|Unexpected"):
        parser.parse((BAD / "E201-if.scene").read_text())


def test_a_mask_allows_what_may_come_next() -> None:
    run = matcher(grammar_text("llguidance"))
    assert run.consume_tokens(list(b"(let"))
    mask = run.compute_logit_bias()
    allowed = {chr(token) for token in range(256) if mask[token]}
    assert {" ", "(", "*", "r", "-", "t"} <= allowed
    assert not {"[", ")", '"'} & allowed
    assert run.consume_tokens(list(b" ("))
    mask = run.compute_logit_bias()
    assert mask[ord("(")]
    assert not mask[ord("a")]
    assert byte_tokenizer().eos_token == 256


def test_textmate_knows_every_name_of_the_language() -> None:
    grammar = json.loads(grammar_text("textmate"))
    rules = {
        rule["name"]: re.compile(rule["match"].replace("|^)", ")"))
        for rule in grammar["repository"]["names"]["patterns"]
    }
    known = lambda name: [scope for scope, rule in rules.items() if rule.search(f"({name} ")]
    assert not [name for name in (*FORMS, *build_library().builtins) if len(known(name)) != 1]
    assert known("call") == ["keyword.other.paper.scene"]
    assert not known("my-own-name")


def test_the_editors_files_are_not_stale() -> None:
    folder = ROOT / "editors" / "vscode"
    stale = [name for name, text in files().items() if (folder / name).read_text("utf-8") != text]
    assert not stale, "run `make editors`"


def test_what_a_snippet_leaves_is_a_form() -> None:
    entries = json.loads(files()["snippets/scene.json"])
    assert entries.keys() == FORMS.keys() - {"syntax-rules"}
    for entry in entries.values():
        text = re.sub(r"\$\{\d+:([^}]*)\}", r"\1", entry["body"]).removesuffix("$0")
        assert acceptor("llguidance")(text.encode()), text
