#include "soil_test_fit.h"

#include <nlopt.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <memory>
#include <random>
#include <set>


namespace grouser::diagnosis {
namespace {

constexpr double noise_prior_dof = 10, tail = 5;
constexpr int rounds = 3, round_draws = 1500, last_draws = 6000, kept_draws = 500, starts = 6;

SoilTestCoordinate normal_coordinate(const GrainCoordinate& g, const SoilPrior& prior, std::array<double, 2> range) {
  return {g.key, g.unit, true, range[0], range[1], prior.mean, prior.sd};
}

SoilTestCoordinate even_coordinate(const SoilTestEffect& e) {
  return {e.id, e.unit, e.logarithmic, e.lower, e.upper, 0, 0};
}

/// Draws of Student's t with `tail` degrees of freedom, and the ln density of that.
struct Proposal {
  Eigen::VectorXd centre;
  Eigen::MatrixXd root;
  double ln_scale = 0;
  Proposal(Eigen::VectorXd c, const Eigen::MatrixXd& covariance) : centre(std::move(c)) {
    Eigen::MatrixXd V = covariance;
    V.diagonal() *= 1 + 1e-6;
    V.diagonal().array() += 1e-12;
    root = Eigen::LLT<Eigen::MatrixXd>(V).matrixL();
    const double d = static_cast<double>(centre.size());
    ln_scale = std::lgamma(0.5 * (tail + d)) - std::lgamma(0.5 * tail) -
               0.5 * d * std::log(tail * 3.14159265358979323846) - root.diagonal().array().log().sum();
  }
  Eigen::VectorXd draw(std::mt19937_64& random) const {
    std::normal_distribution<double> normal;
    std::chi_squared_distribution<double> chi(tail);
    Eigen::VectorXd e(centre.size());
    for (Eigen::Index i = 0; i < e.size(); ++i) e[i] = normal(random);
    return centre + root * e * std::sqrt(tail / chi(random));
  }
  double ln_density(const Eigen::VectorXd& x) const {
    const double d = static_cast<double>(centre.size());
    const double q = root.triangularView<Eigen::Lower>().solve(x - centre).squaredNorm();
    return ln_scale - 0.5 * (tail + d) * std::log1p(q / tail);
  }
};

}  // namespace

SoilTestFits::SoilTestFits(const SoilTestModel& model, const SoilTestCase& c,
                           const std::vector<SoilTestCondition>& conditions, bool rise)
    : model_(model), case_(c) {
  std::array<double, 2> squares{}, dof{};
  for (const SoilTestCondition& condition : conditions) {
    SoilTestValues v{condition, {}, Eigen::VectorXd::Zero(model.outputs(condition.kind))};
    for (const SoilTestCurve& curve : condition.curves) {
      v.repeats.push_back(soil_test_outputs(condition.kind, curve, rise));
      v.mean += v.repeats.back();
    }
    v.mean /= static_cast<double>(v.repeats.size());
    const auto k = static_cast<std::size_t>(condition.kind);
    const Eigen::LLT<Eigen::MatrixXd> S(model.scatter(condition.kind));
    for (const Eigen::VectorXd& y : v.repeats)
      squares[k] += Eigen::VectorXd(S.matrixL().solve(y - v.mean)).squaredNorm();
    dof[k] += static_cast<double>((v.repeats.size() - 1) * static_cast<std::size_t>(v.mean.size()));
    size_ += static_cast<int>(v.mean.size());
    values_.push_back(std::move(v));
  }
  for (const std::size_t k : {0U, 1U}) {
    lambda_[k] = (squares[k] + noise_prior_dof) / (dof[k] + noise_prior_dof);
    dof_[k] = dof[k] + noise_prior_dof;
  }
  y_.resize(size_);
  Eigen::Index at = 0;
  for (const SoilTestValues& v : values_) y_.segment(at, v.mean.size()) = v.mean, at += v.mean.size();
}

std::vector<SoilTestAccount> SoilTestFits::accounts() const {
  std::vector<SoilTestAccount> out;
  const auto start = [&](const std::string& id, RollingLaw law) {
    SoilTestAccount a;
    a.id = id, a.law = law;
    for (int i = 0; i < (law == RollingLaw::rate ? 2 : grain_count); ++i)
      a.coordinates.push_back(normal_coordinate(grain_coordinates()[static_cast<std::size_t>(i)],
                                                case_.soil[static_cast<std::size_t>(i)], model_.range(law, i)));
    return a;
  };
  out.push_back(start("none", RollingLaw::constant));
  for (int e = 0; e < static_cast<int>(soil_test_effects().size()); ++e) {
    const SoilTestEffect& known = soil_test_effects()[static_cast<std::size_t>(e)];
    if (std::find(case_.effects.begin(), case_.effects.end(), known.id) == case_.effects.end()) continue;
    SoilTestAccount a = start(known.id, e == 0 ? RollingLaw::rate : RollingLaw::constant);
    a.named = true, a.effect = e;
    a.coordinates.push_back(even_coordinate(known));
    out.push_back(std::move(a));
  }
  // Outside the list: the stress of one kind of test drifts with what varies there.
  for (const SoilTestKind kind : {SoilTestKind::shear, SoilTestKind::plate}) {
    std::set<double> pressures, speeds;
    bool other = false, some = false;
    for (const SoilTestValues& v : values_) {
      (v.condition.kind == kind ? some : other) = true;
      if (v.condition.kind != kind) continue;
      pressures.insert(std::log(v.condition.normal_stress)), speeds.insert(std::log(v.condition.speed));
    }
    if (!some) continue;
    const char* through = kind == SoilTestKind::shear ? "shear stress" : "plate pressure";
    struct Way {
      const char* variable;
      bool there;
    };
    for (const Way& way : {Way{"test", other && kind == SoilTestKind::shear}, Way{"displacement", true},
                           Way{"normal_stress_Pa", pressures.size() > 1}, Way{"speed_mm_s", speeds.size() > 1}}) {
      if (!way.there) continue;
      SoilTestAccount a = start(std::string(through) + " drifts with " + way.variable, RollingLaw::constant);
      a.variable = way.variable, a.through = through;
      const std::string variable = way.variable;
      const auto centred = [](const std::set<double>& all, double x) {
        const double low = *all.begin(), high = *all.rbegin();
        return 2 * (x - low) / (high - low) - 1;
      };
      const bool two = variable == "displacement";
      for (const SoilTestValues& v : values_) {
        Eigen::MatrixXd D = Eigen::MatrixXd::Zero(v.mean.size(), two ? 2 : 1);
        if (v.condition.kind == kind) {
          if (two)
            D(0, 0) = -1, D(2, 0) = 1, D(0, 1) = D(2, 1) = 0.5, D(1, 1) = -1;
          else
            D.col(0).head(3).setConstant(variable == "test" ? 1
                                         : variable == "speed_mm_s"
                                             ? centred(speeds, std::log(v.condition.speed))
                                             : centred(pressures, std::log(v.condition.normal_stress)));
        }
        a.drift.push_back(std::move(D));
      }
      out.push_back(std::move(a));
    }
  }
  return out;
}

/// Coordinates of the model: those of the account, amounts of effects in their places.
Eigen::VectorXd SoilTestFits::full(const SoilTestAccount& a, const Eigen::VectorXd& x) const {
  if (a.effect <= 0) return x;
  Eigen::VectorXd y(grain_count + nested_effects);
  y.head(grain_count) = x.head(grain_count);
  for (int e = 1; e <= nested_effects; ++e)
    y[grain_count + e - 1] = e == a.effect ? x[grain_count] : soil_test_effects()[static_cast<std::size_t>(e)].off;
  return y;
}

Eigen::VectorXd SoilTestFits::predict(const SoilTestAccount& a, const Eigen::VectorXd& x, const SoilTestCondition& c,
                                      Eigen::MatrixXd* error) const {
  const Eigen::VectorXd h = model_.features(a.law, c, full(a, x));
  if (h.size() == 0) return {};
  const Emulator& e = model_.emulator(a.law, c.kind);
  if (error) *error = e.share(h, h) * e.scatter();
  return e.mean(h);
}

Eigen::VectorXd SoilTestFits::stacked(const SoilTestAccount& a, const Eigen::VectorXd& x) const {
  Eigen::VectorXd out(size_);
  Eigen::Index at = 0;
  for (const SoilTestValues& v : values_) {
    const Eigen::VectorXd y = predict(a, x, v.condition);
    if (y.size() == 0) return {};
    out.segment(at, y.size()) = y, at += y.size();
  }
  return out;
}

SoilTestFits::Said SoilTestFits::likelihood(const SoilTestAccount& a, const Eigen::VectorXd& x,
                                            const Eigen::VectorXd& y) const {
  Said said;
  const Eigen::VectorXd at_full = full(a, x);
  std::vector<Eigen::VectorXd> h;
  Eigen::VectorXd r(size_);
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(size_, size_);
  Eigen::Index at = 0;
  for (std::size_t i = 0; i < values_.size(); ++i) {
    const SoilTestKind kind = values_[i].condition.kind;
    const Emulator& e = model_.emulator(a.law, kind);
    h.push_back(model_.features(a.law, values_[i].condition, at_full));
    if (h.back().size() == 0) return said;
    const Eigen::Index m = e.outputs();
    r.segment(at, m) = y.segment(at, m) - e.mean(h.back());
    C.block(at, at, m, m) +=
        repeat_scatter(kind) / static_cast<double>(values_[i].repeats.size()) + fixed_scatter(kind);
    Eigen::Index other = 0;
    for (std::size_t j = 0; j <= i; ++j) {
      const Eigen::Index n = values_[j].mean.size();
      Eigen::MatrixXd block = Eigen::MatrixXd::Zero(m, n);
      if (values_[j].condition.kind == kind) block = e.share(h[i], h[j]) * e.scatter();
      if (!a.drift.empty()) block += drift_sd * drift_sd * a.drift[i] * a.drift[j].transpose();
      C.block(at, other, m, n) += block;
      if (j < i) C.block(other, at, n, m) += block.transpose();
      other += n;
    }
    at += m;
  }
  const Eigen::LLT<Eigen::MatrixXd> L(C);
  if (L.info() != Eigen::Success) return said;
  said.chi2 = Eigen::VectorXd(L.matrixL().solve(r)).squaredNorm();
  const double ln_det = 2 * Eigen::MatrixXd(L.matrixL()).diagonal().array().log().sum();
  said.ln_likelihood = -0.5 * (said.chi2 + ln_det + static_cast<double>(size_) * std::log(2 * 3.14159265358979323846));
  said.ok = std::isfinite(said.ln_likelihood);
  return said;
}

double SoilTestFits::ln_prior(const SoilTestAccount& a, const Eigen::VectorXd& x) const {
  double sum = 0;
  for (std::size_t i = 0; i < a.coordinates.size(); ++i)
    sum += a.coordinates[i].ln_prior(x[static_cast<Eigen::Index>(i)]);
  return sum;
}

Eigen::VectorXd SoilTestFits::maximum(const SoilTestAccount& a, const Eigen::VectorXd& y, bool determinant) const {
  const std::size_t n = a.coordinates.size();
  std::vector<double> lower(n), upper(n), step(n);
  for (std::size_t i = 0; i < n; ++i) {
    const SoilTestCoordinate& c = a.coordinates[i];
    lower[i] = c.lower, upper[i] = c.upper;
    step[i] = c.sd > 0 ? std::min(0.5 * c.sd, 0.2 * (c.upper - c.lower)) : 0.15 * (c.upper - c.lower);
  }
  auto cost = [&](const std::vector<double>& v) {
    const Eigen::VectorXd x = Eigen::Map<const Eigen::VectorXd>(v.data(), static_cast<Eigen::Index>(n));
    const Said said = likelihood(a, x, y);
    const double prior = ln_prior(a, x);
    if (!said.ok || !std::isfinite(prior)) return 1e10;
    return determinant ? -said.ln_likelihood - prior : 0.5 * said.chi2 - prior;
  };
  using Cost = decltype(cost);
  const auto objective = [](unsigned count, const double* v, double*, void* f) {
    return (*static_cast<Cost*>(f))(std::vector<double>(v, v + count));
  };
  std::vector<double> best;
  double least = 1e10;
  for (int s = 0; s < starts; ++s) {
    std::vector<double> x(n);
    for (std::size_t i = 0; i < n; ++i) {  // spread over the middle of the ranges: a Kronecker sequence
      const SoilTestCoordinate& c = a.coordinates[i];
      const double u = std::fmod(0.5 + s * (0.618034 + 0.137 * static_cast<double>(i)), 1.0);
      x[i] = c.sd > 0 ? c.mean + 2 * c.sd * (u - 0.5) * (s > 0) : c.lower + (c.upper - c.lower) * (0.1 + 0.8 * u);
      x[i] = std::clamp(x[i], lower[i], upper[i]);
    }
    const std::unique_ptr<nlopt_opt_s, decltype(&nlopt_destroy)> opt(
        nlopt_create(NLOPT_LN_SBPLX, static_cast<unsigned>(n)), nlopt_destroy);
    nlopt_set_lower_bounds(opt.get(), lower.data());
    nlopt_set_upper_bounds(opt.get(), upper.data());
    nlopt_set_initial_step(opt.get(), step.data());
    nlopt_set_min_objective(opt.get(), objective, &cost);
    nlopt_set_xtol_rel(opt.get(), 1e-5);
    nlopt_set_maxeval(opt.get(), 600);
    double f = 1e10;
    nlopt_optimize(opt.get(), x.data(), &f);
    if (f < least) least = f, best = x;
  }
  if (best.empty()) return {};
  return Eigen::Map<Eigen::VectorXd>(best.data(), static_cast<Eigen::Index>(n));
}

double SoilTestFits::best_objective(const SoilTestAccount& a, const Eigen::VectorXd& y) const {
  const Eigen::VectorXd x = maximum(a, y, false);
  if (x.size() == 0) return INFINITY;
  double penalty = 0;
  for (std::size_t i = 0; i < a.coordinates.size(); ++i)
    if (a.coordinates[i].sd > 0)
      penalty += std::pow((x[static_cast<Eigen::Index>(i)] - a.coordinates[i].mean) / a.coordinates[i].sd, 2);
  return likelihood(a, x, y).chi2 + penalty;
}

SoilTestPosterior SoilTestFits::posterior(const SoilTestAccount& a) const {
  SoilTestPosterior out;
  out.best = maximum(a, y_, true);
  if (out.best.size() == 0) return out;
  const Said said = likelihood(a, out.best, y_);
  out.ln_likelihood = said.ln_likelihood, out.chi2 = said.chi2;
  const double dof = size_ - static_cast<double>(a.coordinates.size());
  if (dof >= 1)
    out.p = boost::math::cdf(
        boost::math::complement(boost::math::fisher_f(dof, noise_dof()), std::max(said.chi2, 0.0) / dof));
  // First proposal: a third of what is known before the data, in each direction; the rounds adapt it.
  const auto n = static_cast<Eigen::Index>(a.coordinates.size());
  Eigen::MatrixXd V = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const SoilTestCoordinate& c = a.coordinates[static_cast<std::size_t>(i)];
    V(i, i) = std::pow(c.sd > 0 ? 0.5 * c.sd : (c.upper - c.lower) / 12, 2);
  }
  Eigen::VectorXd centre = out.best;
  std::mt19937_64 random(20101);
  for (int round = 0; round <= rounds; ++round) {
    const Proposal proposal(centre, V);
    const int count = round == rounds ? last_draws : round_draws;
    Eigen::MatrixXd x(n, count);
    std::vector<double> ln_w(static_cast<std::size_t>(count), -INFINITY);
    double top = -INFINITY;
    for (int k = 0; k < count; ++k) {
      x.col(k) = proposal.draw(random);
      const double prior = ln_prior(a, x.col(k));
      if (!std::isfinite(prior)) continue;
      const Said s = likelihood(a, x.col(k), y_);
      if (!s.ok) continue;
      double& w = ln_w[static_cast<std::size_t>(k)];
      w = s.ln_likelihood + prior - proposal.ln_density(x.col(k));
      top = std::max(top, w);
    }
    if (!std::isfinite(top)) return out;
    double sum = 0, squares = 0;
    Eigen::VectorXd mean = Eigen::VectorXd::Zero(n);
    std::vector<double> w(ln_w.size());
    for (std::size_t k = 0; k < w.size(); ++k) {
      w[k] = std::exp(ln_w[k] - top);
      sum += w[k], squares += w[k] * w[k];
      mean += w[k] * x.col(static_cast<Eigen::Index>(k));
    }
    mean /= sum;
    Eigen::MatrixXd spread = Eigen::MatrixXd::Zero(n, n);
    for (std::size_t k = 0; k < w.size(); ++k) {
      const Eigen::VectorXd d = x.col(static_cast<Eigen::Index>(k)) - mean;
      spread += w[k] / sum * d * d.transpose();
    }
    out.effective = sum * sum / squares;
    out.ln_evidence = top + std::log(sum / count);
    if (round < rounds) {
      centre = mean;
      V = out.effective > 20 ? Eigen::MatrixXd(1.3 * spread) : Eigen::MatrixXd(0.5 * (V + spread));
      continue;
    }
    // Equally likely draws: systematic resampling.
    out.draws.resize(n, kept_draws);
    double passed = w[0];
    std::size_t k = 0;
    for (int i = 0; i < kept_draws; ++i) {
      const double at = (i + 0.5) / kept_draws * sum;
      while (passed < at && k + 1 < w.size()) passed += w[++k];
      out.draws.col(i) = x.col(static_cast<Eigen::Index>(k));
    }
    out.ok = true;
  }
  return out;
}

}  // namespace grouser::diagnosis
