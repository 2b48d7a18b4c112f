#include "candidates.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <algorithm>
#include <functional>
#include <set>

namespace grouser::diagnosis {
namespace {

using bekker::Effect;

int effect_input(Effect e) { return soil_count + static_cast<int>(e); }
int map_input(Map m) { return soil_count + static_cast<int>(bekker::effect_count) + static_cast<int>(m); }

struct Through {
  const char* name;
  int input;
  double reach;  ///< of a coefficient
};
const std::vector<Through>& throughs() {
  static const std::vector<Through> list{{"k", 0, 3},
                                         {"n", 1, 2},
                                         {"c", 2, 5e3},
                                         {"phi", 3, 0.6},
                                         {"K", 4, 4},
                                         {"theta_m", 5, 0.7},
                                         {"theta_r", effect_input(Effect::exit_angle), 0.7},
                                         {"drawbar", map_input(Map::drawbar_bias), 200},
                                         {"torque", map_input(Map::torque_offset), 30},
                                         {"sinkage", map_input(Map::sinkage_datum), 0.1}};
  return list;
}

struct Variable {
  const char* name;
  std::function<double(const Run&)> of;
};
const std::vector<Variable>& variables() {
  static const std::vector<Variable> list{
      {"slip", [](const Run& r) { return r.slip; }},
      {"load_N", [](const Run& r) { return r.load; }},
      {"omega_rad_s", [](const Run& r) { return std::log(std::max(r.omega, 1e-6)); }},
      {"pass", [](const Run& r) { return static_cast<double>(r.pass); }},
      {"order", [](const Run& r) { return r.order; }},
      {"slope_deg", [](const Run& r) { return r.slope; }},
      {"time", [](const Run& r) { return r.time; }}};
  return list;
}

std::size_t levels(const std::vector<Run>& runs, const Variable& v) {
  std::set<long> seen;
  for (const Run& r : runs) seen.insert(std::lround(v.of(r) * 1e6));
  return seen.size();
}

/// Orthonormal in the sense of one unit of mean square, without the constant.
std::vector<Eigen::VectorXd> shapes(const std::vector<Run>& runs, const Variable& v, std::size_t count, bool slip) {
  const auto n = static_cast<Eigen::Index>(runs.size());
  Eigen::VectorXd x(n);
  for (Eigen::Index i = 0; i < n; ++i) x[i] = v.of(runs[static_cast<std::size_t>(i)]);
  const double low = x.minCoeff(), high = x.maxCoeff();
  if (!slip) x = (2 * (x.array() - low) / (high - low) - 1).matrix();
  Eigen::MatrixXd A(n, 1 + static_cast<Eigen::Index>(count));
  A.col(0).setOnes();
  for (std::size_t k = 1; k <= count; ++k) {
    const auto c = static_cast<Eigen::Index>(k);
    if (slip) {  // what happens at slip 0 may differ on its two sides
      if (k == 1) A.col(c) = x.cwiseAbs();
      if (k == 2) A.col(c) = x;
      if (k == 3) A.col(c) = x.array().square();
      if (k == 4) A.col(c) = x.array() * x.array().abs();
    } else {
      A.col(c) = x.array().pow(static_cast<double>(k));
    }
  }
  const Eigen::MatrixXd Q =
      Eigen::HouseholderQR<Eigen::MatrixXd>(A).householderQ() * Eigen::MatrixXd::Identity(n, A.cols());
  std::vector<Eigen::VectorXd> out;
  for (Eigen::Index c = 1; c < A.cols(); ++c) out.push_back(Q.col(c) * std::sqrt(static_cast<double>(n)));
  return out;
}

/// What comes and goes in the course of the series (temperature, tide, a loose part): sine and cosine of 1 to 16 turns.
std::vector<Candidate> periodic_candidates(const std::vector<Run>& runs) {
  std::vector<Candidate> out;
  if (runs.size() < 40) return out;
  const auto n = static_cast<Eigen::Index>(runs.size());
  for (const Through& p : throughs()) {
    const std::string through = p.name;
    if (through != "k" && through != "phi" && through != "drawbar" && through != "torque" && through != "sinkage")
      continue;
    for (int half = 2; half <= 32; ++half) {
      Candidate c{through + " comes and goes with order", {}, {}, "order", through};
      for (const double shift : {0.0, 1.5707963267948966}) {
        Eigen::VectorXd x(n);
        for (Eigen::Index i = 0; i < n; ++i)
          x[i] = std::sqrt(2.0) * std::sin(3.141592653589793 * half * runs[static_cast<std::size_t>(i)].order + shift);
        c.terms.push_back({p.input, x, -p.reach, p.reach, 0.05 * p.reach});
      }
      out.push_back(std::move(c));
    }
  }
  return out;
}

}  // namespace

Candidate with_priors(Candidate c, const DiagnosisCase& given) {
  for (std::size_t t = 0; t < c.effects.size(); ++t) {
    const auto found = given.amplitude_sd.find(effect_entries()[static_cast<std::size_t>(c.effects[t])].id);
    if (found != given.amplitude_sd.end()) c.terms[t].sd = found->second;
  }
  return c;
}

Candidate nominal_candidate() { return {"none", {}, {}, "", ""}; }

Candidate effect_candidate(int entry) {
  const EffectEntry& e = effect_entries()[static_cast<std::size_t>(entry)];
  return {e.id, {{input_of_effect(entry), {}, e.lower - e.off, e.upper - e.off, e.typical - e.off}}, {entry}, "", ""};
}

Candidate pair_candidate(int a, int b) {
  Candidate c = effect_candidate(a), d = effect_candidate(b);
  c.id += "+" + d.id;
  c.terms.push_back(d.terms[0]);
  c.effects.push_back(b);
  return c;
}

std::vector<Candidate> drift_candidates(const std::vector<Run>& runs, bool order_known) {
  std::vector<Candidate> out;
  for (const Variable& v : variables()) {
    const std::size_t n = levels(runs, v);
    if (n < 2 || (!order_known && std::string(v.name) == "order")) continue;
    const bool slip = std::string(v.name) == "slip";
    const std::size_t count = slip ? std::min<std::size_t>(n - 1, 4) : std::min<std::size_t>(n - 1, 3);
    const auto basis = shapes(runs, v, count, slip);
    for (const Through& p : throughs()) {
      const std::string name = v.name, through = p.name;
      const bool one = count == 1;
      if (name == "pass" && (through == "k" || through == "phi")) continue;
      if (one && name == "omega_rad_s" && through == "torque") continue;
      if (one && name == "load_N" && (through == "torque" || through == "sinkage" || through == "K")) continue;
      Candidate c{through + " drifts with " + name, {}, {}, name, through};
      for (const Eigen::VectorXd& b : basis) c.terms.push_back({p.input, b, -p.reach, p.reach, 0.05 * p.reach});
      out.push_back(std::move(c));
    }
  }
  if (order_known)
    for (Candidate& c : periodic_candidates(runs)) out.push_back(std::move(c));
  return out;
}

std::vector<int> visible_effects(const DiagnosisCase& c, const RunTable& t, const std::vector<Run>& runs) {
  bool second = false;
  for (const Run& r : runs) second = second || r.pass >= 2;
  std::vector<int> out;
  for (const std::string& id : c.effects) {
    const int e = entry_of(id);
    if (std::any_of(c.known.begin(), c.known.end(), [&](const KnownEffect& k) { return k.id == id; })) continue;
    if (!second && (id == "repetitive_loading" || id == "pass_strength")) continue;
    if (id == "preparation_drift" && !t.has_order) continue;  // the order of the rows says nothing
    if (!t.has_omega && (id == "torque_viscous")) continue;
    out.push_back(e);
  }
  return out;
}

ScoreTable::ScoreTable(const Series& s, const Candidate& base, const Fit& fit, const Whitener& w,
                       const std::vector<Candidate>& others)
    : others_(others) {
  Eigen::MatrixXd all;
  std::vector<double> theta = fit.theta;
  if (!s.all_slopes(base, fit.x, theta, all)) return;
  Eigen::Index count = 0;
  for (const Candidate& c : others) {
    columns_.emplace_back();
    for (std::size_t k = 0; k < c.terms.size(); ++k) columns_.back().push_back(count++);
  }
  Eigen::MatrixXd Q(s.layout().size(), count);
  for (std::size_t c = 0; c < others.size(); ++c)
    for (std::size_t k = 0; k < others[c].terms.size(); ++k) {
      const Term& t = others[c].terms[k];
      Eigen::MatrixXd::ColXpr q = Q.col(columns_[c][k]);
      q = all.col(t.input);
      if (t.shape.size())
        for (int i = 0; i < s.layout().size(); ++i) q[i] *= t.shape[s.layout()[i].run];
    }
  Eigen::MatrixXd A = fit.jacobian, r = fit.residual;
  w.apply(A);
  w.apply(r);
  w.apply(Q);
  Eigen::MatrixXd N = A.transpose() * A;
  Eigen::VectorXd g = A.transpose() * r;
  for (int i = 0; i < s.soil_parameters(); ++i) {
    const Parameter& p = s.parameter(i);
    N(i, i) += 1 / (p.sd * p.sd);
    g[i] -= (fit.x[i] - p.mean) / (p.sd * p.sd);
    // A value on its bound stays there.
    if (fit.x[i] <= p.lower + 1e-9 || fit.x[i] >= p.upper - 1e-9) {
      N.row(i).setZero(), N.col(i).setZero(), N(i, i) = 1, g[i] = 0;
      A.col(i).setZero();
    }
  }
  for (std::size_t t = 0; t < base.terms.size(); ++t) {
    const double sd = base.terms[t].sd;
    const Eigen::Index i = s.soil_parameters() + static_cast<Eigen::Index>(t);
    if (sd > 0) N(i, i) += 1 / (sd * sd), g[i] -= fit.x[i] / (sd * sd);
  }
  const Eigen::MatrixXd B = A.transpose() * Q;
  const Eigen::LDLT<Eigen::MatrixXd> solver(N);
  turn_ = -solver.solve(B);
  while (static_cast<std::size_t>(singles_) < others.size() &&
         others[static_cast<std::size_t>(singles_)].effects.size() == 1)
    ++singles_;
  S_ = Q.leftCols(singles_).transpose() * Q.leftCols(singles_) +
       B.leftCols(singles_).transpose() * turn_.leftCols(singles_);
  for (const auto& c : columns_) {
    const auto n = static_cast<Eigen::Index>(c.size());
    own_.push_back(Q.middleCols(c[0], n).transpose() * Q.middleCols(c[0], n) +
                   B.middleCols(c[0], n).transpose() * turn_.middleCols(c[0], n));
  }
  t_ = Q.transpose() * r.col(0) - B.transpose() * solver.solve(g);
  ok_ = S_.allFinite() && t_.allFinite();
}

ScoreTable::Score ScoreTable::solve(Eigen::MatrixXd S, const Eigen::VectorXd& t,
                                    const std::vector<const Term*>& terms) const {
  const Eigen::Index n = t.size();
  for (Eigen::Index i = 0; i < n; ++i) {
    const double sd = terms[static_cast<std::size_t>(i)]->sd;
    S(i, i) = S(i, i) * (1 + 1e-9) + (sd > 0 ? 1 / (sd * sd) : 1e-300);
  }
  Score out;
  out.amplitude = S.ldlt().solve(t);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Term& term = *terms[static_cast<std::size_t>(i)];
    const double clipped = std::clamp(out.amplitude[i], term.lower, term.upper);
    if (clipped == out.amplitude[i]) continue;
    out.amplitude[i] = clipped;  // the others follow
    if (n == 2) {
      const Eigen::Index o = 1 - i;
      const Term& other = *terms[static_cast<std::size_t>(o)];
      out.amplitude[o] = std::clamp((t[o] - S(o, i) * clipped) / S(o, o), other.lower, other.upper);
    }
  }
  out.gain = std::max(0.0, t.dot(out.amplitude) - 0.5 * out.amplitude.dot(S * out.amplitude));
  if (!std::isfinite(out.gain)) out.gain = 0;
  return out;
}

