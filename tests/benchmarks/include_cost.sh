#!/usr/bin/env bash
# What including a header costs: lines after the preprocessor, and processor seconds to check the
# syntax of a file that holds nothing else (best of 3), for each compiler that is there.
# Usage: tests/benchmarks/include_cost.sh [compiler...]
# SPDX-License-Identifier: BSD-3-Clause
set -euo pipefail

root="$(cd "$(dirname "$0")/../.." && pwd)"
file="$(mktemp --suffix=.cpp)"
trap 'rm -f "$file"' EXIT
flags=(-std=c++20 -isystem "${EIGEN:-/usr/include/eigen3}" -I "$root/include")
TIMEFORMAT=%U

[ $# -gt 0 ] || set -- g++ clang++
for compiler in "$@"; do
  command -v "$compiler" >/dev/null || continue
  "$compiler" --version | head -1
  printf '  %-34s  %8s  %8s\n' header lines seconds
  for header in Eigen/Geometry bristle/bristle.hpp bristle/geometry/fcl_rays.hpp \
    bristle/geometry/fcl_backend.hpp; do
    echo "#include <$header>" >"$file"
    if ! "$compiler" "${flags[@]}" -fsyntax-only "$file" 2>/dev/null; then
      printf '  %-34s  %8s  %8s\n' "$header" - -  # FCL is not there, say
      continue
    fi
    lines="$("$compiler" "${flags[@]}" -E -P "$file" | wc -l)"
    best="$(for _ in 1 2 3; do
      { time "$compiler" "${flags[@]}" -fsyntax-only "$file"; } 2>&1
    done | sort -n | head -1)"
    printf '  %-34s  %8d  %8s\n' "$header" "$lines" "$best"
  done
done
