#include "run_model.h"

#include <ceres/jet.h>

#include <unordered_map>

#include "rig_model.h"

namespace grouser::bekker {
template <int N>
struct PlainPart<ceres::Jet<double, N>> {
  static double of(const ceres::Jet<double, N>& x) { return x.a; }
};
}  // namespace grouser::bekker

namespace grouser::diagnosis {
namespace {

using bekker::Effect;
std::uint32_t active_effects(const Inputs& in) {
  std::uint32_t active = 0;
  for (int i = 0; i < model_effects; ++i)
    if (in[static_cast<std::size_t>(soil_count + i)] != effect_entries()[static_cast<std::size_t>(i)].off)
      active |= 1U << i;
  return active;
}

double value(const Inputs& in, Map m) { return in[static_cast<std::size_t>(input_of(m))]; }

/// Slip as it is, of what was stated; `by_e`: its slope by the error of the radius.
double true_slip(const Run& run, double e, double& by_e) {
  by_e = 0;
  const double s0 = run.slip, kappa0 = s0 < 0 ? (s0 <= -1 ? INFINITY : 1 / (1 + s0)) : 1 - s0;
  if (!std::isfinite(kappa0)) return s0;
  const double kappa = kappa0 * (1 + e);
  by_e = kappa <= 1 ? -kappa0 : -kappa0 / (kappa * kappa);
  if (e == 0) return s0;
  return kappa <= 1 ? 1 - kappa : 1 / kappa - 1;
}

constexpr std::uint32_t bit(Effect e) { return 1U << static_cast<unsigned>(e); }
constexpr Looks steady_looks{bit(Effect::pressure_rate) | bit(Effect::shear_rate),
                             bit(Effect::repetitive_loading) | bit(Effect::pass_strength),
                             bit(Effect::preparation_drift), false, false};

Seen seen_by(const Run& run, const Inputs& in, const Asked& asked, const Looks& to) {
  Seen s;
  std::copy(in.begin(), in.begin() + soil_count, s.soil.begin());
  std::copy(in.begin() + soil_count, in.begin() + soil_count + model_effects, s.effect.begin());
  std::uint32_t looks = active_effects(in);
  for (int i = 0; i < asked.count; ++i) looks |= 1U << static_cast<unsigned>(asked.list[static_cast<std::size_t>(i)]);
  double unused;
  s.slip = true_slip(run, value(in, Map::wheel_radius_error), unused);
  s.load = run.load * (1 + value(in, Map::load_error));
  if (to.always_speed || (looks & to.speed)) s.omega = run.omega;
  if (to.always_pass || (looks & to.pass)) s.pass = run.pass;
  if (looks & to.order) s.order = run.order;
  return s;
}

/// One pass with N columns: soil, theta_f, slip and load where asked, then the effects listed. The equilibrium Fz(theta_f, x) = W
/// gives d theta_f/dx = -(dFz/dx - dW/dx)/(dFz/d theta_f) exactly.
template <int N>
bool derive(const bekker::EffectWheel& wheel, const bekker::EffectCondition& run, const bekker::WheelState<double>& q,
            const Asked& asked, Turned& t) {
  using J = ceres::Jet<double, N>;
  constexpr int angle_column = soil_count;
  [[maybe_unused]] constexpr int slip_column = soil_count + 1, load_column = soil_count + 2;
  [[maybe_unused]] const int first_effect = soil_count + 1 + (asked.slip_load ? 2 : 0);
  bekker::WheelState<J> s;
  s.k = exp(J(std::log(q.k), 0));
  s.n = J(q.n, 1), s.c = J(q.c, 2), s.phi = J(q.phi, 3);
  s.K = exp(J(std::log(q.K), 4));
  s.a0 = J(q.a0, 5), s.a1 = J(q.a1, 6);
  s.slip = J(q.slip), s.load = J(q.load);
  if constexpr (N >= soil_count + 3)
    if (asked.slip_load) s.slip.v[slip_column] = 1, s.load.v[load_column] = 1;
  s.active = q.active;
  for (std::size_t i = 0; i < s.effect.size(); ++i) s.effect[i] = J(q.effect[i]);
  for (int i = 0; i < asked.count; ++i) {
    const int e = asked.list[static_cast<std::size_t>(i)];
    if constexpr (N > soil_count + 1) s.effect[static_cast<std::size_t>(e)].v[first_effect + i] = 1;
    s.active |= 1U << static_cast<unsigned>(e);
  }
  bekker::WheelAnswer<J> a;
  if (!bekker::effect_forces(wheel, run, s, J(t.theta, angle_column), a)) return false;
  const double slope = a.Fz.v[angle_column];
  if (!(std::abs(slope) > 0)) return false;
  const Eigen::Matrix<double, N, 1> turn = (s.load.v - a.Fz.v) / slope;
  const J* y[channel_count] = {&a.drawbar, &a.torque, &a.sinkage};
  for (int c = 0; c < channel_count; ++c) {
    const Eigen::Matrix<double, N, 1> d = y[c]->v + y[c]->v[angle_column] * turn;
    t.soil.row(c) = d.template head<soil_count>().transpose();
    if constexpr (N >= soil_count + 3)
      if (asked.slip_load) t.slip[c] = d[slip_column], t.load[c] = d[load_column];
    if constexpr (N > soil_count + 1)
      for (int i = 0; i < asked.count; ++i)
        t.effect[static_cast<std::size_t>(asked.list[static_cast<std::size_t>(i)])][c] = d[first_effect + i];
  }
  return true;
}

/// t.theta: in: near the answer or 0.
void turn(const bekker::EffectWheel& wheel, const Seen& s, const Asked& asked, Turned& t) {
  bekker::WheelState<double> q;
  q.k = std::exp(s.soil[0]), q.n = s.soil[1], q.c = s.soil[2], q.phi = s.soil[3], q.K = std::exp(s.soil[4]);
  q.a0 = s.soil[5], q.a1 = s.soil[6];
  q.slip = s.slip, q.load = s.load;
  q.active = 0;
  for (std::size_t i = 0; i < bekker::effect_count; ++i) {
    q.effect[i] = s.effect[i];
    if (q.effect[i] != effect_entries()[i].off) q.active |= 1U << i;
  }
  const bekker::EffectCondition condition{s.omega * wheel.radius, static_cast<int>(s.pass), s.order};
  bekker::WheelAnswer<double> a{};
  t.good = bekker::effect_equilibrium(wheel, condition, q, t.theta, t.theta, a) == bekker::ForceStatus::ok;
  t.y = {a.drawbar, a.torque, a.sinkage};
  if (!t.good || asked.value_only) return;
  const int columns = soil_count + 1 + (asked.slip_load ? 2 : 0) + asked.count;
  t.good = columns <= 8    ? derive<8>(wheel, condition, q, asked, t)
           : columns <= 10 ? derive<10>(wheel, condition, q, asked, t)
           : columns <= 12 ? derive<12>(wheel, condition, q, asked, t)
                           : derive<soil_count + 3 + model_effects>(wheel, condition, q, asked, t);
}

/// Every different wheel once; `at`: which of them each run is.
struct Batch {
  std::vector<Turned> turned;
  std::vector<std::size_t> at;
  bool good = true;
};
Batch turn_all(const AskedWheel& wheel, const std::vector<Run>& runs, const std::vector<Inputs>& in, const Asked& asked,
               const std::vector<double>& theta) {
  Batch b;
  const Looks& looks = wheel.rig ? wheel.rig->looks() : steady_looks;
  b.at.reserve(runs.size());
  std::unordered_map<Seen, std::size_t, SeenHash> known;
  known.reserve(runs.size());
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const Seen s = seen_by(runs[r], in[r], asked, looks);
    const auto [found, fresh] = known.emplace(s, b.turned.size());
    b.at.push_back(found->second);
    if (!fresh) continue;
    b.turned.emplace_back();
    b.turned.back().theta = theta[r];
    if (wheel.rig)
      wheel.rig->turn(wheel.shape, runs[r], s, asked, b.turned.back());
    else
      turn(wheel.shape, s, asked, b.turned.back());
    if (b.turned.back().good) continue;
    b.good = false;
    return b;
  }
  return b;
}

/// What the rig shows of a wheel.
bool rig_shows(const Run& run, const Inputs& in, const Turned& t, Outputs& out, double& tilt) {
  const double F = t.y[0], T = t.y[1], W = run.load;
  tilt = std::tan(run.slope + value(in, Map::bed_slope));
  out[0] = (1 + value(in, Map::drawbar_gain)) * (F - W * tilt) + value(in, Map::drawbar_bias);
  out[1] = (1 + value(in, Map::torque_gain)) * T + value(in, Map::torque_offset) +
           value(in, Map::torque_viscous) * run.omega + value(in, Map::torque_bearing) * W;
  out[2] = t.y[2] + value(in, Map::sinkage_datum) + value(in, Map::rig_compliance) * W;
  return std::isfinite(out[0]) && std::isfinite(out[1]) && std::isfinite(out[2]);
}

void map_slopes(const Run& run, const Inputs& in, const Turned& t, double tilt, bool slip_load, Slopes& d) {
  const double F = t.y[0], T = t.y[1], W = run.load;
  const double gain_F = 1 + value(in, Map::drawbar_gain), gain_T = 1 + value(in, Map::torque_gain);
  if (slip_load) {
    double by_e;
    true_slip(run, value(in, Map::wheel_radius_error), by_e);
    d.col(input_of(Map::wheel_radius_error)) = by_e * t.slip;
    d.col(input_of(Map::load_error)) = W * t.load;
  }
  d.row(0) *= gain_F;
  d.row(1) *= gain_T;
  d(0, input_of(Map::drawbar_gain)) = F - W * tilt;
  d(1, input_of(Map::torque_gain)) = T;
  d(0, input_of(Map::drawbar_bias)) = 1;
  d(0, input_of(Map::bed_slope)) = -gain_F * W * (1 + tilt * tilt);
  d(1, input_of(Map::torque_offset)) = 1;
  d(1, input_of(Map::torque_viscous)) = run.omega;
  d(1, input_of(Map::torque_bearing)) = W;
  d(2, input_of(Map::sinkage_datum)) = 1;
  d(2, input_of(Map::rig_compliance)) = W;
}

}  // namespace

