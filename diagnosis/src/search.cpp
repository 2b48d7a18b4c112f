#include "search.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <ctime>

#include "grouser/terrain/config.h"
#include "importance.h"

namespace grouser::diagnosis {
namespace {

constexpr int full = 25, quick = 5;  // iterations
constexpr std::size_t most_finalists = 3;
constexpr int most_rounds = 4;           // of rolling where a fit ended and fitting again
constexpr double at_rest = 0.1;          // in -2 ln likelihood
constexpr double far_below = 1;          // in ln likelihood
constexpr double other_noise = 5;        // in ln likelihood
constexpr double structure_left = 1e-3;  // p
constexpr int most_rankings = 2;
constexpr std::size_t most_from_afar = 4;
constexpr std::size_t most_settled = 12;  // accounts
constexpr int evidence_draws = 64;
constexpr double least_effective = 10, most_correction = 3;
constexpr std::size_t shortlist = 12, most_drifts = 6, pair_bases = 6, most_pairs = 16;

/// Sd of each value; where none is stated from the repeats, else from the range, to be scaled by fit_noise.
std::vector<std::array<double, channel_count>> sd_of(const std::vector<Run>& runs) {
  std::vector<std::array<double, channel_count>> out(runs.size());
  for (std::size_t c = 0; c < channel_count; ++c) {
    double low = INFINITY, high = -INFINITY;
    for (const Run& r : runs)
      if (std::isfinite(r.value[c])) low = std::min(low, r.value[c]), high = std::max(high, r.value[c]);
    const double fallback = high > low ? 0.03 * (high - low) : 1;
    for (std::size_t i = 0; i < runs.size(); ++i) out[i][c] = runs[i].sd[c] > 0 ? runs[i].sd[c] : fallback;
  }
  return out;
}

/// Slopes at slip 0 that are one-sided: two of these look alike at amplitude 0 and are not.
bool kinked_at_zero_slip(const std::string& id) {
  return id == "wheel_radius_error" || id == "flexible_wheel" || id == "lugs";
}

double kink_step(const std::string& id) { return id == "lugs" ? 0.003 : 0.01; }

}  // namespace

Search::Search(const DiagnosisCase& c, const RunTable& t, std::vector<Run> runs)
    : case_(c), stated_(t.stated_sd), ordered_(t.has_order || t.has_time) {
  sd_ = sd_of(runs);
  for (const int e : visible_effects(c, t, runs)) all_.push_back(with_priors(effect_candidate(e), case_));
  named_ = all_.size();
  aliases_.resize(named_);
  for (Candidate& d : drift_candidates(runs, t.has_order)) all_.push_back(std::move(d));
  series_ = std::make_unique<Series>(case_, std::move(runs), sd_);
  noise_.weight.assign(series_->runs().size(), 1);
}

std::array<double, channel_count> Search::usual_sd() const {
  std::array<double, channel_count> out{};
  for (std::size_t c = 0; c < channel_count; ++c) {
    std::vector<double> all;
    for (std::size_t r = 0; r < sd_.size(); ++r)
      if (std::isfinite(series_->runs()[r].value[c])) all.push_back(sd_[r][c]);
    if (all.empty()) continue;
    std::nth_element(all.begin(), all.begin() + static_cast<long>(all.size() / 2), all.end());
    out[c] = all[all.size() / 2];
  }
  return out;
}

void Search::set_whitener() { whitener_ = std::make_unique<Whitener>(series_->layout(), noise_, scatter_); }

void Search::fit_nominal() {
  const Candidate c = nominal_candidate();
  const Eigen::VectorXd mean = series_->prior_mean();
  const std::vector<double> cold(series_->runs().size(), 0.0);
  scatter_ = Eigen::MatrixXd::Zero(series_->layout().size(), static_cast<Eigen::Index>(scattered.size()));
  set_whitener();
  // Prior means, then shifts of ln K (continuation from a softer onset of shear), n, phi and a1.
  const auto shifted = [&](std::initializer_list<std::pair<int, double>> by) {
    Eigen::VectorXd x = mean;
    for (const auto& [which, step] : by)
      for (int i = 0; i < series_->soil_parameters(); ++i)
        if (series_->parameter(i).input == which) x[i] += step;
    return x;
  };
  std::vector<Fit> found;
  for (const Eigen::VectorXd& start : {mean, shifted({{4, 2.3}}), shifted({{4, 1.0}, {6, 0.2}}),
                                       shifted({{1, 0.3}, {0, -0.4}}), shifted({{3, 0.07}, {5, 0.1}})}) {
    Fit f = series_->fit(c, *whitener_, start, cold, found.empty() ? full : quick);
    if (f.ok) found.push_back(std::move(f));
  }
  if (found.empty())
    throw ConfigError(case_.file.string(), 0, 0,
                      "the model carries the load of no run, or not of all of them, at the prior means of the soil; "
                      "check units, width and "
                      "reference_width");
  const auto best = std::min_element(found.begin(), found.end(),
                                     [](const Fit& a, const Fit& b) { return a.objective() < b.objective(); });
  none_ = best == found.begin() ? *best : series_->fit(c, *whitener_, best->x, best->theta, full);
  none_ = settled(c, std::move(none_));
}

Fit Search::settled(const Candidate& c, Fit f) const {
  if (!case_.rig.model()) return f;
  for (int round = 0; round < most_rounds && f.ok; ++round) {
    const double before = f.objective();
    if (!series_->settle(c, f.x)) return f;
    Fit g = series_->fit(c, *whitener_, f.x, f.theta, full);
    if (!g.ok) return f;
    f = std::move(g);
    if (std::abs(f.objective() - before) < at_rest) break;
  }
  return f;
}

/// The accounts that could win, best first: what was foretold for them from elsewhere is rolled.
void Search::settle_leading() {
  if (!case_.rig.model()) return;
  std::vector<Rival*> left;
  for (Rival& r : rivals_)
    if (r.refitted && r.fit.ok) left.push_back(&r);
  double best = 0, rise = 0;  // the most that one gained by it
  for (std::size_t k = 0; k < most_settled && !left.empty(); ++k) {
    const auto next = std::max_element(left.begin(), left.end(), [](const Rival* a, const Rival* b) {
      return a->evidence + a->weight < b->evidence + b->weight;
    });
    Rival& r = **next;
    left.erase(next);
    if (r.evidence + r.weight + rise < best - 2 * std::log(decisive)) break;
    const double foretold = r.evidence;
    take(r, settled(r.candidate, std::move(r.fit)));
    best = std::max(best, r.evidence + r.weight);
    rise = std::max(rise, r.evidence - foretold);
  }
}

Fit Search::refit(const Candidate& c, const Eigen::VectorXd& guess, const Fit& base) const {
  Fit f = series_->fit(c, *whitener_, guess, base.theta, full);
  if (f.ok && f.objective() <= base.objective() + 1e-6) return f;
  // From the base with a trace of the effect: descent can only improve on it.
  Eigen::VectorXd x = Eigen::VectorXd::Zero(guess.size());
  x.head(std::min(base.x.size(), x.size())) = base.x.head(std::min(base.x.size(), x.size()));
  Fit g = series_->fit(c, *whitener_, x, base.theta, full);
  if (g.ok && (!f.ok || g.objective() < f.objective())) return g;
  return f;
}

Candidate Search::pair_of(const Candidate& a, const Candidate& b) const {
  return with_priors(pair_candidate(a.effects[0], b.effects[0]), case_);
}

/// Of a gain in ln likelihood that the last amplitudes of `x` bring.
double Search::price(const Candidate& c, double gain, const Eigen::VectorXd& x) const {
  const double k = static_cast<double>(c.terms.size());
  if (!c.named()) return k * std::log(15.0);
  // Amplitude log-uniform over visible sizes of 1 to 60: independent of units, the same for every effect.
  // Where an ordinary size is stated: normal, and its penalty is in the gain already.
  const double d = std::max(1.0, std::sqrt(2 * gain / k));
  double out = 0;
  for (std::size_t t = 0; t < c.terms.size(); ++t) {
    const double sd = c.terms[t].sd;
    const Eigen::Index i = x.size() - static_cast<Eigen::Index>(c.terms.size() - t);
    const double known = i < 0 ? 0 : std::abs(x[i]) / d;  // the data's own error of the amplitude
    out += sd > 0 ? 0.5 * std::log1p(known > 0 ? sd * sd / (known * known) : d * d)
                  : std::log(d * std::log(60.0) / std::sqrt(2 * 3.14159265358979));
  }
  return out;
}

/// Effects that do the same to these runs, to a millionth, are one candidate that answers to all their names.
void Search::join_aliases() {
  const ScoreTable scores(*series_, nominal_candidate(), none_, *whitener_, all_);
  if (!scores.ok()) return;
  std::vector<bool> gone(named_, false);
  for (std::size_t a = 0; a < named_; ++a)
    for (std::size_t b = a + 1; b < named_ && !gone[a]; ++b)
      if (!gone[b] && !kinked_at_zero_slip(all_[a].id) && !kinked_at_zero_slip(all_[b].id) && scores.visible(a) > 0 &&
          scores.likeness(a, b) > 1 - 1e-6) {
        gone[b] = true;
        aliases_[a].push_back(all_[b].id);
      }
  std::vector<Candidate> kept;
  std::vector<std::vector<std::string>> names;
  for (std::size_t i = 0; i < all_.size(); ++i) {
    if (i < named_ && gone[i]) continue;
    if (i < named_) names.push_back(aliases_[i]);
    kept.push_back(all_[i]);
  }
  all_ = std::move(kept);
  aliases_ = std::move(names);
  named_ = aliases_.size();
}

const std::vector<std::string>& Search::aliases(int entry) const {
  static const std::vector<std::string> none;
  for (std::size_t i = 0; i < named_; ++i)
    if (all_[i].effects[0] == entry) return aliases_[i];
  return none;
}

bool Search::rank(bool last) {
  rivals_.clear();
  scores_ = std::make_unique<ScoreTable>(*series_, nominal_candidate(), none_, *whitener_, all_);
  if (!scores_->ok()) return true;
  const auto add = [&](Candidate c, const std::vector<std::size_t>& of, const ScoreTable::Score& s, double share) {
    Rival r;
    r.candidate = std::move(c);
    r.gain = s.gain;
    r.evidence = s.gain - price(r.candidate, s.gain, s.amplitude);
    r.weight = std::log(share);
    r.guess = Eigen::VectorXd(none_.x.size() + s.amplitude.size());
    r.guess << none_.x + scores_->base_step(of, s.amplitude), s.amplitude;
    rivals_.push_back(std::move(r));
  };
  double n = static_cast<double>(named_);
  for (const auto& also : aliases_) n += static_cast<double>(also.size());
  const double drifts = static_cast<double>(all_.size() - named_);
  for (std::size_t i = 0; i < all_.size(); ++i)
    add(all_[i], {i}, scores_->of(i),
        i < named_ ? share_named / n * (1 + static_cast<double>(aliases_[i].size())) : share_drift / drifts);
  for (std::size_t a = 0; a < named_; ++a)
    for (std::size_t b = a + 1; b < named_; ++b)
      add(pair_of(all_[a], all_[b]), {a, b}, scores_->of_pair(a, b), 2 * share_pair / (n * (n - 1)));

  // Single effects: the best by score, and those whose slope at zero says little of their size.
  std::vector<std::size_t> order(named_);
  for (std::size_t i = 0; i < named_; ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return rivals_[a].evidence > rivals_[b].evidence; });
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::string& id = all_[order[k]].id;
    const bool radius = id == "wheel_radius_error", kinked = kinked_at_zero_slip(id);
    Rival& r = rivals_[order[k]];
    if (k < shortlist || kinked) take(r, refit(r.candidate, r.guess, none_));
    if (!kinked || !r.fit.ok) continue;
    for (const double side : {-1.0, 1.0}) {  // both sides of the step at slip 0
      if (side < 0 && !radius) continue;
      const double e = side * kink_step(id);
      Eigen::VectorXd x(none_.x.size() + 1);
      x << none_.x, e;
      Fit f = series_->fit(r.candidate, *whitener_, x, none_.theta, full);
      if (f.ok && f.objective() < r.fit.objective()) take(r, std::move(f));
    }
  }
  for (std::size_t i = 0; i < named_; ++i)
    if (elsewhere_[i].size()) take_if_better(i, series_->fit(all_[i], *whitener_, elsewhere_[i], none_.theta, full));
  // Nesting: the nominal model from where the best extended one ended.
  const auto top = std::max_element(rivals_.begin(), rivals_.begin() + static_cast<long>(named_),
                                    [](const Rival& a, const Rival& b) {
                                      return a.refitted < b.refitted || (a.refitted == b.refitted && a.gain < b.gain);
                                    });
  if (top->refitted && top->fit.ok) {
    Fit again = series_->fit(nominal_candidate(), *whitener_, top->fit.x.head(none_.x.size()), top->fit.theta, full);
    again = settled(nominal_candidate(), std::move(again));
    if (again.ok && again.objective() < none_.objective() - 1e-3) {
      const double less = 0.5 * (none_.objective() - again.objective());
      none_ = std::move(again);
      if (less > far_below && !last) return false;
      for (Rival& r : rivals_)
        if (r.refitted)
          r.gain = std::max(0.0, r.gain - less), r.evidence = r.gain - price(r.candidate, r.gain, r.fit.x);
    }
  }
  // Drifts: refit those that could still win, best first.
  const auto best_refitted = [&] {
    double best = 0;
    for (const Rival& r : rivals_)
      if (r.refitted) best = std::max(best, r.evidence + r.weight);
    return best;
  };
  for (std::size_t k = 0; k < most_drifts; ++k) {
    Rival* next = nullptr;
    for (Rival& r : rivals_)
      if (!r.refitted && !r.candidate.named() && (!next || r.evidence + r.weight > next->evidence + next->weight))
        next = &r;
    if (!next || next->evidence + next->weight < best_refitted() - std::log(decisive) - 1) break;
    take(*next, refit(next->candidate, next->guess, none_));
  }
  rank_pairs();
  if (singles_from_pairs()) rank_pairs();
  if (singles_from_afar()) {
    rank_pairs();
    singles_from_pairs();
  }
  // A slope alone is an upper bound: what was not refitted cannot win.
  for (Rival& r : rivals_)
    if (!r.refitted) r.evidence = std::min(r.evidence, 0.0);
  return true;
}

