/// @file
/// The ranks of the program, which slab of the worlds each of them owns, and how they end together.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <mpi.h>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace cluster {

/// Bad input, or a file that fails. All ranks throw it together, so none waits for another.
class Refused : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Worlds of one rank: those from number `first` on.
struct Slab {
  std::size_t first = 0;
  std::size_t size = 0;
};

/// The ranks that mpirun has started, or one where there is no mpirun.
class Ranks {
 public:
  Ranks() {
    MPI_Comm_rank(MPI_COMM_WORLD, &own_);
    MPI_Comm_size(MPI_COMM_WORLD, &count_);
  }

  [[nodiscard]] int own() const { return own_; }
  [[nodiscard]] int count() const { return count_; }
  [[nodiscard]] bool is_first() const { return own_ == 0; }

  /// Sizes of slabs differ by one at most.
  [[nodiscard]] Slab slab(std::size_t worlds, int rank) const {
    const auto start = [&](int of) {
      return worlds * static_cast<std::size_t>(of) / static_cast<std::size_t>(count_);
    };
    return {start(rank), start(rank + 1) - start(rank)};
  }

  /// Ends all ranks if any of them has an error.
  /// @throws Refused with the error of the lowest rank that has one.
  void agree(const std::string& error) const {
    int speaker = error.empty() ? count_ : own_;
    MPI_Allreduce(MPI_IN_PLACE, &speaker, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
    if (speaker == count_) return;
    std::string text = error;
    std::uint64_t length = text.size();
    MPI_Bcast(&length, 1, MPI_UINT64_T, speaker, MPI_COMM_WORLD);
    text.resize(length);
    MPI_Bcast(text.data(), static_cast<int>(length), MPI_CHAR, speaker, MPI_COMM_WORLD);
    throw Refused(text);
  }

  /// Brings values of all worlds to the first rank, in order of world number.
  /// @param own  Values of this rank's worlds, `width` for each.
  /// @param all  Those of all worlds on the first rank. Others leave it alone.
  template <typename T>
  void gather(std::span<const T> own, std::size_t worlds, std::size_t width,
              std::vector<T>& all) const {
    static_assert(std::is_same_v<T, float> || std::is_same_v<T, std::uint64_t>);
    const MPI_Datatype type = std::is_same_v<T, float> ? MPI_FLOAT : MPI_UINT64_T;
    std::vector<int> sizes;
    std::vector<int> starts;
    for (int rank = 0; rank < count_; ++rank) {
      const Slab of_rank = slab(worlds, rank);
      sizes.push_back(static_cast<int>(of_rank.size * width));
      starts.push_back(static_cast<int>(of_rank.first * width));
    }
    if (is_first()) all.resize(worlds * width);
    MPI_Gatherv(own.data(), static_cast<int>(own.size()), type, all.data(), sizes.data(),
                starts.data(), type, 0, MPI_COMM_WORLD);
  }

 private:
  int own_ = 0;
  int count_ = 1;
};

}  // namespace cluster
