#include <algorithm>
#include <cmath>
#include <ctime>

#include "cross_validation.h"
#include "gain.h"
#include "grouser/diagnosis/design.h"
#include "grouser/diagnosis/diagnose.h"
#include "grouser/terrain/config.h"
#include "grouser/terrain/csv.h"
#include "lack_of_fit.h"
#include "needed.h"
#include "next_experiment.h"
#include "profile.h"
#include "rig_model.h"
#include "search.h"
#include "statics.h"
#include "told.h"

namespace grouser::diagnosis {
namespace {

constexpr double conflict_z = 3, swallowing = 2.5, suspicious = 3, beyond_doubt = 20, normal_95 = 1.6448536269514722;
constexpr double moved_z = 2, needed_rise = 20;  // a soil value that had to move, inside its prior
constexpr double absurd = 6;                     // times the ordinary size of what a sensor does wrong

/// `typical`: ordinary size of the amplitude.
Interval shown_interval(int entry, double amplitude, double low, double high, double sd, double typical) {
  const EffectEntry& e = effect_entries()[static_cast<std::size_t>(entry)];
  const auto show = [&](double a) { return e.inverse ? (a > 0 ? 1 / a : INFINITY) : (e.off + a) * e.shown; };
  Interval i;
  i.value = show(amplitude);
  i.sd = e.inverse ? sd / std::max(amplitude * amplitude, 1e-12) : sd * e.shown;
  i.low = std::min(show(low), show(high)), i.high = std::max(show(low), show(high));
  i.unit = e.unit;
  i.times_typical = std::abs(amplitude / typical);
  i.at_bound = e.off + amplitude <= e.lower + 1e-9 || e.off + amplitude >= e.upper - 1e-9;
  return i;
}

/// Ordinary size of a term: what the case states, else that of the list.
double ordinary(int entry, const Term& t) {
  const EffectEntry& e = effect_entries()[static_cast<std::size_t>(entry)];
  return t.sd > 0 ? t.sd : std::abs(e.typical - e.off);
}

std::vector<Interval> amplitudes_of(const Search& s, const Rival& r) {
  std::vector<Interval> out;
  if (!r.refitted || !r.fit.ok) return out;
  const Eigen::MatrixXd V = s.covariance(r.fit);
  const Eigen::Index p = s.series().soil_parameters();
  for (std::size_t k = 0; k < r.candidate.effects.size(); ++k) {
    const auto i = p + static_cast<Eigen::Index>(k);
    const double a = r.fit.x[i], sd = std::sqrt(std::max(V(i, i), 0.0));
    const Term& t = r.candidate.terms[k];
    out.push_back(shown_interval(r.candidate.effects[k], a, std::max(a - normal_95 * sd, t.lower),
                                 std::min(a + normal_95 * sd, t.upper), sd, ordinary(r.candidate.effects[k], t)));
  }
  return out;
}

FittedModel model_of(const Search& s, const Fit& f) {
  FittedModel m;
  const Series& series = s.series();
  const Eigen::MatrixXd V = s.covariance(f);
  m.chi2 = f.chi2;
  m.dof = series.layout().size() - static_cast<double>(f.x.size());
  std::array<double, channel_count> sum{};
  std::array<int, channel_count> count{};
  m.predicted.resize(series.runs().size());
  for (auto& p : m.predicted) p.fill(std::numeric_limits<double>::quiet_NaN());
  for (int i = 0; i < series.layout().size(); ++i) {
    const auto ch = static_cast<std::size_t>(series.layout()[i].channel);
    sum[ch] += f.residual[i] * f.residual[i];
    ++count[ch];
    const auto run = static_cast<std::size_t>(series.layout()[i].run);
    m.predicted[run][ch] = series.runs()[run].value[ch] - f.residual[i];
  }
  for (std::size_t ch = 0; ch < channel_count; ++ch)
    m.rmse[ch] = count[ch] ? std::sqrt(sum[ch] / count[ch]) : std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < series.soil_parameters(); ++i) {
    const Parameter& p = series.parameter(i);
    const double sd = std::sqrt(std::max(V(i, i), 0.0));
    FittedValue v{p.logarithmic ? std::exp(f.x[i]) : f.x[i], sd, (f.x[i] - p.mean) / p.sd, p.unit};
    v.sd_over_prior = sd / p.sd;
    if (p.logarithmic) v.sd *= v.value;
    m.parameters[p.name] = v;
  }
  return m;
}

/// Withheld runs and the others. "load_N=225" or "slip=0.3..0.7".
struct Split {
  std::vector<Run> kept, withheld;
};
Split split(const RunTable& t, const std::vector<std::string>& withhold) {
  Split out;
  struct Rule {
    std::string column;
    double low, high;
    bool used = false;
  };
  std::vector<Rule> rules;
  for (const std::string& text : withhold) {
    const std::size_t eq = text.find('=');
    const std::string value = eq == std::string::npos ? "" : text.substr(eq + 1);
    const std::size_t dots = value.find("..");
    const auto low = parse_number(value.substr(0, dots)),
               high = dots == std::string::npos ? low : parse_number(value.substr(dots + 2));
    if (eq == std::string::npos || !low || !high)
      throw ConfigError(
          "--withhold", 0, 0,
          "'" + text + "' is not understood; write a column and a value as in load_N=225 or slip=0.3..0.7");
    const std::string column = text.substr(0, eq);
    if (t.runs[0].cells.count(column) == 0) {
      std::vector<std::string> known;
      for (const auto& [name, x] : t.runs[0].cells) known.push_back(name);
      const auto near = did_you_mean(column, known);
      throw ConfigError("--withhold", 0, 0,
                        "'" + column + "' cannot be withheld by" +
                            (near ? "; did you mean '" + *near + "'?" : "; one of " + list_of(known)));
    }
    rules.push_back({column, *low, *high});
  }
  for (const Run& r : t.runs) {
    bool out_of_fit = false;
    for (Rule& rule : rules) {
      const double x = r.cells.at(rule.column), slack = 1e-6 * (1 + std::abs(rule.low));
      if (x >= rule.low - slack && x <= rule.high + slack) out_of_fit = rule.used = true;
    }
    (out_of_fit ? out.withheld : out.kept).push_back(r);
  }
  for (const Rule& rule : rules)
    if (!rule.used)
      throw ConfigError("--withhold", 0, 0,
                        "no run has " + rule.column + " of " + short_number(rule.low) +
                            (rule.high > rule.low ? " to " + short_number(rule.high) : ""));
  if (out.kept.empty()) throw ConfigError("--withhold", 0, 0, "every run is withheld; nothing is left to fit");
  return out;
}

/// Effects that the case knows, as given or as refitted with the soil.
void add_known(const Search& s, const Fit& f, const Eigen::MatrixXd& V, std::map<std::string, Interval>& out) {
  for (const KnownEffect& k : s.series().given().known) {
    const int entry = entry_of(k.id);
    const EffectEntry& e = effect_entries()[static_cast<std::size_t>(entry)];
    double x = k.value, sd = 0;
    for (int i = 0; i < s.series().soil_parameters(); ++i)
      if (s.series().parameter(i).input == input_of_effect(entry)) x = f.x[i], sd = std::sqrt(std::max(V(i, i), 0.0));
    out[k.id] = shown_interval(entry, x - e.off, std::max(x - normal_95 * sd, e.lower) - e.off,
                               std::min(x + normal_95 * sd, e.upper) - e.off, sd, std::abs(e.typical - e.off));
  }
}

/// Amplitudes of the extended model with profile intervals.
std::map<std::string, Interval> profiled(const Search& s, const Candidate& c, const Fit& f) {
  std::map<std::string, Interval> out;
  const Eigen::MatrixXd V = s.covariance(f);
  for (std::size_t k = 0; k < c.effects.size(); ++k) {
    const auto i = s.series().soil_parameters() + static_cast<Eigen::Index>(k);
    const auto [low, high] = profile_interval(s, c, f, k);
    out[effect_entries()[static_cast<std::size_t>(c.effects[k])].id] = shown_interval(
        c.effects[k], f.x[i], low, high, std::sqrt(std::max(V(i, i), 0.0)), ordinary(c.effects[k], c.terms[k]));
  }
  add_known(s, f, V, out);
  return out;
}

/// Whether runs left out agree with the name: it does better than the nominal model, and no rival does so much better that its odds
/// would turn to ten to one. `better`: the rival that does.
struct Crossed {
  bool agrees = true, done = false;
  const Rival* better = nullptr;
};
Crossed cross(const Search& s, const Rival& named, Diagnosis& d) {
  const Candidate none = nominal_candidate();
  std::vector<Account> accounts{{&none, &s.nominal()}, {&named.candidate, &named.fit}};
  std::vector<const Rival*> of{nullptr, &named};
  for (const Rival& r : s.rivals())
    if (&r != &named && r.refitted && r.fit.ok && r.candidate.named() && accounts.size() < 4 &&
        r.posterior * decisive * decisive > named.posterior)
      accounts.push_back({&r.candidate, &r.fit}), of.push_back(&r);
  const std::vector<double> gain = cross_validate(s, accounts);
  Crossed out;
  if (std::isnan(gain[1])) return out;
  out.done = true;
  for (std::size_t i = 1; i < of.size(); ++i)
    for (Ranked& r : d.ranking)
      if (r.id == of[i]->candidate.id) r.cross_validation = gain[i];
  // A cause that shows at one slip alone (a wrong radius at slip 0) is lost with that block: strong evidence is not given up for it.
  out.agrees = gain[1] > 0 || named.gain > beyond_doubt;
  for (std::size_t i = 2; i < of.size(); ++i)
    if (gain[i] - gain[1] > std::log(decisive) + std::log(named.posterior / std::max(of[i]->posterior, 1e-12)))
      out.agrees = false, out.better = of[i];
  return out;
}

/// Where nothing can be told yet: the runs that would separate most causes.
void runs_to_begin_with(const Search& s, const RunTable& data, Diagnosis& d) {
  RunTable plan = data;
  plan.runs = s.series().runs();
  for (std::size_t r = 0; r < plan.runs.size(); ++r) plan.runs[r].sd = s.stated_sd()[r];
  const Design design = judge_design(s.series().given(), plan);
  for (const DesignRun& run : design.add) {
    NextExperiment e;
    e.condition = run.condition;
    for (const auto& cluster : design.clusters) e.decides.insert(e.decides.end(), cluster.begin(), cluster.end());
    e.runs = run.repeats, e.cost = run.repeats;
    e.chance =
        design.alike_pairs > 0 ? 1 - static_cast<double>(run.alike_pairs) / static_cast<double>(design.alike_pairs) : 0;
    d.next.push_back(e);
    if (d.next.size() == 3) break;
  }
  d.notes.push_back("the chance of a next run is here the share of look-alike pairs of causes that it would separate");
}

}  // namespace

