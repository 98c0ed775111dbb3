// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/core/bit_hash.hpp>

#include <doctest/doctest.h>

#include <set>
#include <vector>

using bristle::detail::BitHash;

namespace {

std::uint64_t of(std::initializer_list<double> values) {
  bristle::detail::BitHash hash;
  for (const double v : values) hash.add(v);
  return hash.value();
}

}  // namespace

TEST_CASE(
    "bristle::detail::BitHash: the same values in the same order give the same number, others do "
    "not") {
  CHECK(of({1, 2, 3}) == of({1, 2, 3}));
  CHECK(of({1, 2, 3}) != of({1, 3, 2}));
  CHECK(of({1, 2}) != of({1, 2, 0}));
  CHECK(of({0.0}) != of({-0.0}));
  CHECK(of({}) != of({0}));
  CHECK(of({0}) != of({0, 0}));
}

TEST_CASE("bristle::detail::BitHash: every single bit of a sequence counts") {
  // 16 words: 1024 sequences that differ from zeros, and from each other, in one or two bits.
  std::set<std::uint64_t> seen;
  for (int bit = -1; bit < 1024; ++bit) {
    bristle::detail::BitHash hash;
    for (int word = 0; word < 16; ++word) {
      hash.add(bit / 64 == word && bit >= 0 ? std::uint64_t{1} << (bit % 64) : std::uint64_t{0});
    }
    seen.insert(hash.value());
  }
  CHECK(seen.size() == 1025);
}

TEST_CASE("hash_of: blocks of any length, by every byte") {
  std::set<std::uint64_t> seen;
  for (std::size_t size = 0; size < 20; ++size) {
    std::vector<std::byte> bytes(size);
    seen.insert(bristle::detail::hash_of(bytes));
    for (std::size_t i = 0; i < size; ++i) {
      bytes[i] = std::byte{1};
      seen.insert(bristle::detail::hash_of(bytes));
      bytes[i] = std::byte{0};
    }
  }
  CHECK(seen.size() == 20 + 190);
}