/// Nesting: each effect of the leading pairs alone, from where the pair ended. A descent that stopped short before is seen here.
bool Search::singles_from_pairs() {
  bool found = false;
  double best = 0;
  for (const Rival& r : rivals_)
    if (r.refitted) best = std::max(best, r.evidence + r.weight);
  for (std::size_t p = all_.size(); p < rivals_.size(); ++p) {
    const Rival& pair = rivals_[p];
    if (!pair.refitted || !pair.fit.ok || pair.evidence + pair.weight < best - std::log(decisive)) continue;
    for (std::size_t i = 0; i < named_; ++i)
      for (std::size_t term = 0; term < 2; ++term) {
        if (pair.candidate.effects[term] != all_[i].effects[0]) continue;
        Eigen::VectorXd x(none_.x.size() + 1);
        x << pair.fit.x.head(none_.x.size()), pair.fit.x[none_.x.size() + static_cast<Eigen::Index>(term)];
        found |= take_if_better(i, series_->fit(all_[i], *whitener_, x, pair.fit.theta, full));
      }
  }
  return found;
}

/// Where nothing that was found follows the runs, once: each effect at its usual size, both signs, from the prior means of the soil.
bool Search::singles_from_afar() {
  if (looked_afar_) return false;
  const Rival* leading = leader();
  if (remainder(leading ? leading->candidate : nominal_candidate(), leading ? leading->fit : none_).p > structure_left)
    return false;
  looked_afar_ = true;
  const std::vector<double> cold(series_->runs().size(), 0.0);
  std::vector<std::pair<std::size_t, Fit>> ends;
  for (std::size_t i = 0; i < named_; ++i) {
    const Term& t = all_[i].terms[0];
    for (const double size : {t.start, -t.start}) {
      if (size < t.lower || size > t.upper) continue;
      Eigen::VectorXd x(none_.x.size() + 1);
      x << series_->prior_mean(), size;
      Fit f = series_->fit(all_[i], *whitener_, x, cold, quick);
      if (f.ok) ends.emplace_back(i, std::move(f));
    }
  }
  std::stable_sort(ends.begin(), ends.end(),
                   [](const auto& a, const auto& b) { return a.second.objective() < b.second.objective(); });
  bool found = false;
  for (std::size_t k = 0; k < std::min(most_from_afar, ends.size()); ++k) {
    const auto& [i, end] = ends[k];
    found |= take_if_better(i, series_->fit(all_[i], *whitener_, end.x, end.theta, full));
  }
  return found;
}

