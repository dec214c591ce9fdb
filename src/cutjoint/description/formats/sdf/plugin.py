"""The `<plugin>`s of an SDF, in its models and worlds and in what stands in them."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from cutjoint.description.formats.common.plugins import Plugged, PluginNames, read_plugin
from cutjoint.description.formats.sdf.scope import MODEL, Scope
from cutjoint.description.xml import children


def read_plugins(scopes: Sequence[Scope]) -> Plugged:
    """What all plugins of models and worlds do."""
    done = Plugged()
    for scope in scopes:
        joints = [name for kind, name in scope.host.names if kind == "joint"]
        names = PluginNames(partial(_full, scope, "joint"), partial(_full, scope, "link"), (scope.name, MODEL), joints)
        elements = [*children(scope.element, "plugin")]
        elements += [one for item in scope.items for one in item.element.iter("plugin") if item.kind != "model"]
        for element in elements:
            read_plugin(element, names, done, scope.findings)
    return done


def _full(scope: Scope, kind: str, name: str) -> str | None:
    """The full name of a joint or link that a scope knows."""
    item = scope.find(name, (kind,)) if name else None
    return None if item is None else item.full
