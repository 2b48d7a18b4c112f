// The search, its cases and what they say.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "soil_calibration.h"

namespace grouser::app {

namespace {

namespace fs = std::filesystem;

double sqr(double x) { return x * x; }

/// Logarithmic between the bounds, to five digits, so that a table shows what was run.
std::vector<double> values_at(const Calibration& c, const Point& x) {
  std::vector<double> out;
  for (std::size_t k = 0; k < x.size(); ++k) {
    const CalibrationParameter& p = c.parameters[k];
    const double v = p.lower * std::pow(p.upper / p.lower, x[k]);
    out.push_back(std::clamp(std::stod(fmt::format("{:.4e}", v)), p.lower, p.upper));
  }
  return out;
}

/// The cases of a test with these parameters; their names end in their hash.
std::vector<SoilCase> cases_with(const Calibration& c, const CalibrationTest& t, const std::vector<double>& values) {
  std::vector<SoilCase> cases = read_soil_file(t.file, t.kind, [&](dem::SoilSettings& s) {
                                  for (std::size_t k = 0; k < values.size(); ++k) c.parameters[k].set(s, values[k]);
                                }).cases;
  for (SoilCase& k : cases) k.name += "-" + k.hash;
  return cases;
}

class Search {
 public:
  Search(const Calibration& c, fs::path out, SoilRunOptions o,
         const std::function<void(const std::vector<CalibrationSet>&)>& finished)
      : c_(c), out_(std::move(out)), o_(std::move(o)), finished_(finished) {}

  std::vector<double> values(const std::vector<Point>& points) {
    std::vector<std::vector<double>> wanted, missing;
    for (const Point& x : points) {
      wanted.push_back(values_at(c_, x));
      const bool known = at_.count(wanted.back()) > 0 || std::count(missing.begin(), missing.end(), wanted.back()) > 0;
      if (!known) missing.push_back(wanted.back());
    }
    if (!missing.empty()) run(missing);
    std::vector<double> y;
    double worst = 0;
    for (const CalibrationSet& s : sets_)
      if (s.total > worst) worst = s.total;
    if (worst == 0) throw dem::DemError("no set could be computed; the last one: " + sets_.back().failure);
    // The search is kept away from sets that stop.
    for (const auto& v : wanted) {
      const double e = sets_[at_.at(v)].total;
      y.push_back(std::isnan(e) ? 2 * worst : e);
    }
    return y;
  }
  const std::vector<CalibrationSet>& sets() const { return sets_; }

 private:
  void run(const std::vector<std::vector<double>>& missing) {
    struct Place {
      std::size_t set, test;
    };
    std::vector<std::vector<SoilCase>> cases;  // per set and test; jobs point into it
    for (const auto& v : missing)
      for (const CalibrationTest& t : c_.tests) cases.push_back(cases_with(c_, t, v));
    std::vector<SoilJob> jobs;
    std::vector<Place> places;
    for (std::size_t k = 0; k < cases.size(); ++k)
      for (const SoilCase& s : cases[k]) {
        jobs.push_back({&s, out_ / c_.tests[k % 2].kind});
        places.push_back({k / 2, k % 2});
      }
    const std::size_t done = sets_.size(), most = std::max(c_.search.most, done + missing.size());
    o_.head = missing.size() == 1 ? fmt::format("set {} of {}: ", done + 1, most)
                                  : fmt::format("sets {} to {} of {}: ", done + 1, done + missing.size(), most);
    o_.then = static_cast<double>(most - done - missing.size()) / static_cast<double>(missing.size());
    const std::vector<SoilCaseResult> results = run_soil_cases(jobs, o_, {});
    for (std::size_t s = 0; s < missing.size(); ++s) {
      CalibrationSet set;
      set.values = missing[s];
      double weight = 0, noise = 0;
      for (std::size_t t = 0; t < 2; ++t) {
        std::vector<SoilCaseResult> own;
        for (std::size_t k = 0; k < results.size(); ++k) {
          if (places[k].set != s || places[k].test != t) continue;
          own.push_back(results[k]);
          if (set.failure.empty() && !results[k].done)
            set.failure = c_.tests[t].kind + ", packing " + std::to_string(results[k].spec->packing + 1) + ": " +
                          results[k].failure;
        }
        if (!set.failure.empty()) break;
        set.curves[t] = group_curves(own);
        set.misfit[t] = misfit(c_.tests[t], set.curves[t]);
        weight += c_.tests[t].weight;
        set.total += c_.tests[t].weight * sqr(set.misfit[t].error);
        noise += c_.tests[t].weight * sqr(set.misfit[t].noise);
        // The cases go; those of the file are the same but for the parameters.
        for (SoilGroup& g : set.curves[t])
          g.first = &*std::find_if(c_.tests[t].plan.cases.begin(), c_.tests[t].plan.cases.end(),
                                   [&](const SoilCase& k) { return k.group == g.name; });
      }
      if (set.failure.empty()) {
        set.total = std::sqrt(set.total / weight);
        set.noise = std::sqrt(noise / weight);
      } else {
        set.curves = {};
        set.total = set.noise = std::numeric_limits<double>::quiet_NaN();
        set.misfit.fill({set.total, set.total, set.total});
      }
      at_[set.values] = sets_.size();
      sets_.push_back(std::move(set));
    }
    if (finished_) finished_(sets_);
  }