/// A single effect that ends lower than it did: kept, and begun from there when all is ranked again.
bool Search::take_if_better(std::size_t single, Fit f) {
  Rival& one = rivals_[single];
  const double before = one.refitted && one.fit.ok ? one.fit.objective() : none_.objective();
  if (!f.ok || f.objective() > before - 2 * far_below) return false;
  elsewhere_[single] = f.x;
  take(one, std::move(f));
  return true;
}

/// The best account that is not the nominal model, null where there is none that pays.
const Rival* Search::leader() const {
  const Rival* best = nullptr;
  for (const Rival& r : rivals_)
    if (r.refitted && r.fit.ok && r.evidence + r.weight > (best ? best->evidence + best->weight : 0)) best = &r;
  return best;
}

/// The leading account follows the runs far better than the noise says that it could. Of few rows a pair follows many by chance.
bool Search::other_noise_wins() const {
  const Rival* best = leader();
  return best && !from_repeats_ && series_->layout().size() >= few && own_noise_gain(best->fit) > other_noise;
}

/// What a fit says of an account.
void Search::take(Rival& r, Fit f) const {
  r.fit = std::move(f);
  r.refitted = true;
  r.gain = r.fit.ok ? std::max(0.0, 0.5 * (none_.objective() - r.fit.objective())) : 0;
  r.evidence = r.gain - price(r.candidate, r.gain, r.fit.x);
}

