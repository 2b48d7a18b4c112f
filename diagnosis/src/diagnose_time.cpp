// From series to verdict: every account is fitted, weighed and tested; then what would decide and what is gained.
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <ctime>
#include <map>
#include <random>

#include "grouser/terrain/csv.h"
#include "shares.h"
#include "time_next.h"
#include "told.h"

namespace grouser::diagnosis {

namespace {

constexpr TimeExtra extras[] = {TimeExtra::shape_time, TimeExtra::shape_travel, TimeExtra::drift, TimeExtra::levels};

TimeAccount with(std::initializer_list<TimeEffect> effects, TimeExtra extra = TimeExtra::none) {
  TimeAccount a;
  for (const TimeEffect e : effects) a.on[static_cast<std::size_t>(e)] = true;
  a.extra = extra;
  return a;
}

struct Split {
  std::vector<TimeRun> kept, withheld;
};
/// A run is withheld by what its last row says.
Split split(const TimeTable& t, const std::vector<std::string>& withhold) {
  Split out;
  std::vector<bool> leave(t.runs.size(), false);
  for (const std::string& text : withhold) {
    const std::size_t eq = text.find('='), dots = text.find("..", eq == std::string::npos ? 0 : eq);
    const std::string column = text.substr(0, eq), value = eq == std::string::npos ? "" : text.substr(eq + 1);
    const auto low = parse_number(value.substr(0, dots == std::string::npos ? dots : dots - eq - 1));
    const auto high = dots == std::string::npos ? low : parse_number(text.substr(dots + 2));
    if (!low || !high)
      throw ConfigError("--withhold", 0, 0,
                        "'" + text + "' is not understood; write a column and a value as in batch=3 or slip=0.7..0.95");
    const auto& cells = t.runs[0].rows[0].cells;
    if (cells.count(column) == 0) {
      std::vector<std::string> known;
      for (const auto& [name, x] : cells) known.push_back(name);
      const auto near = did_you_mean(column, known);
      throw ConfigError("--withhold", 0, 0,
                        "'" + column + "' cannot be withheld by" +
                            (near ? "; did you mean '" + *near + "'?" : "; one of " + list_of(known)));
    }
    bool used = false;
    for (std::size_t r = 0; r < t.runs.size(); ++r) {
      const double x = t.runs[r].rows.back().cells.at(column), slack = 1e-6 * (1 + std::abs(*low));
      if (x >= *low - slack && x <= *high + slack) leave[r] = used = true;
    }
    if (!used) throw ConfigError("--withhold", 0, 0, "the last row of no run has " + text);
  }
  for (std::size_t r = 0; r < t.runs.size(); ++r) (leave[r] ? out.withheld : out.kept).push_back(t.runs[r]);
  if (out.kept.empty()) throw ConfigError("--withhold", 0, 0, "every run is withheld; nothing is left to fit");
  return out;
}

/// Effects that these rows can show at all; why not goes to the notes.
std::array<bool, time_effect_count> visible(const TimeModel& m, std::vector<std::string>& notes) {
  std::array<bool, time_effect_count> out = m.given().options.considered;
  const auto ripple = static_cast<std::size_t>(TimeEffect::ripple);
  if (out[ripple]) {
    double fastest = 0, least_turn = 1e300;
    for (const TimeRun& r : m.runs()) {
      for (const Run& row : r.rows) fastest = std::max(fastest, row.omega * r.spacing);
      least_turn = std::min(least_turn, r.turn.back());
    }
    const double lugs = m.given().options.lugs;
    if (fastest * lugs > 2.8) {  // pi is the end; a little before it sine and cosine are one column
      out[ripple] = false;
      notes.push_back("ripple is left out: between two rows up to " + short_number(fastest * lugs / 6.2831853, 2) +
                      " lugs pass; more than two rows for each lug are needed");
    } else if (least_turn * lugs < 6.3) {
      notes.emplace_back("in some run less than one lug passes: its ripple looks like an offset there");
    }
  }
  return out;
}

/// Largest change of the steady answer within a run, over the noise.
double excitement(const TimeModel& m, const RowMatrix& y) {
  double most = 0;
  for (std::size_t i = 0; i < m.items().size(); ++i) {
    const TimeModel::Item& a = m.items()[i];
    for (std::size_t j = i; j-- > 0 && m.items()[j].run == a.run && m.items()[j].channel == a.channel;) {
      if (m.items()[j].gap > 0) continue;  // first of this run and channel
      most = std::max(most, std::abs(y(a.row, a.channel) - y(m.items()[j].row, a.channel)) / a.sd);
    }
  }
  return most;
}

Interval shown(const TimeModel& m, const TimeRival& r, TimeEffect e) {
  Interval out;
  const int i = m.index_of(r.account, e);
  const double nu = std::max(1.0, static_cast<double>(m.items().size()) - static_cast<double>(r.fit.x.size()));
  const double t = boost::math::quantile(boost::math::students_t(nu), 0.95);
  out.unit = time_effects()[static_cast<std::size_t>(e)].unit;
  if (e == TimeEffect::ripple) {  // of the first force channel
    const double a = r.fit.x[i], b = r.fit.x[i + 1];
    out.value = std::hypot(a, b);
    const double u = out.value > 0 ? a / out.value : 1, v = out.value > 0 ? b / out.value : 0;
    out.sd = std::sqrt(std::max(u * u * r.fit.covariance(i, i) + v * v * r.fit.covariance(i + 1, i + 1) +
                                    2 * u * v * r.fit.covariance(i, i + 1),
                                0.0));
    out.low = std::max(0.0, out.value - t * out.sd), out.high = out.value + t * out.sd;
    out.unit = channel_names()[static_cast<std::size_t>(m.channels()[0])].unit;
  } else {
    const double sd = std::sqrt(std::max(r.fit.covariance(i, i), 0.0));
    out.value = std::exp(r.fit.x[i]);
    out.sd = out.value * sd, out.low = out.value * std::exp(-t * sd), out.high = out.value * std::exp(t * sd);
    const TimeParameter p = m.parameters(r.account)[static_cast<std::size_t>(i)];
    out.at_bound = r.fit.x[i] < p.lower + 1e-6 || r.fit.x[i] > p.upper - 1e-6;
  }
  return out;
}

FittedModel model_of(const TimeModel& m, const TimeRival& r) {
  FittedModel out;
  std::array<double, channel_count> sum{}, count{};
  const Eigen::VectorXd left = m.measured() - m.item_values(r.fit.predicted);
  for (std::size_t i = 0; i < m.items().size(); ++i) {
    const auto ch = static_cast<std::size_t>(m.channels()[static_cast<std::size_t>(m.items()[i].channel)]);
    sum[ch] += std::pow(left[static_cast<Eigen::Index>(i)], 2), count[ch] += 1;
  }
  for (std::size_t c = 0; c < channel_count; ++c)
    out.rmse[c] = count[c] > 0 ? std::sqrt(sum[c] / count[c]) : std::numeric_limits<double>::quiet_NaN();
  out.chi2 = r.fit.chi2;
  out.dof = static_cast<double>(m.items().size()) - m.soil_parameters() - r.account.effects();
  for (int k = 0; k < m.soil_parameters(); ++k) {
    const int i = m.free_soil()[static_cast<std::size_t>(k)];
    const SoilCoordinate& s = soil_coordinates()[static_cast<std::size_t>(i)];
    const SoilPrior& p = m.given().steady.soil[static_cast<std::size_t>(i)];
    const double x = r.fit.x[k], sd = std::sqrt(std::max(r.fit.covariance(k, k), 0.0));
    out.parameters[s.name] = {s.logarithmic ? std::exp(x) : x, s.logarithmic ? std::exp(x) * sd : sd,
                              (x - p.mean) / p.sd, s.unit};
  }
  for (int row = 0; row < m.rows(); ++row) {
    std::array<double, channel_count> y;
    y.fill(std::numeric_limits<double>::quiet_NaN());
    for (std::size_t k = 0; k < m.channels().size(); ++k)
      y[static_cast<std::size_t>(m.channels()[k])] = r.fit.predicted(row, static_cast<Eigen::Index>(k));
    out.predicted.push_back(y);
  }
  return out;
}

/// Rows of `runs` foretold by a fit to others: their own soil scatter is zero; a state begins at its first row where starts are free.
/// Sum of squares over stated sd, without that first row; NaN where the model has no answer.
struct Missed {
  double square = 0, rows = 0;
  std::array<double, channel_count> sum{}, count{};
};
std::optional<Missed> missed(const TimeModel& fitted, const TimeRival& r, const TimeRun& run,
                             const std::array<bool, channel_count>& measured,
                             const std::array<bool, channel_count>& stated) {
  const TimeModel other(fitted.given(), {run}, measured, stated);
  Eigen::VectorXd x = other.start(r.account);  // starts: the first measured value
  x.head(fitted.soil_parameters()) = r.fit.x.head(fitted.soil_parameters());
  for (int e = 0; e < time_effect_count; ++e) {
    const int i = fitted.index_of(r.account, static_cast<TimeEffect>(e)),
              j = other.index_of(r.account, static_cast<TimeEffect>(e));
    const int n = e == static_cast<int>(TimeEffect::ripple) ? 2 * static_cast<int>(fitted.channels().size()) : 1;
    if (i >= 0) x.segment(j, n) = r.fit.x.segment(i, n);
  }
  RowMatrix y;
  if (!other.predict(r.account, x, y, nullptr)) return std::nullopt;
  Missed out;
  const Eigen::VectorXd left = other.measured() - other.item_values(y);
  for (std::size_t i = 0; i < other.items().size(); ++i) {
    const TimeModel::Item& item = other.items()[i];
    if (item.gap == 0) continue;
    const auto ch = static_cast<std::size_t>(other.channels()[static_cast<std::size_t>(item.channel)]);
    const double e = left[static_cast<Eigen::Index>(i)];
    out.square += e * e / (item.sd * item.sd), out.rows += 1;
    out.sum[ch] += e * e, out.count[ch] += 1;
  }
  return out;
}

class TimeSearch {
 public:
  TimeSearch(const TimeCase& c, const TimeTable& data, std::vector<TimeRun> runs)
      : model_(c, std::move(runs), data.rows.measured, data.rows.stated_sd) {}

