#include "decides.h"

#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "hidden.h"

namespace blind {
namespace {

using nlohmann::json;

std::vector<std::string> fields(const std::string& line) {
  std::vector<std::string> out;
  std::istringstream in(line);
  for (std::string one; std::getline(in, one, ',');) out.push_back(one);
  return out;
}

// The conditions of the rows of the set, slip by the larger speed and the wheel's radius.
std::vector<PlannedRun> runs_of(const std::string& csv, const Wheel& wheel) {
  std::istringstream in(csv);
  std::string line;
  std::getline(in, line);
  const std::vector<std::string> names = fields(line);
  const auto column = [&](const std::vector<std::string>& row, const char* name) {
    for (std::size_t i = 0; i < names.size(); ++i)
      if (names[i] == name) return row.at(i);
    throw std::runtime_error(std::string("the data lack the column ") + name);
  };
  std::vector<PlannedRun> out;
  double last = 1;
  while (std::getline(in, line)) {
    const std::vector<std::string> row = fields(line);
    const double slip = std::stod(column(row, "slip")), radius = std::stod(column(row, "slip_radius_m"));
    const double kappa =
        (column(row, "slip_definition") == "rim" ? 1.0 - slip : speed_ratio(slip)) * radius / wheel.radius;
    PlannedRun p;
    // Nine digits in the file: the runs of one cell must stay equal.
    p.run.slip = std::round(slip_of_ratio(kappa) * 1e7) * 1e-7;
    p.run.load = std::stod(column(row, "load_N"));
    p.run.omega = std::stod(column(row, "omega_rad_s"));
    p.run.pass = std::stoi(column(row, "pass"));
    p.order = std::stoi(column(row, "order"));
    p.withheld = p.run.load == kWithheldLoad;
    last = std::max(last, static_cast<double>(p.order));
    out.push_back(p);
  }
  for (PlannedRun& p : out) p.run.order_share = last > 1 ? (p.order - 1) / (last - 1) : 0.0;
  return out;
}

std::optional<Condition> run_of(const json& condition, Wheel& wheel) {
  Condition run{0.3, 115, 0.3, 1};
  if (!condition.is_object()) return {};
  for (const auto& [key, value] : condition.items()) {
    if (!value.is_number()) return {};
    if (key == "slip")
      run.slip = value.get<double>();
    else if (key == "load_N")
      run.load = value.get<double>();
    else if (key == "omega_rad_s")
      run.omega = value.get<double>();
    else if (key == "pass")
      run.pass = static_cast<int>(value.get<double>());
    else if (key == "wheel_width_m")
      wheel.width = value.get<double>();
    else
      return {};
  }
  return run;
}

/// Truth, and the rival fitted to the noise-free data of the set.
struct Fitted {
  Wheel wheel;
  Priors priors;
  Soil soil;
  NoiseModel noise;
  Amplitudes truth;
  Refit rival;
};

Fitted fitted_rival(const json& answer, const std::string& csv, const std::string& rival) {
  Fitted f;
  const json& s = answer.at("soil");
  f.soil = {s.at("k"), s.at("n"), s.at("c"), s.at("phi"), s.at("K"), s.at("a0"), s.at("a1")};
  for (int i = 0; i < 3; ++i) f.noise.sd[i] = answer.at("noise_sd").at(static_cast<std::size_t>(i));
  f.noise.ln_k_scatter = answer.at("preparation").at(0);
  f.noise.phi_scatter = answer.at("preparation").at(1);
  for (const json& e : answer.at("effects")) f.truth[effect(e.at("id").get<std::string>()).id] = e.at("x");
  const SoilVector u = scaled(f.priors, f.soil);
  const Effect& other = effect(rival);
  const Fingerprint fingerprint(f.wheel, f.priors, u, runs_of(csv, f.wheel), f.noise);
  const std::vector<Observation> rows = grouped(fingerprint.observe(f.truth), other.uses);
  double best = std::numeric_limits<double>::infinity();
  for (const double sign : {1.0, -1.0}) {
    if (other.signs != 2 && other.signs != static_cast<int>(sign)) continue;
    Amplitudes start;
    start[other.id] = sign * 0.2 * other.typical;
    const Refit fitted = refit(f.wheel, f.priors, rows, u, start, other.id);
    if (fitted.chi2 + fitted.penalty >= best) continue;
    best = fitted.chi2 + fitted.penalty;
    f.rival = fitted;
  }
  return f;
}

/// Error of an amplitude read on the bench.
double bench_error(Id id, const Eigen::Vector3d& sd, int readings) {
  const Eigen::Vector3d read = sd / std::sqrt(static_cast<double>(readings));
  switch (id) {
    case Id::torque_offset:
      return read[1];
    case Id::torque_viscous:
      return read[1] / 0.9;
    case Id::torque_bearing:
      return read[1] / 225;
    case Id::torque_gain:
      return read[1] / 15;
    case Id::drawbar_bias:
      return read[0];
    case Id::drawbar_gain:
      return read[0] / 100;
    case Id::bed_slope:
      return 0.1 * 0.017453292519943295;
    case Id::sinkage_datum:
      return read[2];
    case Id::rig_compliance:
      return read[2] / 225;
    case Id::wheel_radius_error:
    case Id::load_error:
      return 0.002;
    default:
      return std::numeric_limits<double>::infinity();
  }
}

}  // namespace

std::optional<double> separation(const json& answer, const std::string& csv, const std::string& rival,
                                 const json& condition, int repeats) {
  Wheel wheel;  // of the new runs
  const std::optional<Condition> run = run_of(condition, wheel);
  if (!run) return {};
  try {
    const Fitted f = fitted_rival(answer, csv, rival);
    const Channels a = simulate(wheel, f.soil, f.truth, *run),
                   b = simulate(wheel, soil_of(f.priors, f.rival.u), f.rival.x, *run);
    return std::sqrt(static_cast<double>(repeats)) * (vector_of(a) - vector_of(b)).cwiseQuotient(f.noise.sd).norm();
  } catch (const std::runtime_error&) {
    return {};
  }
}

std::optional<double> bench_separation(const json& answer, const std::string& csv, const std::string& rival,
                                       const std::string& checked, int readings) {
  const Id id = effect(checked).id;
  try {
    const Fitted f = fitted_rival(answer, csv, rival);
    const double error = bench_error(id, f.noise.sd, readings), x = std::abs(f.truth[id]) + std::abs(f.rival.x[id]);
    if (!std::isfinite(error) || x == 0) return {};
    return x / error;
  } catch (const std::runtime_error&) {
    return {};
  }
}

}  // namespace blind
