/// @file
/// Worker threads for `WorldDef::parallel_for`.
///
/// A program without threads neither compiles nor links any. No other header includes this one;
/// `bristle.hpp` does so only where `BRISTLE_WITH_THREADS` is defined. Programs that include it
/// link the system's threads (CMake: `Threads::Threads`).
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/core_constants.hpp>
#include <bristle/core/parallel.hpp>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <thread>
#include <vector>

namespace bristle::inline BRISTLE_ABI {

/// A fixed number of threads that share the tasks of one loop at a time.
///
/// Use `WorldDef::parallel_for = pool.hook()`. The pool must outlive the worlds that have its hook,
/// and their copies. Any number of worlds may share it. A loop that finds the pool busy runs on its
/// own thread alone. Such a loop comes from another thread, or from within a task. Tasks must not
/// throw. A loop does not allocate.
///
/// Each worker has the same share of every loop. So data it wrote in one loop is in its cache for
/// the next. A worker that is done with its own share helps the others.
///
/// A step has several loops, some of ten microseconds. Waking a thread takes that long. So after a
/// loop threads spin for a while before they sleep. They soon yield the processor meanwhile.
class ThreadPool {
 public:
  /// @param workers  [-] Threads that work on a loop, including the calling one. At 0 and 1 it is
  ///                 the only one.
  /// @throws std::system_error when the system has no more threads; those made so far have ended.
  explicit ThreadPool(unsigned workers = std::thread::hardware_concurrency())
      : shares_(std::max(1u, workers)) {
    threads_.reserve(shares_.size() - 1);
    Ending unless_complete{this};
    for (unsigned i = 1; i < workers; ++i) threads_.emplace_back([this, i] { wait_for_loops(i); });
    unless_complete.pool = nullptr;
  }
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;
  ~ThreadPool() { const Ending all{this}; }

  /// [-] Threads that work on a loop, including the calling one.
  [[nodiscard]] std::size_t workers() const noexcept { return shares_.size(); }

  /// Runs task(i) once for every i in [0, count). Returns when all are done.
  void run(std::size_t count, const std::function<void(std::size_t)>& task) {
    if (count < 2 || threads_.empty() || is_busy_.test_and_set(std::memory_order_acquire)) {
      serial_for(count, task);
      return;
    }
    // Several turns for each worker: no worker waits for one long turn of another.
    const std::size_t grain =
        std::max<std::size_t>(1, count / (detail::chosen::turns_of_worker * workers()));
    const std::size_t turns = (count + grain - 1) / grain;
    undone_.store(turns, std::memory_order_relaxed);
    const std::size_t number = shares_[0].number.load(std::memory_order_relaxed) + 1;
    for (std::size_t k = 0; k < workers(); ++k) {
      const std::size_t end = (k + 1) * turns / workers();
      shares_[k].loop = {&task, count, grain, end};
      shares_[k].left.store(static_cast<std::ptrdiff_t>(end - k * turns / workers()),
                            std::memory_order_release);
      shares_[k].number.store(number, std::memory_order_release);
    }
    wake_sleepers();
    work(0);
    if (!look_out([this] { return is_done(); })) {
      std::unique_lock<std::mutex> lock(mutex_);
      is_caller_asleep_.store(true);
      has_done_.wait(lock, [this] { return is_done(); });
      is_caller_asleep_.store(false);
    }
    is_busy_.clear(std::memory_order_release);
  }

  /// The hook for `WorldDef::parallel_for`.
  [[nodiscard]] ParallelFor hook() {
    return [this](std::size_t count, const std::function<void(std::size_t)>& task) {
      run(count, task);
    };
  }

 private:
  /// Ends the threads of a pool when its scope ends.
  struct Ending {
    ThreadPool* pool;

    ~Ending() {
      if (pool == nullptr) return;
      pool->is_ending_.store(true);
      pool->wake_sleepers();
      for (std::thread& thread : pool->threads_) thread.join();
    }
  };

  /// Turns of a loop.
  struct Loop {
    const std::function<void(std::size_t)>* task = nullptr;
    /// [-] Tasks of the loop, tasks of a turn, and number behind the last turn.
    std::size_t count = 0;
    std::size_t grain = 1;
    std::size_t end = 0;
  };

