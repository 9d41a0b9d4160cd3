"""Procedures at run time: closures, escapes, and how arguments meet parameters."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, TypeAlias

from scenelang.grammar.diagnostics import SceneError, suggest
from scenelang.interpreter.show import show
from scenelang.interpreter.types import Mismatch, Type, type_name
from scenelang.interpreter.values import NIL, Embedding, Keyword, Mutable, Pair, Procedure, make_list
from scenelang.interpreter.values import Condition as Condition

if TYPE_CHECKING:
    from scenelang.interpreter.runtime import Runtime

Frame: TypeAlias = list[Any]  # [frame of the enclosing function, slot 1, slot 2, ...]
Node: TypeAlias = Callable[[Frame], Any]  # a compiled expression


class Tail:
    """The mark that a compiled expression returns to ask its caller to make a tail call."""

    __slots__ = ()


TAIL = Tail()
_FEW = 32  # arguments: more of them are charged


class Undefined:
    """What a variable holds before its definition has run."""

    __slots__ = ()


UNDEFINED = Undefined()


class Cell(Mutable):
    """A variable that some ``set!`` assigns."""

    __slots__ = ("value",)

    def __init__(self, value: Any, birth: int) -> None:
        self.birth = birth
        self.observed = False
        self.value = value


@dataclass(frozen=True, slots=True)
class CodeParameter:
    """A parameter of compiled code. ``kind``: required, optional, keyword, rest or keys."""

    name: str
    kind: str
    slot: int
    type: Type | None = None
    default: Node | None = None
    in_cell: bool = False


@dataclass(eq=False, slots=True)
class Code:
    """A compiled ``lambda``. ``arity`` is the number of parameters when all are plain, else -1."""

    name: str
    parameters: tuple[CodeParameter, ...]
    usage: str
    arity: int
    body: Node
    keyword_names: frozenset[str] | None = field(init=False)
    required: int = field(init=False)
    positional: int = field(init=False)
    rest: CodeParameter | None = field(init=False)

    def __post_init__(self) -> None:
        kinds = [p.kind for p in self.parameters]
        names = frozenset(p.name for p in self.parameters if p.kind == "keyword")
        self.keyword_names = names if names or "keys" in kinds else None
        self.required = kinds.count("required")
        self.positional = self.required + kinds.count("optional")
        self.rest = next((p for p in self.parameters if p.kind == "rest"), None)

    @property
    def takes_any_keyword(self) -> bool:
        return any(p.kind == "keys" for p in self.parameters)


class Closure(Procedure):
    """A function value. ``arity`` and ``body`` repeat the code's, to be near at hand."""

    __slots__ = ("arity", "body", "code", "env")

    def __init__(self, code: Code, env: Frame) -> None:
        self.code = code
        self.env = env
        self.arity = code.arity
        self.body = code.body

    @property
    def name(self) -> str:  # type: ignore[override]
        return self.code.name


class Escape(Procedure):
    """The procedure that ``let/ec`` binds."""

    __slots__ = ("active", "name")

    def __init__(self, name: str) -> None:
        self.name = name
        self.active = True


class EscapeSignal(Exception):
    """Unwinds to the ``let/ec`` that made ``escape``."""

    def __init__(self, escape: Escape, value: Any) -> None:
        super().__init__()
        self.escape = escape
        self.value = value


def arity_error(code: Code, given: int) -> SceneError:
    required, positional = code.required, code.positional
    if code.rest is not None:
        wanted = f"at least {required}"
    elif required == positional:
        wanted = str(required)
    else:
        wanted = f"{required} to {positional}"
    plural = "" if wanted.split()[-1] == "1" else "s"
    message = f"`{code.name}` wants {wanted} argument{plural}, got {given}"
    return SceneError("arity", message, hint=f"its parameters are {code.usage}")


def split_keywords(name: str, usage: str, arguments: Sequence[Any]) -> tuple[list[Any], dict[str, Any]]:
    """Positional arguments, and keyword arguments by name."""
    positional: list[Any] = []
    keywords: dict[str, Any] = {}
    pending = iter(arguments)
    for argument in pending:
        if type(argument) is not Keyword:
            positional.append(argument)
            continue
        key = str(argument)
        if key in keywords:
            raise SceneError("keyword", f"`:{key}` is given twice to `{name}`", hint=f"its parameters are {usage}")
        try:
            keywords[key] = next(pending)
        except StopIteration:
            raise SceneError("keyword", f"`:{key}` is followed by no value in a call of `{name}`") from None
    return positional, keywords


