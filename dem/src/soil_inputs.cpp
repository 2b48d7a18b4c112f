// Inputs as text: results are known by it.
#include <cstdio>

#include "grouser/dem/soil_test.h"
#include "packing.h"

namespace grouser::dem {

void put_line(std::string& text, const char* name, const std::string& value) {
  text += name;
  text += ' ';
  text += value;
  text += '\n';
}
void put_line(std::string& text, const char* name, double value) {
  char b[40];
  std::snprintf(b, sizeof b, "%.17g", value);
  put_line(text, name, std::string(b));
}

std::string hash_text(const std::string& text) {
  std::uint64_t h = 1469598103934665603ull;
  for (char c : text) h = (h ^ static_cast<unsigned char>(c)) * 1099511628211ull;
  char b[20];
  std::snprintf(b, sizeof b, "%016llx", static_cast<unsigned long long>(h));
  return b;
}

std::string inputs_text(const SoilSettings& s) {
  std::string t;
  put_line(t, "seed", s.seed);
  put_line(t, "diameter_smallest_m", s.smallest);
  put_line(t, "diameter_largest_m", s.largest);
  put_line(t, "density_kg_m3", s.density);
  put_line(t, "bulk_density_kg_m3", s.bulk_density);
  put_line(t, "time_step_s", s.dt);
  put_line(t, "precision", s.precision == Precision::single ? "single" : "double");
  const LawSettings& l = s.law;
  put_line(t, "model", l.model == ContactModel::hertz_ch4 ? "hertz-ch4" : "hertz-ch3");
  put_line(t, "rolling_law",
           l.rolling == RollingCoefficient::constant ? "constant"
           : l.rolling == RollingCoefficient::rate   ? "rate"
                                                     : "rate_without_spin");
  put_line(t, "tangential_stiffness", l.tangential == TangentialStiffness::mindlin ? "mindlin" : "printed");
  put_line(t, "cap", l.cap == Cap::sum ? "sum" : "springs");
  put_line(t, "damping", l.damping == Damping::implicit_ ? "implicit" : "explicit");
  for (const Material& m : s.materials.materials) {
    put_line(t, "material", m.name);
    put_line(t, "young_Pa", m.young);
    put_line(t, "poisson", m.poisson);
  }
  for (const PairProperties& p : s.materials.pairs) {
    put_line(t, "pair_friction", p.friction);
    put_line(t, "rolling", p.rolling);
    put_line(t, "restitution", p.restitution);
    put_line(t, "cohesion_J_m3", p.cohesion);
    if (l.model == ContactModel::hertz_ch3) {
      put_line(t, "kn_N_m2", p.kn);
      put_line(t, "kt_N_m2", p.kt);
      put_line(t, "gamma_n", p.gamma_n);
      put_line(t, "gamma_t", p.gamma_t);
    }
  }
  return t;
}

std::string inputs_text(const PourSettings& p) {
  std::string t;
  put_line(t, "pour", p.walls ? "box" : p.slab ? "slab" : "periodic");
  put_line(t, "lx_m", p.lx);
  put_line(t, "ly_m", p.ly);
  put_line(t, "height_m", p.height);
  put_line(t, "compaction_Pa", p.compaction);
  return t;
}

std::string inputs_text(const ShearSettings& s) {
  std::string t;
  put_line(t, "test", "direct shear");
  put_line(t, "side_m", s.side);
  put_line(t, "height_m", s.height);
  put_line(t, "pressure_Pa", s.pressure);
  put_line(t, "rate_m_s", s.rate);
  put_line(t, "displacement_m", s.displacement);
  put_line(t, "rest_s", s.rest);
  if (s.rest_speed != ShearSettings().rest_speed) put_line(t, "rest_speed_m_s", s.rest_speed);
  put_line(t, "samples", s.samples);
  return t;
}

std::string inputs_text(const ReposeSettings& s) {
  std::string t;
  put_line(t, "test", "angle of repose");
  put_line(t, "base_x_m", s.base_x);
  put_line(t, "base_y_m", s.base_y);
  put_line(t, "height_m", s.height);
  put_line(t, "lift_m_s", s.lift);
  put_line(t, "duration_s", s.duration);
  put_line(t, "samples", s.samples);
  return t;
}

std::string inputs_text(const OedometerSettings& s) {
  std::string t;
  put_line(t, "test", "oedometer");
  put_line(t, "side_m", s.side);
  put_line(t, "height_m", s.height);
  for (double p : s.pressures) put_line(t, "pressure_Pa", p);
  put_line(t, "hold_s", s.hold);
  put_line(t, "rest_speed_m_s", s.rest_speed);
  return t;
}

std::string inputs_text(const TriaxialSettings& s) {
  std::string t;
  put_line(t, "test", "triaxial");
  put_line(t, "side_m", s.side);
  put_line(t, "height_m", s.height);
  put_line(t, "pressure_Pa", s.pressure);
  put_line(t, "strain_rate_1_s", s.strain_rate);
  put_line(t, "strain", s.strain);
  put_line(t, "wall_speed_m_s", s.wall_speed);
  put_line(t, "rest_s", s.rest);
  put_line(t, "rest_speed_m_s", s.rest_speed);
  put_line(t, "samples", s.samples);
  return t;
}

std::string inputs_text(const SinkageSettings& s) {
  std::string t;
  put_line(t, "test", "pressure-sinkage");
  put_line(t, "bin_x_m", s.bin_x);
  put_line(t, "bin_y_m", s.bin_y);
  put_line(t, "depth_m", s.depth);
  put_line(t, "plate_x_m", s.plate_x);
  put_line(t, "plate_y_m", s.plate_y);
  put_line(t, "plate_z_m", s.plate_z);
  put_line(t, "rate_m_s", s.rate);
  put_line(t, "sinkage_m", s.sinkage);
  put_line(t, "brick_m", s.brick);
  put_line(t, "samples", s.samples);
  return t;
}

}  // namespace grouser::dem
