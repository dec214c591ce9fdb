"""Defaults in MJCF: attributes that an element takes from its class, the class of the body around it, or from main."""

from __future__ import annotations

from cutjoint.description.findings import Findings, nearest
from cutjoint.description.xml import Element, children


class Defaults:
    """The tree of `<default>` classes of a file."""

    def __init__(self, root: Element, findings: Findings) -> None:
        self.findings = findings
        self._classes: dict[str, dict[str, dict[str, str]]] = {"main": {}}
        for element in children(root, "default"):
            self._read(element, str(element.get("class") or "main"), {})

    def _read(self, element: Element, name: str, above: dict[str, dict[str, str]]) -> None:
        own = {tag: dict(values) for tag, values in (above or self._classes.get(name, {})).items()}
        for child in children(element):
            if child.tag != "default":
                own[str(child.tag)] = own.get(str(child.tag), {}) | {str(k): str(v) for k, v in child.attrib.items()}
        self._classes[name] = own
        for child in children(element, "default"):
            inner = str(child.get("class") or "")
            if not inner:
                self.findings.error("<default> without class", '<default class="...">', "", child.sourceline)
                continue
            self._read(child, inner, own)

    def attributes(self, element: Element, childclass: str) -> dict[str, str]:
        """The attributes of an element with those of its class filled in."""
        name = str(element.get("class") or childclass or "main")
        if name not in self._classes:
            found = f"unknown class '{name}'"
            self.findings.error(found, "a class of <default>", nearest(name, self._classes), element.sourceline)
            name = "main"
        own = {str(key): str(value) for key, value in element.attrib.items()}
        inherited = self._classes[name].get(str(element.tag), {})
        if set(own) & _ORIENTED:
            inherited = {key: value for key, value in inherited.items() if key not in _ORIENTED}
        return inherited | own


_ORIENTED = {"quat", "axisangle", "xyaxes", "zaxis", "euler"}
