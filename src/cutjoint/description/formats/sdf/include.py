"""The scopes of an SDF file and of the models that it includes.

`<include>` names a folder with a model.config or a model.sdf, or a file: model://NAME and NAME are looked for beside
the file and as meshes are.  Nothing is fetched from the net; Gazebo's ground and sun are not missed.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import unquote

from cutjoint.description.files import search_folders
from cutjoint.description.formats.sdf.names import check_names
from cutjoint.description.formats.sdf.scope import Item, Scope
from cutjoint.description.formats.sdf.values import child_flag, flag, text_of, version_of
from cutjoint.description.xml import Element, children, name_of, only_child, read_xml, refuse_xacro
from cutjoint.files import is_file
from cutjoint.findings import Findings, clip

DEEPEST = 10
"""Files that include each other."""
_SCENERY = frozenset({"sun", "ground_plane"})
MOST = 500
"""Models in one robot."""


@dataclass
class Build:
    """How many models there are so far, and the files that are open, outermost first."""

    models: int = 0
    files: list[Path] = field(default_factory=list)


def open_sdf(path: Path, findings: Findings) -> Element | None:
    """The checked `<sdf>` element of a file, or None after noting why not."""
    root = read_xml(path, findings, "SDF")
    if root is None:
        return None
    if root.tag != "sdf":
        findings.error(f"the root element is <{root.tag}>", "<sdf>", "is this another format?", root.sourceline)
        return None
    refuse_xacro(root, findings)
    check_names(root, version_of(root, Findings()), findings)
    return root


def outermost(root: Element, path: Path, findings: Findings) -> Scope | None:
    """The scope of an `<sdf>` with a world or with a model, and all that is in it; None where there are several."""
    version = version_of(root, findings)
    outer = [*children(root, "world")]
    alone = [*children(root, "model")]
    if len(outer) + bool(alone) > 1:
        found = f"{len(outer)} worlds and {len(alone)} models side by side"
        findings.error(found, "one world, or one model", "keep the one with the robot", root.sourceline)
        return None
    scope = Scope(outer[0] if outer else root, "", path, version, findings)
    _fill(scope, Build(files=[path.resolve()]))
    return scope


def _fill(scope: Scope, build: Build) -> None:
    for element in children(scope.element):
        kind = str(element.tag)
        if kind == "include":
            _include(element, scope, build)
        elif kind == "model":
            name = name_of(element, scope.findings)
            if name is not None:
                model = Scope(element, name, scope.file, scope.version, scope.findings, scope)
                model.pose = only_child(element, "pose", scope.findings)
                model.placement_frame = str(element.get("placement_frame") or "").strip()
                model.static = scope.static or child_flag(element, "static", scope.findings)
                _enter(model, element, scope, build)
        elif kind in ("joint", "frame") or (kind == "link" and scope.is_model):
            name = name_of(element, scope.findings)
            if name is not None:
                scope.add(Item(kind, name, element, scope))


def _enter(model: Scope, element: Element, scope: Scope, build: Build) -> None:
    build.models += 1
    if build.models > MOST:
        if build.models == MOST + 1:
            scope.findings.error(f"more than {MOST} models", "fewer", "split the file", element.sourceline)
        return
    scope.add(Item("model", model.name, element, scope, model))
    _fill(model, build)


def _include(element: Element, scope: Scope, build: Build) -> None:
    """Read the included model as if it stood here, with the name, pose, ... that the `<include>` gives it."""
    findings, line = scope.findings, element.sourceline
    if any("params" in str(child.tag) and ":" in _prefixed(child) for child in children(element)):
        findings.error("<include> with experimental:params", "a plain <include>", "write the changed model out", line)
    uri = text_of(only_child(element, "uri", findings))
    file = _file(uri, element, scope)
    if file is None or not _may_open(file, uri, element, scope, build):
        return
    own = Findings(str(file))
    own.problems = findings.problems
    root = open_sdf(file, own)
    if root is None:
        return
    version = version_of(root, own)
    found = [*children(root, "model")]
    if len(found) != 1:
        if found or not any(children(root, tag) for tag in ("actor", "light")):
            told = f"<include> of '{clip(uri)}', which has {len(found)} models"
            findings.error(told, "a file with one model", "", line)
        return
    given = text_of(only_child(element, "name", findings))
    name = given or name_of(found[0], own)
    if name is None:
        return
    model = Scope(found[0], name, file, version, own, scope)
    _override(model, element, scope)
    if model.merged and not scope.is_model:
        findings.error("<include merge> in a world", "merge inside a <model>", "remove merge", line)
        return
    build.files.append(file.resolve())
    _enter(model, element, scope, build)
    build.files.pop()


def _override(model: Scope, element: Element, scope: Scope) -> None:
    findings, own = scope.findings, model.findings
    pose = only_child(element, "pose", findings)
    frame = only_child(element, "placement_frame", findings)
    static = only_child(element, "static", findings)
    model.merged = flag(str(element.get("merge") or ""), "merge of <include>", findings, element.sourceline)
    model.pose = only_child(model.element, "pose", own) if pose is None else pose
    model.placement_frame = str(model.element.get("placement_frame") or "").strip() if frame is None else text_of(frame)
    if frame is not None and pose is None:
        findings.error("<placement_frame> without <pose> in <include>", "both", "", frame.sourceline)
    itself = child_flag(model.element, "static", own) if static is None else child_flag(element, "static", findings)
    model.static = scope.static or itself


def _prefixed(element: Element) -> str:
    return f"{element.prefix or ''}:{element.tag}"


def _may_open(file: Path, uri: str, element: Element, scope: Scope, build: Build) -> bool:
    if file.resolve() in build.files:
        found = f"<include> of '{clip(uri)}', which includes itself"
        scope.findings.error(found, "files without a ring", "", element.sourceline)
        return False
    if len(build.files) > DEEPEST:
        found = f"<include> of '{clip(uri)}', more than {DEEPEST} files deep"
        scope.findings.error(found, "fewer", "", element.sourceline)
        return False
    return True


def _file(uri: str, element: Element, scope: Scope) -> Path | None:
    """The SDF file that a URI means, or None after noting that there is none."""
    scheme, apart, name = unquote(uri).partition("://")
    if not apart:
        scheme, name = "", unquote(uri)
    findings, line = scope.findings, element.sourceline
    if not name or scheme not in ("", "model", "package", "file"):
        found = f"<include> of '{clip(uri)}'" if uri else "<include> without <uri>"
        mend = "fetch the model and include it by model:// or a relative path" if uri else ""
        _missing(uri, found, "a model on this machine", mend, line, scope)
        return None
    near = [scope.file.parent, *search_folders(scope.file)] if scheme != "file" else [scope.file.parent]
    tried = [Path(os.path.normpath(folder / name)) for folder in near]
    for one in dict.fromkeys(tried):
        found_there = _model_file(one, findings)
        if found_there is not None:
            return found_there
    places = ", ".join(map(str, list(dict.fromkeys(tried))[:2]))
    mend = "" if scheme == "file" else "add the folder that holds it to GAZEBO_MODEL_PATH"
    found = f"model '{clip(uri)}' of an <include> not found"
    _missing(uri, found, f"a folder or file, such as {places}", mend, line, scope)
    return None


def _missing(uri: str, found: str, expected: str, mend: str, line: int | None, scope: Scope) -> None:
    """Note a model that is not there: beside the robot it may be passed, as part of it not."""
    if scope.is_model or not uri:
        scope.findings.error(found, expected, mend, line)
    elif uri.rstrip("/").rpartition("/")[2].lower().replace(" ", "_") in _SCENERY:
        scope.findings.warn(f"{found}; it is left out", "", "", line)
    else:
        scope.findings.doubt(found, expected, mend, line)


def _model_file(path: Path, findings: Findings) -> Path | None:
    """The file itself, or that which the folder's model.config names for the newest version, or its model.sdf."""
    if is_file(path):
        return path
    config = path / "model.config"
    if is_file(config):
        own = Findings(str(config))
        root = read_xml(config, own, "model.config")
        findings.problems.extend(own.problems)
        named = [] if root is None else [*children(root, "sdf")]
        named.sort(key=lambda one: version_of(one, Findings()))
        if named and text_of(named[-1]):
            return path / text_of(named[-1])
    return path / "model.sdf" if is_file(path / "model.sdf") else None
