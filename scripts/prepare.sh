# shellcheck shell=bash
# Sourced by the scripts: installs the missing packages of the lists in scripts/ (packages.txt where none is named)
# and builds Release into build/.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
export root=$PWD

# missing_packages LIST...: of the lists in scripts/.
missing_packages() {
  local package
  (cd scripts && sed 's/#.*//' "$@") | while read -r package; do
    [ -z "$package" ] && continue
    [ "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" = installed ] || echo "$package"
  done
}

# install_packages [LIST...]: packages.txt, or those lists.
install_packages() {
  local missing sudo=
  missing=$(missing_packages "${@:-packages.txt}")
  [ -z "$missing" ] && return
  # shellcheck disable=SC2086
  echo "installing:" $missing
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || {
      echo "error: packages are missing and neither root nor sudo is at hand; install the ones listed above" >&2
      exit 1
    }
    sudo=sudo
  fi
  $sudo apt-get update -q
  # shellcheck disable=SC2086
  $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends $missing
}

# build ON|OFF [TARGET]: with or without the tests; TARGET alone, or all.
build() {
  export CCACHE_DEPEND=1  # what the cache lacks is not preprocessed twice
  cmake -S . -B build -G Ninja -DCMAKE_BUILD_TYPE=Release -DMAQUETTE_TESTS="$1"
  ninja -C build -j "$(nproc)" ${2:+"$2"}
}

# sanitizer_build: configures build-sanitize/ for clang and its sanitizers, each file alone, warnings as errors.
sanitizer_build() {
  export CCACHE_DEPEND=1
  cmake -S . -B build-sanitize -G Ninja -DCMAKE_BUILD_TYPE=Sanitize -DCMAKE_CXX_COMPILER=clang++ -DCMAKE_UNITY_BUILD=OFF \
    -DCMAKE_COMPILE_WARNING_AS_ERROR=ON -DMAQUETTE_TESTS=ON >/dev/null
}
