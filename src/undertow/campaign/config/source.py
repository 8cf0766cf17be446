"""A YAML file as plain values, with the line of each, and the sentence for each thing that is wrong in it.

Belongs here: YAML 1.2, overrides, lines, nearest keys. Does not belong here: which keys there are (settings.py).
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails
from ruamel.yaml import YAML, tokens
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

from undertow.errors import ConfigError
from undertow.recording.conditions import number

Location = tuple[int | str, ...]
Wrong = tuple[Location, str]
"""Where a config is wrong, and how, in a sentence."""

_HELD: Mapping[type, str] = {list: "a list", str: "one text"}
"""What a file without keys holds, in words."""

BYTES_AT_MOST = 1_000_000
"""Of a config: ten thousand trials named one by one take a third of it."""

TOKENS_AT_MOST = 100_000
"""Keys, values and marks of a config: ten thousand windows by file name have 90,000, read in some seconds."""

DEEPEST = 32
"""Levels of a config; the deepest key of all lies 6 levels deep."""

Model = TypeVar("Model", bound=BaseModel)

TOLD = 4
"""Keys of a section up to which a message says what each means."""

_SHOWN = 60  # characters of a value in a message
_STARTS = (
    tokens.BlockMappingStartToken, tokens.BlockSequenceStartToken, tokens.FlowMappingStartToken,
    tokens.FlowSequenceStartToken,
)  # fmt: skip
_ENDS = (tokens.BlockEndToken, tokens.FlowMappingEndToken, tokens.FlowSequenceEndToken)


@dataclass(frozen=True)
class Source:
    """What a config file says (``data``), where each key stands in it, and what was set on the command line."""

    path: Path
    data: Mapping[str, Any]
    root: Node = field(compare=False, repr=False)
    overrides: Mapping[Location, str] = field(default_factory=dict)

    def place(self, location: Location) -> str:
        """Where a key was written: ``config.yaml line 12``, or ``--set seed=x``."""
        for path, text in self.overrides.items():
            if tuple(map(str, location[: len(path)])) == tuple(map(str, path)):
                return f"--set {text}"
        return f"{self.path.name} line {_line(self.root, location)}"


def read_source(path: Path, overrides: Sequence[str] = ()) -> Source:
    """A config file and ``a.b=value`` overrides, whose values are read as YAML.

    Raises ConfigError where the file is missing, too large or deep, is no YAML mapping, repeats a key, or uses tags or
    aliases (they are refused: a config says everything once, in plain values).
    """
    try:
        size = path.stat().st_size
        if size > BYTES_AT_MOST:
            raise ConfigError(
                f"config {path} has {size} bytes, more than {BYTES_AT_MOST}; is it a config? lists of trials belong in "
                "recordings.index"
            )
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
        instead = f"undertow init {path} writes a config for a folder" if path.is_dir() else "check the path"
        raise ConfigError(f"config {path} cannot be read: {reason}; {instead}") from error
    try:
        _allow(text, path.name)
        root = YAML(typ="safe", pure=True).compose(text)
        data = YAML(typ="safe", pure=True).load(text)
    except (YAMLError, ValueError, RecursionError) as error:
        if isinstance(error, ConfigError):
            raise
        raise ConfigError(_yaml_sentence(path.name, error)) from error
    if not isinstance(data, dict):
        held = "is empty" if data is None else f"holds {_HELD.get(type(data), 'one value')}, not keys with values"
        raise ConfigError(f"config {path} {held}; is it a config? undertow init writes one for a folder of recordings")
    given: dict[Location, str] = {}
    for override in overrides:
        data, location = _with_override(data, override)
        given[location] = override
    return Source(path, data, root, given)


def _allow(text: str, name: str) -> None:
    """ConfigError where YAML has tags, aliases or keys that are no text, or more or deeper parts than a config: a
    parser takes minutes there.

    Raises YAMLError as the scanner does.
    """
    depth, before = 0, None
    for count, token in enumerate(YAML(typ="safe", pure=True).scan(text)):
        where = f"{name} line {token.start_mark.line + 1}"
        if isinstance(token, tokens.TagToken | tokens.AliasToken):
            kind = "a tag (!...)" if isinstance(token, tokens.TagToken) else "an alias (*...)"
            raise ConfigError(f"{where}: {kind} is not read; write the value itself")
        if isinstance(before, tokens.KeyToken) and isinstance(token, _STARTS):
            raise ConfigError(f"{where}: a key is a list or has keys itself; write it as plain text")
        before = token
        depth += isinstance(token, _STARTS) - isinstance(token, _ENDS)
        if depth > DEEPEST:
            raise ConfigError(f"{where}: lists and keys lie more than {DEEPEST} levels deep; no key of a config does")
        if count > TOKENS_AT_MOST:
            raise ConfigError(
                f"{where}: there are more than {TOKENS_AT_MOST} keys, values and marks up to here; lists of trials "
                "belong in recordings.index"
            )


OF_SEVERAL = ("literal_error", "tuple_type", "list_type")
"""Errors of pydantic that name one of the kinds that may stand at a place, or Python's name of it."""


