#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include "grouser/terrain/ground.h"

namespace ground_test {

inline std::filesystem::path examples() { return std::filesystem::path(GROUSER_SOURCE_DIR) / "examples/grounds"; }

/// A folder of its own that disappears with the test.
class Folder {
 public:
  Folder() {
    const auto* t = testing::UnitTest::GetInstance()->current_test_info();
    path = std::filesystem::path(testing::TempDir()) /
           ("grouser_ground_" + std::string(t->name()) + "_" + std::to_string(std::random_device{}()));
    std::filesystem::create_directories(path);
  }
  ~Folder() { std::filesystem::remove_all(path); }
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(path / name, std::ios::binary) << text;
    return path / name;
  }
  std::filesystem::path path;
};

/// Gradient by central differences small against every feature, large against rounding.
inline grouser::Vec2 numeric_gradient(const grouser::Ground& g, double x, double y) {
  const double d = 1e-6;
  return {(g.height(x + d, y) - g.height(x - d, y)) / (2 * d), (g.height(x, y + d) - g.height(x, y - d)) / (2 * d)};
}

/// normal() against numeric_gradient() at (x, y).
inline void expect_normal_is_gradient(const grouser::Ground& g, double x, double y, double tolerance) {
  const grouser::Vec3 n = g.normal(x, y);
  const grouser::Vec2 d = numeric_gradient(g, x, y);
  EXPECT_NEAR(n.norm(), 1, 1e-14);
  EXPECT_GT(n.z(), 0);
  EXPECT_NEAR(-n.x() / n.z(), d.x(), tolerance) << "at " << x << ", " << y;
  EXPECT_NEAR(-n.y() / n.z(), d.y(), tolerance) << "at " << x << ", " << y;
}

}  // namespace ground_test