def bind_arguments(runtime: Runtime, closure: Closure, arguments: Sequence[Any]) -> Frame:
    """The frame for a call of ``closure``; the callee decides whether keywords are arguments or plain values."""
    code = closure.code
    if len(arguments) > _FEW:
        runtime.charge(len(arguments) >> 2)
    if code.keyword_names is None:
        return _fill(runtime, closure, arguments, {})
    positional, keywords = split_keywords(code.name, code.usage, arguments)
    check_keywords(code, keywords)
    return _fill(runtime, closure, positional, keywords)


def check_keywords(code: Code, names: Sequence[str] | Mapping[str, Any], word: str | None = None) -> None:
    """Refuse keywords that ``code`` does not know."""
    known = code.keyword_names
    if known is None or code.takes_any_keyword:
        return
    for name in names:
        if name not in known:
            target = f'"{word}"' if word is not None else f"`{code.name}`"
            hint = suggest(name, known) or f"its parameters are {code.usage}"
            raise SceneError("keyword", f"{target} has no parameter `:{name}`", hint=hint)


def bind_entity(runtime: Runtime, closure: Closure, word: str, z: Embedding, rest: Any) -> Frame:
    """The frame for an entity function: z, then gamma, and z's attributes by keyword (language.md, section 2)."""
    code = closure.code
    if code.required > 2:
        message = f'the function of "{word}" has {code.required} required parameters; `call` gives it at most two'
        hint = f"an embedding and the list of its descendants' embeddings; its parameters are {code.usage}"
        raise SceneError("arity", message, hint=hint)
    positional = [*(z, rest)][: code.required]
    tail: Any = NIL
    if code.rest is not None:
        tail = (Pair(z, rest), rest, NIL)[code.required]
    return _fill(runtime, closure, positional, z.attributes, tail, word)


def _fill(
    runtime: Runtime,
    closure: Closure,
    positional: Sequence[Any],
    keywords: Mapping[str, Any],
    entity_rest: Any = None,
    word: str | None = None,
) -> Frame:
    code = closure.code
    given = len(positional)
    if word is None and (given < code.required or (given > code.positional and code.rest is None)):
        raise arity_error(code, given)
    frame: Frame = [closure.env, *([None] * len(code.parameters))]
    index = 0
    for parameter in code.parameters:
        kind = parameter.kind
        if kind == "required" or (kind == "optional" and index < given):
            value = _checked(runtime, code, parameter, positional[index], word)
            index += 1
        elif kind == "keyword" and parameter.name in keywords:
            value = _checked(runtime, code, parameter, keywords[parameter.name], word)
        elif kind == "rest":
            value = entity_rest if word is not None else make_list(positional[code.positional :])
            value = _checked(runtime, code, parameter, value, word)
        elif kind == "keys":
            known = code.keyword_names or frozenset()
            extra = {name: value for name, value in keywords.items() if name not in known}
            value = runtime.table_of({name: (name, value) for name, value in extra.items()})
        elif parameter.default is not None:
            value = _checked(runtime, code, parameter, parameter.default(frame), word)
        else:
            owner = f'"{word}"' if word is not None else f"`{code.name}`"
            what = "attribute" if word is not None else "argument"
            message = f"{owner} needs the {what} `:{parameter.name}`"
            raise SceneError("keyword", message, hint=f"its parameters are {code.usage}")
        frame[parameter.slot] = Cell(value, runtime.clock) if parameter.in_cell else value
    return frame


def _checked(runtime: Runtime, code: Code, parameter: CodeParameter, value: Any, word: str | None) -> Any:
    if parameter.type is None:
        return value
    try:
        return parameter.type.checker(runtime)(value)
    except Mismatch:
        owner = f'"{word}"' if word is not None else f"`{code.name}`"
        sign = ":" if parameter.kind == "keyword" else ""
        message = (
            f"the parameter `{sign}{parameter.name}` of {owner} is of type {parameter.type.name}, "
            f"but got {type_name(value)}: {show(value, 60)}"
        )
        raise SceneError("type", message, hint=f"its parameters are {code.usage}") from None
