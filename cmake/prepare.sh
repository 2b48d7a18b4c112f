# Sourced by examples/run and tests/run: install the Debian packages that are missing, configure and build.
#   prepare PRESET [TARGET...]   leaves the build in build/PRESET
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

install_missing() {
  local wanted missing=()
  wanted=$(grep -v '^#' "$root/cmake/debian-packages.txt")
  for p in $wanted; do
    dpkg-query -W -f='${Status}' "$p" 2>/dev/null | grep -q 'ok installed' || missing+=("$p")
  done
  [ ${#missing[@]} = 0 ] && return
  if [ "$(id -u)" != 0 ]; then
    echo "these Debian packages are missing: ${missing[*]}" >&2
    echo "install them: sudo apt-get install ${missing[*]}" >&2
    exit 2
  fi
  echo "installing ${#missing[@]} Debian packages: ${missing[*]}"
  local log
  log=$(mktemp)
  if ! { apt-get update && DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "${missing[@]}"; } >"$log" 2>&1; then
    tail -n 20 "$log" >&2
    echo "apt-get failed; whole log: $log" >&2
    exit 1
  fi
  rm -f "$log"
}

prepare() {
  local preset=$1
  shift
  install_missing
  cd "$root"
  local log=build/$preset/prepare.log
  mkdir -p "build/$preset"
  echo "configuring and building (preset $preset; log $log)"
  if ! { cmake --preset "$preset" >"$log" 2>&1 && cmake --build --preset "$preset" ${@:+--target "$@"} >>"$log" 2>&1; }; then
    tail -n 40 "$log" >&2
    echo "the build failed; whole log: $root/$log" >&2
    exit 1
  fi
}