  const TimeModel& model() const { return model_; }
  std::vector<TimeRival> rivals;  ///< most probable first
  TimeRival none;

  void run(std::vector<std::string>& notes) {
    const std::array<bool, time_effect_count> seen = visible(model_, notes);
    std::array<TimeNoise, channel_count> noise{};
    for (TimeNoise& n : noise) n.rho = 0.5;
    none.fit = model_.fit(none.account, model_.start(none.account), noise);
    if (!none.fit.ok)
      throw ConfigError(model_.given().steady.file.string(), 0, 0,
                        "the steady wheel has no answer for some row at the stated soil; check load, radius and soil");
    std::vector<double> ln{std::log(share_none) + none.fit.log_evidence};
    rivals = {none};
    std::vector<TimeEffect> ids;
    for (int e = 0; e < time_effect_count; ++e)
      if (seen[static_cast<std::size_t>(e)]) ids.push_back(static_cast<TimeEffect>(e));
    const double singles = static_cast<double>(ids.size()), pairs = singles * (singles - 1) / 2;
    std::map<TimeEffect, TimeRival> alone;
    const auto add = [&](TimeRival r, double share) {
      if (!r.fit.ok) return;
      ln.push_back(std::log((1 - share_none) * share) + r.fit.log_evidence);
      rivals.push_back(std::move(r));
    };
    for (const TimeEffect e : ids) {
      TimeRival r{with({e}), {}, 0};
      r.fit = model_.search(r.account, none.account, none.fit);
      alone[e] = r;
      add(std::move(r), share_named / singles);
    }
    for (const TimeExtra x : extras) {
      TimeRival r{with({}, x), {}, 0};
      r.fit = model_.search(r.account, none.account, none.fit);
      add(std::move(r), share_drift / std::size(extras));
    }
    // Pairs, from the better of the two; where nothing gains anything, two things gain nothing either.
    double most = 0;
    for (const TimeRival& r : rivals) most = std::max(most, r.fit.log_likelihood - none.fit.log_likelihood);
    for (std::size_t a = 0; most > 3 && a < ids.size(); ++a)
      for (std::size_t b = a + 1; b < ids.size(); ++b) {
        TimeRival r{with({ids[a], ids[b]}), {}, 0};
        const TimeRival &p = alone[ids[a]], &q = alone[ids[b]];
        const TimeRival& base = !q.fit.ok || (p.fit.ok && p.fit.log_evidence > q.fit.log_evidence) ? p : q;
        if (base.fit.ok) r.fit = model_.search(r.account, base.account, base.fit);
        add(std::move(r), share_pair / pairs);
      }
    const double top = *std::max_element(ln.begin(), ln.end());
    double sum = 0;
    for (double& v : ln) sum += v = std::exp(v - top);
    for (std::size_t i = 0; i < rivals.size(); ++i) rivals[i].posterior = ln[i] / sum;
    none.posterior = rivals[0].posterior;
    std::stable_sort(rivals.begin(), rivals.end(),
                     [](const TimeRival& a, const TimeRival& b) { return a.posterior > b.posterior; });
  }

