// Ranks of MPI share a batch of worlds; any number of them gives the same bits.
//
// Two fingers hold a part and are shaken, in worlds that differ by mass, friction and motion. All
// that differs is drawn by the number of the world. Each rank steps a slab of the worlds, and the
// first one gathers what a learner would see. A grip holds while the load m g / (mu sum F_N) is
// below 1, and shaking takes its share.
//
// The states are written to a file now and then. When a rank dies, mpirun ends the others, and
// --resume goes on from that file with as many ranks as there are. examples/cluster/launch does so
// by itself.
//
// Usage: mpirun -n RANKS cluster [OPTION...]; --help lists the options.
// SPDX-License-Identifier: BSD-3-Clause
#include "cluster/checkpoint.hpp"
#include "cluster/grip.hpp"
#include "cluster/options.hpp"
#include "cluster/ranks.hpp"

#include <bristle/bristle.hpp>

#include <algorithm>
#include <array>
#include <cinttypes>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <exception>
#include <mpi.h>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

using namespace cluster;

namespace {

/// [s] Times of a rank.
struct Times {
  double total = 0;
  /// Of the processor: other programs on the machine do not matter to how slabs differ.
  double stepping = 0;
  double gathering = 0;
  double writing = 0;
};

double processor_time() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// Adds to a time what passes until its end, by a clock.
class Stopwatch {
 public:
  explicit Stopwatch(double& total, double (*clock)() = MPI_Wtime)
      : total_(total), clock_(clock), start_(clock()) {}
  ~Stopwatch() { total_ += clock_() - start_; }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  double& total_;
  double (*clock_)();
  double start_;
};

/// What a learner sees. All of it is on the first rank, and nothing on the others.
struct Observations {
  /// [world][13] As `gather_bodies` has it.
  std::vector<float> parts;
  /// [world][pad][channel][sensor] As `gather_taxels` has it.
  std::vector<float> taxels;
};

/// The worlds of one rank.
class SlabOfGrips {
 public:
  SlabOfGrips(const Ranks& ranks, const Options& options)
      : ranks_(ranks),
        worlds_(options.worlds),
        slab_(ranks.slab(options.worlds, ranks.own())),
        origin_(options.sensors_per_row),
        batch_(origin_.world, slab_.size) {
    batch_.for_each([&](std::size_t i, World<float>& world) { origin_.vary(world, number(i)); });
  }

  [[nodiscard]] Batch& batch() { return batch_; }
  [[nodiscard]] std::uint64_t scene() const { return origin_.world.state_hash(); }

  /// @throws std::runtime_error when a world could not be stepped.
  void step(std::uint64_t round) {
    batch_.for_each(
        [&](std::size_t i, World<float>& world) { origin_.shake(world, number(i), round); });
    batch_.step(Grip::steps_per_round);
    const auto failed = batch_.failed();
    const auto worst = std::find_if(failed.begin(), failed.end(), [](auto f) { return f != 0; });
    if (worst == failed.end()) return;
    throw std::runtime_error(
        "a step failed in world " +
        std::to_string(number(static_cast<std::size_t>(worst - failed.begin()))));
  }

  void gather(Observations& to) const {
    const std::array<bristle::BodyId, 1> parts{origin_.part};
    const std::size_t taxels =
        origin_.pads.size() * bristle::tactile_channel_count * origin_.sensors.size();
    std::vector<float> own(slab_.size * 13);
    batch_.gather_bodies(parts, own);
    ranks_.gather<float>(own, worlds_, 13, to.parts);
    own.resize(slab_.size * taxels);
    batch_.gather_taxels(origin_.pads, own);
    ranks_.gather<float>(own, worlds_, taxels, to.taxels);
  }

  /// [-] Hashes of the states of all worlds on the first rank.
  [[nodiscard]] std::vector<std::uint64_t> gather_hashes() const {
    std::vector<std::uint64_t> own;
    std::vector<std::uint64_t> all;
    for (std::size_t i = 0; i < slab_.size; ++i) own.push_back(batch_.world(i).state_hash());
    ranks_.gather<std::uint64_t>(own, worlds_, 1, all);
    return all;
  }

 private:
  [[nodiscard]] std::uint64_t number(std::size_t i) const { return slab_.first + i; }

