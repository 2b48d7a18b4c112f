#pragma once
// What one wheel is asked and answers, before the maps of the measurement: the same for the steady law and for a
// model in the rig.
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>

#include "effect_list.h"
#include "grouser/diagnosis/runs.h"

namespace grouser::diagnosis {

constexpr int model_effects = static_cast<int>(bekker::effect_count);
using Outputs = std::array<double, channel_count>;
using Column = Eigen::Matrix<double, channel_count, 1>;

/// A wheel's own answer.
struct Turned {
  bool good = false;
  double theta = 0;
  Outputs y{};
  Eigen::Matrix<double, channel_count, soil_count> soil;
  Column slip, load;
  std::array<Column, model_effects> effect;
};

/// Effects whose slopes are asked for in one pass, and whether those by slip and load are.
struct Asked {
  std::array<int, model_effects> list{};
  int count = 0;
  bool slip_load = false, value_only = true;
  bool has(bekker::Effect e) const {
    return std::find(list.begin(), list.begin() + count, static_cast<int>(e)) != list.begin() + count;
  }
};

/// All that the wheel sees of a run. Doubles alone, so that equal means bitwise equal.
struct Seen {
  std::array<double, soil_count> soil{};
  std::array<double, model_effects> effect{};
  double slip = 0, load = 0, omega = 0, pass = 1, order = 0;
  bool operator==(const Seen& o) const { return std::memcmp(this, &o, sizeof *this) == 0; }
};
struct SeenHash {
  std::size_t operator()(const Seen& s) const {
    std::uint64_t word[sizeof(Seen) / 8], h = 0x9e3779b97f4a7c15U;
    std::memcpy(word, &s, sizeof s);
    for (const std::uint64_t w : word) h = (h ^ w) * 0x9fb21c651e98df25U, h ^= h >> 32U;
    return h;
  }
};
static_assert(sizeof(Seen) == 8 * (soil_count + model_effects + 5));

/// Which effects (bits) make a wheel look at a run's speed, pass and place in the series, and whether it does so
/// without any.
struct Looks {
  std::uint32_t speed = 0, pass = 0, order = 0;
  bool always_speed = false, always_pass = false;
};

}  // namespace grouser::diagnosis