  /// What is left over by `best`: each account without a name on top of it, p of the gain times the number of tests.
  std::vector<TimeDiagnosis::Test> gate(const TimeRival& best) const {
    std::vector<TimeDiagnosis::Test> out;
    for (const TimeExtra x : extras) {
      TimeAccount more = best.account;
      more.extra = x;
      const auto known = std::find_if(rivals.begin(), rivals.end(), [&](const TimeRival& r) {
        return r.account.on == more.on && r.account.extra == x;
      });
      const TimeFit f = known != rivals.end()
                            ? known->fit
                            : model_.fit(more, model_.carried(best.account, best.fit.x, more), best.fit.noise);
      if (!f.ok) continue;
      const double gain = 2 * (f.log_likelihood - best.fit.log_likelihood);
      const double k = static_cast<double>(f.x.size() - best.fit.x.size());
      const double p = gain > 0 ? boost::math::cdf(boost::math::complement(boost::math::chi_squared(k), gain)) : 1.0;
      out.push_back({with({}, x).id(), std::min(1.0, p * static_cast<double>(std::size(extras)))});
    }
    std::sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.p < b.p; });
    return out;
  }

  /// Gain in chi2 on runs left out, five at most; NaN with a single run.
  double cross_validate(const TimeCase& c, const TimeTable& data, const TimeRival& r) const {
    const std::size_t R = model_.runs().size(), folds = std::min<std::size_t>(R, 5);
    if (R < 2) return std::numeric_limits<double>::quiet_NaN();
    double gain = 0;
    int foretold = 0;
    for (std::size_t fold = 0; fold < folds; ++fold) {
      std::vector<TimeRun> kept, out;
      for (std::size_t i = 0; i < R; ++i) (i % folds == fold ? out : kept).push_back(model_.runs()[i]);
      const TimeModel m(c, kept, data.rows.measured, data.rows.stated_sd);
      Eigen::VectorXd still = m.start(none.account);
      still.head(m.soil_parameters()) = none.fit.x.head(m.soil_parameters());
      const TimeRival plain{none.account, m.fit(none.account, still, none.fit.noise), 0};
      TimeRival named{r.account, {}, 0};
      Eigen::VectorXd x = m.start(r.account);
      x.head(m.soil_parameters()) = r.fit.x.head(m.soil_parameters());
      for (int e = 0; e < time_effect_count; ++e) {
        const int i = model_.index_of(r.account, static_cast<TimeEffect>(e)),
                  j = m.index_of(r.account, static_cast<TimeEffect>(e));
        const int n = e == static_cast<int>(TimeEffect::ripple) ? 2 * static_cast<int>(m.channels().size()) : 1;
        if (i >= 0) x.segment(j, n) = r.fit.x.segment(i, n);
      }
      named.fit = m.fit(r.account, x, r.fit.noise, 2);
      if (!plain.fit.ok || !named.fit.ok) continue;
      for (const TimeRun& run : out) {
        const auto a = missed(m, plain, run, data.rows.measured, data.rows.stated_sd);
        const auto b = missed(m, named, run, data.rows.measured, data.rows.stated_sd);
        if (a && b) gain += a->square - b->square, ++foretold;
      }
    }
    return foretold > 0 ? gain : std::numeric_limits<double>::quiet_NaN();  // NaN: the steady wheel has no answer there
  }

