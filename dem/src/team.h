#pragma once
// Threads that walk through the phases of a step together.
#include <atomic>
#include <cstddef>
#include <exception>
#include <thread>
#include <utility>
#include <vector>
#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace grouser::dem {

/// Waits for another thread, some 50 us, then lets others run: phases last tens of microseconds, and giving the core away
/// for less costs more than it saves (200 turns: 3 % slower on two threads).
class Patience {
 public:
  void wait() {
    if (++turns_ > 1000) {
      std::this_thread::yield();
    } else {
#if defined(__SSE2__)
      _mm_pause();
#endif
    }
  }

 private:
  int turns_ = 0;
};

/// Threads 0..n-1, all of which run the same function. What any of them throws stops all of them.
class Team {
 public:
  explicit Team(int n) : first_done_(static_cast<std::size_t>(n)), n_(n) {}
  int size() const { return n_; }

  /// f(t) on all threads at the same time; 0 is the caller. Throws what one of them threw.
  template <class F>
  void together(F&& f) {
    std::vector<std::thread> others;
    for (int t = 1; t < n_; ++t) others.emplace_back([&f, t] { f(t); });
    f(0);
    for (std::thread& t : others) t.join();
    if (failure_) std::rethrow_exception(failure_);
  }
  /// Runs f here; a failure is kept until all have come to the next wait.
  template <class F>
  void guard(F&& f) {
    try {
      f();
    } catch (...) {
      if (!failing_.exchange(true)) failure_ = std::current_exception();
    }
  }
  /// Everybody waits for everybody; the last to come runs `alone` while the others wait. False after a failure.
  template <class F>
  bool wait(F&& alone) {
    const int turn = turn_.load(std::memory_order_acquire);
    if (arrived_.fetch_add(1, std::memory_order_acq_rel) + 1 == n_) {
      arrived_.store(0, std::memory_order_relaxed);
      if (!failing_) guard(alone);
      turn_.store(turn + 1, std::memory_order_release);
    } else {
      for (Patience p; turn_.load(std::memory_order_acquire) == turn;) p.wait();
    }
    return !failing_;
  }
  bool wait() {
    return wait([] {});
  }

  /// Thread t has done its first piece of work of step `step`; another waits for that.
  void first_done(int t, long step) {
    first_done_[static_cast<std::size_t>(t)].step.store(step, std::memory_order_release);
  }
  void wait_for_first(int t, long step) const {
    const std::atomic<long>& done = first_done_[static_cast<std::size_t>(t)].step;
    for (Patience p; done.load(std::memory_order_acquire) < step;) p.wait();
  }

  /// Part t of n things.
  std::pair<std::size_t, std::size_t> share(std::size_t n, int t) const {
    const auto T = static_cast<std::size_t>(n_), u = static_cast<std::size_t>(t);
    return {n * u / T, n * (u + 1) / T};
  }

 private:
  struct alignas(64) Mark {
    std::atomic<long> step{-1};
  };
  std::vector<Mark> first_done_;
  const int n_;
  std::exception_ptr failure_;
  std::atomic<bool> failing_{false};
  alignas(64) std::atomic<int> arrived_{0};
  alignas(64) std::atomic<int> turn_{0};
};

}  // namespace grouser::dem