  const Calibration& c_;
  fs::path out_;
  SoilRunOptions o_;
  const std::function<void(const std::vector<CalibrationSet>&)>& finished_;
  std::vector<CalibrationSet> sets_;
  std::map<std::vector<double>, std::size_t> at_;
};

}  // namespace

Target::Target(const CalibrationTest& test, const SoilGroup& curve)
    : reference_(&test.plan.reference), points_(&test.targets.at(0)) {
  if (const auto* shear = std::get_if<dem::ShearSettings>(&curve.first->test)) {
    pressure_ = shear->pressure;
    for (const CalibrationTarget& t : test.targets)
      if (t.pressure == pressure_) points_ = &t;
  }
}

double Target::operator()(double x) const {
  if (!points_->x.empty()) return value_at(points_->x, points_->y, x);
  return pressure_ > 0 ? reference_->shear_stress(pressure_, x) : reference_->pressure(x);
}

Misfit misfit(const CalibrationTest& test, const std::vector<SoilGroup>& groups) {
  Misfit m;
  for (const SoilGroup& g : groups) {
    const auto column =
        static_cast<std::size_t>(std::find(g.columns.begin(), g.columns.end(), test.column) - g.columns.begin());
    const Target target(test, g);
    double square = 0, far = 0, spread = 0, sum = 0, n = 0;
    for (std::size_t k = 0; k < g.x.size(); ++k) {
      const double aim = target(g.x[k]), y = g.mean[column][k];
      if (std::isnan(aim) || std::isnan(y) || g.x[k] <= 0) continue;
      square += sqr(aim);
      far += sqr(y - aim);
      spread += sqr(g.sd[column][k]) / static_cast<double>(g.packings);
      sum += y;
      ++n;
    }
    if (n < 3)
      throw ConfigError(test.file.string(), 0, 0,
                        fmt::format("{}: its target ({}) covers {} samples of the curve; at least 3 are needed", g.name,
                                    target.source(), n));
    const double scale = std::sqrt(square / n), share = 1.0 / static_cast<double>(groups.size());
    m.error += share * far / square;
    m.noise += g.packings > 1 ? share * spread / square : std::numeric_limits<double>::quiet_NaN();
    m.level += share * sum / n / scale;
  }
  m.error = std::sqrt(m.error);
  m.noise = std::sqrt(m.noise);
  return m;
}

CalibrationSummary summarize(const Calibration& c, const std::vector<CalibrationSet>& sets) {
  CalibrationSummary s;
  std::array<std::vector<double>, 2> error;
  for (const CalibrationSet& k : sets)
    for (std::size_t t = 0; t < 2; ++t) error[t].push_back(k.misfit[t].error);
  const auto least = [&](auto&& value) {
    std::size_t best = 0;
    for (std::size_t k = 1; k < sets.size(); ++k)
      if (sets[k].failure.empty() && (!sets[best].failure.empty() || value(k) < value(best))) best = k;
    return best;
  };
  s.best = least([&](std::size_t k) { return sets[k].total; });
  for (std::size_t t = 0; t < 2; ++t) s.best_of[t] = least([&](std::size_t k) { return error[t][k]; });
  s.front = pareto_front(error[0], error[1]);
  const double noise = std::isnan(sets[s.best].noise) ? 0 : sets[s.best].noise;
  for (const CalibrationSet& k : sets) s.like_best.push_back(sqr(k.total) <= sqr(sets[s.best].total) + sqr(noise));
  for (std::size_t p = 0; p < c.parameters.size(); ++p) {
    std::pair<double, double> r{sets[s.best].values[p], sets[s.best].values[p]};
    for (std::size_t k = 0; k < sets.size(); ++k)
      if (s.like_best[k]) r = {std::min(r.first, sets[k].values[p]), std::max(r.second, sets[k].values[p])};
    s.range_like.push_back(r);
  }
  for (std::size_t t = 0; t < 2; ++t) {
    std::vector<Point> x;
    std::vector<double> y;
    for (const CalibrationSet& k : sets) {
      if (!(k.misfit[t].level > 0)) continue;
      x.emplace_back();
      for (double v : k.values) x.back().push_back(std::log(v));
      y.push_back(std::log(k.misfit[t].level));
    }
    s.elasticity[t] = plane_through(x, y);
  }
  return s;
}

std::vector<CalibrationSet> calibrate(const Calibration& c, const fs::path& out, const SoilRunOptions& o,
                                      const std::function<void(const std::vector<CalibrationSet>&)>& finished) {
  for (const CalibrationTest& t : c.tests) {
    std::error_code failed;
    fs::create_directories(out / t.kind, failed);
    if (failed) throw ConfigError((out / t.kind).string(), 0, 0, "cannot be made: " + failed.message());
  }
  Search s(c, out, o, finished);
  search(c.parameters.size(), c.search, [&](const std::vector<Point>& x) { return s.values(x); });
  return s.sets();
}

}  // namespace grouser::app
