// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/core/dynamic_array.hpp>

#include <doctest/doctest.h>

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

using namespace bristle;
using namespace bristle::detail;

namespace {

// An element that owns memory, so that a missing or doubled destructor shows under a sanitizer and
// in the count of owners.
struct Owner {
  Owner() = default;
  explicit Owner(std::shared_ptr<int> p, int n = 0) : shared(std::move(p)), number(n) {}
  std::shared_ptr<int> shared{};
  int number = 7;

  friend bool operator==(const Owner&, const Owner&) = default;
};

std::ptrdiff_t offset(std::size_t place) { return static_cast<std::ptrdiff_t>(place); }

}  // namespace

TEST_CASE("DynamicArray: does what std::vector does, in ten thousand random calls") {
  DynamicArray<std::string> array;
  std::vector<std::string> expected;
  std::uint32_t state = 1;
  const auto draw = [&state](std::size_t below) {
    state = state * 1664525u + 1013904223u;
    return static_cast<std::size_t>(state >> 8) % below;
  };
  std::size_t disagreements = 0;
  for (int i = 0; i < 10'000; ++i) {
    const std::string value(draw(40), static_cast<char>('a' + draw(26)));
    const std::size_t place = draw(expected.size() + 1);
    const std::size_t last = place + draw(expected.size() - place + 1);
    const auto at = expected.begin() + offset(place);
    const auto to = expected.begin() + offset(last);
    switch (draw(13)) {
      case 0:
      case 1:
        array.push_back(value), expected.push_back(value);
        break;
      case 2:
        array.emplace_back(3u, 'x'), expected.emplace_back(3u, 'x');
        break;
      case 3:
        array.resize(place), expected.resize(place);
        break;
      case 4:
        array.resize(place + 5, value), expected.resize(place + 5, value);
        break;
      case 5:
        array.assign(place, value), expected.assign(place, value);
        break;
      case 6:
        array.insert(array.begin() + offset(place), value), expected.insert(at, value);
        break;
      case 7:
        array.erase(array.begin() + offset(place), array.begin() + offset(last)),
            expected.erase(at, to);
        break;
      case 8: {
        const auto is_short = [](const std::string& text) { return text.size() < 4; };
        disagreements += erase_if(array, is_short) != std::erase_if(expected, is_short) ? 1u : 0u;
        break;
      }
      case 9: {
        const std::vector<std::string> others(place % 7, value);
        array.append(others.begin(), others.end());
        expected.insert(expected.end(), others.begin(), others.end());
        break;
      }
      case 10:
        array = DynamicArray<std::string>(array);
        break;
      case 11: {
        DynamicArray<std::string> other{value, "y"};
        other.swap(array);
        array = std::move(other);
        break;
      }
      default:
        if (expected.empty()) break;
        array.pop_back();
        expected.pop_back();
    }
    if (expected.size() > 60) array.clear(), expected.clear();
    const bool is_same = std::equal(array.begin(), array.end(), expected.begin(), expected.end());
    disagreements += is_same && array.empty() == expected.empty() ? 0u : 1u;
    disagreements += array.capacity() < array.size() ? 1u : 0u;
  }
  CHECK(disagreements == 0);
}

TEST_CASE("DynamicArray: each element that is made is ended once") {
  const auto counted = std::make_shared<int>(1);
  {
    DynamicArray<Owner> array;
    for (int i = 0; i < 50; ++i) array.emplace_back(counted, i);
    CHECK(counted.use_count() == 51);
    DynamicArray<Owner> copy = array;
    CHECK(copy == array);
    CHECK(counted.use_count() == 101);
    copy.erase(copy.begin() + 10, copy.begin() + 20);
    copy.resize(5);
    CHECK(counted.use_count() == 56);
    array = std::move(copy);
    CHECK(counted.use_count() == 6);
    CHECK(copy.empty());  // NOLINT(bugprone-use-after-move): it is empty, as a std::vector is.
    array.resize(8);
    CHECK(array.back().number == 7);
    CHECK(counted.use_count() == 6);
  }
  CHECK(counted.use_count() == 1);
}

TEST_CASE("DynamicArray: an element of it may be added to it as it grows") {
  DynamicArray<std::string> array{"a text too long for the object itself, so that it has memory"};
  for (int i = 0; i < 20; ++i) array.push_back(array.front());
  CHECK(array.size() == 21);
  CHECK(array.back() == array.front());
}

TEST_CASE("DynamicArray: doubles as it grows, and keeps its memory where it does not") {
  DynamicArray<double> array(100, 1.0);
  const double* const memory = array.data();
  array.clear();
  array.assign(70, 2.0);
  array.resize(100);
  CHECK(array.data() == memory);
  CHECK(array[69] == 2.0);
  CHECK(array[70] == 0.0);
  array.resize(101);
  CHECK(array.capacity() == 200);
  array.assign(201, 3.0);
  CHECK(array.capacity() == 400);
  array.reserve(401);
  CHECK(array.capacity() == 401);
}

TEST_CASE("DynamicArray: copies keep the memory of the elements they are assigned to") {
  DynamicArray<DynamicArray<int>> array(3, DynamicArray<int>(100, 1));
  const int* const memory = array[2].data();
  array = DynamicArray<DynamicArray<int>>(array);  // Moved: the memory is that of the copy.
  CHECK(array[2].data() != memory);
  const int* const kept = array[2].data();
  const DynamicArray<DynamicArray<int>> other(3, DynamicArray<int>(50, 2));
  array = other;
  CHECK(array[2].data() == kept);
  CHECK(array == other);
}

// The address sanitizer stops a program that asks for as much, rather than refusing it.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__clang__)
TEST_CASE("DynamicArray: more elements than can be counted in bytes are too many") {
  DynamicArray<double> array{1.0};
  CHECK_THROWS_AS(array.reserve(SIZE_MAX / 8 + 2), std::bad_alloc);
  CHECK(array.size() == 1);
  CHECK(array[0] == 1.0);
}
#endif

TEST_CASE_TEMPLATE("LineArray: begins at a cache line, however long, and as it grows", T, float,
                   double, std::uint32_t) {
  for (std::size_t n = 1; n < 5000; n = 2 * n + 1) {
    LineArray<T> row(n, T(3));
    row.push_back(T(4));
    CHECK(reinterpret_cast<std::uintptr_t>(row.data()) % 64 == 0);
    CHECK(row.front() == T(3));
    CHECK(row.back() == T(4));
  }
}
