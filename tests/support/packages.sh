# shellcheck shell=sh
# Installing Debian packages for tests/run, examples/run and .ci/run, which source this file.
# SPDX-License-Identifier: BSD-3-Clause

# ensure_packages NAME...  installs those that are missing; quick and silent when none is.
ensure_packages() {
  if ! command -v dpkg-query >/dev/null 2>&1; then
    echo "Not a Debian system: taking these for installed: $*"
    return 0
  fi
  missing=""
  for package in "$@"; do
    case "$(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null)" in
      installed) ;;
      *) missing="$missing $package" ;;
    esac
  done
  [ -n "$missing" ] || return 0

  if [ "$(id -u)" -eq 0 ]; then
    as_root="env"
  elif command -v sudo >/dev/null 2>&1; then
    as_root="sudo"
  else
    echo "These packages are missing:$missing" >&2
    echo "Neither root nor sudo is at hand to install them. As root, run:" >&2
    echo "  apt-get install$missing" >&2
    exit 1
  fi
  echo "Installing:$missing"
  # shellcheck disable=SC2086  # a list of words on purpose
  if ! { $as_root apt-get update -qq &&
    $as_root DEBIAN_FRONTEND=noninteractive \
      apt-get install -qq -y --no-install-recommends $missing; }; then
    echo "apt-get could not install:$missing" >&2
    exit 1
  fi
}

# build_tools  prints the packages of a compiler, CMake and a build tool that are not there yet.
build_tools() {
  command -v c++ >/dev/null 2>&1 || echo g++
  command -v cmake >/dev/null 2>&1 || echo cmake
  command -v ninja >/dev/null 2>&1 || command -v make >/dev/null 2>&1 || echo ninja-build
}

# prepare NAME...  installs the build tools and these packages, and settles how builds go: by Ninja
# where it is installed, though a build folder that exists keeps what it was made with.
prepare() {
  # shellcheck disable=SC2046  # a list of words on purpose
  ensure_packages $(build_tools) "$@"
  if command -v ninja >/dev/null 2>&1; then
    export CMAKE_GENERATOR="${CMAKE_GENERATOR:-Ninja}"
  fi
  jobs="$(nproc 2>/dev/null || echo 2)"
}
