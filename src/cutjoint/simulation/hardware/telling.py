"""Hardware in words: what is not ideal of it, a row a part."""

from __future__ import annotations

from collections.abc import Mapping


def told(parts: Mapping[str, object]) -> list[tuple[str, str]]:
    """Rows of a table: what is not ideal in `Result.about["hardware"]`."""
    rows = []
    for name, part in parts.items():
        if isinstance(part, Mapping):
            plain = {key: value for key, value in part.items() if not isinstance(value, Mapping)}
            words = ", ".join(f"{key} {_short(value)}" for key, value in plain.items() if value not in (0.0, "joint"))
            rows += [(name, words)] if words else []
            rows += told({key: value for key, value in part.items() if isinstance(value, Mapping)})
        elif part:
            rows.append((name, str(part)))
    return [(name.replace("_", " "), words.replace("_", " ")) for name, words in rows]


def _short(value: object) -> str:
    if isinstance(value, list | tuple):
        return " ".join(map(_short, value))
    return f"{value:g}" if isinstance(value, float) else str(value)
