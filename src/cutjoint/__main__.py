"""The program `cutjoint`, also as `python -m cutjoint`: signals are watched before anything else is loaded."""

from __future__ import annotations

from cutjoint import interrupts


def main() -> None:
    """Entry point of `cutjoint`; see `cutjoint.cli.main`."""
    interrupts.watch()
    from cutjoint.cli import main as command_line

    command_line()


if __name__ == "__main__":
    main()
