/// @file
/// Worker threads for `WorldDef::parallel_for`.
///
/// Who does not want threads neither compiles nor links any: no other header includes this one, and
/// `bristle.hpp` does so only where `BRISTLE_WITH_THREADS` is defined. Programs that include it
/// link the system's threads (CMake: `Threads::Threads`).
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bristle/core/parallel.hpp>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <thread>
#include <vector>

namespace bristle {

/// A fixed number of threads that share the tasks of one loop at a time.
///
/// `WorldDef::parallel_for = pool.hook()`; the pool must outlive the worlds that have its hook, and
/// their copies. Any number of them may use it: who finds it busy, from another thread or from
/// within a task, does its loop alone. Tasks must not throw. A loop does not allocate.
///
/// A step has several loops, of ten microseconds some of them, and to be woken takes a thread that
/// long. So after a loop threads look out for the next one for a while before they sleep, and let
/// others have the processor meanwhile.
class ThreadPool {
 public:
  /// @param workers  [-] Threads that work on a loop, the calling one included; 0 and 1: only that
  ///                 one.
  explicit ThreadPool(unsigned workers = std::thread::hardware_concurrency()) {
    for (unsigned i = 1; i < workers; ++i) threads_.emplace_back([this] { wait_for_loops(); });
  }
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;
  ~ThreadPool() {
    {
      const std::lock_guard lock(mutex_);
      is_ending_ = true;
    }
    has_loop_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }

  /// [-] Threads that work on a loop, the calling one included.
  [[nodiscard]] std::size_t workers() const noexcept { return threads_.size() + 1; }

  /// Runs task(i) once for every i in [0, count) and returns when all are done.
  void run(std::size_t count, const std::function<void(std::size_t)>& task) {
    if (count < 2 || threads_.empty() || is_busy_.test_and_set(std::memory_order_acquire)) {
      serial_for(count, task);
      return;
    }
    {
      const std::lock_guard lock(mutex_);
      task_ = &task;
      count_ = count;
      // Several turns for each worker, so that none is left waiting for one long turn of another.
      grain_ = std::max<std::size_t>(1, count / (8 * workers()));
      next_.store(0, std::memory_order_relaxed);
      ++loop_;
      is_open_ = true;
    }
    has_loop_.notify_all();
    work();
    look_out([this] { return working_.load(std::memory_order_relaxed) == 0; });
    {
      // Workers that have not woken by now are not waited for: nothing is left for them.
      std::unique_lock lock(mutex_);
      is_open_ = false;
      is_done_.wait(lock, [this] { return working_.load(std::memory_order_relaxed) == 0; });
    }
    is_busy_.clear(std::memory_order_release);
  }

  /// What to give to `WorldDef::parallel_for`.
  [[nodiscard]] ParallelFor hook() {
    return [this](std::size_t count, const std::function<void(std::size_t)>& task) {
      run(count, task);
    };
  }

 private:
  /// [-] How often a thread looks before it sleeps: some fifty microseconds.
  static constexpr int most_looks = 100;

  /// Waits a while for what others are about to do. What they did is seen under the lock only.
  template <typename Condition>
  static void look_out(const Condition& is_there) {
    for (int i = 0; i < most_looks && !is_there(); ++i) std::this_thread::yield();
  }

  void work() {
    for (;;) {
      const std::size_t begin = next_.fetch_add(grain_, std::memory_order_relaxed);
      if (begin >= count_) return;
      const std::size_t end = std::min(count_, begin + grain_);
      for (std::size_t i = begin; i < end; ++i) (*task_)(i);
    }
  }

  void wait_for_loops() {
    std::size_t seen = 0;
    std::unique_lock lock(mutex_);
    for (;;) {
      has_loop_.wait(lock, [&] { return is_ending_ || (is_open_ && loop_ != seen); });
      if (is_ending_) return;
      seen = loop_;
      ++working_;
      lock.unlock();
      work();
      lock.lock();
      if (--working_ == 0) is_done_.notify_one();
      lock.unlock();
      look_out([&] { return loop_.load(std::memory_order_relaxed) != seen; });
      lock.lock();
    }
  }

  std::vector<std::thread> threads_;
  std::atomic_flag is_busy_ = ATOMIC_FLAG_INIT;
  std::atomic<std::size_t> next_{0};

  // The loop at hand; set while no worker works, under the lock.
  const std::function<void(std::size_t)>* task_ = nullptr;
  std::size_t count_ = 0;
  std::size_t grain_ = 1;

  std::mutex mutex_;
  std::condition_variable has_loop_, is_done_;
  // Written under the lock; looked at without it too.
  std::atomic<std::size_t> loop_{0};
  std::atomic<std::size_t> working_{0};
  bool is_open_ = false;
  bool is_ending_ = false;
};

}  // namespace bristle