/// All pairs by score: from the nominal model, and beside each of the best single effects at its own size, which shows partners that a
/// slope at zero does not. Those that could still win are refitted, best estimate first.
void Search::rank_pairs() {
  std::vector<std::size_t> singles;
  for (std::size_t i = 0; i < named_; ++i)
    if (rivals_[i].refitted && rivals_[i].fit.ok) singles.push_back(i);
  std::stable_sort(singles.begin(), singles.end(),
                   [&](std::size_t a, std::size_t b) { return rivals_[a].gain > rivals_[b].gain; });
  if (singles.empty() || rivals_[singles[0]].gain < 4) return;
  if (singles.size() > pair_bases) singles.resize(pair_bases);
  std::vector<std::size_t> place(named_ * named_);  // of a pair in rivals_
  for (std::size_t r = all_.size(), a = 0; a < named_; ++a)
    for (std::size_t b = a + 1; b < named_; ++b, ++r) place[a * named_ + b] = place[b * named_ + a] = r;
  const std::vector<Candidate> partners(all_.begin(), all_.begin() + static_cast<long>(named_));
  for (const std::size_t base : singles) {
    const Rival& one = rivals_[base];
    const ScoreTable scores(*series_, one.candidate, one.fit, *whitener_, partners);
    if (!scores.ok()) continue;
    for (std::size_t i = 0; i < named_; ++i) {
      if (i == base) continue;
      Rival& pair = rivals_[place[base * named_ + i]];
      const ScoreTable::Score s = scores.of(i);
      const double estimate = one.gain + s.gain;
      if ((pair.base || pair.refitted) && pair.gain >= estimate) continue;  // from the nominal model: far less sure
      pair.candidate = pair_of(one.candidate, partners[i]);
      pair.base = true, pair.refitted = false;
      pair.gain = estimate;
      pair.guess = Eigen::VectorXd(one.fit.x.size() + 1);
      pair.guess << one.fit.x + scores.base_step({i}, s.amplitude), s.amplitude;
      pair.evidence = estimate - price(pair.candidate, estimate, pair.guess);
    }
  }
  // Slopes at slip 0 say little of a wrong radius, lugs or a soft wheel: beside the best from both sides of the step.
  const Rival& one = rivals_[singles[0]];
  for (std::size_t i = 0; i < named_; ++i) {
    const std::string& id = all_[i].id;
    if (i == singles[0] || !kinked_at_zero_slip(id)) continue;
    Rival& pair = rivals_[place[singles[0] * named_ + i]];
    for (const double side : {-1.0, 1.0}) {
      if (side < 0 && id != "wheel_radius_error") continue;
      Eigen::VectorXd x(one.fit.x.size() + 1);
      x << one.fit.x, side * kink_step(id);
      const Candidate c = pair_of(one.candidate, all_[i]);
      const Fit f = series_->fit(c, *whitener_, x, one.fit.theta, quick);
      const double gain = f.ok ? 0.5 * (none_.objective() - f.objective()) : 0;
      if (gain <= pair.gain && (pair.base || pair.refitted)) continue;
      pair.candidate = c, pair.base = true, pair.refitted = false, pair.gain = gain, pair.guess = f.x;
      pair.evidence = gain - price(c, gain, f.x);
    }
  }
  std::vector<Rival*> order;
  for (std::size_t r = all_.size(); r < rivals_.size(); ++r) order.push_back(&rivals_[r]);
  std::stable_sort(order.begin(), order.end(),
                   [](const Rival* a, const Rival* b) { return a->evidence > b->evidence; });
  double best = 0;
  for (const Rival& r : rivals_)
    if (r.refitted) best = std::max(best, r.evidence + r.weight);
  for (std::size_t k = 0; k < std::min(most_pairs, order.size()); ++k) {
    Rival& r = *order[k];
    if (r.evidence + r.weight < best - std::log(decisive) - 1) break;
    if (!r.refitted) {
      Fit f = refit(r.candidate, r.guess, none_);
      take(r, r.fit.ok && r.fit.objective() <= f.objective() ? std::move(r.fit) : std::move(f));
    }
    best = std::max(best, r.evidence + r.weight);
  }
}

