#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <random>

#include "grouser/terrain/config.h"
#include "grouser/terrain/csv.h"
#include "shares.h"
#include "soil_test_fit.h"
#include "soil_test_next.h"

namespace grouser::diagnosis {
namespace {

constexpr double conflict_z = 3, shows = 3;

std::string number(double x, int digits = 3) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*g", digits, x);
  return text;
}

std::string list_of(const std::vector<std::string>& ids) {
  std::string out;
  for (std::size_t i = 0; i < ids.size(); ++i) out += (i == 0 ? "" : i + 1 == ids.size() ? " or " : ", ") + ids[i];
  return out;
}

struct Split {
  std::vector<SoilTestCondition> kept, withheld;
};
Split split(const SoilTestData& data, const std::vector<std::string>& withhold) {
  Split out;
  std::vector<bool> used(withhold.size(), false);
  for (const SoilTestCondition& c : data.conditions) {
    bool away = false;
    for (std::size_t i = 0; i < withhold.size(); ++i) {
      const std::string& rule = withhold[i];
      const std::size_t eq = rule.find('=');
      const std::string key = rule.substr(0, eq), value = eq == std::string::npos ? "" : rule.substr(eq + 1);
      const auto x = parse_number(value);
      const bool shear = c.kind == SoilTestKind::shear;
      bool hit = false;
      if (key == "test" && (value == "plate" || value == "shear"))
        hit = value == (shear ? "shear" : "plate");
      else if (key == "normal_stress_Pa" && x)
        hit = shear && std::abs(c.normal_stress - *x) <= 1e-3 * *x;
      else if (key == "speed_mm_s" && x)
        hit = std::abs(c.speed * 1e3 - *x) <= 1e-3 * *x;
      else
        throw ConfigError(
            "--withhold", 0, 0,
            "'" + rule + "' is not understood; write test=plate, normal_stress_Pa=17830 or speed_mm_s=0.66");
      if (hit) away = true, used[i] = true;
    }
    (away ? out.withheld : out.kept).push_back(c);
  }
  for (std::size_t i = 0; i < withhold.size(); ++i)
    if (!used[i]) throw ConfigError("--withhold", 0, 0, "no curve has " + withhold[i]);
  if (out.kept.empty()) throw ConfigError("--withhold", 0, 0, "every curve is withheld; nothing is left to fit");
  return out;
}

Interval interval_of(const Eigen::MatrixXd& draws, Eigen::Index row, const SoilTestCoordinate& c, double best) {
  std::vector<double> x;
  for (Eigen::Index k = 0; k < draws.cols(); ++k) x.push_back(c.logarithmic ? std::exp(draws(row, k)) : draws(row, k));
  std::sort(x.begin(), x.end());
  double mean = 0, squares = 0;
  for (const double v : x) mean += v, squares += v * v;
  const double n = static_cast<double>(x.size());
  mean /= n;
  Interval i;
  i.value = c.logarithmic ? std::exp(best) : best;
  i.sd = std::sqrt(std::max(squares / n - mean * mean, 0.0));
  i.low = x[static_cast<std::size_t>(0.05 * n)], i.high = x[static_cast<std::size_t>(0.95 * n)];
  i.unit = c.unit;
  const double slack = 1e-3 * (c.upper - c.lower);
  i.at_bound = best <= c.lower + slack || best >= c.upper - slack;
  return i;
}

std::map<std::string, FittedValue> soil_of(const SoilTestAccount& a, const SoilTestPosterior& p) {
  std::map<std::string, FittedValue> out;
  for (std::size_t i = 0; i < a.coordinates.size(); ++i) {
    const SoilTestCoordinate& c = a.coordinates[i];
    if (!(c.sd > 0)) continue;
    const Interval v = interval_of(p.draws, static_cast<Eigen::Index>(i), c, p.best[static_cast<Eigen::Index>(i)]);
    out[c.name] = {v.value, v.sd, (p.best[static_cast<Eigen::Index>(i)] - c.mean) / c.sd, c.unit};
  }
  return out;
}

/// Root mean square of ln stress of curves about predictions; `pick`: which curves, with repetition.
double ln_error(const SoilTestFits& fits, const SoilTestAccount& a, const Eigen::VectorXd& x,
                const std::vector<std::pair<const SoilTestCondition*, Eigen::VectorXd>>& curves,
                const std::vector<std::size_t>& pick) {
  double sum = 0;
  int count = 0;
  for (const std::size_t i : pick) {
    const Eigen::VectorXd y = fits.predict(a, x, *curves[i].first);
    if (y.size() == 0) return NAN;
    sum += (curves[i].second.head(3) - y.head(3)).squaredNorm(), count += 3;
  }
  return std::sqrt(sum / count);
}

Gain gain_of(const SoilTestFits& fits, const SoilTestAccount& none, const Eigen::VectorXd& x_none,
             const SoilTestAccount& other, const Eigen::VectorXd& x_other,
             const std::vector<SoilTestCondition>& withheld, const std::vector<std::string>& names, bool rise) {
  Gain g;
  g.withheld = names;
  std::vector<std::pair<const SoilTestCondition*, Eigen::VectorXd>> curves;
  std::vector<std::size_t> all;
  for (const SoilTestCondition& c : withheld)
    for (const SoilTestCurve& curve : c.curves) {
      all.push_back(curves.size());
      curves.emplace_back(&c, soil_test_outputs(c.kind, curve, rise));
    }
  g.runs = static_cast<int>(all.size());
  g.nominal_rmse.fill(NAN), g.extended_rmse.fill(NAN);
  g.nominal_rmse[0] = ln_error(fits, none, x_none, curves, all);
  g.extended_rmse[0] = ln_error(fits, other, x_other, curves, all);
  g.rmse_ratio = g.extended_rmse[0] / g.nominal_rmse[0];
  std::mt19937_64 random(5511);
  std::uniform_int_distribution<std::size_t> any(0, all.size() - 1);
  std::vector<double> ratios;
  for (int k = 0; k < 1000; ++k) {
    for (std::size_t& i : all) i = any(random);
    ratios.push_back(ln_error(fits, other, x_other, curves, all) / ln_error(fits, none, x_none, curves, all));
  }
  std::sort(ratios.begin(), ratios.end());
  g.low = ratios[25], g.high = ratios[974];
  return g;
}

/// d of an effect at its typical size: what a refit of the nominal law leaves of it.
double visible_size(const SoilTestFits& fits, const SoilTestAccount& none, const Eigen::VectorXd& soil,
                    const SoilTestAccount& effect) {
  const SoilTestEffect& e = soil_test_effects()[static_cast<std::size_t>(effect.effect)];
  Eigen::VectorXd x(static_cast<Eigen::Index>(effect.coordinates.size()));
  for (Eigen::Index i = 0; i < x.size(); ++i) x[i] = i + 1 == x.size() ? e.typical : soil[i];
  const Eigen::VectorXd y = fits.stacked(effect, x);
  return y.size() == 0 ? NAN : std::sqrt(std::max(fits.best_objective(none, y), 0.0));
}

void say(SoilTestDiagnosis& d, const Ranked* best) {
  std::string odds = "beyond count";
  double second = d.posterior["none"] + d.posterior["unknown"];
  for (const Ranked& r : d.ranking)
    if (best && r.id != best->id) second = std::max(second, r.posterior);
  if (best && best->posterior / std::max(second, 1e-12) < 1e6)
    odds = number(best->posterior / std::max(second, 1e-12), 2) + ":1";
  std::string& s = d.sentence;
  if (d.verdict == "named") {
    const Interval& i = d.parameters.at(d.cause);
    s = "The curves are those of " + d.cause + " (" + number(i.value) + (i.unit == "1" ? "" : " " + i.unit) +
        ", 90 % " + number(i.low) + " to " + number(i.high) + "; odds " + odds + " over all else)";
    s += "; the error of ln stress falls from " + number(d.nominal_rmse, 2) + " to " + number(d.extended_rmse, 2);
  } else if (d.verdict == "class") {
    s = "The nominal law does not make these curves; they cannot tell " + list_of(d.members) + " apart";
  } else if (d.verdict == "unknown") {
    s = "The nominal law does not make these curves and no known cause does";
    if (!d.unknown_through.empty()) s += ": " + d.unknown_through + " drifts with " + d.unknown_variable;
  } else if (d.verdict == "parameter") {
    s = "The nominal law makes these curves, with a soil outside its prior:";
    for (const auto& [name, v] : d.nominal)
      if (std::abs(v.prior_z) > conflict_z)
        s += " " + name + " " + number(v.value) + " (" + number(v.prior_z, 2) + " sd)";
  } else if (d.verdict == "undecidable") {
    s = "These tests could not show any of the causes";
  } else {
    s = "The nominal law makes these curves";
    std::vector<std::string> open;
    for (const Ranked& r : d.ranking)
      if (d.posterior.count(r.id) && r.posterior * decisive > d.posterior["none"]) open.push_back(r.id);
    if (!open.empty()) s += ", but " + list_of(open) + " could, too";
    std::vector<std::string> hidden;
    for (const auto& [id, size] : d.visible)
      if (!(size > shows)) hidden.push_back(id);
    if (!hidden.empty()) s += "; " + list_of(hidden) + " of typical size would not show in these tests";
  }
  if (d.gain) {
    s += "; on the curves never used the error is " + number(d.gain->rmse_ratio, 2) + " [" + number(d.gain->low, 2) +
         ", " + number(d.gain->high, 2) + "] of the nominal law's";
    if (d.gain->high >= 1) s += ": no gain can be claimed";
  }
  s += ".";
}

}  // namespace

