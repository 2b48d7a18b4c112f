#pragma once
// Threads that walk through the phases of a step together.
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace grouser::dem {

/// Everybody waits for everybody. Spins briefly, then yields: phases last tens of microseconds.
class Barrier {
 public:
  explicit Barrier(int n) : n_(n) {}
  void wait() {
    const int turn = turn_.load(std::memory_order_acquire);
    if (arrived_.fetch_add(1, std::memory_order_acq_rel) + 1 == n_) {
      arrived_.store(0, std::memory_order_relaxed);
      turn_.store(turn + 1, std::memory_order_release);
      return;
    }
    for (int spin = 0; turn_.load(std::memory_order_acquire) == turn; ++spin)
      if (spin > 2000) std::this_thread::yield();
  }

 private:
  const int n_;
  std::atomic<int> arrived_{0}, turn_{0};
};

/// f(t) on threads t = 0..n-1 at the same time; t = 0 is the caller.
template <class F>
void together(int n, F&& f) {
  std::vector<std::thread> others;
  for (int t = 1; t < n; ++t) others.emplace_back([&f, t] { f(t); });
  f(0);
  for (std::thread& t : others) t.join();
}

}  // namespace grouser::dem
