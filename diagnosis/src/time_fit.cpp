// Fit of an account of a series: least squares in whitened residuals, noise from what is left, evidence.
#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>

#include "time_model.h"

namespace grouser::diagnosis {

namespace {
constexpr double largest_rho = 0.99, scale_ln_sd = 0.3;

double correlation(double rho, double gap) { return gap > 0 && rho > 0 ? std::pow(rho, gap) : 0; }
}  // namespace

void TimeModel::whiten(Eigen::MatrixXd& m, const std::array<TimeNoise, channel_count>& noise) const {
  // From the last item to the first, so that each still sees the one before as it was.
  for (auto i = static_cast<Eigen::Index>(items_.size()) - 1; i >= 0; --i) {
    const Item& item = items_[static_cast<std::size_t>(i)];
    const TimeNoise& n = noise[static_cast<std::size_t>(channels_[static_cast<std::size_t>(item.channel)])];
    const double rho = correlation(n.rho, item.gap), own = n.scale * item.sd;
    if (rho > 0) {
      const double before = n.scale * items_[static_cast<std::size_t>(i - 1)].sd;
      m.row(i) = (m.row(i) / own - rho / before * m.row(i - 1)) / std::sqrt(1 - rho * rho);
    } else {
      m.row(i) /= own;
    }
  }
}

double TimeModel::log_determinant(const std::array<TimeNoise, channel_count>& noise) const {
  double sum = 0;
  for (const Item& item : items_) {
    const TimeNoise& n = noise[static_cast<std::size_t>(channels_[static_cast<std::size_t>(item.channel)])];
    const double rho = correlation(n.rho, item.gap);
    sum += 2 * std::log(n.scale * item.sd) + std::log1p(-rho * rho);
  }
  return sum;
}

double TimeModel::noise_penalty(const std::array<TimeNoise, channel_count>& noise) const {
  double sum = 0;
  for (const int ch : channels_)
    if (stated_[static_cast<std::size_t>(ch)])
      sum += std::pow(std::log(noise[static_cast<std::size_t>(ch)].scale) / scale_ln_sd, 2);
  return sum;
}

std::array<TimeNoise, channel_count> TimeModel::noise_of(const Eigen::VectorXd& residual,
                                                         double free_parameters) const {
  std::array<TimeNoise, channel_count> out{};
  const double lost = std::min(free_parameters / static_cast<double>(items_.size()), 0.5);
  for (int k = 0; k < static_cast<int>(channels_.size()); ++k) {
    const auto ch = static_cast<std::size_t>(channels_[static_cast<std::size_t>(k)]);
    double scale = 1;
    // -2 ln likelihood over rho, the scale at its best (mode under its prior where the error was stated).
    const auto cost = [&](double rho) {
      double square = 0, volume = 0, n = 0;
      for (std::size_t i = 0; i < items_.size(); ++i) {
        const Item& item = items_[i];
        if (item.channel != k) continue;
        double e = residual[static_cast<Eigen::Index>(i)] / item.sd;
        const double q = correlation(rho, item.gap);
        if (q > 0) {
          e -= q * residual[static_cast<Eigen::Index>(i) - 1] / items_[i - 1].sd;
          square += e * e / (1 - q * q);
          volume += std::log1p(-q * q);
        } else {
          square += e * e;
        }
        n += 1;
      }
      n *= 1 - lost;
      double ln = 0.5 * std::log(std::max(square / n, 1e-12));
      if (stated_[ch])  // n ln s^2 + square/s^2 + (ln s/sd)^2: Newton in ln s
        for (int step = 0; step < 30; ++step) {
          const double v = square * std::exp(-2 * ln);
          const double slope = 2 * n - 2 * v + 2 * ln / (scale_ln_sd * scale_ln_sd),
                       bend = 4 * v + 2 / (scale_ln_sd * scale_ln_sd);
          ln -= std::clamp(slope / bend, -0.5, 0.5);
        }
      scale = std::exp(ln);
      return 2 * n * ln + square * std::exp(-2 * ln) + volume +
             (stated_[ch] ? ln * ln / (scale_ln_sd * scale_ln_sd) : 0);
    };
    std::uintmax_t steps = 60;
    const double rho = boost::math::tools::brent_find_minima(cost, 0.0, largest_rho, 20, steps).first;
    cost(rho);
    out[ch] = {scale, rho};
  }
  return out;
}

class TimeCost : public ceres::CostFunction {
 public:
  TimeCost(const TimeModel& m, const TimeAccount& a, const std::array<TimeNoise, channel_count>& noise)
      : m_(m), a_(a), noise_(noise), parameters_(m.parameters(a)) {
    mutable_parameter_block_sizes()->push_back(static_cast<int>(parameters_.size()));
    set_num_residuals(static_cast<int>(m.items().size() + parameters_.size()));
  }
  bool Evaluate(double const* const* p, double* residuals, double** jacobians) const override {
    const auto n = static_cast<Eigen::Index>(parameters_.size()), N = static_cast<Eigen::Index>(m_.items().size());
    const Eigen::VectorXd x = Eigen::Map<const Eigen::VectorXd>(p[0], n);
    const bool slopes = jacobians && jacobians[0];
    RowMatrix y;
    Eigen::MatrixXd J;
    if (!m_.predict(a_, x, y, slopes ? &J : nullptr)) return false;
    Eigen::MatrixXd r = m_.item_values(y) - m_.measured();
    m_.whiten(r, noise_);
    Eigen::Map<Eigen::VectorXd> out(residuals, N + n);
    out.head(N) = r;
    for (Eigen::Index i = 0; i < n; ++i)
      out[N + i] = (x[i] - parameters_[static_cast<std::size_t>(i)].mean) / parameters_[static_cast<std::size_t>(i)].sd;
    if (!slopes) return true;
    const auto C = static_cast<Eigen::Index>(m_.channels().size());
    Eigen::MatrixXd D(N, n);
    for (Eigen::Index i = 0; i < N; ++i) {
      const TimeModel::Item& item = m_.items()[static_cast<std::size_t>(i)];
      D.row(i) = J.row(item.row * C + item.channel);
    }
    m_.whiten(D, noise_);
    Eigen::Map<RowMatrix> all(jacobians[0], N + n, n);
    all.setZero();
    all.topRows(N) = D;
    for (Eigen::Index i = 0; i < n; ++i) all(N + i, i) = 1 / parameters_[static_cast<std::size_t>(i)].sd;
    return true;
  }