/// Degrees of freedom behind the sensors' scales; a stated sd (prior 0.3 of its logarithm) counts as 1/(2 0.3^2) squares a channel.
double Search::noise_dof(double parameters) const {
  double dof = series_->layout().size() - parameters;
  for (const bool s : stated_) dof += s ? 5.5 : 0;
  return std::max(dof, 1.0);
}

void Search::weigh() {
  // The noise was fitted too: with scales known from nu squares, a loss of g in ln likelihood is one of nu/2 ln(1 + 2 g/nu) (Student).
  double most = 0;
  const Rival* leading = nullptr;
  for (const Rival& r : rivals_) {
    if (r.refitted) most = std::max(most, r.gain);
    if (r.refitted && r.fit.ok && (!leading || r.evidence + r.weight > leading->evidence + leading->weight))
      leading = &r;
  }
  const double nu = noise_dof(static_cast<double>(none_.x.size()) + 1);
  const auto student = [&](double g) { return -0.5 * nu * std::log1p(2 * std::max(most - g, 0.0) / nu); };
  // What more noise could explain is no effect; the leading account may have the noise that suits it as well.
  const double relief = own_noise_gain(none_) - (leading ? own_noise_gain(leading->fit) : 0);
  const double none = none_correction_ + std::max(student(0), std::min(relief - most, 0.0));
  const auto score = [&](const Rival& r) {
    return student(r.gain) + (r.evidence - r.gain) + r.weight - (r.refitted ? 0 : r.gain);
  };
  double top = none;
  for (const Rival& r : rivals_) top = std::max(top, score(r));
  double sum = std::exp(none - top), some = 0, unknown = 0;
  for (const Rival& r : rivals_) some += std::exp(score(r) - top);
  sum += some;
  for (Rival& r : rivals_) {
    r.posterior = std::exp(score(r) - top) / sum;
    if (!r.candidate.named()) unknown += r.posterior;
  }
  posterior_none_ = std::exp(none - top) / sum;
  posterior_unknown_ = unknown;
  mixture_ = some / std::max(std::exp(none - top), 1e-300);
  std::stable_sort(rivals_.begin(), rivals_.end(),
                   [](const Rival& a, const Rival& b) { return a.posterior > b.posterior; });
}

