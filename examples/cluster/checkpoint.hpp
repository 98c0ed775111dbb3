/// @file
/// The states of all worlds in one file, FOLDER/states, which any number of ranks writes and reads.
///
/// The file is a head, the size of the snapshot of each world, and the snapshots, in order of world
/// number. So its bytes do not depend on the number of ranks.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cluster/draw.hpp"
#include "cluster/ranks.hpp"

#include <bristle/bristle.hpp>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <vector>

namespace cluster {

using Batch = bristle::WorldBatch<float>;

/// What comes first in the file.
struct CheckpointHead {
  static constexpr std::uint64_t expected_magic = 0x73657461'74730002u;  // "states", and a number.

  std::uint64_t magic = expected_magic;
  /// [-] Hash of the scene that all worlds start as.
  std::uint64_t scene = 0;
  std::uint64_t worlds = 0;
  /// [-] Rounds that the worlds have behind them.
  std::uint64_t rounds = 0;
  /// [-] `hash_of` this head and the sizes. Snapshots have hashes of their own.
  std::uint64_t hash = 0;
};

/// [-] Hash of a head, but for its own hash, and of the sizes of all snapshots.
inline std::uint64_t hash_of(const CheckpointHead& head, std::span<const std::uint64_t> sizes) {
  std::uint64_t hash = mixed(mixed(head.magic, head.scene), mixed(head.worlds, head.rounds));
  for (const std::uint64_t size : sizes) hash = mixed(hash, size);
  return hash;
}

/// Reads and writes the checkpoint of a folder.
class Checkpoint {
 public:
  Checkpoint(const Ranks& ranks, const std::string& folder, std::uint64_t scene, std::size_t worlds)
      : ranks_(ranks),
        path_((std::filesystem::path(folder) / "states").string()),
        scene_(scene),
        worlds_(worlds),
        slab_(ranks.slab(worlds, ranks.own())) {
    std::error_code ignored;
    ranks.agree(
        std::filesystem::is_directory(folder, ignored) ? "" : folder + ": there is no such folder");
  }

  /// Replaces the file. Ranks write under another name, and the first one renames what is complete.
  /// So a rank that dies meanwhile leaves the last file as it was.
  /// @throws Refused on all ranks when the file cannot be written.
  void write(const Batch& batch, std::uint64_t rounds) const {
    std::vector<std::uint64_t> sizes;
    std::vector<std::byte> states;
    for (std::size_t i = 0; i < batch.size(); ++i) {
      const std::vector<std::byte> state = batch.world(i).snapshot();
      states.insert(states.end(), state.begin(), state.end());
      sizes.push_back(state.size());
    }
    std::uint64_t before = 0;
    const std::uint64_t own = states.size();
    MPI_Exscan(&own, &before, 1, MPI_UINT64_T, MPI_SUM, MPI_COMM_WORLD);

    std::vector<std::uint64_t> all_sizes;
    ranks_.gather<std::uint64_t>(sizes, worlds_, 1, all_sizes);

    const std::string part = path_ + ".part";
    // What a rank that died has left must not follow the new states.
    if (ranks_.is_first()) std::remove(part.c_str());
    MPI_Barrier(MPI_COMM_WORLD);
    MPI_File file = MPI_FILE_NULL;
    int code = MPI_File_open(MPI_COMM_WORLD, part.c_str(), MPI_MODE_CREATE | MPI_MODE_WRONLY,
                             MPI_INFO_NULL, &file);
    ranks_.agree(error_of(part, code));
    const auto put = [&](std::uint64_t at, const void* bytes, std::size_t count) {
      // A count of MPI is an int.
      constexpr std::size_t most = std::size_t{1} << 30;
      const auto* from = static_cast<const std::byte*>(bytes);
      for (std::size_t done = 0; done < count && code == MPI_SUCCESS; done += most) {
        code = MPI_File_write_at(file, static_cast<MPI_Offset>(at + done), from + done,
                                 static_cast<int>(std::min(most, count - done)), MPI_BYTE,
                                 MPI_STATUS_IGNORE);
      }
    };
    if (ranks_.is_first()) {
      CheckpointHead head{.scene = scene_, .worlds = worlds_, .rounds = rounds};
      head.hash = hash_of(head, all_sizes);
      put(0, &head, sizeof head);
      put(sizes_start, all_sizes.data(), worlds_ * sizeof(std::uint64_t));
    }
    put(states_start() + before, states.data(), states.size());
    const int synced = MPI_File_sync(file);
    const int closed = MPI_File_close(&file);
    if (code == MPI_SUCCESS) code = synced != MPI_SUCCESS ? synced : closed;
    ranks_.agree(error_of(part, code));

    std::string error;
    if (ranks_.is_first() && std::rename(part.c_str(), path_.c_str()) != 0) {
      error = path_ + ": " + std::strerror(errno);
    }
    ranks_.agree(error);
  }