SoilTestDiagnosis diagnose_soil_tests(const SoilTestCase& c, const SoilTestData& data,
                                      const std::vector<std::string>& withhold) {
  const std::clock_t begin = std::clock();
  SoilTestDiagnosis d;
  d.notes = data.notes;
  const Split parts = split(data, withhold);
  const SoilTestModel model(c.stored, data.rise);
  for (std::size_t i = 0; i < grain_count; ++i) {
    const auto range = model.range(RollingLaw::constant, static_cast<int>(i));
    if (c.soil[i].mean < range[0] || c.soil[i].mean > range[1])
      throw ConfigError(c.file.string(), 0, 0,
                        std::string("soil.") + grain_coordinates()[i].key + ": " + number(std::exp(c.soil[i].mean)) +
                            " is outside the stored runs (" + number(std::exp(range[0])) + " to " +
                            number(std::exp(range[1])) + " " + grain_coordinates()[i].unit + ")");
  }
  const SoilTestFits fits(model, c, parts.kept, data.rise);
  d.values = fits.size();
  d.noise_scale = {fits.scale(SoilTestKind::shear), fits.scale(SoilTestKind::plate)};
  d.emulators = model.quality();

  const std::vector<SoilTestAccount> accounts = fits.accounts();
  std::vector<SoilTestPosterior> found;
  double named = 0, drifts = 0;
  for (const SoilTestAccount& a : accounts) {
    found.push_back(fits.posterior(a));
    (a.named ? named : drifts) += a.id == "none" ? 0 : 1;
  }
  const SoilTestPosterior& none = found[0];
  if (!none.ok)
    throw ConfigError(data.file.string(), 0, 0,
                      "a test lies outside the stored runs of " + c.stored.string() + " (normal stress, speed)");
  // Shares before the data: a cause as likely as none; drifts outside the list as in the diagnosis of wheels.
  const double some = share_named + share_drift;
  std::vector<double> score;
  for (std::size_t i = 0; i < accounts.size(); ++i) {
    const double share =
        i == 0 ? share_none
               : (1 - share_none) * (accounts[i].named ? share_named / named : share_drift / drifts) / some;
    score.push_back(found[i].ok ? found[i].ln_evidence + std::log(share) : -INFINITY);
  }
  const double top = *std::max_element(score.begin(), score.end());
  double sum = 0;
  for (const double s : score) sum += std::exp(s - top);
  std::vector<double> posterior;
  for (const double s : score) posterior.push_back(std::exp(s - top) / sum);
  std::vector<std::size_t> order;
  for (std::size_t i = 1; i < accounts.size(); ++i) order.push_back(i);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return posterior[a] > posterior[b]; });
  double unknown = 0;
  for (const std::size_t i : order) {
    const SoilTestAccount& a = accounts[i];
    Ranked r;
    r.id = a.id, r.posterior = posterior[i], r.refitted = true;
    r.cross_validation = NAN;
    if (found[i].ok) {
      r.log_likelihood = found[i].ln_likelihood - none.ln_likelihood;
      r.log_evidence = found[i].ln_evidence - none.ln_evidence;
      if (a.named)
        r.amplitudes.push_back(interval_of(found[i].draws, static_cast<Eigen::Index>(a.coordinates.size()) - 1,
                                           a.coordinates.back(), found[i].best[found[i].best.size() - 1]));
      if (found[i].effective < 200)
        d.notes.push_back("the evidence of " + a.id + " rests on " + number(found[i].effective) + " draws only");
    } else {
      d.notes.push_back(a.id + " has no answer within the stored runs");
    }
    if (a.named)
      d.posterior[a.id] = posterior[i];
    else
      unknown += posterior[i];
    d.ranking.push_back(std::move(r));
  }
  d.posterior["none"] = posterior[0], d.posterior["unknown"] = unknown;
  for (std::size_t i = 0; i < accounts.size(); ++i)
    if (accounts[i].named && found[i].ok)
      d.visible[accounts[i].id] = visible_size(fits, accounts[0], none.best, accounts[i]);

  d.nominal = soil_of(accounts[0], none);
  d.nominal_chi2 = none.chi2, d.nominal_p = none.p;
  bool conflict = false, any_visible = false;
  for (const auto& [name, v] : d.nominal) conflict = conflict || std::abs(v.prior_z) > conflict_z;
  for (const auto& [id, size] : d.visible) any_visible = any_visible || size > shows;

  // The best of what is named, and the best drift.
  std::size_t best = 0, drift = 0;
  for (const std::size_t i : order) {
    if (!found[i].ok) continue;
    std::size_t& slot = accounts[i].named ? best : drift;
    if (slot == 0) slot = i;
  }
  std::size_t extended = 0;
  std::vector<std::size_t> group;
  const double mixture = (1 - posterior[0]) / std::max(posterior[0], 1e-300);
  if (mixture > decisive) {
    if (best == 0 || found[best].p < gate_p || unknown > posterior[best]) {
      d.verdict = "unknown";
      if (best != 0 && unknown <= posterior[best]) extended = best;
      if (drift != 0) d.unknown_variable = accounts[drift].variable, d.unknown_through = accounts[drift].through;
    } else {
      group.push_back(best);
      for (const std::size_t i : order)
        if (i != best && accounts[i].named && posterior[i] * decisive > posterior[best]) group.push_back(i);
      const bool alone = group.size() == 1 && unknown * decisive < posterior[best];
      extended = best;
      d.verdict = alone ? "named" : "class";
      if (alone) d.cause = accounts[best].id;
    }
  } else if (conflict) {
    d.verdict = "parameter";
  } else if (!any_visible || d.values < grain_count + 2) {
    d.verdict = "undecidable";
  } else {
    d.verdict = none.p < gate_p ? "unknown" : "adequate";
  }
  for (const std::size_t i : group) d.members.push_back(accounts[i].id);

  const SoilTestAccount& account = accounts[extended];
  d.extended = soil_of(account, found[extended]);
  d.extended_chi2 = found[extended].chi2, d.extended_p = found[extended].p;
  d.law = account.law == RollingLaw::rate ? "rate" : "constant";
  for (std::size_t i = 0; i < account.coordinates.size(); ++i) {
    const SoilTestCoordinate& x = account.coordinates[i];
    const double value = found[extended].best[static_cast<Eigen::Index>(i)];
    d.extended_values[x.name] = x.logarithmic ? std::exp(value) : value;
    if (x.sd == 0) d.parameters[x.name] = interval_of(found[extended].draws, static_cast<Eigen::Index>(i), x, value);
  }
  for (const std::size_t i : group)
    if (i != extended)
      d.parameters[accounts[i].id] =
          interval_of(found[i].draws, static_cast<Eigen::Index>(accounts[i].coordinates.size()) - 1,
                      accounts[i].coordinates.back(), found[i].best[found[i].best.size() - 1]);
  double squares[2] = {0, 0};
  int count = 0;
  for (const SoilTestValues& v : fits.values()) {
    SoilTestFigures f{v.condition,
                      v.repeats,
                      v.mean,
                      fits.repeat_scatter(v.condition.kind).diagonal().cwiseSqrt(),
                      fits.predict(accounts[0], none.best, v.condition),
                      fits.predict(account, found[extended].best, v.condition)};
    squares[0] += (f.nominal - f.mean).head(3).squaredNorm(), squares[1] += (f.extended - f.mean).head(3).squaredNorm();
    count += 3;
    d.figures.push_back(std::move(f));
  }
  d.nominal_rmse = std::sqrt(squares[0] / count), d.extended_rmse = std::sqrt(squares[1] / count);
  if (!parts.withheld.empty())
    d.gain = gain_of(fits, accounts[0], none.best, account, found[extended].best, parts.withheld, withhold, data.rise);

  // What to run next: between the members of a class, else between the best named cause and its nearest rival.
  if (group.size() < 2) {
    std::size_t second = 0;
    for (const std::size_t i : order)
      if (found[i].ok && accounts[i].named && i != best && posterior[i] > posterior[second]) second = i;
    group = {best, second};
    if (best == 0) group.clear();
  }
  // Odds beyond 10:1 are left out of it: the run is to decide by itself.
  std::vector<SoilTestMember> members;
  for (const std::size_t i : group)
    members.push_back({&accounts[i], &found[i],
                       std::max(std::log(std::max(posterior[i], 1e-300)),
                                std::log(std::max(posterior[group[0]], 1e-300)) - std::log(decisive))});
  d.next = next_soil_tests(fits, members);
  const auto shown = std::find_if(d.ranking.begin(), d.ranking.end(), [&](const Ranked& r) { return r.id == d.cause; });
  d.seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  say(d, shown == d.ranking.end() ? nullptr : &*shown);
  return d;
}

