#!/usr/bin/env bash
# Make a virtual environment: Relume, editable, beside the newest bpy that its Python runs (5.2 on 3.13, 5.0.1 on 3.11).
#   tools/make_venv.sh [FOLDER [VERSION]]   FOLDER: .venv, VERSION: the newest of 3.13 and 3.11 that this machine has
#   tools/make_venv.sh --find [VERSION]     prints that Python, and fails where there is none
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

find_python() {
  local version candidate wanted=$*
  for version in "$@"; do
    # On PATH may be a pyenv shim whose version is not chosen: only running a candidate tells.
    for candidate in $(type -ap "python$version" python3) \
      "${PYENV_ROOT:-$HOME/.pyenv}/versions/$version".*/bin/python; do
      if "$candidate" -c "import ensurepip, sys; sys.exit(sys.version_info[:2] != (${version/./, }))" 2>/dev/null; then
        echo "$candidate"
        return
      fi
    done
  done
  echo "error: no Python ${wanted// / or } with venv and pip was found, on PATH or in pyenv's versions" >&2
  return 1
}

folder=${1:-.venv}
# shellcheck disable=SC2086  # two versions are two words
python=$(find_python ${2:-3.13 3.11})
if [[ $folder == --find ]]; then
  echo "$python"
  exit
fi
echo "Making $folder with $("$python" --version) ($python) and downloading Blender as a Python module (about 400 MB)"
"$python" -m venv --clear "$folder"
"$folder/bin/pip" install --disable-pip-version-check --progress-bar off --editable '.[blender,dev,docs]' |
  sed -nEu 's/^ *(Downloading|Using cached) ([^ /]+-[^ /]+\.whl) (\(.*\))$/  \2 \3/p'
