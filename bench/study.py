"""Study files: YAML in, a validated study out, and one line for whatever is wrong with them."""

from __future__ import annotations

from difflib import get_close_matches
from importlib.resources import files
from pathlib import Path
from typing import Any

import yaml
from pydantic import ValidationError

from bench.errors import BenchError, unknown_name
from bench.study_errors import reason
from bench.study_model import Study, models


def names() -> list[str]:
    """The packaged studies, sorted."""
    return sorted(f.name.removesuffix(".yaml") for f in _packaged().iterdir() if f.name.endswith(".yaml"))


def load(name_or_path: str | Path) -> Study:
    """Load a packaged study by name, or a study file.

    Parameters
    ----------
    name_or_path : str or Path
        What ends in ``.yaml`` or ``.yml``, or holds a slash, is a file.

    Raises
    ------
    BenchError
        One line with file, key and what is allowed.
    """
    text = str(name_or_path)
    if text.endswith((".yaml", ".yml")) or "/" in text or isinstance(name_or_path, Path):
        return parse(_read(Path(text)), text)
    if text not in names():
        raise unknown_name("study", text, names())
    return parse((_packaged() / f"{text}.yaml").read_text(encoding="utf-8"), f"studies/{text}.yaml")


def parse(text: str, where: str) -> Study:
    """Validate the text of a study file; ``where`` names it in errors.

    Raises
    ------
    BenchError
        For bad YAML, an unknown key or a value that does not fit.
    """
    try:
        content = yaml.load(text, Loader=_UniqueKeys)
    except yaml.YAMLError as error:
        raise BenchError(f"{where}: not valid YAML: {_yaml_reason(error)}") from None
    if not isinstance(content, dict):
        raise BenchError(f"{where}: must hold keys and values, such as 'sequence: rendered' and 'name: mine'")
    model = _model_of(content, where)
    try:
        study: Study = model.model_validate(content)
        return study
    except ValidationError as error:
        raise BenchError(f"{where}: {reason(model, error)}") from None


def dump(study: Study) -> str:
    """Write a study as YAML with every default filled in; `parse` gives the same study back."""
    return yaml.safe_dump(study.model_dump(mode="json"), sort_keys=False, allow_unicode=True, width=110)


def _packaged() -> Any:
    return files("bench") / "studies"


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise BenchError(f"study file {path}: not found; packaged studies are {', '.join(names())}") from None
    except (OSError, UnicodeDecodeError) as error:
        raise BenchError(f"study file {path}: cannot be read: {error}") from None


class _UniqueKeys(yaml.SafeLoader):
    """Refuses a key that stands twice, where plain YAML silently keeps the last, and 30 February."""

    def construct_object(self, node: yaml.Node, deep: bool = False) -> Any:
        try:
            return super().construct_object(node, deep=deep)
        except ValueError as error:  # of the date that a scalar looks like
            raise yaml.MarkedYAMLError(None, None, f"{node.value}: {error}", node.start_mark) from None

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        seen: set[str] = set()
        for key, _ in node.value:
            if not isinstance(key, yaml.ScalarNode) or key.value in seen:
                plain = isinstance(key, yaml.ScalarNode)
                shown, problem = (repr(key.value), "stands twice") if plain else ("here", "is not plain text")
                raise yaml.MarkedYAMLError(None, None, f"the key {shown} {problem}", key.start_mark)
            seen.add(key.value)
        return super().construct_mapping(node, deep=deep)


def _yaml_reason(error: yaml.YAMLError) -> str:
    mark, problem = getattr(error, "problem_mark", None), getattr(error, "problem", None)
    reason = " ".join(str(problem or error).split())
    return f"line {mark.line + 1}, column {mark.column + 1}: {reason}" if mark else reason


def _model_of(content: dict[Any, Any], where: str) -> type[Study]:
    """The model that the key ``sequence`` chooses."""
    allowed = " or ".join(models())
    if "sequence" not in content:
        near = get_close_matches("sequence", [str(key) for key in content], n=1)
        hint = f" (instead of {near[0]!r}?)" if near else ""
        raise BenchError(f"{where}: sequence: is missing{hint}; allowed: {allowed}")
    kind = content["sequence"]
    if not isinstance(kind, str) or kind not in models():
        raise BenchError(f"{where}: sequence: {kind!r} is not known; allowed: {allowed}")
    return models()[kind]
