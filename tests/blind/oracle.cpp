#include "oracle.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <tuple>

namespace blind {
namespace {

std::vector<Condition> runs_of(const std::vector<Observation>& rows) {
  std::vector<Condition> out;
  for (const Observation& o : rows) out.push_back(o.run);
  return out;
}

double within_bounds(Id id, double x) {
  const auto [low, high] = bounds(id);
  return std::clamp(x, low, high);
}

struct Projection {
  Eigen::MatrixXd slopes;             // whitened J
  Eigen::Matrix<double, 7, 7> inner;  // (1 + J'J)^-1
  Eigen::VectorXd apply(const Eigen::VectorXd& v) const { return v - slopes * (inner * (slopes.transpose() * v)); }
};

}  // namespace

std::vector<Eigen::Vector3d> simulate_all(const Wheel& wheel, const Soil& soil, const Amplitudes& x,
                                          const std::vector<Condition>& runs, Numerics numerics) {
  using Key = std::tuple<double, double, double, int, double, double, double>;
  const unsigned uses = x.uses();
  std::map<Key, Eigen::Vector3d> known;
  std::vector<Eigen::Vector3d> out;
  for (const Condition& r : runs) {
    const Key key{r.slip,
                  r.load,
                  uses & uses_speed ? r.omega : 0.0,
                  uses & uses_pass ? r.pass : 0,
                  uses & uses_order ? r.order_share : 0.0,
                  r.ln_k_shift,
                  r.phi_shift};
    auto found = known.find(key);
    if (found == known.end()) found = known.emplace(key, vector_of(simulate(wheel, soil, x, r, numerics))).first;
    out.push_back(found->second);
  }
  return out;
}

namespace {

/// The data at the true soil: whitened, with all that the soil can absorb taken out.
class Bench {
 public:
  Bench(const Wheel& wheel, const Priors& priors, const std::vector<Observation>& noisy, const SoilVector& truth)
      : wheel_(wheel), soil_(soil_of(priors, truth)), runs_(runs_of(noisy)), whitener_(noisy.size()) {
    const auto rows = static_cast<Eigen::Index>(noisy.size());
    for (std::size_t i = 0; i < noisy.size(); ++i) whitener_[i] = noisy[i].weight.llt().matrixU();
    nominal_ = simulate_all(wheel, soil_, {}, runs_);
    std::vector<Eigen::Vector3d> seen;
    for (const Observation& o : noisy) seen.push_back(o.y);
    p_.slopes.resize(3 * rows, kSoilParameters);
    std::map<std::pair<double, double>, Slopes> known;
    for (Eigen::Index i = 0; i < rows; ++i) {
      const Condition& r = runs_[static_cast<std::size_t>(i)];
      auto found = known.find({r.slip, r.load});
      if (found == known.end()) {
        Condition plain = r;
        plain.ln_k_shift = plain.phi_shift = 0;
        found = known.emplace(std::pair{r.slip, r.load}, slopes(wheel, priors, truth, {}, plain, {}, 0.5)).first;
      }
      p_.slopes.middleRows<3>(3 * i) = whitener_[static_cast<std::size_t>(i)] * found->second.by;
    }
    p_.inner = (Eigen::Matrix<double, 7, 7>::Identity() + p_.slopes.transpose() * p_.slopes).inverse();
    left_ = p_.apply(whitened(seen, nominal_) + p_.slopes * truth);
  }
  std::vector<Eigen::Vector3d> run(const Amplitudes& x) const { return simulate_all(wheel_, soil_, x, runs_); }
  const std::vector<Eigen::Vector3d>& nominal() const { return nominal_; }
  const Eigen::VectorXd& left() const { return left_; }
  Eigen::VectorXd projected(const Eigen::VectorXd& v) const { return p_.apply(v); }
  Eigen::VectorXd whitened(const std::vector<Eigen::Vector3d>& a, const std::vector<Eigen::Vector3d>& b) const {
    Eigen::VectorXd out(3 * static_cast<Eigen::Index>(a.size()));
    for (std::size_t i = 0; i < a.size(); ++i)
      out.segment<3>(3 * static_cast<Eigen::Index>(i)) = whitener_[i] * (a[i] - b[i]);
    return out;
  }