  /// Turns of one worker, before others help. All its data is in one cache line.
  struct alignas(64) Share {
    /// [-] Turns that no thread has taken; 0 and less: none. Only a thread that took a turn may
    /// read `loop`. It does not change until the turn is done.
    std::atomic<std::ptrdiff_t> left{0};
    /// [-] Number of the loop, written last: a new number calls the worker.
    std::atomic<std::size_t> number{0};
    Loop loop{};
  };

  /// Waits a short while for a condition that other threads are about to fulfil.
  /// @return True if it is fulfilled.
  template <typename Condition>
  static bool look_out(const Condition& is_there) {
    for (int i = 0; i < detail::chosen::looks_before_yield; ++i) {
      if (is_there()) return true;
      rest();
    }
    for (int i = 0; i < detail::chosen::yields_before_sleep; ++i) {
      if (is_there()) return true;
      std::this_thread::yield();
    }
    return false;
  }

  /// Tells the processor that this thread only waits, where that is possible.
  static void rest() {
#if defined(__GNUC__) && (defined(__x86_64__) || defined(__i386__))
    __builtin_ia32_pause();
#elif defined(__GNUC__) && defined(__aarch64__)
    asm volatile("yield");
#endif
  }

  [[nodiscard]] bool is_done() const { return undone_.load() == 0; }

  /// Takes turns until none is left, first from the share `own`.
  void work(std::size_t own) {
    std::size_t done = 0;
    for (std::size_t k = 0; k < workers(); ++k) {
      Share& share = shares_[(own + k) % workers()];
      while (share.left.load(std::memory_order_relaxed) > 0) {
        const std::ptrdiff_t left = share.left.fetch_sub(1, std::memory_order_acquire);
        if (left <= 0) break;
        // A copy: others take turns from the same line.
        do_turn(Loop(share.loop), static_cast<std::size_t>(left));
        ++done;
      }
    }
    // A caller that sleeps announced it before its last look.
    if (done > 0 && undone_.fetch_sub(done) == done && is_caller_asleep_.load()) {
      { const std::lock_guard<std::mutex> lock(mutex_); }
      has_done_.notify_one();
    }
  }

  /// @param left  [-] Turns of the share before this one was taken.
  static void do_turn(const Loop& loop, std::size_t left) {
    const std::size_t turn = loop.end - left;
    const std::size_t end = std::min(loop.count, (turn + 1) * loop.grain);
    for (std::size_t i = turn * loop.grain; i < end; ++i) (*loop.task)(i);
  }

  /// Wakes sleeping threads. A thread that falls asleep is counted here. Else it finds the value
  /// stored before.
  void wake_sleepers() {
    if (sleepers_.fetch_add(0) == 0) return;
    { const std::lock_guard<std::mutex> lock(mutex_); }
    has_loop_.notify_all();
  }

  void wait_for_loops(std::size_t own) {
    std::size_t seen = 0;
    const auto is_wanted = [&] { return shares_[own].number.load() != seen || is_ending_.load(); };
    for (;;) {
      if (!look_out(is_wanted)) {
        std::unique_lock<std::mutex> lock(mutex_);
        sleepers_.fetch_add(1);
        has_loop_.wait(lock, is_wanted);
        sleepers_.fetch_sub(1);
      }
      if (is_ending_.load()) return;
      seen = shares_[own].number.load();
      work(own);
    }
  }

  std::vector<Share> shares_;
  std::vector<std::thread> threads_;
  std::atomic<bool> is_ending_{false};
  // In cache lines of their own. All threads read the members above all the time.
  alignas(64) std::atomic_flag is_busy_ = ATOMIC_FLAG_INIT;
  /// [-] Turns of the current loop that are not known to be done.
  alignas(64) std::atomic<std::size_t> undone_{0};

  alignas(64) std::mutex mutex_;
  std::condition_variable has_loop_, has_done_;
  std::atomic<std::size_t> sleepers_{0};
  std::atomic<bool> is_caller_asleep_{false};
};

}  // namespace bristle::inline BRISTLE_ABI
