"""Machine code kept in the user's cache folder, so that a robot is compiled once and not in every process.

It is loaded and run as Python's own `.pyc` files are: whoever can write the user's files can have that run anyway, so
what is asked for is that nobody else can have written it (`cutjoint.compile.kept`).  Its name is the digest of what is
compiled, of the source text of the compiler, of LLVM's version and of the processor, so that another one looks for
another name; its own digest tells a damaged file; and what it computes is compared with the model like everything that
is compiled (`cutjoint.compile.functions.verify`).  `cached=False` neither reads nor writes any.
"""

from __future__ import annotations

from hashlib import sha256

from cutjoint.compile import kept

KIND = "machine/code"
DIGEST = 32


def key(*what: bytes) -> str:
    """Name of machine code: 64 hexadecimal digits."""
    digest = sha256(kept.code_version().encode())
    for part in what:
        digest.update(len(part).to_bytes(8, "little") + part)
    return digest.hexdigest()


def read(name: str) -> bytes | None:
    """The object file, or None where there is none that may be used."""
    data = kept.read(KIND, name)
    if data is None or len(data) <= DIGEST or sha256(data[DIGEST:]).digest() != data[:DIGEST]:
        return None
    return data[DIGEST:]


def drop(name: str) -> None:
    """Forget an object file."""
    kept.drop(KIND, name)


def write(name: str, code: bytes) -> None:
    """Keep an object file."""
    kept.write(KIND, name, sha256(code).digest() + code)
