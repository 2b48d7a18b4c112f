#include "time_generator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "blind/dice.h"
#include "blind/wheel.h"

namespace hidden {

namespace {

using Row = std::array<double, 3>;
constexpr int substeps = 40;

struct Truth {
  blind::Soil soil;
  std::vector<double> ln_k_shift, phase;
};

/// Steady answers on a fine grid of slip.
class Steady {
 public:
  Steady(const blind::Soil& soil, double ln_k_shift) {
    for (int i = 0; i <= cells; ++i) {
      blind::Condition c;
      c.slip = low + (high - low) * i / cells;
      c.load = load, c.ln_k_shift = ln_k_shift;
      const blind::Channels y = blind::simulate({radius, width, 1600}, soil, {}, c);
      table_.push_back({y.drawbar, y.torque, y.sinkage});
    }
  }
  Row at(double slip) const {
    const double u = std::clamp((slip - low) / (high - low), 0.0, 1.0) * cells;
    const auto i = std::min(static_cast<std::size_t>(u), static_cast<std::size_t>(cells - 1));
    const double f = u - static_cast<double>(i);
    Row out;
    for (std::size_t c = 0; c < 3; ++c) out[c] = (1 - f) * table_[i][c] + f * table_[i + 1][c];
    return out;
  }

 private:
  static constexpr int cells = 120;
  static constexpr double low = -0.25, high = 0.55;
  std::vector<Row> table_;
};

/// Steps of slip: 0.05, 0.5 from a quarter of the run, -0.2 from 0.6 of it.
double slip_at(double t, const Plan& p) {
  const auto step = [&](double from, double at) { return from * std::clamp((t - at) / p.ramp, 0.0, 1.0); };
  return 0.05 + step(0.45, 0.25 * p.duration) - step(0.7, 0.6 * p.duration);
}

struct Path {
  std::vector<double> t, slip, omega;
  std::vector<Row> y;
};

Path simulate(const Truth& truth, const Steady& steady, std::size_t run, What what, double size, const Plan& p) {
  Path out;
  const int rows = static_cast<int>(std::lround(p.duration / p.spacing)) + 1;
  const double h = p.spacing / substeps, v = p.travel[run];
  const auto omega_of = [&](double s) { return (s < 0 ? v * (1 + s) : v / (1 - s)) / radius; };
  Row a = steady.at(slip_at(0, p)), slow = a, b = a, rate{};
  double turn = 0;
  std::vector<Row> past;  // one for each substep, for the delay
  for (int i = 0; i < rows; ++i) {
    for (int k = 0; k < (i == 0 ? 1 : substeps); ++k) {
      const double t = i == 0 ? 0 : (i - 1) * p.spacing + (k + 1) * h;
      const Row u = steady.at(slip_at(t, p));
      const double step = i == 0 ? 0 : h;
      turn += step * omega_of(slip_at(t, p));
      for (std::size_t c = 0; c < 3; ++c) {
        const auto lag = [&](double& x, double scale) { x += (u[c] - x) * (1 - std::exp(-step / scale)); };
        const double wave = std::sin(lugs * turn + truth.phase[0] + 0.7 * static_cast<double>(c));
        const double part = c == 0 ? 1 : c == 1 ? 0.08 : 2e-4;  // N, N m, m for each N of drawbar
        switch (what) {
          case What::relaxation:
            lag(a[c], size / v);
            b[c] = a[c];
            break;
          case What::filter:
            lag(b[c], size);
            break;
          case What::ripple:
            b[c] = u[c] + size * part * wave;
            break;
          case What::relaxation_and_ripple:
            lag(a[c], 0.03 / v);
            b[c] = a[c] + size * part * wave;
            break;
          case What::two_scales:
            lag(a[c], size / v), lag(slow[c], 10 * size / v);
            b[c] = 0.55 * a[c] + 0.45 * slow[c];
            break;
          case What::one_sensor:
            if (c == 1)
              lag(b[c], size);
            else
              b[c] = u[c];
            break;
          case What::overshoot: {
            const double w = v / size;
            rate[c] += step * (w * w * (u[c] - b[c]) - 2 * 0.3 * w * rate[c]);
            b[c] += step * rate[c];
            break;
          }
          default:
            b[c] = u[c];
        }
      }
      past.push_back(b);
    }
    out.t.push_back(i * p.spacing);
    out.slip.push_back(slip_at(i * p.spacing, p));
    out.omega.push_back(omega_of(out.slip.back()));
    Row y = b;
    if (what == What::delay) {
      const double back = std::max(0.0, static_cast<double>(past.size() - 1) - size / h);
      const auto j = std::min(static_cast<std::size_t>(back), past.size() - 1);
      const double f = back - static_cast<double>(j);
      for (std::size_t c = 0; c < 3; ++c) y[c] = (1 - f) * past[j][c] + f * past[std::min(j + 1, past.size() - 1)][c];
    }
    out.y.push_back(y);
  }
  return out;
}

/// Length of the difference of two series, whitened as AR(1).
double length(const std::vector<Path>& a, const std::vector<Path>& b, double rho) {
  double sum = 0;
  for (std::size_t r = 0; r < a.size(); ++r)
    for (std::size_t c = 0; c < 3; ++c) {
      double last = 0;
      for (std::size_t i = 0; i < a[r].y.size(); ++i) {
        const double e = (a[r].y[i][c] - b[r].y[i][c]) / noise[c];
        sum += i == 0 ? e * e : (e - rho * last) * (e - rho * last) / (1 - rho * rho);
        last = e;
      }
    }
  return std::sqrt(sum);
}

}  // namespace

const char* name_of(What w) {
  const char* names[] = {"nothing",    "soil only",  "soil scatters", "relaxation_length",
                         "filter",     "delay",      "ripple",        "relaxation_length+ripple",
                         "two scales", "one sensor", "overshoot"};
  return names[static_cast<int>(w)];
}

std::string right_name(What w) {
  switch (w) {
    case What::relaxation:
    case What::filter:
    case What::delay:
    case What::ripple:
    case What::relaxation_and_ripple:
      return name_of(w);
    default:
      return "";
  }
}

Set make(What what, double d, std::uint64_t seed, const Plan& plan) {
  blind::Dice dice(seed);
  Truth truth;
  blind::Soil& s = truth.soil;
  const double half = 0.5;
  s.k *= std::exp(half * 0.3 * dice.normal()), s.n += half * 0.14 * dice.normal();
  s.c = std::max(0.0, s.c + half * 415 * dice.normal()), s.phi += half * 0.0502 * dice.normal();
  s.K *= std::exp(half * dice.normal());
  s.a0 = std::clamp(s.a0 + half * 0.2 * dice.normal(), 0.0, 0.5);
  s.a1 = std::clamp(s.a1 + half * 0.2 * dice.normal(), 0.0, 0.6);
  if (what == What::soil)
    s.k = 254.1e3 * std::exp(0.9 * (dice.chance(0.5) ? 1 : -1)), s.phi = 0.606 + 0.1 * (dice.chance(0.5) ? 1 : -1);
  truth.phase.push_back(dice.uniform(0, 6.283));
  std::vector<Steady> steady;
  for (std::size_t r = 0; r < plan.travel.size(); ++r)
    steady.emplace_back(s, what == What::scattered ? 0.06 * dice.normal() : 0.0);
  const auto all = [&](What w, double size) {
    std::vector<Path> out;
    for (std::size_t r = 0; r < plan.travel.size(); ++r) out.push_back(simulate(truth, steady[r], r, w, size, plan));
    return out;
  };
  Set set;
  std::vector<Path> shown = all(What::nothing, 0);
  if (what != What::nothing && what != What::soil && what != What::scattered) {
    const std::vector<Path> plain = what == What::relaxation_and_ripple ? all(What::relaxation, 0.03) : shown;
    double low = what == What::ripple || what == What::relaxation_and_ripple ? 1e-3 : 1e-4, high = low * 3e5;
    for (int k = 0; k < 40; ++k) {
      const double middle = std::sqrt(low * high);
      (length(all(what, middle), plain, plan.rho) < d ? low : high) = middle;
      if (high / low < 1.01) break;
    }
    set.size = std::sqrt(low * high);
    shown = all(what, set.size);
    set.d = length(shown, plain, plan.rho);
  }
  set.csv =
      "batch,time_s,slip,slip_radius_m,load_N,omega_rad_s,drawbar_N,torque_Nm,sinkage_m,drawbar_sd_N,torque_sd_Nm,"
      "sinkage_sd_m\n";
  for (std::size_t r = 0; r < shown.size(); ++r) {
    Row e{dice.normal(), dice.normal(), dice.normal()};
    for (std::size_t i = 0; i < shown[r].t.size(); ++i) {
      if (i > 0)
        for (double& x : e) x = plan.rho * x + std::sqrt(1 - plan.rho * plan.rho) * dice.normal();
      char line[240];
      std::snprintf(line, sizeof line, "%zu,%.3f,%.6f,0.13,115,%.7f,%.5f,%.6f,%.8f,2,0.2,0.0015\n", r, shown[r].t[i],
                    shown[r].slip[i], shown[r].omega[i], shown[r].y[i][0] + noise[0] * e[0],
                    shown[r].y[i][1] + noise[1] * e[1], shown[r].y[i][2] + noise[2] * e[2]);
      set.csv += line;
    }
  }
  return set;
}

std::string case_text(bool scatter) {
  return std::string(R"(model: bekker.steady
wheel: {radius: 0.13 m, width: 0.16 m, mass: 3.2 kg}
soil:
  pressure: {law: k_ref, reference_width: 0.16 m, k: {value: 254.1 kPa, ln_sd: 0.30}, n: {value: 1.387, sd: 0.14}}
  shear: {type: A, c: {value: 139.28 Pa, sd: 415 Pa}, phi: {value: 0.606 rad, sd: 0.0502 rad}, K: {value: 0.5151 mm, ln_sd: 1.0}}
  angles: {a0: {value: 0.18, sd: 0.2}, a1: {value: 0.32, sd: 0.2}}
  density: {value: 1600 kg/m^3}
series:
  lugs: 12
)") + (scatter ? "  preparation: {ln_k_sd: 0.06}\n" : "");
}

}  // namespace hidden
