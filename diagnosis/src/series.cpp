#include "series.h"

#include <ceres/ceres.h>

#include <algorithm>

namespace grouser::diagnosis {

Series::Series(const DiagnosisCase& c, std::vector<Run> runs, const std::vector<std::array<double, channel_count>>& sd)
    : case_(c), runs_(std::move(runs)), layout_(runs_, sd), y_(layout_.size()) {
  for (std::size_t i = 0; i < soil_count; ++i) {
    const SoilCoordinate& s = soil_coordinates()[i];
    if (c.soil[i].sd > 0)
      free_.push_back(
          {s.name, s.unit, s.logarithmic, s.lower, s.upper, c.soil[i].mean, c.soil[i].sd, static_cast<int>(i)});
  }
  for (const KnownEffect& k : c.known) {
    const int entry = entry_of(k.id);
    const EffectEntry& e = effect_entries()[static_cast<std::size_t>(entry)];
    if (k.sd > 0) free_.push_back({e.id, e.unit, false, e.lower, e.upper, k.value, k.sd, input_of_effect(entry)});
  }
  for (int i = 0; i < layout_.size(); ++i)
    y_[i] = runs_[static_cast<std::size_t>(layout_[i].run)].value[static_cast<std::size_t>(layout_[i].channel)];
}

Eigen::VectorXd Series::prior_mean() const {
  Eigen::VectorXd x(soil_parameters());
  for (int i = 0; i < soil_parameters(); ++i) x[i] = parameter(i).mean;
  return x;
}

Inputs Series::inputs_of_all(const Candidate& c, const Eigen::VectorXd& x) const {
  std::array<double, soil_count> soil;
  for (std::size_t i = 0; i < soil_count; ++i) soil[i] = case_.soil[i].mean;
  Inputs in = plain_inputs(soil);
  for (const KnownEffect& k : case_.known) in[static_cast<std::size_t>(input_of_effect(entry_of(k.id)))] = k.value;
  for (int i = 0; i < soil_parameters(); ++i) in[static_cast<std::size_t>(parameter(i).input)] = x[i];
  for (const Held& h : c.held) in[static_cast<std::size_t>(h.input)] += h.value;
  return in;
}

void Series::add_terms(const Candidate& c, const Eigen::VectorXd& x, std::size_t run, Inputs& in) const {
  for (std::size_t t = 0; t < c.terms.size(); ++t)
    in[static_cast<std::size_t>(c.terms[t].input)] +=
        x[soil_parameters() + static_cast<Eigen::Index>(t)] * c.terms[t].at(run);
}

Inputs Series::inputs_of(const Candidate& c, const Eigen::VectorXd& x, std::size_t run) const {
  Inputs in = inputs_of_all(c, x);
  add_terms(c, x, run, in);
  return in;
}

std::vector<int> Series::touched(const Candidate& c) const {
  std::vector<int> out;
  for (const Parameter& p : free_)
    if (p.input >= soil_count) out.push_back(p.input - soil_count);
  for (const Term& t : c.terms)
    if (t.input >= soil_count && std::find(out.begin(), out.end(), t.input - soil_count) == out.end())
      out.push_back(t.input - soil_count);
  return out;
}

std::vector<Inputs> Series::inputs(const Candidate& c, const Eigen::VectorXd& x) const {
  std::vector<Inputs> in(runs_.size(), inputs_of_all(c, x));
  for (std::size_t r = 0; r < runs_.size(); ++r) add_terms(c, x, r, in[r]);
  return in;
}

bool Series::evaluate(const Candidate& c, const Eigen::VectorXd& x, std::vector<double>& theta, Eigen::VectorXd& y,
                      Eigen::MatrixXd* J) const {
  std::vector<Outputs> out;
  std::vector<Slopes> slopes;
  if (!model_runs(case_, runs_, inputs(c, x), J ? Wanted::soil_and_touched : Wanted::value, touched(c), theta, out,
                  J ? &slopes : nullptr))
    return false;
  y.resize(layout_.size());
  if (J) J->resize(layout_.size(), x.size());
  for (int i = 0; i < layout_.size(); ++i) {
    const auto r = static_cast<std::size_t>(layout_[i].run);
    y[i] = out[r][static_cast<std::size_t>(layout_[i].channel)];
    if (!J) continue;
    for (std::size_t k = 0; k < free_.size(); ++k)
      (*J)(i, static_cast<Eigen::Index>(k)) = slopes[r](layout_[i].channel, free_[k].input);
    for (std::size_t t = 0; t < c.terms.size(); ++t)
      (*J)(i, soil_parameters() + static_cast<Eigen::Index>(t)) =
          slopes[r](layout_[i].channel, c.terms[t].input) * c.terms[t].at(r);
  }
  return true;
}

bool Series::predict(const Candidate& c, const Eigen::VectorXd& x, std::vector<double>& theta,
                     Eigen::VectorXd& y) const {
  return evaluate(c, x, theta, y, nullptr);
}

bool Series::settle(const Candidate& c, const Eigen::VectorXd& x) const {
  return settle_runs(case_, runs_, inputs(c, x));
}

bool Series::all_slopes(const Candidate& c, const Eigen::VectorXd& x, std::vector<double>& theta,
                        Eigen::MatrixXd& out) const {
  out.resize(layout_.size(), input_count);
  std::vector<Outputs> y;
  std::vector<Slopes> slopes;
  if (!model_runs(case_, runs_, inputs(c, x), Wanted::all, {}, theta, y, &slopes)) return false;
  for (int i = 0; i < layout_.size(); ++i)
    out.row(i) = slopes[static_cast<std::size_t>(layout_[i].run)].row(layout_[i].channel);
  return true;
}

double Series::prior_penalty(const Candidate& c, const Eigen::VectorXd& x) const {
  double p = 0;
  for (int i = 0; i < soil_parameters(); ++i) p += std::pow((x[i] - parameter(i).mean) / parameter(i).sd, 2);
  for (std::size_t t = 0; t < c.terms.size(); ++t)
    if (c.terms[t].sd > 0) p += std::pow(x[soil_parameters() + static_cast<Eigen::Index>(t)] / c.terms[t].sd, 2);
  return p;
}

void Series::reweigh(Fit& f, const Whitener& w) const {
  Eigen::MatrixXd u = f.residual;
  w.apply(u);
  f.chi2 = u.squaredNorm();
}

Eigen::MatrixXd Series::scatter_slopes(const Candidate& c, const Fit& f) const {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(layout_.size(), static_cast<Eigen::Index>(scattered.size()));
  std::vector<double> theta = f.theta;
  std::vector<Outputs> y;
  std::vector<Slopes> slopes;
  if (!model_runs(case_, runs_, inputs(c, f.x), Wanted::soil_and_touched, {}, theta, y, &slopes)) return out;
  for (int i = 0; i < layout_.size(); ++i)
    for (std::size_t k = 0; k < scattered.size(); ++k)
      out(i, static_cast<Eigen::Index>(k)) =
          slopes[static_cast<std::size_t>(layout_[i].run)](layout_[i].channel, scattered[k]);
  return out;
}

/// Whitened residuals and the priors as one block: of the parameters, then of all amplitudes (0 where there is none).
/// Ceres asks up to three times at one place (line search, candidate, gradient): the last answer is kept.
class SeriesCost : public ceres::CostFunction {
 public:
  SeriesCost(const Series& s, const Candidate& c, const Whitener& w, std::vector<double> theta)
      : s_(s), c_(c), w_(w), theta_(std::move(theta)) {
    const int n = s.soil_parameters() + static_cast<int>(c.terms.size());
    mutable_parameter_block_sizes()->push_back(n);
    set_num_residuals(s.layout().size() + n);
  }
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const Eigen::Index n = parameter_block_sizes()[0], m = s_.layout().size(), p = s_.soil_parameters();
    const Eigen::VectorXd x = Eigen::Map<const Eigen::VectorXd>(parameters[0], n);
    const bool slopes = jacobians && jacobians[0];
    if (!known_ || x != at_ || (slopes && !with_slopes_)) {
      known_ = false;
      Eigen::VectorXd y;
      if (!s_.evaluate(c_, x, theta_, y, slopes ? &J_ : nullptr)) return false;
      r_ = y - s_.y_;
      w_.apply(r_);
      if (slopes) w_.apply(J_);
      at_ = x, with_slopes_ = slopes, known_ = true;
    }
    Eigen::Map<Eigen::VectorXd> out(residuals, m + n);
    out.head(m) = r_;
    const auto weight = [&](Eigen::Index i) {
      const double sd = i < p ? s_.parameter(i).sd : c_.terms[static_cast<std::size_t>(i - p)].sd;
      return sd > 0 ? 1 / sd : 0;
    };
    for (Eigen::Index i = 0; i < n; ++i) out[m + i] = (x[i] - (i < p ? s_.parameter(i).mean : 0)) * weight(i);
    if (!slopes) return true;
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Eigen::Map<RowMajor> d(jacobians[0], m + n, n);
    d.setZero();
    d.topRows(m) = J_;
    for (Eigen::Index i = 0; i < n; ++i) d(m + i, i) = weight(i);
    return true;
  }