 private:
  const TimeModel& m_;
  const TimeAccount& a_;
  std::array<TimeNoise, channel_count> noise_;
  std::vector<TimeParameter> parameters_;
};

double TimeModel::objective(const TimeAccount& a, const Eigen::VectorXd& x,
                            const std::array<TimeNoise, channel_count>& noise) const {
  RowMatrix y;
  if (!predict(a, x, y, nullptr)) return std::numeric_limits<double>::infinity();
  Eigen::MatrixXd r = item_values(y) - y_;
  whiten(r, noise);
  double sum = r.squaredNorm();
  const std::vector<TimeParameter> p = parameters(a);
  for (std::size_t i = 0; i < p.size(); ++i)
    sum += std::pow((x[static_cast<Eigen::Index>(i)] - p[i].mean) / p[i].sd, 2);
  return sum;
}

TimeFit TimeModel::fit(const TimeAccount& a, Eigen::VectorXd x, std::array<TimeNoise, channel_count> noise,
                       int rounds) const {
  TimeFit f;
  f.x = std::move(x);
  const std::vector<TimeParameter> p = parameters(a);
  const auto P = static_cast<Eigen::Index>(p.size());
  if (!std::isfinite(objective(a, f.x, noise))) return f;
  for (int round = 0; round < rounds; ++round) {
    if (P > 0) {
      ceres::Problem problem;
      problem.AddResidualBlock(new TimeCost(*this, a, noise), nullptr, f.x.data());
      for (Eigen::Index i = 0; i < P; ++i) {
        const TimeParameter& q = p[static_cast<std::size_t>(i)];
        f.x[i] = std::clamp(f.x[i], q.lower, q.upper);
        if (q.lower > -1e299) problem.SetParameterLowerBound(f.x.data(), static_cast<int>(i), q.lower);
        if (q.upper < 1e299) problem.SetParameterUpperBound(f.x.data(), static_cast<int>(i), q.upper);
      }
      ceres::Solver::Options o;
      o.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
      o.max_num_iterations = round == 0 ? 12 : 6;  // the noise moves the minimum more than the last steps do
      o.function_tolerance = 1e-4;                 // of the sum of squares: 0.05 in ln likelihood for 1000 rows
      o.logging_type = ceres::SILENT;
      o.num_threads = 1;
      o.max_num_consecutive_invalid_steps = 12;
      ceres::Solver::Summary summary;
      ceres::Solve(o, &problem, &summary);
      if (summary.termination_type == ceres::FAILURE) return f;
    }
    RowMatrix y;
    if (!predict(a, f.x, y, nullptr)) return f;
    const auto before = noise;
    noise = noise_of(y_ - item_values(y), 0);
    double moved = 0;
    for (std::size_t c = 0; c < channel_count; ++c)
      moved = std::max(
          {moved, std::abs(noise[c].rho - before[c].rho), std::abs(std::log(noise[c].scale / before[c].scale))});
    if (moved < 0.02) break;
  }
  Eigen::MatrixXd J;
  if (!predict(a, f.x, f.predicted, &J)) return f;
  f.noise = noise;
  Eigen::MatrixXd r = y_ - item_values(f.predicted);
  whiten(r, noise);
  f.chi2 = r.squaredNorm();
  f.penalty = 0;
  double ln_precision = 0;
  const auto N = static_cast<Eigen::Index>(items_.size());
  Eigen::MatrixXd D(N, P);
  for (Eigen::Index i = 0; i < N; ++i) {
    const Item& item = items_[static_cast<std::size_t>(i)];
    D.row(i) = J.row(static_cast<Eigen::Index>(item.row) * static_cast<Eigen::Index>(channels_.size()) + item.channel);
  }
  whiten(D, noise);
  Eigen::MatrixXd A = D.transpose() * D;
  for (Eigen::Index i = 0; i < P; ++i) {
    const TimeParameter& q = p[static_cast<std::size_t>(i)];
    f.penalty += std::pow((f.x[i] - q.mean) / q.sd, 2);
    A(i, i) += 1 / (q.sd * q.sd);
    ln_precision -= 2 * std::log(q.sd);
  }
  f.log_likelihood = -0.5 * (f.chi2 + log_determinant(noise) + f.penalty + noise_penalty(noise));
  double ln_volume = 0;
  if (P > 0) {
    const Eigen::LLT<Eigen::MatrixXd> root(A);
    if (root.info() != Eigen::Success) return f;
    const Eigen::MatrixXd L = root.matrixL();
    ln_volume = 2 * L.diagonal().array().log().sum();
    f.covariance = root.solve(Eigen::MatrixXd::Identity(P, P));
  }
  f.log_evidence = f.log_likelihood + 0.5 * (ln_precision - ln_volume);
  f.ok = std::isfinite(f.log_evidence);
  return f;
}

TimeFit TimeModel::search(const TimeAccount& a, const TimeAccount& base, const TimeFit& from) const {
  // Time scales that the base does not have: a grid, soil as it is; the two best places are refitted.
  std::vector<int> fresh;
  for (const TimeEffect e : {TimeEffect::relaxation_length, TimeEffect::filter, TimeEffect::delay})
    if (a.has(e) && !base.has(e)) fresh.push_back(index_of(a, e));
  const std::vector<TimeParameter> p = parameters(a);
  const Eigen::VectorXd x0 = carried(base, from.x, a);
  struct Place {
    double cost;
    Eigen::VectorXd x;
  };
  std::vector<Place> places{{objective(a, x0, from.noise), x0}};
  if (!fresh.empty()) {
    places.clear();
    const TimeParameter& q = p[static_cast<std::size_t>(fresh[0])];
    constexpr int points = 10;
    for (int i = 0; i < points; ++i) {
      Eigen::VectorXd x = x0;
      // A sixth of the spacing to the upper end.
      const double low = q.lower + std::log(5.0);
      for (const int j : fresh)
        x[j] = p[static_cast<std::size_t>(j)].lower + (low - q.lower) + (q.upper - low) * 0.9 * i / (points - 1.0);
      places.push_back({objective(a, x, from.noise), x});
    }
  }
  // Local minima along the grid.
  std::vector<Place> starts;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const bool left = i == 0 || places[i].cost <= places[i - 1].cost;
    const bool right = i + 1 == places.size() || places[i].cost < places[i + 1].cost;
    if (left && right && std::isfinite(places[i].cost)) starts.push_back(places[i]);
  }
  std::sort(starts.begin(), starts.end(), [](const Place& u, const Place& v) { return u.cost < v.cost; });
  if (starts.size() > 2) starts.resize(2);
  TimeFit best;
  for (const Place& s : starts) {
    TimeFit f = fit(a, s.x, from.noise);
    if (f.ok && (!best.ok || f.log_evidence > best.log_evidence)) best = std::move(f);
  }
  return best;
}

}  // namespace grouser::diagnosis
