/// @file
/// What the command line asks for.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "cluster/ranks.hpp"

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

namespace cluster {

inline constexpr const char* usage =
    R"(Usage: mpirun -n RANKS cluster [OPTION...]

  --worlds N             worlds of all ranks together (64)
  --rounds N             rounds of 50 steps of 1 ms, each with other motions of the hand (100)
  --sensors N            sensors in a row of a pad, which has N rows (6)
  --checkpoint FOLDER    writes the states of all worlds to FOLDER/states, which is replaced
  --every N              rounds from one checkpoint to the next (10)
  --resume FOLDER        goes on from the states in FOLDER, with any number of ranks, and writes
                         the next ones there
  --die RANK ROUND       kills a rank before a round, both counted from 0, to see what happens
  --help                 this text

Exit status: 0, 2 for a wrong option or file, or 3 when a world cannot be stepped. When a rank dies,
mpirun ends the others and has another status.
)";

/// A rank that is to die, and when.
struct Death {
  std::uint64_t rank = 0;
  std::uint64_t round = 0;
};

struct Options {
  std::size_t worlds = 64;
  std::uint64_t rounds = 100;
  std::size_t sensors_per_row = 6;
  /// Folder of the checkpoint. It is empty where none is kept.
  std::string folder;
  std::uint64_t rounds_per_checkpoint = 10;
  bool resumes = false;
  bool wants_help = false;
  std::optional<Death> death;
};

/// Reads the words of the command line one after the other.
class OptionReader {
 public:
  OptionReader(int count, char** words) : count_(count), words_(words) {}

  [[nodiscard]] bool is_at_end() const { return next_ == count_; }
  std::string option() { return option_ = words_[next_++]; }
  std::string text() {
    if (is_at_end()) throw Refused(option_ + " needs a value");
    return words_[next_++];
  }
  std::uint64_t number(std::uint64_t low, std::uint64_t high) {
    const std::string word = text();
    std::uint64_t value = 0;
    const auto [end, code] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (code != std::errc() || end != word.data() + word.size() || value < low || value > high) {
      throw Refused(option_ + " " + word + ": must be a whole number from " + std::to_string(low) +
                    " to " + std::to_string(high));
    }
    return value;
  }

 private:
  int count_;
  char** words_;
  int next_ = 1;
  std::string option_;
};

/// All ranks read the same words, and so throw alike.
/// @throws Refused that names the option.
[[nodiscard]] inline Options read_options(int count, char** words, int ranks) {
  constexpr std::uint64_t most = 1'000'000;
  Options options;
  OptionReader reader(count, words);
  while (!reader.is_at_end()) {
    const std::string option = reader.option();
    if (option == "--worlds") {
      options.worlds = reader.number(1, most);
    } else if (option == "--rounds") {
      options.rounds = reader.number(1, most);
    } else if (option == "--sensors") {
      options.sensors_per_row = reader.number(2, 32);
    } else if (option == "--checkpoint" || option == "--resume") {
      if (!options.folder.empty()) {
        throw Refused("one of --checkpoint and --resume is enough: both write to their folder");
      }
      options.folder = reader.text();
      options.resumes = option == "--resume";
      if (options.folder.empty()) throw Refused(option + " needs a folder");
    } else if (option == "--every") {
      options.rounds_per_checkpoint = reader.number(1, most);
    } else if (option == "--die") {
      const std::uint64_t rank = reader.number(0, static_cast<std::uint64_t>(ranks) - 1);
      options.death = Death{rank, reader.number(0, most)};
    } else if (option == "--help" || option == "-h") {
      options.wants_help = true;
    } else {
      throw Refused("unknown option '" + option + "'; try --help");
    }
  }
  if (static_cast<std::uint64_t>(ranks) > options.worlds) {
    throw Refused(std::to_string(ranks) + " ranks for --worlds " + std::to_string(options.worlds) +
                  ": each rank needs a world");
  }
  if (options.death && options.death->round >= options.rounds) {
    throw Refused("--die: no round " + std::to_string(options.death->round) + " of " +
                  std::to_string(options.rounds) + ", which are counted from 0");
  }
  // A gathered message has 8 numbers for each row and column of sensors, and MPI counts by int.
  constexpr std::uint64_t most_numbers = 0x7fffffff;
  if (options.worlds * options.sensors_per_row * options.sensors_per_row * 8 > most_numbers) {
    throw Refused("--worlds and --sensors: the first rank cannot receive that many readings");
  }
  return options;
}

}  // namespace cluster