 private:
  const Series& s_;
  const Candidate& c_;
  const Whitener& w_;
  mutable std::vector<double> theta_;  ///< of the last call: where the next search begins
  mutable bool known_ = false, with_slopes_ = false;
  mutable Eigen::VectorXd at_;
  mutable Eigen::MatrixXd r_, J_;  ///< whitened, at `at_`
};

Fit Series::fit(const Candidate& c, const Whitener& w, const Eigen::VectorXd& start, const std::vector<double>& theta,
                int iterations) const {
  Fit f;
  f.x = start;
  // A step along a slope may leave the bounds (cohesion near 0), and Ceres refuses to begin there.
  std::vector<std::array<double, 2>> bounds;
  for (const Parameter& p : free_) bounds.push_back({p.lower, p.upper});
  for (const Term& t : c.terms) bounds.push_back({t.lower, t.upper});
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    double& x = f.x[static_cast<Eigen::Index>(i)];
    x = std::clamp(x, bounds[i][0], bounds[i][1]);
  }
  std::vector<double> near = theta;
  Eigen::VectorXd y;
  if (!evaluate(c, f.x, near, y, nullptr)) return f;  // no wheel there: nothing to descend from
  ceres::Problem problem;
  if (start.size() > 0)  // nothing free: a prediction
    problem.AddResidualBlock(new SeriesCost(*this, c, w, near), nullptr, f.x.data());
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    problem.SetParameterLowerBound(f.x.data(), static_cast<int>(i), bounds[i][0]);
    problem.SetParameterUpperBound(f.x.data(), static_cast<int>(i), bounds[i][1]);
  }
  ceres::Solver::Options o;
  o.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  o.max_num_iterations = iterations;
  o.function_tolerance = 1e-5;  // of the sum of squares: 0.003 in ln likelihood
  o.logging_type = ceres::SILENT;
  o.num_threads = 1;
  o.max_num_consecutive_invalid_steps = 12;
  ceres::Solver::Summary summary;
  if (iterations > 0 && start.size() > 0) {
    ceres::Solve(o, &problem, &summary);
    if (summary.termination_type == ceres::FAILURE) return f;
  }
  f.theta = near;
  if (!evaluate(c, f.x, f.theta, y, &f.jacobian)) return f;
  f.residual = y_ - y;
  reweigh(f, w);
  f.penalty = prior_penalty(c, f.x);
  f.precision = Eigen::VectorXd::Zero(f.x.size());
  for (int i = 0; i < soil_parameters(); ++i) f.precision[i] = 1 / (parameter(i).sd * parameter(i).sd);
  for (std::size_t t = 0; t < c.terms.size(); ++t)
    if (c.terms[t].sd > 0)
      f.precision[soil_parameters() + static_cast<Eigen::Index>(t)] = 1 / (c.terms[t].sd * c.terms[t].sd);
  f.ok = std::isfinite(f.chi2);
  return f;
}

}  // namespace grouser::diagnosis
