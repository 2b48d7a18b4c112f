#include "noise.h"

#include <nlopt.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <tuple>

namespace grouser::diagnosis {
namespace {

constexpr double bad_share = 0.01, bad_factor = 100;  // of the variance
constexpr double scale_sd = 0.3, omega_k_sd = 0.1, omega_phi_sd = 0.03;

Eigen::MatrixXd covariance(const DataLayout& l, const DataLayout::Group& g, const Noise& noise,
                           const Eigen::MatrixXd& J) {
  const Eigen::Index m = g.count;
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(m, m);
  for (std::size_t k = 0; k < scattered.size(); ++k) {
    const auto j = J.col(static_cast<Eigen::Index>(k)).segment(g.first, m);
    if (noise.omega[k] > 0) C.noalias() += noise.omega[k] * noise.omega[k] * j * j.transpose();
  }
  for (Eigen::Index i = 0; i < m; ++i) {
    const DataLayout::Item& item = l[g.first + static_cast<int>(i)];
    const double s = noise.scale[static_cast<std::size_t>(item.channel)] * item.sd;
    const double w = noise.weight.empty() ? 1 : noise.weight[static_cast<std::size_t>(item.run)];
    C(i, i) += s * s / w;
  }
  return C;
}

/// -2 ln likelihood over scales and omega without factoring each preparation anew. With D the sensors' variances and
/// A = J'D^-1 J, b = J'D^-1 r, q = r'D^-1 r of a preparation, all sums over its channels of 1/scale^2 times what is fixed:
///   r'C^-1 r = q - b'O(1 + O A O)^-1 O b,  ln det C = ln det D + ln det(1 + O A O),  O = diag(omega)   (Woodbury).
class NoiseLikelihood {
 public:
  NoiseLikelihood(const DataLayout& layout, const Eigen::VectorXd& r, const Eigen::MatrixXd& J, const Noise& noise) {
    for (const DataLayout::Group& g : layout.groups()) {
      Sums s;
      for (int i = g.first; i < g.first + g.count; ++i) {
        const DataLayout::Item& item = layout[i];
        const auto c = static_cast<std::size_t>(item.channel);
        const double weight = noise.weight.empty() ? 1 : noise.weight[static_cast<std::size_t>(item.run)],
                     p = weight / (item.sd * item.sd);
        s.A00[c] += p * J(i, 0) * J(i, 0), s.A01[c] += p * J(i, 0) * J(i, 1), s.A11[c] += p * J(i, 1) * J(i, 1);
        s.b0[c] += p * J(i, 0) * r[i], s.b1[c] += p * J(i, 1) * r[i], s.q[c] += p * r[i] * r[i];
        ++count_[c];
        fixed_ -= std::log(p);
      }
      sums_.push_back(s);
    }
  }
  double operator()(const Noise& n) const {
    std::array<double, channel_count> p{};
    double out = fixed_;
    for (std::size_t c = 0; c < channel_count; ++c) {
      p[c] = 1 / (n.scale[c] * n.scale[c]);
      out -= count_[c] * std::log(p[c]);
    }
    const double u = n.omega[0], v = n.omega[1];
    const auto sum = [&](const std::array<double, channel_count>& x) {
      return x[0] * p[0] + x[1] * p[1] + x[2] * p[2];
    };
    double determinant = 1;
    int gathered = 0;
    for (const Sums& s : sums_) {
      out += sum(s.q);
      if (u == 0 && v == 0) continue;
      const double a = 1 + u * u * sum(s.A00), b = u * v * sum(s.A01), d = 1 + v * v * sum(s.A11), det = a * d - b * b;
      const double x = u * sum(s.b0), y = v * sum(s.b1);
      out -= (d * x * x - 2 * b * x * y + a * y * y) / det;
      determinant *= det;
      if (++gathered % 8 == 0) out += std::log(determinant), determinant = 1;
    }
    return out + std::log(determinant);
  }

 private:
  struct Sums {
    std::array<double, channel_count> A00{}, A01{}, A11{}, b0{}, b1{}, q{};
  };
  std::vector<Sums> sums_;
  std::array<double, channel_count> count_{};
  double fixed_ = 0;
};

}  // namespace

DataLayout::DataLayout(const std::vector<Run>& runs, const std::vector<std::array<double, channel_count>>& sd)
    : runs_(static_cast<int>(runs.size())) {
  std::vector<int> order(runs.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return runs[static_cast<std::size_t>(a)].batch < runs[static_cast<std::size_t>(b)].batch;
  });
  int last = -1;
  for (const int r : order) {
    const Run& run = runs[static_cast<std::size_t>(r)];
    for (int c = 0; c < channel_count; ++c) {
      if (!std::isfinite(run.value[static_cast<std::size_t>(c)])) continue;
      if (groups_.empty() || run.batch != last) groups_.push_back({size(), 0});
      last = run.batch;
      ++groups_.back().count;
      items_.push_back({r, c, sd[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)]});
    }
  }
  std::vector<int> along(items_.size());
  std::iota(along.begin(), along.end(), 0);
  const auto run = [&](int i) -> const Run& {
    return runs[static_cast<std::size_t>(items_[static_cast<std::size_t>(i)].run)];
  };
  const auto place = [&](int i) {
    return std::tuple(items_[static_cast<std::size_t>(i)].channel, run(i).order, run(i).time);
  };
  std::stable_sort(along.begin(), along.end(), [&](int a, int b) { return place(a) < place(b); });
  for (std::size_t k = 0; k < along.size(); ++k) {
    if (run(along[k]).line == 0) continue;
    const bool follows = !chain_.empty() && items_[static_cast<std::size_t>(chain_.back()[0])].channel ==
                                                items_[static_cast<std::size_t>(along[k])].channel;
    chain_.push_back({along[k], follows ? chain_.back()[0] : -1});
  }
}