def validated(model: type[Model], source: Source) -> Model:
    """What a file says as its model has it; ConfigError with a sentence for everything that it cannot be."""
    try:
        return model.model_validate(source.data)
    except ValidationError as error:
        found = sentences(source, error.errors(include_url=False), model.model_json_schema())
        raise ConfigError("\n".join(found)) from error


def sentences(source: Source, errors: Sequence[ErrorDetails], schema: Mapping[str, Any]) -> list[str]:
    """One sentence a problem: where, what was written, what it should be, the nearest key."""
    said = []
    for error in errors:
        location = _without_tags(source.data, error["loc"])
        name = ".".join(map(str, location)) or "the config"
        if (parted := _parted_number(source.data, location)) is not None:
            said.append(f"{source.place(location)}: {parted}")
        elif error["type"] == "extra_forbidden":
            said.append(f"{source.place(location)}: {_unknown_key(location, schema)}")
        elif error["type"] == "missing":
            above = ".".join(map(str, location[:-1])) or "the config"
            said.append(f"{source.place(location[:-1])}: {above} has no {location[-1]!r}; it is needed")
        else:
            rule = error["msg"].removeprefix("Value error, ").removeprefix("Input ")
            if error["type"] == "too_short":
                if _within(location, errors):
                    continue  # entries that are none were not counted
                rule = f"should have at least {error['ctx']['min_length']} of them"
            if error["type"] in ("model_type", "dict_type", "dataclass_type"):
                known = listed_keys(properties(schema, location))
                rule = f"should be keys with values{f'; it may have {known}' if known else ''}"
            if error["type"] in OF_SEVERAL and (allowed := kinds(schema, location)):
                rule = f"should be {allowed}"
            mended = number(error["input"]) if isinstance(error["input"], str) else None
            hint = "" if mended is None else f"; write {mended:.10g}, without quotes"
            said.append(f"{source.place(location)}: {name} is {_shown(error['input'])} but {rule}{hint}")
    return list(dict.fromkeys(said))


def _within(location: Location, errors: Sequence[ErrorDetails]) -> bool:
    """Whether something within this place is wrong as well."""
    return any(len(one["loc"]) > len(location) and one["loc"][: len(location)] == location for one in errors)


def _parted_number(data: Any, location: Location) -> str | None:
    """That a decimal comma parted a number within braces, where a key is a number without a value."""
    above = data
    for part in location[:-1]:
        above = next((above[key] for key in above if str(key) == str(part)), None) if isinstance(above, dict) else None
    last = str(location[-1]) if location else ""
    if not isinstance(above, dict) or not last.isdecimal():
        return None
    key = next((key for key in above if str(key) == last), None)
    if key is None or above[key] is not None:
        return None
    name = ".".join(map(str, location[:-1]))
    return f'{name} has {last} without a value: within braces a comma parts entries; write 1.63, or "1,63" in quotes'


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= _SHOWN else text[: _SHOWN - 3] + "..."


def _unknown_key(location: Location, schema: Mapping[str, Any]) -> str:
    key, where = str(location[-1]), ".".join(map(str, location[:-1])) or "the config"
    known = properties(schema, location[:-1])
    near = difflib.get_close_matches(key, sorted(known), n=1, cutoff=0.5)
    hint = f"did you mean {near[0]!r}?" if near else f"it may have {listed_keys(known)}"
    return f"unknown key {key!r} in {where}; {hint}"


def listed_keys(known: Mapping[str, str]) -> str:
    """Keys as a message lists them; the few of a small section with what each means."""
    told = len(known) <= TOLD and all(known.values())
    return ", ".join(f"{key} ({known[key].rstrip('.')})" if told else key for key in sorted(known))


def properties(schema: Mapping[str, Any], location: Location) -> dict[str, str]:
    """Keys that the schema knows at a place, and what each means."""
    return {
        key: str(one.get("description", ""))
        for node in _nodes(schema, location)
        for key, one in node.get("properties", {}).items()
    }


def kinds(schema: Mapping[str, Any], location: Location) -> str:
    """What may stand at a place in words, all that the schema has there: a word, a list, keys; empty where it says
    nothing of it."""
    said = []
    for node in _nodes(schema, location):
        words = [node["const"]] if "const" in node else node.get("enum", [])
        keys = sorted(node.get("properties", {}))
        known = {"array": "a list", "object": f"keys with values ({', '.join(keys)})" if keys else "keys with values"}
        known |= {"number": "a number", "integer": "a whole number"}
        said += [*map(repr, words), *([known[node["type"]]] if node.get("type") in known and not words else [])]
    *first, last = [*dict.fromkeys(said)] or [""]
    return f"{', '.join(first)} or {last}" if first else last