ScoreTable::Score ScoreTable::of(std::size_t c) const {
  std::vector<const Term*> terms;
  for (const Term& t : others_[c].terms) terms.push_back(&t);
  return solve(own_[c], t_.segment(columns_[c][0], own_[c].rows()), terms);
}

ScoreTable::Score ScoreTable::of_pair(std::size_t a, std::size_t b) const {
  const Eigen::Index i = columns_[a][0], j = columns_[b][0];
  Eigen::Matrix2d S;
  S << S_(i, i), S_(i, j), S_(j, i), S_(j, j);
  return solve(S, Eigen::Vector2d(t_[i], t_[j]), {&others_[a].terms[0], &others_[b].terms[0]});
}

double ScoreTable::visible(std::size_t c) const {
  const Eigen::Index i = columns_[c][0];
  return std::abs(others_[c].terms[0].start) * std::sqrt(std::max(S_(i, i), 0.0));
}

double ScoreTable::likeness(std::size_t a, std::size_t b) const {
  const Eigen::Index i = columns_[a][0], j = columns_[b][0];
  return std::abs(S_(i, j)) / std::sqrt(std::max(S_(i, i) * S_(j, j), 1e-300));
}

Eigen::VectorXd ScoreTable::base_step(const std::vector<std::size_t>& candidates,
                                      const Eigen::VectorXd& amplitude) const {
  Eigen::VectorXd step = Eigen::VectorXd::Zero(turn_.rows());
  Eigen::Index at = 0;
  for (const std::size_t c : candidates)
    for (std::size_t k = 0; k < columns_[c].size() && at < amplitude.size(); ++k)
      step += turn_.col(columns_[c][k]) * amplitude[at++];
  return step;
}

}  // namespace grouser::diagnosis
