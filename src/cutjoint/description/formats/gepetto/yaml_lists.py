"""The little YAML that robot files need: a mapping of names to texts and nested lists, with line numbers.

Nothing is constructed (no tags, no objects), and anchors and aliases are refused.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from cutjoint.description.files import read_text_file
from cutjoint.description.findings import Findings, clip

if TYPE_CHECKING:
    import yaml


@dataclass(frozen=True)
class YamlItem:
    """A text, or a list (then `items` is not None)."""

    text: str
    line: int
    items: tuple[YamlItem, ...] | None = None


def read_yaml(path: Path, findings: Findings) -> dict[str, YamlItem] | None:
    """The top-level mapping of a YAML file, or None after noting why not."""
    data = read_text_file(path, findings, "YAML")
    if data is None:
        return None
    try:
        import yaml
    except ImportError:
        findings.error("PyYAML is not installed", "PyYAML, to read robot.yaml", 'pip install "cutjoint[formats]"')
        return None
    try:
        for event in yaml.parse(data, Loader=yaml.SafeLoader):
            if isinstance(event, yaml.AliasEvent):
                findings.error("a YAML alias", "plain values", "write it out", event.start_mark.line + 1)
                return None
        root = yaml.compose(data, Loader=yaml.SafeLoader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        text = clip(str(error.problem or error.context or error))
        findings.error(f"the YAML does not parse: {text}", "YAML 1.1", "", mark.line + 1 if mark else None)
        return None
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        findings.error(f"the YAML does not parse: {clip(str(error), 120)}", "YAML 1.1")
        return None
    if not isinstance(root, yaml.MappingNode):
        findings.error("the YAML is not a mapping", "key: value lines", "", 1)
        return None
    return {str(key.value): _entry(value) for key, value in root.value}


def _entry(node: yaml.Node) -> YamlItem:
    line = node.start_mark.line + 1
    if isinstance(node.value, list):
        items = [child[1] if isinstance(child, tuple) else child for child in node.value]
        return YamlItem("", line, tuple(_entry(child) for child in items))
    return YamlItem(str(node.value), line)