 private:
  TimeModel model_;
};

Gain gain_on(const TimeSearch& s, const TimeRival& r, const std::vector<TimeRun>& withheld, const TimeTable& data,
             const std::vector<std::string>& names) {
  Gain g;
  g.withheld = names;
  std::vector<std::array<double, 2>> runs;
  std::array<double, channel_count> count{};
  for (const TimeRun& run : withheld) {
    const auto a = missed(s.model(), s.none, run, data.rows.measured, data.rows.stated_sd);
    const auto b = missed(s.model(), r, run, data.rows.measured, data.rows.stated_sd);
    if (!a || !b) continue;
    runs.push_back({a->square, b->square});
    for (std::size_t c = 0; c < channel_count; ++c)
      g.nominal_rmse[c] += a->sum[c], g.extended_rmse[c] += b->sum[c], count[c] += a->count[c];
  }
  for (std::size_t c = 0; c < channel_count; ++c) {
    g.nominal_rmse[c] = std::sqrt(g.nominal_rmse[c] / std::max(count[c], 1.0));
    g.extended_rmse[c] = std::sqrt(g.extended_rmse[c] / std::max(count[c], 1.0));
  }
  g.runs = static_cast<int>(runs.size());
  double a = 0, b = 0;
  for (const auto& q : runs) a += q[0], b += q[1];
  g.rmse_ratio = a > 0 ? std::sqrt(b / a) : 1;
  std::mt19937_64 random(20112022);
  std::vector<double> draws;
  for (int k = 0; k < 2000 && !runs.empty(); ++k) {
    double p = 0, q = 0;
    for (std::size_t i = 0; i < runs.size(); ++i) {
      const auto& pick = runs[random() % runs.size()];
      p += pick[0], q += pick[1];
    }
    draws.push_back(p > 0 ? std::sqrt(q / p) : 1);
  }
  std::sort(draws.begin(), draws.end());
  if (!draws.empty()) g.low = draws[50], g.high = draws[1949];
  return g;
}

