#!/usr/bin/env bash
# Builds the source archive, from it the wheel, installs that alone into a new environment and uses it from elsewhere.
#
#   tools/try_wheel.sh PYTHON      PYTHON has the package `build`
set -euo pipefail
python=$(realpath -s "$1")
root=$(cd "$(dirname "$0")/.." && pwd)
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT

cd "$root"
export PIP_CONSTRAINT=constraints.txt PIP_BUILD_CONSTRAINT=constraints.txt PIP_DISABLE_PIP_VERSION_CHECK=1
unset PYTHONPATH PYTHONHOME
"$python" -m build --outdir "$place/dist" . >"$place/build.log" 2>&1 || {
    cat "$place/build.log"
    exit 1
}
"$python" -m venv "$place/venv"
"$place/venv/bin/python" -m pip install --quiet "$place"/dist/*.whl

cd "$place"
echo "built $(cd dist && echo *)"
venv/bin/cutjoint list
venv/bin/python -c 'import cutjoint; assert "site-packages" in cutjoint.__file__, cutjoint.__file__; print(cutjoint.__file__)' >/dev/null
