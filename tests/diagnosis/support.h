#pragma once
// The reference case, tables written to a folder of their own, and runs by the library's solver.
#include <gtest/gtest.h>

#include <fstream>
#include <random>

#include "grouser/bekker/forces.h"
#include "grouser/diagnosis/diagnose.h"
#include "grouser/terrain/config.h"

namespace grouser::diagnosis {

namespace fs = std::filesystem;

inline constexpr const char* case_text = R"(model: bekker.steady
wheel: {radius: 0.13 m, width: 0.16 m, mass: 3.2 kg}
soil:
  pressure: {law: k_ref, reference_width: 0.16 m, k: {value: 254.1 kPa, ln_sd: 0.30}, n: {value: 1.387, sd: 0.14}}
  shear: {type: A, c: {value: 139.28 Pa, sd: 415 Pa}, phi: {value: 0.606 rad, sd: 0.0502 rad}, K: {value: 0.5151 mm, ln_sd: 1.0}}
  angles: {a0: {value: 0.18, sd: 0.2}, a1: {value: 0.32, sd: 0.2}}
  density: {value: 1600 kg/m^3}
effects: all
)";

class DiagnoseTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() /
              ("grouser_diagnose_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::create_directories(folder_);
    std::ofstream(folder_ / "case.yaml") << case_text;
  }
  void TearDown() override { fs::remove_all(folder_); }
  DiagnosisCase given() { return read_case(folder_ / "case.yaml"); }
  /// The case with more lines below it, or with something replaced.
  DiagnosisCase given_with(const std::string& lines, const std::string& from = "", const std::string& to = "") {
    std::string text = case_text;
    if (!from.empty()) text.replace(text.find(from), from.size(), to);
    std::ofstream(folder_ / "other.yaml") << text << lines;
    return read_case(folder_ / "other.yaml");
  }
  RunTable table(const std::string& text) {
    std::ofstream(folder_ / "data.csv") << text;
    return read_runs(folder_ / "data.csv", given());
  }
  std::string refusal(const std::string& text) {
    try {
      table(text);
    } catch (const ConfigError& e) {
      return e.what();
    }
    return "accepted";
  }
  fs::path folder_;
};

/// Runs by the library's own solver, not by the one with effects; `change` alters what the rig shows.
template <class Change>
std::string series(Change change, int seed) {
  BekkerSoil b;
  b.pressure = {PressureSinkage::Law::k_b, 0, 0, 280e3, 1.42, 0.16};
  b.shear.cohesion = 250, b.shear.friction_angle = 0.59, b.shear.K = 0.7e-3;
  b.angles = {0.25, 0.3, 0, 0};
  std::mt19937 random(static_cast<unsigned>(seed));
  std::normal_distribution<double> noise;
  std::string out =
      "slip,slip_definition,slip_radius_m,load_N,omega_rad_s,pass,order,drawbar_N,torque_Nm,sinkage_m,drawbar_sd_N,"
      "torque_sd_Nm,sinkage_sd_m\n";
  int order = 0;
  for (const double omega : {0.1, 0.9})
    for (const double slip : {-0.5, -0.1, 0.1, 0.3, 0.6})
      for (const double load : {60.0, 140.0, 225.0}) {
        bekker::LoadCase c;
        c.wheel = {0.13, 0.16, 0, 0};
        c.soil = bekker::SoilLaw::of(b, 0.16);
        c.load = load, c.slip = slip;
        const bekker::Solution s = bekker::solve(c, bekker::Method::nonlinear, 1e-8);
        std::array<double, 3> y{s.wrench.Fx, -s.wrench.My, s.sinkage};
        change(y, slip, load, omega);
        char line[240];
        std::snprintf(line, sizeof line, "%g,larger,0.13,%g,%g,1,%d,%.6f,%.7f,%.9f,2,0.2,0.0015\n", slip, load, omega,
                      (++order * 7) % 31, y[0] + 2 * noise(random), y[1] + 0.2 * noise(random),
                      y[2] + 0.0015 * noise(random));
        out += line;
      }
  return out;
}

}  // namespace grouser::diagnosis
