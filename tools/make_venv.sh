#!/usr/bin/env bash
# Make .venv: Relume, editable, beside the newest bpy that a Python of this machine runs (5.2 on 3.13, 5.0.1 on 3.11).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

find_python() {
  local version candidate
  for version in 3.13 3.11; do
    # On PATH may be a pyenv shim whose version is not chosen: only running a candidate tells.
    for candidate in $(type -ap "python$version" python3) \
      "${PYENV_ROOT:-$HOME/.pyenv}/versions/$version".*/bin/python; do
      if "$candidate" -c "import ensurepip, sys; sys.exit(sys.version_info[:2] != (${version/./, }))" 2>/dev/null; then
        echo "$candidate"
        return
      fi
    done
  done
  echo "error: no Python 3.13 or 3.11 with venv and pip was found, on PATH or in pyenv's versions" >&2
  return 1
}

python=$(find_python)
echo "Making .venv with $("$python" --version) ($python) and downloading Blender as a Python module (about 400 MB)"
"$python" -m venv --clear .venv
.venv/bin/pip install --disable-pip-version-check --progress-bar off --editable '.[blender,dev]' |
  sed -nEu 's/^ *(Downloading|Using cached) ([^ /]+-[^ /]+\.whl) (\(.*\))$/  \2 \3/p'
