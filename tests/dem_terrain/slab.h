#pragma once
// A slab of coarse grains that is its own neighbour across, and a wheel that rolls through it.
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "dem_terrain/coarse.h"

namespace grouser::test {

inline constexpr double kSlab = 0.125, kStep = 1.0 / 1024;  // [m], [s]: whole binary fractions
/// Packing of 0.5 m and torus of 1 m: what lies 1 m further lies in the same place of both.
inline std::string slab_options(int seed = 1, const std::string& more = "") {
  return "{depth: 50 mm, relief: 20 mm, slab: 125 mm, brick: 125 mm, reach: 60 mm, torus: 8, period: [0.5 m, 0.125 m], "
         "seed: " +
         std::to_string(seed) + more + "}";
}
inline std::unique_ptr<Terrain> slab(double width = kWidth, int seed = 1) {
  return coarse_terrain(flat_ground(), 1, slab_options(seed), {"wheel", SmoothCylinder{kRadius, width}});
}

/// From 12 mm deep at (x, y), rolling along x at 0.25 m/s with a slip of 0.2; one answer a step.
inline std::vector<BodyResult> roll_slab(Terrain& t, int from, int to, double x = 0, double y = 0) {
  Ride ride;
  ride.hub = kRadius - 0.012;
  ride.speed = 0.25;
  std::vector<BodyResult> out;
  for (int i = from; i < to; ++i) {
    BodyMotion m = ride.motion(kStep * i, kStep * (i + 1));
    for (Pose* X : {&m.X_WB_begin, &m.X_WB_end}) X->p += Vec3(x, y, 0);
    out.push_back(step_one(t, kStep * i, kStep, m));
  }
  return out;
}

/// 700 steps, whole, with two threads, and stopped after 400, saved and loaded into a new one: same bits. `check` sees those two and the whole.
template <class Make, class Check>
void expect_same_bits_after_load_and_on_two_threads(const Make& make, const Check& check) {
  const std::unique_ptr<Terrain> whole = make(), first = make(), second = make(), two = make();
  two->set_threads(2);
  roll_slab(*whole, 0, 700);
  roll_slab(*two, 0, 700);
  roll_slab(*first, 0, 400);
  State saved = state_of(*first);
  saved.rewind(State::Mode::load);
  second->traverse(saved);
  saved.finish();
  roll_slab(*second, 400, 700);
  for (Terrain* t : {second.get(), two.get()}) {
    const auto d = State::first_difference(state_of(*whole), state_of(*t));
    EXPECT_FALSE(d) << d->field << '[' << d->index << "]: " << d->left << " became " << d->right;
    check(*t, *whole);
  }
}

inline std::string error_of(const std::function<void()>& f) {
  try {
    f();
  } catch (const std::exception& e) {
    return e.what();
  }
  return "no error";
}

inline Vec3 mean_force(const std::vector<BodyResult>& r, std::size_t from) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = from; k < r.size(); ++k) sum += r[k].impulse;
  return sum / (kStep * static_cast<double>(r.size() - from));
}

}  // namespace grouser::test