double run_to_run(const DataLayout& layout, const Eigen::VectorXd& u) {
  double square = 0, product = 0, last = 0;
  int n = 0, before = -1;  // differences; the item before the last one
  for (const auto& [item, previous] : layout.chain()) {
    if (previous < 0) {
      before = -1;
      continue;
    }
    const double now = u[item] - u[previous];
    if (before >= 0) product += now * last, square += 0.5 * (now * now + last * last), ++n;
    before = previous, last = now;
  }
  if (n < 40 || !(square > 0)) return 0;
  const double rho = 1 + 2 * product / square, error = 2 * std::sqrt(0.5 / n);
  return rho > std::max(2 * error, 0.1) ? std::min(rho, 0.7) : 0;
}

Whitener::Whitener(const DataLayout& layout, const Noise& noise, const Eigen::MatrixXd& J)
    : layout_(layout), rho_(noise.rho) {
  if (rho_ != 0)
    for (const auto& [item, previous] : layout.chain())
      if (previous >= 0) log_determinant_ += std::log1p(-rho_ * rho_);
  for (const DataLayout::Group& g : layout.groups()) {
    const Eigen::LLT<Eigen::MatrixXd> llt(covariance(layout, g, noise, J));
    const Eigen::MatrixXd L = llt.matrixL();
    for (Eigen::Index i = 0; i < L.rows(); ++i) {
      for (Eigen::Index k = 0; k < i; ++k) factor_.push_back(L(i, k));
      factor_.push_back(1 / L(i, i));
      log_determinant_ += 2 * std::log(L(i, i));
    }
  }
}

void Whitener::apply(Eigen::Ref<Eigen::MatrixXd> x) const {
  for (Eigen::Index c = 0; c < x.cols(); ++c) {
    const double* l = factor_.data();
    for (const DataLayout::Group& g : layout_.groups()) {
      double* y = &x(g.first, c);
      for (int i = 0; i < g.count; ++i) {
        double sum = y[i];
        for (int k = 0; k < i; ++k) sum -= *l++ * y[k];
        y[i] = sum * *l++;
      }
    }
    if (rho_ == 0) continue;
    const double fresh = 1 / std::sqrt(1 - rho_ * rho_);
    const std::vector<std::array<int, 2>>& chain = layout_.chain();
    for (std::size_t k = chain.size(); k-- > 0;)  // from the end: the one before is still as it was
      if (chain[k][1] >= 0) x(chain[k][0], c) = fresh * (x(chain[k][0], c) - rho_ * x(chain[k][1], c));
  }
}

double noise_penalty(const Noise& noise, const std::array<bool, channel_count>& stated) {
  double p = 0;
  for (std::size_t c = 0; c < channel_count; ++c)
    if (stated[c]) p += std::pow(std::log(noise.scale[c]) / scale_sd, 2);
  return p + std::pow(noise.omega[0] / omega_k_sd, 2) + std::pow(noise.omega[1] / omega_phi_sd, 2);
}

