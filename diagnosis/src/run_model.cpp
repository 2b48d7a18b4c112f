#include "run_model.h"

#include <ceres/jet.h>

namespace grouser::bekker {
template <int N>
struct PlainPart<ceres::Jet<double, N>> {
  static double of(const ceres::Jet<double, N>& x) { return x.a; }
};
}  // namespace grouser::bekker

namespace grouser::diagnosis {
namespace {

constexpr int effects = static_cast<int>(bekker::effect_count);
constexpr int slip_column = soil_count, load_column = soil_count + 1, angle_column = soil_count + 2,
              first_effect = soil_count + 3;

int map_input(Map m) { return soil_count + effects + static_cast<int>(m); }

/// Model's own slopes by slip and load, that the maps need, beside those that go to the caller.
struct Raw {
  Outputs y{};
  Eigen::Matrix<double, channel_count, soil_count> soil;
  Eigen::Matrix<double, channel_count, 1> slip, load;
  std::array<Eigen::Matrix<double, channel_count, 1>, effects> effect;
};

/// One pass with N columns: soil, slip, load, theta_f, then the effects listed. The equilibrium Fz(theta_f, x) = W gives
/// d theta_f/dx = -(dFz/dx - dW/dx)/(dFz/d theta_f) exactly.
template <int N>
bool derive(const bekker::EffectWheel& wheel, const bekker::EffectCondition& run, const bekker::WheelState<double>& q,
            double theta, const int* list, int count, Raw& raw) {
  using J = ceres::Jet<double, N>;
  bekker::WheelState<J> s;
  s.k = J(std::log(q.k), 0);
  s.k = exp(s.k);
  s.n = J(q.n, 1), s.c = J(q.c, 2), s.phi = J(q.phi, 3);
  s.K = exp(J(std::log(q.K), 4));
  s.a0 = J(q.a0, 5), s.a1 = J(q.a1, 6);
  s.slip = J(q.slip, slip_column), s.load = J(q.load, load_column);
  s.active = q.active;
  for (std::size_t i = 0; i < s.effect.size(); ++i) s.effect[i] = J(q.effect[i]);
  for (int i = 0; i < count; ++i) {
    s.effect[static_cast<std::size_t>(list[i])].v[first_effect + i] = 1;
    s.active |= 1U << static_cast<unsigned>(list[i]);
  }
  bekker::WheelAnswer<J> a;
  if (!bekker::effect_forces(wheel, run, s, J(theta, angle_column), a)) return false;
  const double slope = a.Fz.v[angle_column];
  if (!(std::abs(slope) > 0)) return false;
  const Eigen::Matrix<double, N, 1> turn = (s.load.v - a.Fz.v) / slope;
  const J* y[channel_count] = {&a.drawbar, &a.torque, &a.sinkage};
  for (int c = 0; c < channel_count; ++c) {
    const Eigen::Matrix<double, N, 1> d = y[c]->v + y[c]->v[angle_column] * turn;
    raw.soil.row(c) = d.template head<soil_count>().transpose();
    raw.slip[c] = d[slip_column];
    raw.load[c] = d[load_column];
    for (int i = 0; i < count; ++i) raw.effect[static_cast<std::size_t>(list[i])][c] = d[first_effect + i];
  }
  return true;
}

}  // namespace

Inputs plain_inputs(const std::array<double, soil_count>& soil) {
  Inputs in{};
  std::copy(soil.begin(), soil.end(), in.begin());
  for (std::size_t i = 0; i < effect_entries().size(); ++i) in[soil_count + i] = effect_entries()[i].off;
  return in;
}

bool model_run(const bekker::EffectWheel& wheel, const Run& run, const Inputs& in, Wanted wanted,
               const std::vector<int>& touched, double& theta_f, Outputs& out, Slopes* slopes) {
  const auto map = [&](Map m) { return in[static_cast<std::size_t>(map_input(m))]; };
  // Slip and load as they are, of what was stated.
  const double e = map(Map::wheel_radius_error), s0 = run.slip;
  double slip = s0, slip_by_e = 0;
  const double kappa0 = s0 < 0 ? (s0 <= -1 ? INFINITY : 1 / (1 + s0)) : 1 - s0;
  if (std::isfinite(kappa0)) {
    const double kappa = kappa0 * (1 + e);
    slip = kappa <= 1 ? 1 - kappa : 1 / kappa - 1;
    slip_by_e = kappa <= 1 ? -kappa0 : -kappa0 / (kappa * kappa);
    if (e == 0) slip = s0;
  }
  bekker::WheelState<double> q;
  q.k = std::exp(in[0]), q.n = in[1], q.c = in[2], q.phi = in[3], q.K = std::exp(in[4]), q.a0 = in[5], q.a1 = in[6];
  q.slip = slip;
  q.load = run.load * (1 + map(Map::load_error));
  q.active = 0;
  for (std::size_t i = 0; i < bekker::effect_count; ++i) {
    q.effect[i] = in[soil_count + i];
    if (q.effect[i] != effect_entries()[i].off) q.active |= 1U << i;
  }
  const bekker::EffectCondition condition{run.omega * wheel.radius, run.pass, run.order};
  bekker::WheelAnswer<double> a{};
  if (bekker::effect_equilibrium(wheel, condition, q, theta_f, theta_f, a) != bekker::ForceStatus::ok) return false;

  const double F = a.drawbar, T = a.torque, W = run.load, tilt = std::tan(run.slope + map(Map::bed_slope));
  const double gain_F = 1 + map(Map::drawbar_gain), gain_T = 1 + map(Map::torque_gain);
  out[0] = gain_F * (F - W * tilt) + map(Map::drawbar_bias);
  out[1] = gain_T * T + map(Map::torque_offset) + map(Map::torque_viscous) * run.omega + map(Map::torque_bearing) * W;
  out[2] = a.sinkage + map(Map::sinkage_datum) + map(Map::rig_compliance) * W;
  for (const double y : out)
    if (!std::isfinite(y)) return false;
  if (wanted == Wanted::value || !slopes) return true;

  Raw raw;
  int list[effects];
  int count = 0;
  for (int i = 0; i < effects; ++i)
    if (wanted == Wanted::all || std::find(touched.begin(), touched.end(), i) != touched.end()) list[count++] = i;
  const bool good = count <= 2 ? derive<12>(wheel, condition, q, theta_f, list, count, raw)
                               : derive<32>(wheel, condition, q, theta_f, list, count, raw);
  if (!good) return false;
  Slopes& d = *slopes;
  d.setZero();
  d.leftCols<soil_count>() = raw.soil;
  for (int i = 0; i < count; ++i) d.col(soil_count + list[i]) = raw.effect[static_cast<std::size_t>(list[i])];
  d.col(map_input(Map::wheel_radius_error)) = slip_by_e * raw.slip;
  d.col(map_input(Map::load_error)) = W * raw.load;
  d.row(0) *= gain_F;
  d.row(1) *= gain_T;
  d(0, map_input(Map::drawbar_gain)) = F - W * tilt;
  d(1, map_input(Map::torque_gain)) = T;
  d(0, map_input(Map::drawbar_bias)) = 1;
  d(0, map_input(Map::bed_slope)) = -gain_F * W * (1 + tilt * tilt);
  d(1, map_input(Map::torque_offset)) = 1;
  d(1, map_input(Map::torque_viscous)) = run.omega;
  d(1, map_input(Map::torque_bearing)) = W;
  d(2, map_input(Map::sinkage_datum)) = 1;
  d(2, map_input(Map::rig_compliance)) = W;
  return d.allFinite();
}

}  // namespace grouser::diagnosis