Diagnosis diagnose(const DiagnosisCase& c, const RunTable& data, const std::vector<std::string>& withhold) {
  const std::clock_t begin = std::clock();
  Diagnosis d;
  const Split parts = split(data, withhold);
  d.runs = parts.kept;
  d.notes = data.notes;
  d.notes.insert(d.notes.end(), c.notes.begin(), c.notes.end());
  Search s(c, data, parts.kept);
  s.run();
  d.rank_seconds = s.refit_seconds();
  d.nominal = model_of(s, s.nominal());
  const Fit as_stated =
      s.series().fit(nominal_candidate(), s.whitener(), s.series().prior_mean(), s.nominal().theta, 0);
  if (as_stated.ok) d.stated = model_of(s, as_stated);
  d.judged = judge_soil(c);
  d.needed = needed_by_refit(s);
  d.statics = statics_of(s);
  for (std::size_t k = 0; k < channel_count; ++k) d.noise_scale[k] = s.noise().scale[k];
  d.scatter_ln_k = s.noise().omega[0], d.scatter_phi = s.noise().omega[1];
  for (std::size_t r = 0; r < s.noise().weight.size(); ++r)
    if (s.noise().weight[r] < 0.5) d.suspect_lines.push_back(s.series().runs()[r].line);
  d.weights = s.noise().weight;
  d.sd = s.stated_sd();
  for (auto& sd : d.sd)
    for (std::size_t k = 0; k < channel_count; ++k) sd[k] *= s.noise().scale[k];
  if (s.disowned())
    d.notes.push_back("more rows than outliers would be lie far from every account: all keep their weight");

  const std::vector<Rival>& rivals = s.rivals();
  for (std::size_t i = 0; i < std::min<std::size_t>(rivals.size(), 20); ++i) {
    Ranked r;
    r.id = rivals[i].candidate.id;
    r.log_likelihood = rivals[i].gain, r.log_evidence = rivals[i].evidence, r.posterior = rivals[i].posterior;
    r.refitted = rivals[i].refitted;
    r.cross_validation = std::numeric_limits<double>::quiet_NaN();
    r.amplitudes = amplitudes_of(s, rivals[i]);
    d.ranking.push_back(r);
  }
  d.posterior["none"] = s.posterior_none();
  d.posterior["unknown"] = s.posterior_unknown();
  int shown = 0;
  for (const Rival& r : rivals) {
    if (!r.candidate.named() || shown >= 12) continue;
    ++shown;
    // Effects that these runs cannot tell apart at all share one probability.
    std::vector<std::string> ids{r.candidate.id};
    if (r.candidate.effects.size() == 1)
      for (const std::string& also : s.aliases(r.candidate.effects[0])) ids.push_back(also);
    for (const std::string& id : ids) d.posterior[id] = r.posterior / static_cast<double>(ids.size());
    if (ids.size() > 1) d.notes.push_back(list_of(ids) + " do exactly the same to these runs");
  }

  const Rival* best = rivals.empty() ? nullptr : &rivals[0];
  const Candidate none = nominal_candidate();
  std::string conflict;
  for (const auto& [name, v] : d.nominal.parameters)
    if (std::abs(v.prior_z) > conflict_z) conflict += (conflict.empty() ? "" : ", ") + name;
  bool any_visible = false;
  for (std::size_t i = 0; i < s.named_count(); ++i) any_visible = any_visible || s.scores().visible(i) > 3;
  const std::vector<Run>& fitted = s.series().runs();
  const bool one_condition = std::all_of(fitted.begin(), fitted.end(), [&](const Run& r) {
    return r.slip == fitted[0].slip && r.load == fitted[0].load && r.omega == fitted[0].omega &&
           r.pass == fitted[0].pass && r.slope == fitted[0].slope;
  });
  const bool poor = one_condition || s.series().layout().size() < s.series().soil_parameters() + 3 ||
                    (!any_visible && s.named_count() > 0);

  // The noise found swallows what no account explains: with a stated sd that is a misfit, unless repeats show that noise.
  std::string swallowed;
  for (std::size_t k = 0; k < channel_count; ++k)
    if (data.stated_sd[k] && d.noise_scale[k] > swallowing) {
      if (!s.noise_in_repeats())
        swallowed += (swallowed.empty() ? "" : ", ") + std::string(channel_names()[k].short_name);
      d.notes.push_back("the noise of " + std::string(channel_names()[k].short_name) + " would have to be " +
                        short_number(d.noise_scale[k], 2) + " times what is stated" +
                        (s.noise_in_repeats() ? ", and repeats scatter as much" : ""));
    }
  const Candidate* extended = &none;
  const Fit* extended_fit = &s.nominal();
  Search::Remainder left;
  std::vector<std::string> group_ids;
  std::vector<std::pair<std::string, std::string>>
      disguised;  // effect of the name, soil value that it cannot be told from
  const bool declared = !one_condition && best && s.mixture_bayes_factor() > decisive && best->refitted && best->fit.ok;
  if (!declared) {
    left = s.remainder(none, s.nominal());
    if (one_condition)  // rows that disagree with each other, not with the model
      d.verdict = "undecidable";
    else if (!swallowed.empty() && conflict.empty())
      d.verdict = "unknown";
    else if (poor)
      d.verdict = "undecidable";
    else if (!conflict.empty())
      d.verdict = "parameter";
    else
      d.verdict = left.p < gate_p && s.mixture_bayes_factor() > suspicious ? "undecidable" : "adequate";
    // Inside its prior, and yet the whole of the agreement hangs on it.
    if ((d.verdict == "adequate" || (d.verdict == "undecidable" && !poor)) && !d.needed.empty() &&
        d.needed[0].held.size() == 1 && std::abs(d.needed[0].prior_z) > moved_z && d.needed[0].rise > needed_rise) {
      d.verdict = "parameter";
      conflict = d.needed[0].held[0];
    }
  } else {
    const auto at_bound = [&](const Rival& r) {
      for (const Interval& i : amplitudes_of(s, r))
        if (i.at_bound) return true;
      return false;
    };
    const auto beyond_belief = [&](const Rival& r) {
      const std::vector<Interval> sizes = amplitudes_of(s, r);
      for (std::size_t i = 0; i < sizes.size(); ++i)
        if (effect_entries()[static_cast<std::size_t>(r.candidate.effects[i])].is_map &&
            sizes[i].times_typical > absurd)
          return true;
      return false;
    };
    const auto first = [&](std::size_t size) -> const Rival* {
      for (const Rival& r : rivals)
        if (r.refitted && r.fit.ok && r.candidate.effects.size() == size && (size < 2 || !at_bound(r))) return &r;
      return nullptr;
    };
    const Rival *named = first(1), *pair = first(2), *drift = first(0);
    left = named ? s.remainder(named->candidate, named->fit) : s.remainder(none, s.nominal());
    // Two causes where one leaves a structured remainder, or where two are beyond doubt the better account.
    double one = 0, two = 0, unlisted = 0;
    for (const Rival& r : rivals)
      (r.candidate.effects.size() == 1 ? one : r.candidate.effects.size() == 2 ? two : unlisted) += r.posterior;
    if (named && pair && pair->posterior > named->posterior && (left.p < gate_p || two > decisive * one)) {
      named = pair;
      left = s.remainder(pair->candidate, pair->fit);
    }
    const double unknown = drift ? drift->posterior : 0;
    if (!named || left.p < gate_p || unknown > named->posterior) {
      d.verdict = "unknown";
      if (named) extended = &named->candidate, extended_fit = &named->fit;
    } else {
      std::vector<const Rival*> group{named};
      for (const Rival& r : rivals) {
        if (&r == named || !r.refitted || !r.candidate.named()) continue;
        const bool same_size = r.candidate.effects.size() == named->candidate.effects.size();
        if (!same_size && r.candidate.effects.size() == 2) continue;  // one cause is enough
        // The odds, and the likelihood alone where the sizes of amplitudes would decide.
        if (r.posterior * decisive > named->posterior || (same_size && named->gain - r.gain < std::log(decisive)))
          group.push_back(&r);
      }
      extended = &named->candidate, extended_fit = &named->fit;
      bool alone = group.size() == 1 && unknown * decisive < named->posterior;
      for (const int e : named->candidate.effects) alone = alone && s.aliases(e).empty();
      if (alone)
        for (std::size_t k = 0; k < named->candidate.effects.size(); ++k) {
          const std::string soil = s.soil_in_disguise(named->candidate, named->fit, k);
          const EffectEntry& e = effect_entries()[static_cast<std::size_t>(named->candidate.effects[k])];
          if (!soil.empty()) disguised.emplace_back(e.id, soil);
        }
      if (alone && at_bound(*named)) {
        d.verdict = "unknown";
        d.notes.push_back(named->candidate.id + " would follow the runs, but only at the bound of what is physical");
      } else if (std::all_of(group.begin(), group.end(), [&](const Rival* r) { return beyond_belief(*r); })) {
        d.verdict = "unknown";
        d.notes.push_back(named->candidate.id + " would follow the runs, but more than " + short_number(absurd) +
                          " times as large as such errors are");
      } else if (alone && !disguised.empty() && named->candidate.effects.size() == 1) {
        d.verdict = "parameter";
        conflict = disguised[0].second;
        d.notes.push_back(disguised[0].first + " does to these runs what another " + conflict +
                          " does: only what the case says of " + conflict + " sets them apart");
      } else if (alone && !disguised.empty()) {
        d.verdict = "class";
      } else if (alone) {
        const Crossed x = cross(s, *named, d);
        // An account that stands on noise far beyond what is stated leaves something over that no entry has.
        d.verdict = x.agrees && swallowed.empty() ? "named" : "class";
        if (d.verdict == "named") d.cause = named->candidate.id;
        if (x.better) group.push_back(x.better);
        if (!x.agrees)
          d.notes.push_back("on runs left out " + named->candidate.id + " does not do better than " +
                            (x.better ? x.better->candidate.id : "the nominal model"));
      } else {
        d.verdict = "class";
      }
      for (const Rival* r : group) {
        group_ids.push_back(r->candidate.id);
        for (const int e : r->candidate.effects) {
          std::vector<std::string> ids = s.aliases(e);
          ids.insert(ids.begin(), effect_entries()[static_cast<std::size_t>(e)].id);
          for (const std::string& id : ids)
            if (std::find(d.members.begin(), d.members.end(), id) == d.members.end()) d.members.push_back(id);
        }
      }
    }
    if (d.verdict == "unknown") {
      for (const Candidate& c0 : s.candidates())
        if (c0.id == left.id && !c0.named()) d.unknown_variable = c0.variable, d.unknown_through = c0.acts_through;
      const bool strong = drift && (!named || drift->evidence > named->evidence);
      if (drift && (strong || d.unknown_variable.empty())) {
        d.unknown_variable = drift->candidate.variable, d.unknown_through = drift->candidate.acts_through;
        if (drift->refitted && drift->fit.ok) {
          extended = &drift->candidate, extended_fit = &drift->fit;
          for (std::size_t r = 0; r < s.series().runs().size(); ++r) {
            double change = 0;
            for (std::size_t t = 0; t < drift->candidate.terms.size(); ++t)
              change += drift->fit.x[s.series().soil_parameters() + static_cast<Eigen::Index>(t)] *
                        drift->candidate.terms[t].at(r);
            const auto cell = s.series().runs()[r].cells.find(drift->candidate.variable);
            d.unknown_curve.push_back({cell == s.series().runs()[r].cells.end() ? 0 : cell->second, change});
          }
          std::sort(d.unknown_curve.begin(), d.unknown_curve.end());
          d.unknown_curve.erase(std::unique(d.unknown_curve.begin(), d.unknown_curve.end(),
                                            [](auto& a, auto& b) { return std::abs(a[0] - b[0]) < 1e-9; }),
                                d.unknown_curve.end());
        }
      }
    }
    d.parameters = profiled(s, *extended, *extended_fit);
  }
  if (!declared) add_known(s, s.nominal(), s.covariance(s.nominal()), d.parameters);
  d.extended = model_of(s, *extended_fit);
  const bool ordered = data.has_order || data.has_time;
  d.nominal.tests = lack_of_fit(s, s.nominal(), s.remainder(none, s.nominal()), ordered);
  d.extended.tests =
      lack_of_fit(s, *extended_fit, extended->named() ? left : s.remainder(*extended, *extended_fit), ordered);
  if (d.verdict == "class" || d.verdict == "undecidable" || d.verdict == "unknown")
    d.next = next_experiments(s, group_ids);
  if (!d.next.empty() && d.verdict != "undecidable") {
    double most = 0;
    for (const NextExperiment& e : d.next) most = std::max(most, e.chance);
    if (most < 0.5)
      d.notes.push_back("nothing in reach decides between " + list_of(d.next[0].decides) +
                        ": neither 48 repeats of one condition, other loads (a quarter to four times), a wheel half or "
                        "twice as wide nor a bench check; the surest of them has a chance of " +
                        short_number(most, 2));
  }
  if (d.verdict == "undecidable" && d.next.empty()) runs_to_begin_with(s, data, d);
  if (!parts.withheld.empty()) d.gain = gain_on(s, *extended, *extended_fit, parts.withheld, withhold, d.notes);

  // The next that is not this cause with a trace of a second.
  double second = 0;
  for (const Rival& r : rivals) {
    const auto& effects = r.candidate.effects;
    const bool nested = best && std::all_of(best->candidate.effects.begin(), best->candidate.effects.end(), [&](int e) {
                          return std::find(effects.begin(), effects.end(), e) != effects.end();
                        });
    if (!nested || !r.candidate.named()) second = std::max(second, r.posterior);
  }
  second = std::max(second, s.posterior_none());
  std::string cause;
  if (d.verdict == "named")
    cause = "The cause of the misfit is " + d.cause + " (odds " +
            (second > 0 ? short_number(best->posterior / std::max(second, 1e-12), 2) : "many") + ":1 over the next).";
  else if (d.verdict == "class" && !disguised.empty())
    cause = list_of(d.members, " with ") + " accounts for the misfit, but " + disguised[0].first +
            " does to these runs what another " + disguised[0].second + " does: nothing is named.";
  else if (d.verdict == "class")
    cause = d.members.size() > 1
                ? "The misfit is real, but these runs cannot tell " + list_of(d.members) + " apart."
                : "The misfit is real and " + list_of(d.members) +
                      " accounts for it, but these runs do not rule out something that is not in the list.";
  else if (d.verdict == "unknown")
    cause =
        d.unknown_variable.empty()
            ? !declared ? "No known cause explains why " + swallowed + " is missed by far more than its stated error."
              : left.p < gate_p && !left.id.empty()
                  ? "The likeliest known cause, " + best->candidate.id + ", leaves something over that looks like " +
                        left.id + " (p = " + short_number(left.p, 1) + "): nothing is named."
                  : "None of the known causes accounts for the misfit at a size that it can have."
            : (s.named_count() > 0 ? "None of the known causes fits: " : "No cause was considered: ") +
                  d.unknown_through + " changes with " + d.unknown_variable +
                  " in a way that no entry of the library has.";
  else if (d.verdict == "parameter")
    cause = "The model follows the runs only where soil values leave what the case says of them: " + conflict + ".";
  else if (d.verdict == "undecidable")
    cause = poor ? "The runs are too few or too noisy to tell anything apart."
                 : "Something is probably wrong with the model (odds " + short_number(s.mixture_bayes_factor(), 2) +
                       ":1), but not by enough to be declared (" + short_number(decisive) + ":1).";
  else
    cause = std::string("The model ") + (soil_moved(d) ? "with refitted soil " : "as stated ") +
            "follows the runs within their noise.";
  d.sentence = told(d, data, cause);
  if (const RigModel* rig = s.series().given().rig.model())
    d.notes.push_back("wheels rolled in the rig: " + std::to_string(rig->rolls()) + " at " +
                      std::to_string(rig->anchors()) + " points, by the slopes there between them");
  d.total_seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  return d;
}

}  // namespace grouser::diagnosis