/// Evidence of those that could still win by importance sampling of the full model (D11b): the integrand exp(-objective/2)/prod |a| over soil and
/// amplitudes, against the normal that Laplace has in its place. What bends (the transition at slip 0, bounds) is in the first alone.
void Search::correct_finalists() {
  std::vector<Rival*> finalists;
  for (Rival& r : rivals_)
    if (r.refitted && r.fit.ok && finalists.size() < most_finalists &&
        r.posterior * decisive * decisive > rivals_[0].posterior)
      finalists.push_back(&r);
  // Far from every decision nothing is corrected: nothing to declare, or one account far ahead of all others and of none.
  if (mixture_ < 0.3 || (finalists.size() < 2 && mixture_ > 1e4)) return;
  const auto correction = [&](const Candidate& c, const Fit& f) {
    const Eigen::MatrixXd V = covariance(f);
    const Eigen::Index p = series_->soil_parameters();
    // Visible: beyond its error where all else is known, but no more than a third of the size found.
    const Eigen::VectorXd least = V.inverse().diagonal().cwiseInverse().cwiseMin(f.x.cwiseAbs2() / 9);
    constexpr double nowhere = -std::numeric_limits<double>::infinity();
    const auto ln_density = [&](const Eigen::VectorXd& x) {
      double ln = 0;
      for (Eigen::Index i = 0; i < x.size(); ++i) {
        const Term* t = i < p ? nullptr : &c.terms[static_cast<std::size_t>(i - p)];
        const double low = t ? t->lower : series_->parameter(i).lower,
                     high = t ? t->upper : series_->parameter(i).upper;
        if (x[i] < low || x[i] > high) return nowhere;
        if (!t || !c.named() || t->sd > 0) continue;
        if (x[i] * f.x[i] <= 0 || x[i] * x[i] < least[i]) return nowhere;  // not visible
        ln -= std::log(std::abs(x[i]));
      }
      std::vector<double> theta = f.theta;
      Eigen::VectorXd y;
      if (!series_->predict(c, x, theta, y)) return nowhere;
      Eigen::MatrixXd u = series_->measured() - y;
      whitener_->apply(u);
      return ln - 0.5 * (u.squaredNorm() + series_->prior_penalty(c, x) - f.objective());
    };
    const Integral z = importance_integral(f.x, V, ln_density, evidence_draws);
    return z.effective < least_effective ? 0 : std::clamp(z.ln - z.ln_normal, -most_correction, most_correction);
  };
  for (Rival* r : finalists) r->correction = correction(r->candidate, r->fit), r->evidence += r->correction;
  if (mixture_ < 1e4) none_correction_ = correction(nominal_candidate(), none_);
  weigh();
}

