"""Programs kept in the user's cache folder, so that tracing a robot is paid once.

What is stored is data: instructions as numbers (`Program.to_bytes`).  A stored program is used only if all of this
holds:

- its name is the digest of the model, the options, and the source text of the compiler and of the papers' equations, so
  a changed model or version looks for another name; and the file repeats that digest inside;
- nobody but the user can have written it (`cutjoint.compile.kept`);
- its own digest matches its content, and the content is straight-line code with the arguments and results asked for;
- the numbers it gives agree with the model it claims to be (`cutjoint.compile.functions.verify` compares it with
  Pinocchio, or with the published model, before it is handed out).

Anything else is ignored and written anew.  Processes that compile the same robot at once do the work twice and
otherwise do not notice each other.  Machine code is kept beside, see `cutjoint.compile.machine.llvm.objects`.
"""

from __future__ import annotations

from hashlib import sha256

from cutjoint.compile import kept
from cutjoint.compile.expressions.program import Program, ProgramError
from cutjoint.compile.kept import code_version

KIND = "programs/program"


def key(content: str, what: str, options: str) -> str:
    """Name of a program: 64 hexadecimal digits."""
    return sha256("\0".join((code_version(), content, what, options)).encode()).hexdigest()


def read(name: str) -> Program | None:
    """The stored program, or None where there is none that may be used."""
    data = kept.read(KIND, name)
    try:
        return None if data is None else Program.from_bytes(data)
    except ProgramError:
        return None


def write(name: str, program: Program) -> None:
    """Store a program."""
    kept.write(KIND, name, program.to_bytes())


def drop(name: str) -> None:
    """Forget a program."""
    kept.drop(KIND, name)