Noise fit_noise(const DataLayout& layout, const Eigen::VectorXd& residual, const Eigen::MatrixXd& J, const Noise& start,
                const std::array<bool, channel_count>& stated, bool scatter, int free_parameters) {
  std::array<int, channel_count> counts{};
  for (int i = 0; i < layout.size(); ++i) ++counts[static_cast<std::size_t>(layout[i].channel)];
  // What the parameters took from the residuals.
  const double N = layout.size(), share = std::sqrt(std::max(N - free_parameters, 1.0) / N);
  const NoiseLikelihood likelihood(layout, residual / share, J, start);
  const auto value = [&](const std::vector<double>& x) {
    Noise n = start;
    for (std::size_t c = 0; c < channel_count; ++c) n.scale[c] = std::exp(x[c]);
    n.omega = {x[3], x[4]};
    return likelihood(n) + noise_penalty(n, stated);
  };
  std::vector<double> x(5), lower(5), upper(5), step(5);
  for (std::size_t c = 0; c < channel_count; ++c) {
    x[c] = std::log(start.scale[c]);
    // Not stated: from a fifth of 3 % of the range, or a few points would be followed exactly, to the range itself.
    lower[c] = counts[c] == 0 ? x[c] : -1.6, upper[c] = counts[c] == 0 ? x[c] : stated[c] ? 1.6 : 3.5;
    x[c] = std::clamp(x[c], lower[c], upper[c]);
    step[c] = 0.2;
  }
  const double top[2] = {scatter ? 0.4 : 0, scatter ? 0.12 : 0};
  for (std::size_t k = 0; k < 2; ++k) {
    lower[3 + k] = 0, upper[3 + k] = top[k];
    x[3 + k] = scatter ? std::clamp(std::max(start.omega[k], 0.1 * top[k]), 0.0, top[k]) : 0;
    step[3 + k] = scatter ? 0.1 * top[k] : 0.01;
  }
  std::vector<std::size_t> free;
  for (std::size_t i = 0; i < 5; ++i)
    if (upper[i] > lower[i]) free.push_back(i);
  if (free.empty()) return start;
  std::vector<double> y, lo, hi, st;
  for (const std::size_t i : free)
    y.push_back(x[i]), lo.push_back(lower[i]), hi.push_back(upper[i]), st.push_back(step[i]);
  struct Bound {
    const decltype(value)* f;
    std::vector<double> x;
    const std::vector<std::size_t>* free;
  } bound{&value, x, &free};
  const auto objective = [](unsigned n, const double* p, double*, void* data) {
    auto& b = *static_cast<Bound*>(data);
    for (std::size_t i = 0; i < n; ++i) b.x[(*b.free)[i]] = p[i];
    return (*b.f)(b.x);
  };
  const std::unique_ptr<nlopt_opt_s, decltype(&nlopt_destroy)> o(
      nlopt_create(free.size() > 1 ? NLOPT_LN_BOBYQA : NLOPT_LN_COBYLA, static_cast<unsigned>(free.size())),
      nlopt_destroy);
  nlopt_set_min_objective(o.get(), objective, &bound);
  nlopt_set_lower_bounds(o.get(), lo.data());
  nlopt_set_upper_bounds(o.get(), hi.data());
  nlopt_set_initial_step(o.get(), st.data());
  nlopt_set_ftol_abs(o.get(), 0.02);
  nlopt_set_maxeval(o.get(), 150);
  double best = 0;
  nlopt_optimize(o.get(), y.data(), &best);  // also where it stops for rounding, y is the best found
  for (std::size_t i = 0; i < free.size(); ++i) x[free[i]] = y[i];
  Noise out = start;
  for (std::size_t c = 0; c < channel_count; ++c) out.scale[c] = std::exp(x[c]);
  out.omega = {x[3], x[4]};
  return out;
}

double update_weights(const DataLayout& layout, const Eigen::VectorXd& residual, const Eigen::MatrixXd& J,
                      Noise& noise) {
  // Each run by itself: its own channels and the scatter of its preparation.
  std::vector<std::vector<int>> of_run(static_cast<std::size_t>(layout.runs()));
  for (int i = 0; i < layout.size(); ++i) of_run[static_cast<std::size_t>(layout[i].run)].push_back(i);
  noise.weight.assign(of_run.size(), 1);
  double added = 0;
  for (std::size_t run = 0; run < of_run.size(); ++run) {
    const auto m = static_cast<Eigen::Index>(of_run[run].size());
    if (m == 0) continue;
    Eigen::MatrixXd C = Eigen::MatrixXd::Zero(m, m);
    Eigen::VectorXd r(m);
    for (Eigen::Index a = 0; a < m; ++a) {
      const int i = of_run[run][static_cast<std::size_t>(a)];
      r[a] = residual[i];
      const double s = noise.scale[static_cast<std::size_t>(layout[i].channel)] * layout[i].sd;
      C(a, a) += s * s;
      for (Eigen::Index b = 0; b < m; ++b)
        for (std::size_t k = 0; k < 2; ++k)
          C(a, b) += noise.omega[k] * noise.omega[k] * J(i, static_cast<Eigen::Index>(k)) *
                     J(of_run[run][static_cast<std::size_t>(b)], static_cast<Eigen::Index>(k));
    }
    const double q = r.dot(C.llt().solve(r));
    // p_good ~ exp(-q/2), p_bad ~ factor^(-m/2) exp(-q/(2 factor))
    const double odds = bad_share / (1 - bad_share) *
                        std::exp(-0.5 * static_cast<double>(m) * std::log(bad_factor) + 0.5 * q * (1 - 1 / bad_factor));
    const double bad = std::isinf(odds) ? 1 : odds / (1 + odds);
    noise.weight[run] = 1 - bad + bad / bad_factor;
    // Between the mixture's and the weighted normal's -2 ln.
    const double mixture =
        std::isinf(odds) ? q / bad_factor + static_cast<double>(m) * std::log(bad_factor) - 2 * std::log(bad_share)
                         : q - 2 * std::log1p(odds) - 2 * std::log(1 - bad_share);
    added += mixture - (q * noise.weight[run] - static_cast<double>(m) * std::log(noise.weight[run]));
  }
  return added;
}

}  // namespace grouser::diagnosis