void Search::run() {
  const std::clock_t begin = std::clock();
  fit_nominal();
  join_aliases();
  elsewhere_.assign(named_, {});
  settle_noise({nominal_candidate(), none_});
  // What was ranked beside a nominal model that had not found its best, or under a noise that the winner denies, is ranked anew.
  for (int again = most_rankings; !rank(again == 0) || (again > 0 && other_noise_wins()); --again) {
    const Rival* best = leader();
    const std::pair<Candidate, Fit> first =
        best ? std::pair(best->candidate, best->fit) : std::pair(nominal_candidate(), none_);
    settle_noise(first);
  }
  // Few rows have many minima: the leading accounts from more places.
  if (series_->layout().size() < few) {
    std::vector<Rival*> leading;
    for (Rival& r : rivals_)
      if (r.refitted && r.fit.ok && r.candidate.named()) leading.push_back(&r);
    std::stable_sort(leading.begin(), leading.end(),
                     [](const Rival* a, const Rival* b) { return a->evidence + a->weight > b->evidence + b->weight; });
    if (leading.size() > 6) leading.resize(6);
    for (Rival* r : leading) {
      const Fit from = r->fit;
      for (int i = 0; i < series_->soil_parameters(); ++i)
        for (const double side : {-1.5, 0.0, 1.5}) {
          Eigen::VectorXd x = from.x;
          x[i] = series_->parameter(i).mean + side * series_->parameter(i).sd;
          Fit f = series_->fit(r->candidate, *whitener_, x, from.theta, full);
          if (f.ok && f.objective() < r->fit.objective()) r->fit = std::move(f);
        }
      take(*r, std::move(r->fit));
    }
  }
  settle_leading();
  weigh();
  correct_finalists();
  seconds_ = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

Search::Remainder Search::remainder(const Candidate& c, const Fit& f) const {
  Remainder out;
  std::vector<Candidate> others;
  for (const Candidate& o : all_)
    if (!(c.effects.size() == 1 && o.effects == c.effects)) others.push_back(o);
  const ScoreTable scores(*series_, c, f, *whitener_, others);
  if (!scores.ok()) return out;
  // What memory the noise still has beyond the one that it was given: slow changes are held against (1 + rho)/(1 - rho) of its variance.
  Eigen::MatrixXd u = f.residual;
  whitener_->apply(u);
  const double rho = ordered_ ? run_to_run(series_->layout(), u.col(0)) : 0, slow = (1 + rho) / (1 - rho);
  for (std::size_t i = 0; i < others.size(); ++i) {
    const double gain = scores.of(i).gain / (others[i].variable == "order" ? slow : 1);
    if (!(gain > 0)) continue;
    const double k = static_cast<double>(others[i].terms.size()),
                 nu = std::max(noise_dof(static_cast<double>(f.x.size())) - k, 1.0);
    const boost::math::fisher_f distribution(k, nu);
    // Squares that remain: of nu + k, which many rows have by the noise that was fitted to them; of few those that there are.
    const double all = series_->layout().size() < few ? std::max(f.objective(), nu + k) : nu + k;
    const double left = std::max(all - 2 * gain, 1e-6);
    const double p = boost::math::cdf(boost::math::complement(distribution, 2 * gain / k / (left / nu))) *
                     static_cast<double>(others.size());
    if (p < out.p) out = {p, others[i].id, gain};
  }
  return out;
}

std::string Search::soil_in_disguise(const Candidate& c, const Fit& f, std::size_t term) const {
  constexpr double own = 0.01;
  std::vector<double> theta = f.theta;
  Eigen::MatrixXd all;
  if (!series_->all_slopes(c, f.x, theta, all)) return "";
  const auto column = [&](int input, const Term* t) {
    Eigen::VectorXd q = all.col(input);
    if (t && t->shape.size())
      for (int i = 0; i < series_->layout().size(); ++i) q[i] *= t->shape[series_->layout()[i].run];
    return q;
  };
  Eigen::MatrixXd base(series_->layout().size(), soil_count + static_cast<Eigen::Index>(c.terms.size()) - 1);
  for (int i = 0; i < static_cast<int>(soil_count); ++i) base.col(i) = column(i, nullptr);
  Eigen::Index at = soil_count;
  for (std::size_t t = 0; t < c.terms.size(); ++t)
    if (t != term) base.col(at++) = column(c.terms[t].input, &c.terms[t]);
  Eigen::MatrixXd q = column(c.terms[term].input, &c.terms[term]);
  whitener_->apply(base);
  whitener_->apply(q);
  const double whole = q.norm();
  if (!(whole > 0)) return "";
  for (Eigen::Index i = 0; i < base.cols(); ++i)
    if (base.col(i).norm() > 0) base.col(i).normalize();
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(base);
  qr.setThreshold(1e-9);
  const double left = (q.col(0) - base * qr.solve(q.col(0))).norm();
  const double amplitude = f.x[series_->soil_parameters() + static_cast<Eigen::Index>(term)];
  if (left > own * whole || left * std::abs(amplitude) > 1) return "";
  Eigen::Index nearest = 0;
  (base.leftCols(soil_count).transpose() * q.col(0)).cwiseAbs().maxCoeff(&nearest);
  return soil_coordinates()[static_cast<std::size_t>(nearest)].name;
}

Eigen::MatrixXd Search::covariance(const Fit& f) const {
  Eigen::MatrixXd A = f.jacobian;
  whitener_->apply(A);
  Eigen::MatrixXd N = A.transpose() * A;
  N.diagonal() += f.precision;
  return N.ldlt().solve(Eigen::MatrixXd::Identity(N.rows(), N.cols()));
}

}  // namespace grouser::diagnosis