  const Ranks& ranks_;
  std::size_t worlds_;
  Slab slab_;
  Grip origin_;
  Batch batch_;
};

/// [N] Sum over both pads of a world.
float normal_force(std::span<const float> taxels) {
  const std::size_t sensors = taxels.size() / (2 * bristle::tactile_channel_count);
  float sum = 0;
  for (std::size_t pad = 0; pad < 2; ++pad) {
    const std::size_t channel = pad * bristle::tactile_channel_count +
                                static_cast<std::size_t>(bristle::TactileChannel::normal_force);
    for (const float force : taxels.subspan(channel * sensors, sensors)) sum += force;
  }
  return sum;
}

void print_table(std::size_t worlds, const Observations& seen,
                 const std::vector<std::uint64_t>& hashes) {
  struct Row {
    const char* loads;
    float below;
    std::size_t worlds = 0;
    std::size_t held = 0;
    float force = 0;
  };
  std::array<Row, 4> rows{
      {{"0 to 0.5", 0.5f}, {"0.5 to 0.8", 0.8f}, {"0.8 to 1", 1.0f}, {"above 1", 1e9f}}};
  const std::size_t taxels = seen.taxels.size() / worlds;
  for (std::size_t number = 0; number < worlds; ++number) {
    const float load = Grip::load(number);
    Row& row =
        *std::find_if(rows.begin(), rows.end(), [&](const Row& r) { return load < r.below; });
    ++row.worlds;
    const float height = seen.parts[13 * number + 2];
    if (height > -0.01f) ++row.held;
    row.force += normal_force(std::span(seen.taxels).subspan(number * taxels, taxels));
  }
  std::puts("load m g / (mu sum F_N)  worlds  held  mean force of both pads [N]");
  for (const Row& row : rows) {
    const float count = static_cast<float>(std::max<std::size_t>(row.worlds, 1));
    std::printf("%-23s  %6zu  %4zu  %27.3f\n", row.loads, row.worlds, row.held,
                static_cast<double>(row.force / count));
  }
  std::uint64_t hash = 0;
  for (const std::uint64_t of_world : hashes) hash = mixed(hash, of_world);
  std::printf("states %016" PRIx64 "\n", hash);
}

/// Prints the longest times of all ranks to stderr, since they differ from run to run.
void print_times(const Ranks& ranks, const Times& own) {
  std::array<double, 5> longest{own.total, own.stepping, -own.stepping, own.gathering, own.writing};
  MPI_Allreduce(MPI_IN_PLACE, longest.data(), static_cast<int>(longest.size()), MPI_DOUBLE, MPI_MAX,
                MPI_COMM_WORLD);
  if (!ranks.is_first()) return;
  std::fprintf(stderr,
               "%d ranks: %.3f s; processor time of steps: %.3f s on the busiest rank, %.3f s on "
               "the idlest; "
               "gathering and waiting %.3f s, checkpoints %.3f s\n",
               ranks.count(), longest[0], longest[1], -longest[2], longest[3], longest[4]);
}

void run(const Ranks& ranks, const Options& options) {
  SlabOfGrips slab(ranks, options);
  std::optional<Checkpoint> checkpoint;
  std::uint64_t round = 0;
  Times times;
  const double start = MPI_Wtime();
  const auto write = [&] {
    const Stopwatch watch(times.writing);
    checkpoint->write(slab.batch(), round);
  };
  if (!options.folder.empty()) {
    checkpoint.emplace(ranks, options.folder, slab.scene(), options.worlds);
    if (options.resumes) {
      round = checkpoint->read(slab.batch());
      ranks.agree(round <= options.rounds
                      ? ""
                      : "--rounds " + std::to_string(options.rounds) + ": the states in " +
                            options.folder + " have " + std::to_string(round) + " behind them");
    } else {
      // From now on there is a state of this run to go back to, and none of another one.
      write();
    }
  }

  Observations seen;
  while (round < options.rounds) {
    if (options.death && options.death->round == round &&
        options.death->rank == static_cast<std::uint64_t>(ranks.own())) {
      std::raise(SIGKILL);
    }
    {
      const Stopwatch watch(times.stepping, processor_time);
      slab.step(round);
    }
    {
      const Stopwatch watch(times.gathering);
      slab.gather(seen);
    }
    ++round;
    if (checkpoint && (round % options.rounds_per_checkpoint == 0 || round == options.rounds)) {
      write();
    }
  }
  times.total = MPI_Wtime() - start;
  // A run that is resumed at its end has gathered nothing yet.
  slab.gather(seen);
  const std::vector<std::uint64_t> hashes = slab.gather_hashes();
  if (ranks.is_first()) print_table(options.worlds, seen, hashes);
  print_times(ranks, times);
}

}  // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  const Ranks ranks;
  int status = 0;
  try {
    const Options options = read_options(argc, argv, ranks.count());
    if (!options.wants_help) {
      run(ranks, options);
    } else if (ranks.is_first()) {
      std::fputs(usage, stdout);
    }
  } catch (const Refused& error) {
    if (ranks.is_first()) std::fprintf(stderr, "cluster: %s\n", error.what());
    status = 2;
  } catch (const std::exception& error) {
    // The other ranks know nothing of it, and would wait.
    std::fprintf(stderr, "cluster: rank %d: %s\n", ranks.own(), error.what());
    MPI_Abort(MPI_COMM_WORLD, 3);
  }
  MPI_Finalize();
  return status;
}