std::string extended_soil_text(const SoilTestDiagnosis& d) {
  const auto value = [&](const char* key) { return d.extended_values.count(key) ? d.extended_values.at(key) : 0.0; };
  const double scale = d.extended_values.count("grain_size") ? value("grain_size") : 1;
  std::string s = "# " + d.sentence +
                  "\n# The soil of a file of `grouser soil`, or of `dem:` in a soil file, with what was found.\n";
  s += "soil:\n  diameter: [" + number(5 * scale, 4) + " mm, " + number(10 * scale, 4) + " mm]\n";
  s += "  density: 3.1 g/cm^3\n  bulk_density: 1.6 g/cm^3\n  young_modulus: " + number(value("young_modulus"), 4) +
       " Pa\n  poisson_ratio: 0.35\n  friction: " + number(value("friction"), 4) + "\n";
  s += d.law == "rate"
           ? "  rolling: {law: rate, coefficient: " + number(value("rolling_rate_dependence"), 4) + " s^2/m^2}\n"
           : "  rolling: {law: constant, coefficient: " + number(value("rolling_coefficient"), 4) + "}\n";
  if (d.extended_values.count("cohesion")) s += "  cohesion: " + number(value("cohesion"), 4) + " J/m^3\n";
  s += "  restitution: 0.4\n  wall: {friction: " + number(value("wall_effects"), 4) + ", restitution: 0.06}\n";
  return s;
}

}  // namespace grouser::diagnosis
