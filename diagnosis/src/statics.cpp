#include "statics.h"

#include <algorithm>
#include <cmath>

namespace grouser::diagnosis {
namespace {

constexpr double clear = 3;  // sd

struct Angles {
  double theta, theta_f, friction, normal;
};

Angles angles_of(double F, double T, double z, double W, double r) {
  const double S = T / r, whole = std::hypot(W, F);
  const double theta = std::asin(std::clamp(S / whole, -1.0, 1.0)) - std::atan2(F, W);
  const double N = W * std::cos(theta) - F * std::sin(theta);
  return {theta, std::acos(std::clamp(1 - z / r, -1.0, 1.0)), S / N, N};
}

}  // namespace

std::vector<RowStatics> statics_of(const Search& s) {
  std::vector<RowStatics> out;
  const DiagnosisCase& c = s.series().given();
  const double r = c.wheel.radius;
  const double steepest = std::tan(c.soil[3].mean + 2 * c.soil[3].sd), cohesion = c.soil[2].mean + 2 * c.soil[2].sd;
  const auto sd = s.stated_sd();
  const auto grown = s.statics_scale();
  for (std::size_t i = 0; i < s.series().runs().size(); ++i) {
    const Run& run = s.series().runs()[i];
    const double F = run.value[0], T = run.value[1], z = run.value[2];
    if (!std::isfinite(F + T + z) || !(z > 0) || z >= r || run.slope != 0) continue;
    const Angles a = angles_of(F, T, z, run.load, r);
    RowStatics row{run.line, run.slip, run.load, a.theta, a.theta_f, a.friction, 0, 0, false, false};
    for (std::size_t ch = 0; ch < channel_count; ++ch) {
      const double step = sd[i][ch] * grown[ch];
      const Angles b = angles_of(F + (ch == 0 ? step : 0), T + (ch == 1 ? step : 0),
                                 std::max(z - (ch == 2 ? std::min(step, 0.5 * z) : 0), 1e-9), run.load, r);
      row.theta_sd += std::pow(b.theta - b.theta_f - a.theta + a.theta_f, 2);
      row.friction_sd += std::pow(b.friction - a.friction, 2);
    }
    row.theta_sd = std::sqrt(row.theta_sd), row.friction_sd = std::sqrt(row.friction_sd);
    row.outside = a.theta - a.theta_f > clear * row.theta_sd;
    const double bond = cohesion * c.wheel.width * r * a.theta_f / std::abs(a.normal);
    row.slides = std::abs(a.friction) - steepest - bond > clear * row.friction_sd;
    out.push_back(row);
  }
  return out;
}

}  // namespace grouser::diagnosis