  /// Puts the worlds of this rank into their states.
  /// @return The rounds that they have behind them.
  /// @throws Refused on all ranks when the file is not one of this scene and number of worlds.
  [[nodiscard]] std::uint64_t read(Batch& batch) const {
    CheckpointHead head;
    std::string error;
    try {
      head = read_slab(batch);
    } catch (const std::exception& refused) {
      error = path_ + ": " + refused.what();
    }
    ranks_.agree(error);
    return head.rounds;
  }

 private:
  static constexpr std::uint64_t sizes_start = sizeof(CheckpointHead);

  [[nodiscard]] std::uint64_t states_start() const {
    return sizes_start + worlds_ * sizeof(std::uint64_t);
  }

  [[nodiscard]] static std::string error_of(const std::string& path, int code) {
    if (code == MPI_SUCCESS) return "";
    char text[MPI_MAX_ERROR_STRING];
    int length = 0;
    MPI_Error_string(code, text, &length);
    return path + ": " + text;
  }

  /// @throws std::exception that says what is wrong with the file.
  [[nodiscard]] CheckpointHead read_slab(Batch& batch) const {
    std::ifstream file(path_, std::ios::binary);
    if (!file) throw std::runtime_error("cannot be opened");
    const auto get = [&](void* to, std::size_t count) {
      file.read(static_cast<char*>(to), static_cast<std::streamsize>(count));
      if (!file) throw std::runtime_error("is cut short");
    };
    CheckpointHead head;
    get(&head, sizeof head);
    if (head.magic != CheckpointHead::expected_magic) throw std::runtime_error("is no checkpoint");
    if (head.worlds != worlds_) {
      throw std::runtime_error("has " + std::to_string(head.worlds) + " worlds, not " +
                               std::to_string(worlds_));
    }
    if (head.scene != scene_) throw std::runtime_error("is of another scene");

    std::vector<std::uint64_t> sizes(worlds_);
    get(sizes.data(), worlds_ * sizeof(std::uint64_t));
    if (head.hash != hash_of(head, sizes)) throw std::runtime_error("is damaged");
    const std::uint64_t file_size = std::filesystem::file_size(path_);
    std::uint64_t end = states_start();
    std::uint64_t own_start = end;
    for (std::size_t number = 0; number < worlds_; ++number) {
      if (number == slab_.first) own_start = end;
      if (sizes[number] > file_size - end) throw std::runtime_error("is cut short");
      end += sizes[number];
    }
    if (end != file_size) throw std::runtime_error("is longer than its states");

    file.seekg(static_cast<std::streamoff>(own_start));
    std::vector<std::byte> state;
    for (std::size_t i = 0; i < batch.size(); ++i) {
      state.resize(sizes[slab_.first + i]);
      get(state.data(), state.size());
      try {
        batch.world(i).restore(state);
      } catch (const bristle::InvalidArgument& error) {
        throw std::runtime_error("world " + std::to_string(slab_.first + i) + ": " + error.what());
      }
    }
    return head;
  }

  const Ranks& ranks_;
  std::string path_;
  std::uint64_t scene_;
  std::size_t worlds_;
  Slab slab_;
};

}  // namespace cluster