 private:
  const Wheel& wheel_;
  Soil soil_;
  std::vector<Condition> runs_;
  std::vector<Eigen::Matrix3d> whitener_;
  std::vector<Eigen::Vector3d> nominal_;
  Projection p_;
  Eigen::VectorXd left_;
};

constexpr double kNothing = -std::numeric_limits<double>::infinity();

/// Evidence of one effect: ln Bayes factor and the fingerprint per unit of amplitude at its size.
struct Single {
  double ln_bayes = kNothing, x = 0;
  Eigen::VectorXd g;
};
Single single(const Bench& bench, const Effect& entry, double hidden) {
  const double A = entry.typical, sign = entry.signs < 0 ? -1.0 : 1.0;
  Single out;
  out.x = hidden != 0 ? hidden : sign * 0.2 * entry.typical;
  for (int refinement = 0; refinement < 2; ++refinement) {
    Amplitudes with;
    with[entry.id] = out.x;
    try {
      out.g = bench.whitened(bench.run(with), bench.nominal()) / out.x;
      const double q = out.g.dot(bench.projected(out.g)), s = out.g.dot(bench.left());
      const double gain = A * A * s / (1.0 + A * A * q), bounded = within_bounds(entry.id, gain);
      // Beyond its bounds an effect has only what the bound gives.
      out.ln_bayes = -0.5 * std::log1p(A * A * q) + bounded * s - 0.5 * bounded * bounded * (q + 1.0 / (A * A));
      if (hidden != 0 || std::abs(bounded) < 1e-3 * A) break;
      out.x = bounded;
    } catch (const std::runtime_error&) {
      break;
    }
  }
  return out;
}

/// Of two effects together; `x`: their amplitudes.
double ln_bayes_of_two(const Effect& a, const Effect& b, const Eigen::Matrix2d& Q, const Eigen::Vector2d& s,
                       Eigen::Vector2d& x) {
  const Eigen::Vector2d A(a.typical, b.typical);
  const Eigen::Matrix2d M = Q + Eigen::Matrix2d((A.cwiseProduct(A)).cwiseInverse().asDiagonal());
  x = M.inverse() * s;
  const Eigen::Vector2d free = x;
  x[0] = within_bounds(a.id, x[0]), x[1] = within_bounds(b.id, x[1]);
  // The other follows one that its bound holds.
  if (x[0] != free[0]) x[1] = within_bounds(b.id, (s[1] - M(1, 0) * x[0]) / M(1, 1));
  if (x[1] != free[1]) x[0] = within_bounds(a.id, (s[0] - M(0, 1) * x[1]) / M(0, 0));
  const Eigen::Matrix2d scaled = A.asDiagonal() * Q * A.asDiagonal();
  return -0.5 * std::log((Eigen::Matrix2d::Identity() + scaled).determinant()) + x.dot(s) - 0.5 * x.dot(M * x);
}

}  // namespace

OracleAnswer oracle(const Wheel& wheel, const Priors& priors, const std::vector<Observation>& noisy,
                    const SoilVector& truth, const Amplitudes& hidden) {
  const Bench bench(wheel, priors, noisy, truth);
  OracleAnswer out;
  for (int e = 0; e < kLibraryEffects; ++e) {
    const Effect& entry = effects()[static_cast<std::size_t>(e)];
    out.ln_bayes.push_back(single(bench, entry, hidden[entry.id]).ln_bayes);
  }
  std::size_t best = 0;
  for (std::size_t e = 1; e < out.ln_bayes.size(); ++e)
    if (out.ln_bayes[e] > out.ln_bayes[best]) best = e;
  double next = kNothing;
  for (std::size_t e = 0; e < out.ln_bayes.size(); ++e)
    if (e != best) next = std::max(next, out.ln_bayes[e]);
  out.top = effects()[best].name;
  out.ln_over_next = out.ln_bayes[best] - next;
  out.would_name = out.ln_over_next > std::log(10.0) && out.ln_bayes[best] > std::log(10.0);
  return out;
}

PairAnswer pair_oracle(const Wheel& wheel, const Priors& priors, const std::vector<Observation>& noisy,
                       const SoilVector& truth, const Amplitudes& hidden) {
  constexpr std::size_t kRefined = 16;
  const Bench bench(wheel, priors, noisy, truth);
  std::vector<Single> one;
  double best_single = kNothing;
  for (int e = 0; e < kLibraryEffects; ++e) {
    const Effect& entry = effects()[static_cast<std::size_t>(e)];
    one.push_back(single(bench, entry, hidden[entry.id]));
    best_single = std::max(best_single, one.back().ln_bayes);
  }
  struct Two {
    std::size_t a, b;
    double ln_bayes;
    Eigen::Vector2d x;
    bool true_one;
  };
  std::vector<Two> pairs;
  std::vector<Eigen::VectorXd> projected(one.size());
  for (std::size_t e = 0; e < one.size(); ++e)
    if (std::isfinite(one[e].ln_bayes)) projected[e] = bench.projected(one[e].g);
  for (std::size_t a = 0; a < one.size(); ++a)
    for (std::size_t b = a + 1; b < one.size(); ++b) {
      if (!std::isfinite(one[a].ln_bayes) || !std::isfinite(one[b].ln_bayes)) continue;
      Eigen::Matrix2d Q;
      const double cross = one[a].g.dot(projected[b]);
      Q << one[a].g.dot(projected[a]), cross, cross, one[b].g.dot(projected[b]);
      const Eigen::Vector2d s(one[a].g.dot(bench.left()), one[b].g.dot(bench.left()));
      const bool true_one = hidden[effects()[a].id] != 0 && hidden[effects()[b].id] != 0;
      Two t{a, b, 0, {}, true_one};
      t.ln_bayes = ln_bayes_of_two(effects()[a], effects()[b], Q, s, t.x);
      pairs.push_back(t);
    }
  const auto better = [](const Two& x, const Two& y) { return x.ln_bayes > y.ln_bayes; };
  std::stable_sort(pairs.begin(), pairs.end(), better);
  // The best, and the true one, with the fingerprints that they have beside each other.
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    Two& t = pairs[i];
    if (i >= kRefined && !t.true_one) continue;
    const Effect &a = effects()[t.a], &b = effects()[t.b];
    for (int refinement = 0; refinement < (t.true_one ? 1 : 2); ++refinement) {
      const double xa = t.true_one ? hidden[a.id] : t.x[0], xb = t.true_one ? hidden[b.id] : t.x[1];
      if (std::abs(xa) < 1e-3 * a.typical || std::abs(xb) < 1e-3 * b.typical) break;
      try {
        Amplitudes second, both;
        second[b.id] = both[b.id] = xb, both[a.id] = xa;
        const auto with_second = bench.run(second);
        const Eigen::VectorXd ga = bench.whitened(bench.run(both), with_second) / xa,
                              gb = bench.whitened(with_second, bench.nominal()) / xb;
        const Eigen::VectorXd pa = bench.projected(ga), pb = bench.projected(gb);
        Eigen::Matrix2d Q;
        Q << ga.dot(pa), ga.dot(pb), ga.dot(pb), gb.dot(pb);
        t.ln_bayes = ln_bayes_of_two(a, b, Q, {ga.dot(bench.left()), gb.dot(bench.left())}, t.x);
      } catch (const std::runtime_error&) {
        break;
      }
    }
  }
  if (pairs.size() > kRefined)  // what was not refined is no better than a slope
    std::erase_if(pairs, [&, i = std::size_t{0}](const Two& t) mutable { return i++ >= kRefined && !t.true_one; });
  std::stable_sort(pairs.begin(), pairs.end(), better);
  PairAnswer out;
  if (pairs.empty()) return out;
  out.top = std::string(effects()[pairs[0].a].name) + "+" + std::string(effects()[pairs[0].b].name);
  out.first = pairs[0].true_one;
  out.ln_over_next = pairs[0].ln_bayes - std::max(best_single, pairs.size() > 1 ? pairs[1].ln_bayes : kNothing);
  out.would_name = out.ln_over_next > std::log(10.0);
  return out;
}