std::string amount(const Interval& i) {
  const bool mm = i.unit == "m";
  const double f = mm ? 1000 : 1;
  return short_number(i.value * f) + " [" + short_number(i.low * f) + ", " + short_number(i.high * f) + "] " +
         (mm ? "mm" : i.unit);
}

/// "relaxation_length 62 [55, 70] mm"
std::string amounts(const TimeModel& m, const TimeRival& r) {
  std::string out;
  for (int e = 0; e < time_effect_count; ++e)
    if (r.account.on[static_cast<std::size_t>(e)])
      out += (out.empty() ? "" : ", ") + std::string(time_effects()[static_cast<std::size_t>(e)].id) + " " +
             amount(shown(m, r, static_cast<TimeEffect>(e)));
  return out;
}

}  // namespace

TimeDiagnosis diagnose_time(const TimeCase& c, const TimeTable& data, const std::vector<std::string>& withhold) {
  const std::clock_t begin = std::clock();
  TimeDiagnosis t;
  Diagnosis& d = t.d;
  d.notes = data.rows.notes;
  const Split parts = split(data, withhold);
  TimeSearch s(c, data, parts.kept);
  s.run(d.notes);
  d.rank_seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  const TimeModel& m = s.model();

  for (const TimeRun& r : m.runs()) d.runs.insert(d.runs.end(), r.rows.begin(), r.rows.end());
  d.weights.assign(d.runs.size(), 1.0);
  d.posterior["none"] = s.none.posterior;
  d.posterior["unknown"] = 0;
  for (const TimeRival& r : s.rivals) {
    if (r.account.extra != TimeExtra::none) d.posterior["unknown"] += r.posterior;
    if (r.account.effects() == 0 && r.account.extra == TimeExtra::none) continue;
    if (r.account.extra == TimeExtra::none) d.posterior[r.account.id()] = r.posterior;
    Ranked q;
    q.id = r.account.id();
    q.log_likelihood = r.fit.log_likelihood - s.none.fit.log_likelihood;
    q.log_evidence = r.fit.log_evidence - s.none.fit.log_evidence;
    q.posterior = r.posterior;
    q.cross_validation = std::numeric_limits<double>::quiet_NaN();
    q.refitted = true;
    for (int e = 0; e < time_effect_count; ++e)
      if (r.account.on[static_cast<std::size_t>(e)]) q.amplitudes.push_back(shown(m, r, static_cast<TimeEffect>(e)));
    d.ranking.push_back(q);
  }

  // The best account that has a name, and who is within odds of ten of it.
  const TimeRival* best = &s.none;
  for (const TimeRival& r : s.rivals)
    if (r.account.extra == TimeExtra::none) {
      best = &r;
      break;
    }
  const TimeRival& first = s.rivals[0];
  std::vector<TimeRival> members;
  for (const TimeRival& r : s.rivals)
    if (r.account.extra == TimeExtra::none && r.account.effects() > 0 && r.posterior * decisive >= best->posterior)
      members.push_back(r);
  const double odds_any = (1 - s.none.posterior) / std::max(s.none.posterior, 1e-300);
  const double excited = excitement(m, s.none.fit.predicted);
  const bool still = excited < 5 && !c.options.free_start;
  bool strained = false;
  d.nominal = model_of(m, s.none);
  for (const auto& [name, v] : d.nominal.parameters) strained = strained || std::abs(v.prior_z) > 3;

  const TimeRival* extended = best;
  if (still && odds_any < decisive) {
    d.verdict = "undecidable";
    d.sentence = "Nothing changes in these runs: the steady answer moves by " + short_number(excited, 2) +
                 " times the noise, so no delay, filter or relaxation length could show. Step the slip.";
    NextExperiment e;
    e.condition = {{"slip_from", 0}, {"slip_to", 0.5}};
    e.runs = 1, e.cost = 1;
    for (const TimeEffectInfo& info : time_effects()) e.decides.emplace_back(info.id);
    e.chance = std::numeric_limits<double>::quiet_NaN();
    d.next.push_back(e);
    extended = &s.none;
  } else if (odds_any < decisive) {
    extended = &s.none;
    t.gate = s.gate(s.none);
    d.verdict = strained ? "parameter" : "adequate";
    d.sentence = strained ? "The steady wheel answers at once, as the runs do, but its soil leaves what is known of it."
                          : "The steady wheel answers at once, and so do the runs, within their noise.";
    if (odds_any > 1 / decisive)
      d.notes.push_back("that something is hidden cannot be excluded: odds " + short_number(odds_any, 2) + ":1 for it");
  } else {
    t.gate = s.gate(*best);
    bool passed = best->account.effects() > 0;
    for (const auto& test : t.gate) passed = passed && test.p >= gate_p;
    const bool unnamed_close = first.account.extra != TimeExtra::none ||
                               std::any_of(s.rivals.begin(), s.rivals.end(), [&](const TimeRival& r) {
                                 return r.account.extra != TimeExtra::none && r.posterior * decisive > best->posterior;
                               });
    // Scales below half a row are not seen: there all three lags are one shift, and how the rig moved between rows is not known.
    bool tiny = best->account.effects() > 0 && !best->account.has(TimeEffect::ripple);
    for (const TimeEffect e : {TimeEffect::relaxation_length, TimeEffect::filter, TimeEffect::delay}) {
      const int i = m.index_of(best->account, e);
      if (i < 0) continue;
      const double scale = std::exp(best->fit.x[i]) / (e == TimeEffect::relaxation_length ? m.speed() : 1);
      tiny = tiny && scale < 0.5 * m.spacing();
    }
    double crossed = std::numeric_limits<double>::quiet_NaN();
    if (best->account.effects() > 0) {
      crossed = s.cross_validate(c, data, *best);
      for (Ranked& r : d.ranking)
        if (r.id == best->account.id()) r.cross_validation = crossed;
    }
    if (passed && tiny) {
      d.verdict = "undecidable";
      for (const TimeRival& r : members) d.members.push_back(r.account.id());
      NextExperiment e;
      e.condition = {{"spacing_s", m.spacing() / 10}};
      e.decides = d.members, e.runs = 1, e.cost = 1;
      e.chance = std::numeric_limits<double>::quiet_NaN();
      d.next.push_back(e);
    } else if (passed && !unnamed_close && !(crossed <= 0)) {
      d.verdict = members.size() == 1 ? "named" : "class";
      for (const TimeRival& r : members) d.members.push_back(r.account.id());
      if (members.size() == 1) d.cause = members[0].account.id();
    } else {
      d.verdict = "unknown";
      const std::string most = first.account.extra != TimeExtra::none ? first.account.id()
                               : !t.gate.empty()                      ? t.gate[0].about
                                                                      : "";
      d.unknown_variable = most.find("travel") != std::string::npos ? "travel"
                           : most.find("slip") != std::string::npos ? "slip"
                                                                    : "time";
      double worst = 0;
      const Eigen::VectorXd left = m.measured() - m.item_values(best->fit.predicted);
      std::array<double, channel_count> sum{}, count{};
      for (std::size_t i = 0; i < m.items().size(); ++i) {
        const auto ch = static_cast<std::size_t>(m.channels()[static_cast<std::size_t>(m.items()[i].channel)]);
        sum[ch] += std::pow(left[static_cast<Eigen::Index>(i)] / m.items()[i].sd, 2), count[ch] += 1;
      }
      for (std::size_t ch = 0; ch < channel_count; ++ch)
        if (count[ch] > 0 && sum[ch] / count[ch] > worst)
          worst = sum[ch] / count[ch], d.unknown_through = channel_names()[ch].short_name;
      for (const TimeRival& r : members) d.members.push_back(r.account.id());
      if (crossed <= 0) d.notes.emplace_back("on runs left out the leading account does worse than the steady wheel");
    }
    if (d.verdict == "undecidable")
      d.sentence = "Something is late by less than half the time between rows: " + amounts(m, *best) +
                   ". What it is cannot be said; repeat with rows ten times closer.";
    else if (d.verdict == "named")
      d.sentence =
          "The runs do not answer as the steady wheel does: " + amounts(m, *best) + " (odds " +
          (s.rivals.size() > 1 ? short_number(best->posterior / std::max(s.rivals[1].posterior, 1e-300), 2) : "-") +
          ":1 over the next account).";
    else if (d.verdict == "class") {
      std::vector<std::string> ids;
      for (const TimeRival& r : members) ids.push_back(amounts(m, r));
      d.sentence = "The runs lag behind the steady wheel; these rows cannot tell which it is: " + list_of(ids) + ".";
    } else {
      d.sentence = "The runs do not answer as the steady wheel does, and no account in the list leaves only noise: " +
                   (first.account.extra != TimeExtra::none ? first.account.id()
                    : t.gate.empty()                       ? std::string("?")
                                     : t.gate[0].about + " (p = " + short_number(t.gate[0].p, 2) + ")") +
                   (best->account.effects() > 0 ? ". Nearest: " + amounts(m, *best) + "." : ".");
    }
    if (d.verdict == "class" || (d.verdict == "unknown" && members.size() > 1)) d.next = next_series(m, members);
  }
  d.extended = model_of(m, *extended);
  for (int e = 0; e < time_effect_count; ++e)
    if (extended->account.on[static_cast<std::size_t>(e)])
      d.parameters[time_effects()[static_cast<std::size_t>(e)].id] = shown(m, *extended, static_cast<TimeEffect>(e));
  t.nominal_noise = s.none.fit.noise, t.extended_noise = extended->fit.noise;
  d.sd.resize(d.runs.size());
  for (std::size_t i = 0; i < d.runs.size(); ++i) {
    d.sd[i].fill(std::numeric_limits<double>::quiet_NaN());
    for (std::size_t k = 0; k < m.channels().size(); ++k) {
      const auto ch = static_cast<std::size_t>(m.channels()[k]);
      d.sd[i][ch] = m.sd(static_cast<int>(i), static_cast<int>(k)) * t.extended_noise[ch].scale;
    }
  }
  for (std::size_t ch = 0; ch < channel_count; ++ch) d.noise_scale[ch] = t.extended_noise[ch].scale;
  for (const int ch : m.channels())
    if (t.extended_noise[static_cast<std::size_t>(ch)].rho > 0.95)
      d.notes.push_back(std::string(channel_names()[static_cast<std::size_t>(ch)].short_name) +
                        ": what is left over wanders (correlation of neighbours " +
                        short_number(t.extended_noise[static_cast<std::size_t>(ch)].rho) +
                        "); as noise that is a lot, as a slow effect it has no name here");
  if (extended->account.has(TimeEffect::relaxation_length)) {
    const Interval i = shown(m, *extended, TimeEffect::relaxation_length);
    t.physics =
        "relaxation_length " + amount(i) +
        " of all channels is not yet in a model. bekker.steady has an option of that name, in contact lengths, for "
        "the shear displacement alone; its sinkage follows the wheel's own motion.";
  }
  if (extended->account.has(TimeEffect::filter) || extended->account.has(TimeEffect::delay))
    t.physics += std::string(t.physics.empty() ? "" : " ") + "Filter and delay are of the rig: no vehicle feels them.";
  if (!parts.withheld.empty()) d.gain = gain_on(s, *extended, parts.withheld, data, withhold);
  d.total_seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  return t;
}

}  // namespace grouser::diagnosis
