// SPDX-License-Identifier: BSD-3-Clause
#include <bristle/core/thread_pool.hpp>

#include <doctest/doctest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <thread>
#include <vector>

using bristle::ThreadPool;

namespace {

/// Counts how often each task of a loop ran.
std::vector<int> turns(ThreadPool& pool, std::size_t count) {
  std::vector<std::atomic<int>> ran(count);
  pool.run(count, [&](std::size_t i) { ran[i].fetch_add(1); });
  return {ran.begin(), ran.end()};
}

}  // namespace

TEST_CASE("ThreadPool: every task runs once, for any number of tasks and workers") {
  for (const unsigned workers : {0u, 1u, 2u, 3u, 8u}) {
    ThreadPool pool(workers);
    CHECK(pool.workers() == (workers < 2 ? 1u : workers));
    for (const std::size_t count : {0u, 1u, 2u, 3u, 7u, 64u, 1000u}) {
      CHECK(turns(pool, count) == std::vector<int>(count, 1));
    }
  }
}

TEST_CASE("ThreadPool: all is done when a loop returns, many times over") {
  ThreadPool pool(4);
  std::vector<std::size_t> written(50);
  for (std::size_t round = 1; round <= 2000; ++round) {
    pool.run(written.size(), [&](std::size_t i) { written[i] = round; });
    bool all = true;
    for (const std::size_t value : written) all = all && value == round;
    REQUIRE(all);
  }
}

TEST_CASE("ThreadPool: tasks run at the same time") {
  ThreadPool pool(2);
  // Each of the two tasks waits for the other: alone, neither would end.
  std::atomic<int> arrived{0};
  pool.run(2, [&](std::size_t) {
    arrived.fetch_add(1);
    while (arrived.load() < 2) std::this_thread::yield();
  });
  CHECK(arrived == 2);
}

TEST_CASE("ThreadPool: every worker has the same part of each loop") {
  ThreadPool pool(2);
  for (int round = 0; round < 100; ++round) {
    std::array<std::thread::id, 2> ran_on{};
    std::atomic<int> arrived{0};
    pool.run(2, [&](std::size_t i) {
      ran_on[i] = std::this_thread::get_id();
      arrived.fetch_add(1);
      while (arrived.load() < 2) std::this_thread::yield();
    });
    REQUIRE(ran_on[0] == std::this_thread::get_id());
    REQUIRE(ran_on[1] != std::this_thread::get_id());
  }
}

TEST_CASE("ThreadPool: who has nothing of its own to do helps the others") {
  using std::chrono::steady_clock;
  constexpr std::size_t workers = 4;
  ThreadPool pool(workers);
  for (int round = 0; round < 10; ++round) {
    // So that all but the last share are empty before anyone but the caller has woken.
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    const auto deadline = steady_clock::now() + std::chrono::seconds(10);
    std::atomic<std::size_t> arrived{0};
    // Each task of the last share waits for as many as there are workers.
    pool.run(8 * workers, [&](std::size_t i) {
      if (i < 8 * (workers - 1)) return;
      arrived.fetch_add(1);
      while (arrived.load() < workers && steady_clock::now() < deadline) std::this_thread::yield();
    });
    REQUIRE(steady_clock::now() < deadline);
  }
}

TEST_CASE("ThreadPool: who has fallen asleep is woken") {
  ThreadPool pool(3);
  const auto sleep = [] { std::this_thread::sleep_for(std::chrono::milliseconds(20)); };
  for (int round = 0; round < 3; ++round) {
    sleep();  // Far longer than workers look out for a loop.
    std::atomic<int> arrived{0};
    pool.run(3, [&](std::size_t) {
      arrived.fetch_add(1);
      while (arrived.load() < 3) std::this_thread::yield();
    });
    CHECK(arrived == 3);
    // And here longer than the caller looks out for the end.
    std::atomic<int> done{0};
    pool.run(3, [&](std::size_t i) {
      if (i > 0) sleep();
      done.fetch_add(1);
    });
    CHECK(done == 3);
  }
}

TEST_CASE("ThreadPool: a loop within a task, and one from another thread, are done by themselves") {
  ThreadPool pool(3);
  std::atomic<int> inner{0};
  pool.run(6, [&](std::size_t) { pool.run(5, [&](std::size_t) { inner.fetch_add(1); }); });
  CHECK(inner == 30);
  std::atomic<int> sum{0};
  const auto loops = [&] {
    for (int i = 0; i < 200; ++i) pool.run(10, [&](std::size_t) { sum.fetch_add(1); });
  };
  std::thread other(loops);
  loops();
  other.join();
  CHECK(sum == 4000);
}

TEST_CASE("ThreadPool: the hook does what the pool does") {
  ThreadPool pool(2);
  const bristle::ParallelFor hook = pool.hook();
  std::atomic<int> sum{0};
  hook(100, [&](std::size_t i) { sum.fetch_add(static_cast<int>(i)); });
  CHECK(sum == 4950);
}

// Clang does not say that it sanitizes addresses, which need more room than the limit.
#if defined(__linux__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#include <sys/resource.h>
#include <sys/wait.h>
#include <system_error>
#include <unistd.h>

TEST_CASE("ThreadPool: where the system has no more threads, it says so and ends those it has") {
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    // Room for some stacks of eight megabytes beyond what the program has.
    rlimit limit{};
    getrlimit(RLIMIT_AS, &limit);
    limit.rlim_cur = 1u << 30;
    setrlimit(RLIMIT_AS, &limit);
    alarm(30);  // ends a child that waits for ever
    try {
      ThreadPool pool(4000);
      _exit(2);
    } catch (const std::exception&) {
      _exit(0);
    }
  }
  int status = -1;
  REQUIRE(waitpid(child, &status, 0) == child);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
}
#endif