std::vector<Id> exact_class(const Wheel& wheel, const std::vector<Observation>& rows, const Soil& soil, Id hidden,
                            double x) {
  const std::vector<Condition> runs = runs_of(rows);
  const std::vector<Eigen::Vector3d> nominal = simulate_all(wheel, soil, {}, runs);
  const auto fingerprint = [&](Id id, double amplitude) {
    Amplitudes with;
    with[id] = amplitude;
    const std::vector<Eigen::Vector3d> y = simulate_all(wheel, soil, with, runs);
    Eigen::VectorXd out(3 * static_cast<Eigen::Index>(rows.size()));
    for (std::size_t i = 0; i < rows.size(); ++i)
      out.segment<3>(3 * static_cast<Eigen::Index>(i)) =
          rows[i].weight.diagonal().cwiseSqrt().asDiagonal() * (y[i] - nominal[i]);
    return out;
  };
  const Eigen::VectorXd target = fingerprint(hidden, x);
  std::vector<Id> out{hidden};
  for (int e = 0; e < kLibraryEffects; ++e) {
    const Effect& rival = effects()[static_cast<std::size_t>(e)];
    if (rival.id == hidden) continue;
    try {
      const double probe = (rival.signs < 0 ? -0.01 : 0.01) * rival.typical;
      const Eigen::VectorXd g = fingerprint(rival.id, probe);
      const double cosine = g.dot(target) / (g.norm() * target.norm() + 1e-300);
      if (std::abs(cosine) < 1.0 - 1e-7) continue;
      const double needed = probe * g.dot(target) / g.squaredNorm();
      const auto [low, high] = bounds(rival.id);
      if (needed >= low && needed <= high) out.push_back(rival.id);
    } catch (const std::runtime_error&) {
      continue;
    }
  }
  return out;
}

}  // namespace blind
