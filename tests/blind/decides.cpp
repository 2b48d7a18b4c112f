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

std::optional<Condition> run_of(const json& condition) {
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
    else
      return {};
  }
  return run;
}

}  // namespace

std::optional<double> separation(const json& answer, const std::string& csv, const std::string& rival,
                                 const json& condition) {
  const std::optional<Condition> run = run_of(condition);
  if (!run) return {};
  const Wheel wheel;
  const Priors priors;
  const json& s = answer.at("soil");
  const Soil soil{s.at("k"), s.at("n"), s.at("c"), s.at("phi"), s.at("K"), s.at("a0"), s.at("a1")};
  NoiseModel noise;
  for (int i = 0; i < 3; ++i) noise.sd[i] = answer.at("noise_sd").at(static_cast<std::size_t>(i));
  noise.ln_k_scatter = answer.at("preparation").at(0);
  noise.phi_scatter = answer.at("preparation").at(1);
  Amplitudes truth;
  for (const json& e : answer.at("effects")) truth[effect(e.at("id").get<std::string>()).id] = e.at("x");
  const SoilVector u = scaled(priors, soil);
  const Effect& other = effect(rival);
  try {
    const Fingerprint fingerprint(wheel, priors, u, runs_of(csv, wheel), noise);
    const std::vector<Observation> rows = grouped(fingerprint.observe(truth), other.uses);
    double best = std::numeric_limits<double>::infinity(), distance = 0;
    for (const double sign : {1.0, -1.0}) {
      if (other.signs != 2 && other.signs != static_cast<int>(sign)) continue;
      Amplitudes start;
      start[other.id] = sign * 0.2 * other.typical;
      const Refit fitted = refit(wheel, priors, rows, u, start, other.id);
      if (fitted.chi2 + fitted.penalty >= best) continue;
      best = fitted.chi2 + fitted.penalty;
      const Channels a = simulate(wheel, soil, truth, *run),
                     b = simulate(wheel, soil_of(priors, fitted.u), fitted.x, *run);
      distance =
          std::sqrt(static_cast<double>(kDecidingRuns)) * (vector_of(a) - vector_of(b)).cwiseQuotient(noise.sd).norm();
    }
    return distance;
  } catch (const std::runtime_error&) {
    return {};
  }
}

}  // namespace blind