Inputs plain_inputs(const std::array<double, soil_count>& soil) {
  Inputs in{};
  std::copy(soil.begin(), soil.end(), in.begin());
  for (std::size_t i = 0; i < effect_entries().size(); ++i) in[soil_count + i] = effect_entries()[i].off;
  return in;
}

bool model_runs(const AskedWheel& wheel, const std::vector<Run>& runs, const std::vector<Inputs>& in, Wanted wanted,
                const std::vector<int>& touched, std::vector<double>& theta, std::vector<Outputs>& out,
                std::vector<Slopes>* slopes) {
  theta.resize(runs.size(), 0.0);
  out.resize(runs.size());
  // Passes over the runs, by what the effects asked for look at: those of speed would split the runs of all others.
  std::vector<Asked> passes(1);
  const auto ask = [](Asked& a, int e) { a.list[static_cast<std::size_t>(a.count++)] = e; };
  bool by_k_pass = false, by_k_order = false;  // these two only scale k: chain rule
  if (wanted != Wanted::value && slopes) {
    passes[0].value_only = false;
    Asked speed, pass;
    speed.value_only = pass.value_only = false;
    for (int e = 0; e < static_cast<int>(effect_entries().size()); ++e) {
      if (wanted != Wanted::all && std::find(touched.begin(), touched.end(), e) == touched.end()) continue;
      if (e >= model_effects) {
        passes[0].slip_load = passes[0].slip_load || e == model_effects + static_cast<int>(Map::wheel_radius_error) ||
                              e == model_effects + static_cast<int>(Map::load_error);
        continue;
      }
      const auto effect = static_cast<Effect>(e);
      if (wheel.rig) {
        if (wheel.rig->has(e)) ask(wheel.rig->looks().speed >> static_cast<unsigned>(e) & 1U ? speed : passes[0], e);
      } else if (effect == Effect::preparation_drift)
        by_k_order = true;
      else if (effect == Effect::repetitive_loading)
        by_k_pass = true;
      else if (effect == Effect::pass_strength)
        ask(pass, e);
      else if (effect == Effect::pressure_rate || effect == Effect::shear_rate)
        ask(speed, e);
      else
        ask(passes[0], e);
    }
    if (wanted == Wanted::all) {
      if (speed.count > 0) passes.push_back(speed);
      if (pass.count > 0) passes.push_back(pass);
    } else {  // few: one pass
      for (const Asked& more : {speed, pass})
        for (int i = 0; i < more.count; ++i) ask(passes[0], more.list[static_cast<std::size_t>(i)]);
    }
    slopes->resize(runs.size());
  }
  for (std::size_t p = 0; p < passes.size(); ++p) {
    const Batch b = turn_all(wheel, runs, in, passes[p], theta);
    if (!b.good) return false;
    for (std::size_t r = 0; r < runs.size(); ++r) {
      const Turned& t = b.turned[b.at[r]];
      if (p == 0) {
        theta[r] = t.theta;
        double tilt;
        if (!rig_shows(runs[r], in[r], t, out[r], tilt)) return false;
        if (passes[0].value_only) continue;
        Slopes& d = (*slopes)[r];
        d.setZero();
        d.leftCols<soil_count>() = t.soil;
        if (by_k_pass && runs[r].pass >= 2)
          d.col(input_of(Effect::repetitive_loading)) =
              t.soil.col(0) / (1 + in[r][static_cast<std::size_t>(input_of(Effect::repetitive_loading))]);
        if (by_k_order)
          d.col(input_of(Effect::preparation_drift)) =
              t.soil.col(0) * runs[r].order /
              (1 + in[r][static_cast<std::size_t>(input_of(Effect::preparation_drift))] * runs[r].order);
        for (int i = 0; i < passes[0].count; ++i) {
          const int e = passes[0].list[static_cast<std::size_t>(i)];
          d.col(soil_count + e) = t.effect[static_cast<std::size_t>(e)];
        }
        map_slopes(runs[r], in[r], t, tilt, passes[0].slip_load, d);
      } else {
        for (int i = 0; i < passes[p].count; ++i) {
          const int e = passes[p].list[static_cast<std::size_t>(i)];
          Slopes& d = (*slopes)[r];
          d.col(soil_count + e) = t.effect[static_cast<std::size_t>(e)];
          d(0, soil_count + e) *= 1 + value(in[r], Map::drawbar_gain);
          d(1, soil_count + e) *= 1 + value(in[r], Map::torque_gain);
        }
      }
    }
  }
  if (slopes && wanted != Wanted::value)
    for (const Slopes& d : *slopes)
      if (!d.allFinite()) return false;
  return true;
}

bool settle_runs(const AskedWheel& wheel, const std::vector<Run>& runs, const std::vector<Inputs>& in) {
  if (!wheel.rig) return true;
  for (std::size_t r = 0; r < runs.size(); ++r)
    if (!wheel.rig->settle(wheel.shape, runs[r], seen_by(runs[r], in[r], {}, wheel.rig->looks()))) return false;
  return true;
}

bool model_run(const AskedWheel& wheel, const Run& run, const Inputs& in, Wanted wanted,
               const std::vector<int>& touched, double& theta_f, Outputs& out, Slopes* slopes) {
  std::vector<double> theta{theta_f};
  std::vector<Outputs> y;
  std::vector<Slopes> d;
  const bool good = model_runs(wheel, {run}, {in}, wanted, touched, theta, y, slopes ? &d : nullptr);
  theta_f = theta[0];
  out = y[0];
  if (slopes && !d.empty()) *slopes = d[0];
  return good;
}

}  // namespace grouser::diagnosis
