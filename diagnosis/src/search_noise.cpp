// Noise of the runs: what the best account so far leaves over, or what repeats say where the two disagree.
#include <algorithm>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <limits>

#include "replicates.h"
#include "search.h"

namespace grouser::diagnosis {
namespace {

constexpr int full = 25;              // iterations
constexpr int least_replicates = 30;  // values
constexpr double suspect_share = 0.05;
constexpr int most_passes = 6;
constexpr double least_gain = 2;  // in -2 ln likelihood, for which the noise is settled once more
constexpr double far_off =
    2.5;  // times the noise that is stated or usual: rows that a model cannot follow have many minima

/// The nominal fit again with each value in turn moved to both sides of its prior, and with all of them at their means, as long as that helps.
void look_further(const Series& s, const Whitener& w, Fit& nominal) {
  for (int round = 0; round < 3; ++round) {
    const Fit from = nominal;
    const auto try_from = [&](const Eigen::VectorXd& x) {
      Fit f = s.fit(nominal_candidate(), w, x, from.theta, full);
      if (f.ok && f.objective() < nominal.objective()) nominal = std::move(f);
    };
    try_from(s.prior_mean());
    for (int i = 0; i < s.soil_parameters(); ++i)
      for (const double side : {-1.5, 0.0, 1.5}) {
        Eigen::VectorXd x = from.x;
        x[i] = s.parameter(i).mean + side * s.parameter(i).sd;
        try_from(x);
        if (side == 0 && i > 0) x[i - 1] = s.parameter(i - 1).mean, try_from(x);
      }
    if (nominal.objective() > from.objective() - 0.01) return;
  }
}

}  // namespace

/// Repeats that agree with each other are no outliers, and a model that disowns many rows is wrong, not the rows.
void Search::weigh_runs(const Fit& f) {
  const DataLayout& l = series_->layout();
  update_weights(l, f.residual, scatter_, noise_);
  std::vector<std::array<double, channel_count>> u(series_->runs().size());
  for (auto& x : u) x.fill(std::numeric_limits<double>::quiet_NaN());
  for (int i = 0; i < l.size(); ++i) {
    const auto c = static_cast<std::size_t>(l[i].channel);
    u[static_cast<std::size_t>(l[i].run)][c] = f.residual[i] / (noise_.scale[c] * l[i].sd);
  }
  std::size_t suspects = 0;
  for (std::size_t r = 0; r < u.size(); ++r) {
    if (noise_.weight[r] >= 0.5) continue;
    for (std::size_t o = 0; o < u.size(); ++o) {
      if (o == r || series_->runs()[o].condition != series_->runs()[r].condition) continue;
      double apart = 0;
      for (std::size_t c = 0; c < channel_count; ++c)
        if (std::isfinite(u[r][c]) && std::isfinite(u[o][c])) apart = std::max(apart, std::abs(u[r][c] - u[o][c]));
      if (apart < 3 * std::sqrt(2.0)) noise_.weight[r] = 1;
    }
    suspects += noise_.weight[r] < 0.5 ? 1 : 0;
  }
  disowned_ =
      suspects > std::max<std::size_t>(2, static_cast<std::size_t>(suspect_share * static_cast<double>(u.size())));
  if (disowned_) noise_.weight.assign(u.size(), 1);
}

/// From the residuals; from the repeats alone where the residuals are larger than these allow (F test, 0.05).
Noise Search::noise_of(const Fit& f, bool& from_repeats, bool& repeats_show) const {
  from_repeats = repeats_show = false;
  const bool scatter = series_->runs().size() >= 20;
  const DataLayout& l = series_->layout();
  const Noise all = fit_noise(l, f.residual, scatter_, noise_, stated_, scatter, static_cast<int>(f.x.size()));
  const auto repeated = replicates(series_->runs(), l, scatter_, f.residual, least_replicates);
  if (!repeated) return all;
  Noise plain = noise_;
  plain.weight.clear();
  plain.rho = 0;
  Noise own = fit_noise(repeated->layout, repeated->contrast, repeated->slopes, plain, stated_, scatter, 0);
  own.weight = noise_.weight;
  Eigen::MatrixXd u = f.residual;
  Whitener(l, own, scatter_).apply(u);
  const double dof = std::max(l.size() - static_cast<double>(f.x.size()), 1.0);
  const boost::math::fisher_f distribution(dof, repeated->layout.size());
  from_repeats = boost::math::cdf(boost::math::complement(distribution, u.squaredNorm() / dof)) < 0.05;
  // Repeats must allow what the scales say, not only fall within it.
  repeats_show = true;
  for (std::size_t c = 0; c < channel_count; ++c) repeats_show = repeats_show && all.scale[c] < 1.5 * own.scale[c];
  repeats_show = repeats_show || from_repeats;
  return from_repeats ? own : all;
}

std::array<double, channel_count> Search::statics_scale() const {
  std::array<double, channel_count> out{};
  for (std::size_t c = 0; c < channel_count; ++c) out[c] = stated_[c] && !from_repeats_ ? 1 : noise_.scale[c];
  return out;
}

/// Correlation of the errors of one run and the next under this noise.
double Search::memory_of(const Fit& f, Noise noise) const {
  if (!ordered_) return 0;
  noise.rho = 0;
  Eigen::MatrixXd u = f.residual;
  Whitener(series_->layout(), noise, scatter_).apply(u);
  return run_to_run(series_->layout(), u.col(0));
}

/// A second cause that pays for itself: left in the residuals it would count as scatter of the soil.
void Search::add_second(Candidate& best, Fit& f) const {
  const std::vector<Candidate> named(all_.begin(), all_.begin() + static_cast<long>(named_));
  const ScoreTable scores(*series_, best, f, *whitener_, named);
  if (!scores.ok()) return;
  double most = 2;
  std::size_t second = named_;
  for (std::size_t i = 0; i < named_; ++i) {
    if (named[i].effects == best.effects) continue;
    const ScoreTable::Score s = scores.of(i);
    const double e = s.gain - price(named[i], s.gain, s.amplitude);
    if (e > most) most = e, second = i;
  }
  if (second == named_) return;
  const ScoreTable::Score s = scores.of(second);
  Eigen::VectorXd guess(f.x.size() + 1);
  guess << f.x + scores.base_step({second}, s.amplitude), s.amplitude;
  Candidate pair = pair_of(best, named[second]);
  Fit g = refit(pair, guess, f);
  if (!g.ok || g.objective() >= f.objective()) return;
  best = std::move(pair);
  f = std::move(g);
}

/// -2 ln likelihood of the runs under the noise as it stands, with what account and noise cost.
double Search::cost_of_noise(const Candidate& c, Fit f) const {
  series_->reweigh(f, *whitener_);
  const double gain = 0.5 * std::max(none_.objective() - f.objective(), 0.0);
  return f.objective() + whitener_->log_determinant() + noise_penalty(noise_, stated_) +
         (c.terms.empty() ? 0 : 2 * price(c, gain, f.x));
}

/// Best account and its noise in turn: twice, then as long as that makes the runs likelier. Where accounts are near each
/// other, two rounds alone end wherever the last digits of the first lead.
void Search::settle_noise(std::pair<Candidate, Fit> first) {
  double last = std::numeric_limits<double>::infinity();
  const int sure = first.first.terms.empty() ? 2 : 1;  // passes
  for (int pass = 0; pass < most_passes; ++pass) {
    const ScoreTable scores(*series_, nominal_candidate(), none_, *whitener_, all_);
    const bool given = pass == 0 && sure == 1;
    Candidate best = given ? std::move(first.first) : nominal_candidate();
    Fit f = given ? std::move(first.second) : none_;
    if (!given && scores.ok()) {
      double most = 0;
      Eigen::VectorXd guess;
      for (std::size_t i = 0; i < all_.size(); ++i) {
        const ScoreTable::Score s = scores.of(i);
        const double e = s.gain - price(all_[i], s.gain, s.amplitude);
        if (e <= most) continue;
        most = e, best = all_[i];
        guess = Eigen::VectorXd(none_.x.size() + s.amplitude.size());
        guess << none_.x + scores.base_step({i}, s.amplitude), s.amplitude;
      }
      if (most > 0) {
        Fit g = refit(best, guess, none_);
        if (g.ok && g.objective() < none_.objective())
          f = std::move(g);
        else
          best = nominal_candidate();
      }
      if (best.effects.size() == 1) add_second(best, f);
    }
    const Noise noise_before = noise_;
    const Eigen::MatrixXd scatter_before = scatter_;
    const bool disowned_before = disowned_, repeats_before = from_repeats_, show_before = repeats_show_;
    scatter_ = series_->scatter_slopes(best, f);
    weigh_runs(f);
    noise_ = noise_of(f, from_repeats_, repeats_show_);
    weigh_runs(f);
    noise_.rho = memory_of(f, noise_);
    set_whitener();
    const double cost = cost_of_noise(best, f);
    if (pass >= sure && !(cost < last)) {  // no likelier: back
      noise_ = noise_before, scatter_ = scatter_before;
      disowned_ = disowned_before, from_repeats_ = repeats_before, repeats_show_ = show_before;
      set_whitener();
      return;
    }
    none_ = series_->fit(nominal_candidate(), *whitener_, none_.x, none_.theta, full);
    const bool far = std::any_of(noise_.scale.begin(), noise_.scale.end(), [](double k) { return k > far_off; });
    if (far || series_->layout().size() < few) look_further(*series_, *whitener_, none_);
    none_ = settled(nominal_candidate(), std::move(none_));
    if (pass >= 1 && (from_repeats_ || cost > last - least_gain)) return;
    last = cost;
  }
}

double Search::own_noise_gain(const Fit& fit) const {
  Noise own = fit_noise(series_->layout(), fit.residual, scatter_, noise_, stated_, series_->runs().size() >= 20,
                        static_cast<int>(fit.x.size()));
  own.rho = memory_of(fit, own);
  const Whitener w(series_->layout(), own, scatter_);
  Fit f = fit;
  series_->reweigh(f, w);
  const double shared = fit.chi2 + whitener_->log_determinant() + noise_penalty(noise_, stated_);
  const double best = f.chi2 + w.log_determinant() + noise_penalty(own, stated_);
  return std::max(0.0, 0.5 * (shared - best));
}

}  // namespace grouser::diagnosis