def _nodes(schema: Mapping[str, Any], location: Location) -> list[Mapping[str, Any]]:
    """The schema's nodes at a place, its alternatives one by one."""
    nodes = _expanded(schema, schema)
    for part in location:
        inner = []
        for node in nodes:
            found = node.get("properties", {}).get(str(part), node.get("additionalProperties"))
            if isinstance(found, Mapping):
                inner += _expanded(found, schema)
        nodes = inner
    return nodes


def _expanded(node: Mapping[str, Any], schema: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """A schema node without references: its alternatives, one by one."""
    if "$ref" in node:
        return _expanded(schema["$defs"][node["$ref"].rsplit("/", 1)[1]], schema)
    choices = [*node.get("anyOf", ()), *node.get("oneOf", ())]
    return [one for choice in choices for one in _expanded(choice, schema)] if choices else [node]


def _without_tags(data: Any, location: Sequence[int | str]) -> Location:
    """A location in the data: pydantic also names the branch of a union, which is no key."""
    kept: list[int | str] = []
    here = data
    for at, part in enumerate(location):
        keys = {str(key): key for key in here} if isinstance(here, Mapping) else {}
        if str(part) in keys:
            kept.append(part)
            here = here[keys[str(part)]]
        elif isinstance(here, list) and isinstance(part, int) and part < len(here):
            kept.append(part)
            here = here[part]
        elif isinstance(here, Mapping) and at == len(location) - 1:
            kept.append(part)  # a key that is missing
    return tuple(kept)


def _line(root: Node, location: Location) -> int:
    """Line (from 1) of a key, or of the last part of its path that was written."""
    node: Node = root
    line = int(root.start_mark.line) + 1
    for part in location:
        if isinstance(node, MappingNode):
            found = [pair for pair in node.value if isinstance(pair[0], ScalarNode) and _names(pair[0], part)]
            if not found:
                return line
            line, node = int(found[0][0].start_mark.line) + 1, found[0][1]
        elif isinstance(node, SequenceNode) and isinstance(part, int) and part < len(node.value):
            node = node.value[part]
            line = int(node.start_mark.line) + 1
    return line


def _names(key: ScalarNode, part: int | str) -> bool:
    if str(key.value) == str(part):
        return True
    try:
        return float(key.value) == float(part)
    except ValueError:
        return False


def _yaml_sentence(name: str, error: Exception) -> str:
    """A parser's complaint in one line."""
    if isinstance(error, MarkedYAMLError):
        mark = error.problem_mark or error.context_mark
        where = f"{name} line {mark.line + 1}" if mark is not None else name
        problem = " ".join(str(error.problem or error.context).split())
        return f"{where}: {problem}; correct the YAML"
    return f"{name}: {' '.join(str(error).split()) or type(error).__name__}; correct the YAML"


def _with_override(data: Mapping[str, Any], override: str) -> tuple[dict[str, Any], Location]:
    """The data with one ``a.b=value`` in it, and where that is. The data itself stays as it is."""
    path, sign, text = override.partition("=")
    keys = tuple(part for part in path.strip().split("."))
    shown = override if len(override) <= _SHOWN else override[: _SHOWN - 3] + "..."
    if len(keys) > DEEPEST:
        raise ConfigError(f"--set {shown}: the key has {len(keys)} parts; no key of a config has more than {DEEPEST}")
    if not sign or not all(keys):
        raise ConfigError(f"--set {shown}: it must read key.key=value, e.g. seed=1 or specimen.area_m2=0.97")
    try:
        _allow(text, f"--set {keys[0]}=...")
        value = YAML(typ="safe", pure=True).load(text) if text.strip() else None
    except (YAMLError, ValueError, RecursionError) as error:
        if isinstance(error, ConfigError):
            raise
        raise ConfigError(f"--set {shown}: {_shown(text)} is no YAML value; quote it") from error
    return _placed(data, keys, value, override), keys


def _placed(data: Any, keys: Location, value: Any, override: str) -> Any:
    if not keys:
        return value
    if isinstance(data, list):
        if not str(keys[0]).isdigit() or int(keys[0]) >= len(data):
            raise ConfigError(f"--set {override}: {keys[0]!r} is no place in a list of {len(data)}; count from 0")
        at = int(keys[0])
        return [*data[:at], _placed(data[at], keys[1:], value, override), *data[at + 1 :]]
    if data is not None and not isinstance(data, Mapping):
        raise ConfigError(f"--set {override}: {keys[0]!r} lies below {data!r}, which has no keys; set the whole of it")
    table = dict(data or {})
    key = next((key for key in table if str(key) == keys[0]), keys[0])
    table[key] = _placed(table.get(key), keys[1:], value, override)
    return table
