#include "grouser/terrain/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace grouser {
namespace {

TEST(ParallelFor, GivesTheSameBitsForAnyNumberOfThreads) {
  auto work = [](int threads) {
    std::vector<double> x(1000);
    parallel_for(1000, threads, [&](int i) {
      double s = 0;
      for (int k = 1; k < 200; ++k) s += std::sin(0.1 * i * k) / k;
      x[static_cast<std::size_t>(i)] = s;
    });
    return x;
  };
  const auto one = work(1);
  for (int repeat = 0; repeat < 20; ++repeat) {
    EXPECT_EQ(work(2), one);
    EXPECT_EQ(work(4), one);
  }
}

TEST(ParallelFor, RunsEveryItemOnce) {
  for (const int n : {0, 1, 2, 3, 7, 1000}) {
    std::vector<std::atomic<int>> count(static_cast<std::size_t>(n));
    parallel_for(n, 4, [&](int i) { ++count[static_cast<std::size_t>(i)]; });
    for (const auto& c : count) EXPECT_EQ(c, 1);
  }
}

TEST(ParallelFor, RethrowsTheErrorOfTheLowestIndex) {
  for (const int threads : {1, 2, 4})
    for (int repeat = 0; repeat < 50; ++repeat) {
      std::string what;
      try {
        parallel_for(100, threads, [](int i) {
          if (i >= 30) throw std::runtime_error(std::to_string(i));
        });
      } catch (const std::runtime_error& e) {
        what = e.what();
      }
      EXPECT_EQ(what, "30") << threads << " threads";
    }
}

TEST(ParallelFor, WorksAgainAfterAnError) {
  EXPECT_THROW(parallel_for(8, 4, [](int) { throw std::runtime_error("x"); }), std::runtime_error);
  std::atomic<int> n{0};
  parallel_for(8, 4, [&](int) { ++n; });
  EXPECT_EQ(n, 8);
}

TEST(ParallelFor, NestedCallRunsInPlace) {
  std::vector<int> sums(16);
  parallel_for(16, 4, [&](int i) {
    int s = 0;
    const auto outer = std::this_thread::get_id();
    parallel_for(10, 4, [&](int k) {
      EXPECT_EQ(std::this_thread::get_id(), outer);
      s += k;
    });
    sums[static_cast<std::size_t>(i)] = s;
  });
  for (const int s : sums) EXPECT_EQ(s, 45);
}

TEST(ParallelFor, TwoCallersTakeTurns) {
  auto caller = [](std::vector<int>& out) {
    for (int repeat = 0; repeat < 50; ++repeat)
      parallel_for(static_cast<int>(out.size()), 3, [&](int i) { ++out[static_cast<std::size_t>(i)]; });
  };
  std::vector<int> a(64), b(64);
  std::thread ta([&] { caller(a); }), tb([&] { caller(b); });
  ta.join();
  tb.join();
  EXPECT_EQ(a, std::vector<int>(64, 50));
  EXPECT_EQ(b, std::vector<int>(64, 50));
}

}  // namespace
}  // namespace grouser
