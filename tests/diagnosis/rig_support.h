#pragma once
// Cases whose model is rolled in the rig, and runs of `grouser rig`: a Bullet body on fine nodes, no code of the
// diagnosis.
#include <sstream>

#include "../../diagnosis/src/rig_model.h"
#include "../../diagnosis/src/run_model.h"
#include "grouser/models.h"
#include "grouser/vehicle/rig.h"
#include "support.h"

namespace grouser::diagnosis {

struct Sweep {
  std::string effects;  ///< "bulldozing: 1"
  std::string options = "spacing: 3.3 mm";
  std::string wheel = "shape: smooth\nradius: 0.13 m\nwidth: 0.16 m\n";
  std::vector<double> slips{-0.7, -0.3, -0.1, 0.1, 0.3, 0.7}, loads{60, 115, 225};
  double omega = 1;  ///< [rad/s]
  std::string time_step = "1 ms";
};

class RigTest : public DiagnoseTest {
 protected:
  /// The reference case with another model and more lines.
  DiagnosisCase rolled(const std::string& model, const std::string& lines = "") {
    std::string text = case_text;
    text.replace(text.find("bekker.steady"), 13, model);
    std::ofstream(folder_ / "rolled.yaml") << text << lines;
    return read_case(folder_ / "rolled.yaml", &all_models());
  }
  /// The soil of the reference case, in the order ln k, n, c, phi, ln K, a0, a1.
  static std::array<double, soil_count> soil() {
    return {std::log(254.1e3), 1.387, 139.28, 0.606, std::log(0.5151e-3), 0.18, 0.32};
  }
  /// Means of the last 0.36 m of 1.2 m of travel: slip and direction of the effects settle over the chord, 0.15 m.
  std::vector<vehicle::RigRow> sweep(const Sweep& s, const std::array<double, soil_count>& x) {
    const auto list = [](const std::vector<double>& v, const char* unit) {
      std::ostringstream out;
      out.precision(12);
      for (std::size_t i = 0; i < v.size(); ++i) out << (i ? ", " : "[") << v[i] << unit;
      return out.str() + "]";
    };
    std::ofstream(folder_ / "wheel.yaml") << "wheel: w\nsource: test\n" << s.wheel;
    std::ofstream soil_file(folder_ / "soil.yaml");
    soil_file.precision(15);
    soil_file << "soil: s\nsource: test\nbekker:\n  pressure: {law: k_b, k: " << std::exp(x[0]) << " Pa, n: " << x[1]
              << ", reference_width: 0.16 m}\n  shear: {type: A, cohesion: " << x[2] << " Pa, friction_angle: " << x[3]
              << " rad, K: " << std::exp(x[4]) << " m}\n  contact_angles: {a0: " << x[5] << ", a1: " << x[6]
              << ", b0: 0, b1: 0}\nbulk_density: 1600 kg/m^3\n";
    soil_file.close();
    std::ofstream(folder_ / "rig.yaml") << "rig: test\nwheel: wheel.yaml\nterrain:\n  model: bekker.soil_node\n  soil: "
                                           "soil.yaml\n  options: {bekker.soil_node: {"
                                        << s.options << "}}\n"
                                        << (s.effects.empty() ? ""
                                                              : "  effects: {bekker.soil_node: {" + s.effects + "}}\n")
                                        << "load: " << list(s.loads, " N") << "\nslips: " << list(s.slips, "")
                                        << "\nslip_definition: symmetric\nangular_speed: " << s.omega
                                        << " rad/s\nsettle: 0.1 s\nramp: 0.2 s\ndistance: 1.2 m\ntime_step: "
                                        << s.time_step << "\naverage_over: 30 %\noutput: {rate: 2 Hz}\n";
    vehicle::RigOptions o;
    o.out = folder_ / "rig";
    return vehicle::run_rig(folder_ / "rig.yaml", all_models(), o).rows;
  }
  /// A table of them with noise of 2 N, 0.2 N m, 1.5 mm over `quiet`.
  RunTable measured(const std::vector<vehicle::RigRow>& rows, const DiagnosisCase& c, int seed, double quiet = 1) {
    std::mt19937 random(static_cast<unsigned>(seed));
    std::normal_distribution<double> noise;
    std::ofstream out(folder_ / "data.csv");
    out << "slip,slip_definition,slip_radius_m,load_N,omega_rad_s,pass,order,drawbar_N,torque_Nm,sinkage_m,drawbar_sd_"
           "N,torque_sd_Nm,"
           "sinkage_sd_m\n";
    const double sd[3] = {2 / quiet, 0.2 / quiet, 0.0015 / quiet};
    int order = 0;
    for (const vehicle::RigRow& r : rows) {
      char line[300];
      std::snprintf(line, sizeof line, "%g,larger,0.13,%g,%g,1,%d,%.6f,%.7f,%.9f,%g,%g,%g\n", r.spec.slip, r.spec.load,
                    r.spec.angular_speed, (++order * 7) % 31, r.drawbar_pull.mean + sd[0] * noise(random),
                    r.driving_torque.mean + sd[1] * noise(random), r.sinkage_profile.mean + sd[2] * noise(random),
                    sd[0], sd[1], sd[2]);
      out << line;
    }
    out.close();
    return read_runs(folder_ / "data.csv", c);
  }
};

}  // namespace grouser::diagnosis
