#!/bin/sh
# Makes the virtual environment that make uses, with the exact versions of constraints.txt.
#
#   tools/setup.sh FOLDER [PYTHON]
#
# Does nothing, in milliseconds, where FOLDER is ready.  "Ready" is written last, so an interrupted set-up is started
# anew by the next call.  A changed pyproject.toml or constraints.txt, a moved clone or another PYTHON is noticed too.
set -eu

venv=$1
asked=${2:-}
oldest="3.11"
ready="$venv/.ready"

version_of() {
    "$1" -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null
}

new_enough() {
    "$1" -c 'import sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1
}

state() {
    echo "folder $(pwd)"
    cksum pyproject.toml constraints.txt
}

if [ -f "$ready" ] && [ "$(state)" = "$(cat "$ready")" ]; then
    if [ -z "$asked" ] || [ "$(version_of "$asked")" = "$(version_of "$venv/bin/python")" ]; then
        exit 0
    fi
fi

# The interpreter: the one asked for, or the first of these that is new enough.
python=
if [ -n "$asked" ]; then
    found=$(version_of "$asked") || {
        echo "error: PYTHON=$asked does not run. Give the name or path of a Python $oldest or newer." >&2
        exit 1
    }
    new_enough "$asked" || {
        echo "error: cutjoint needs Python $oldest or newer; $asked is $found. Try: make PYTHON=python3.12" >&2
        exit 1
    }
    python=$asked
else
    for candidate in python3 python3.13 python3.12 python3.11 python; do
        if new_enough "$candidate"; then
            python=$candidate
            break
        fi
    done
    if [ -z "$python" ]; then
        found=$(version_of python3) || found="none"
        echo "error: cutjoint needs Python $oldest or newer; found: $found. Install one, or name it: make PYTHON=/path/to/python3" >&2
        exit 1
    fi
fi

# A finished environment of the same Python in the same place is brought up to date; anything else is made anew.
echo "cutjoint: setting up $venv with Python $(version_of "$python") (once; a minute or two)"
if [ -f "$ready" ] && [ "$(head -n 1 "$ready")" = "folder $(pwd)" ] &&
    [ "$(version_of "$python")" = "$(version_of "$venv/bin/python")" ]; then
    rm -f "$ready"
else
    rm -f "$ready"
    "$python" -m venv --clear "$venv" || {
        echo "error: $python could not make a virtual environment. On Debian and Ubuntu: apt install python3-venv" >&2
        exit 1
    }
fi

# The variables, unlike the option, also pin what builds the package (the first up to pip 26.1, the second after it).
PIP_CONSTRAINT=constraints.txt PIP_BUILD_CONSTRAINT=constraints.txt \
    "$venv/bin/python" -m pip install --quiet --disable-pip-version-check --editable '.[dev]' || {
    echo "error: the packages could not be installed (see above); the next make tries again" >&2
    exit 1
}
state >"$ready.new"
mv "$ready.new" "$ready"
