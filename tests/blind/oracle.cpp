#include "oracle.h"

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

OracleAnswer oracle(const Wheel& wheel, const Priors& priors, const std::vector<Observation>& noisy,
                    const SoilVector& truth, const Amplitudes& hidden) {
  const auto rows = static_cast<Eigen::Index>(noisy.size());
  const Soil soil = soil_of(priors, truth);
  const std::vector<Condition> runs = runs_of(noisy);
  std::vector<Eigen::Matrix3d> whitener(noisy.size());
  for (std::size_t i = 0; i < noisy.size(); ++i) whitener[i] = noisy[i].weight.llt().matrixU();
  const auto whitened = [&](const std::vector<Eigen::Vector3d>& a, const std::vector<Eigen::Vector3d>& b,
                            double scale) {
    Eigen::VectorXd out(3 * rows);
    for (Eigen::Index i = 0; i < rows; ++i) {
      const auto at = static_cast<std::size_t>(i);
      out.segment<3>(3 * i) = whitener[at] * (a[at] - b[at]) / scale;
    }
    return out;
  };
  const std::vector<Eigen::Vector3d> nominal = simulate_all(wheel, soil, {}, runs);
  std::vector<Eigen::Vector3d> seen;
  for (const Observation& o : noisy) seen.push_back(o.y);
  Projection p{Eigen::MatrixXd(3 * rows, kSoilParameters), {}};
  std::map<std::pair<double, double>, Slopes> known;
  for (Eigen::Index i = 0; i < rows; ++i) {
    const Condition& r = runs[static_cast<std::size_t>(i)];
    auto found = known.find({r.slip, r.load});
    if (found == known.end()) {
      Condition plain = r;
      plain.ln_k_shift = plain.phi_shift = 0;
      found = known.emplace(std::pair{r.slip, r.load}, slopes(wheel, priors, truth, {}, plain, {}, 0.5)).first;
    }
    p.slopes.middleRows<3>(3 * i) = whitener[static_cast<std::size_t>(i)] * found->second.by;
  }
  p.inner = (Eigen::Matrix<double, 7, 7>::Identity() + p.slopes.transpose() * p.slopes).inverse();
  const Eigen::VectorXd left = p.apply(whitened(seen, nominal, 1.0) + p.slopes * truth);

  OracleAnswer out;
  for (int e = 0; e < kLibraryEffects; ++e) {
    const Effect& entry = effects()[static_cast<std::size_t>(e)];
    const double A = entry.typical, sign = entry.signs < 0 ? -1.0 : 1.0;
    double ln_b = -std::numeric_limits<double>::infinity(),
           x = hidden[entry.id] != 0 ? hidden[entry.id] : sign * 0.2 * entry.typical;
    for (int refinement = 0; refinement < 2; ++refinement) {
      Amplitudes with;
      with[entry.id] = x;
      try {
        const Eigen::VectorXd g = whitened(simulate_all(wheel, soil, with, runs), nominal, x);
        const double q = g.dot(p.apply(g)), s = g.dot(left);
        const double gain = A * A * s / (1.0 + A * A * q), bounded = within_bounds(entry.id, gain);
        // Beyond its bounds an effect has only what the bound gives.
        ln_b = -0.5 * std::log1p(A * A * q) + bounded * s - 0.5 * bounded * bounded * (q + 1.0 / (A * A));
        if (hidden[entry.id] != 0 || std::abs(bounded) < 1e-3 * A) break;
        x = bounded;
      } catch (const std::runtime_error&) {
        break;
      }
    }
    out.ln_bayes.push_back(ln_b);
  }
  std::size_t best = 0;
  for (std::size_t e = 1; e < out.ln_bayes.size(); ++e)
    if (out.ln_bayes[e] > out.ln_bayes[best]) best = e;
  double next = -std::numeric_limits<double>::infinity();
  for (std::size_t e = 0; e < out.ln_bayes.size(); ++e)
    if (e != best) next = std::max(next, out.ln_bayes[e]);
  out.top = effects()[best].name;
  out.ln_over_next = out.ln_bayes[best] - next;
  out.would_name = out.ln_over_next > std::log(10.0) && out.ln_bayes[best] > std::log(10.0);
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
