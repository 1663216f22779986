# SPDX-License-Identifier: MIT
# shellcheck shell=bash
# What the scripts share; sourced, never run. Sets `root`, the repository's folder.

set -euo pipefail
export LC_ALL=C.UTF-8  # a bare Debian has no other locale

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

say() { printf '\n== %s\n' "$*"; }

fail() {
  printf '%s: %s\n' "$(basename "$0")" "$*" >&2
  exit 1
}

# Prints the comment at the head of the calling script, which is its help.
help() { awk 'NR > 2 && /^#/ { sub(/^# ?/, ""); print; next } NR > 2 { exit }' "$0"; }

# The compiler's cache lives in the home folder; not every account has one it can write to.
if [[ -z ${CCACHE_DIR:-} && ! -w ${HOME:-/nonexistent} ]]; then
  export CCACHE_DIR="$root/build/ccache"
fi

# configure_and_build PRESET [TARGET…]
configure_and_build() {
  local preset=$1
  shift
  say "Configuring (preset $preset)"
  (cd "$root" && cmake --preset "$preset")
  say "Building (preset $preset)"
  (cd "$root" && cmake --build --preset "$preset" --parallel "$(nproc)" ${@:+--target "$@"})
}
