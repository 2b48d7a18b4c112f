#include "generate.h"

#include <fmt/core.h>

#include <atomic>
#include <cmath>
#include <exception>
#include <iostream>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "hidden.h"
#include "oracle.h"
#include "seal.h"
#include "set_files.h"

namespace blind {
namespace {

using nlohmann::json;

constexpr int kDraws = 200;

bool is_null(const std::string& family) { return family.rfind("null", 0) == 0; }

std::vector<Id> candidates(const std::string& family, Plan plan) {
  std::vector<Id> out;
  const bool confounded = plan == Plan::constant_load || plan == Plan::constant_speed;
  for (const Effect& e : effects()) {
    const bool library = in_library(e.id);
    if (family == "outside" ? library : !library) continue;
    if (family == "sensor" && !e.sensor) continue;
    if (family == "effect" && e.sensor) continue;
    if (family == "confounded" && confounded && !(e.sensor || e.id == Id::bed_slope)) continue;
    out.push_back(e.id);
  }
  return out;
}

struct Draw {
  Plan plan = Plan::full;
  PlanOptions layout;
  NoiseModel noise;
  Numerics numerics;
  ColumnStyle columns;
  std::vector<std::string> variants;
};

Draw draw_variants(const std::string& plan, const std::string& family, Dice& dice) {
  Draw out;
  if (plan == "confounded") out.plan = dice.chance(0.5) ? Plan::constant_load : Plan::constant_speed;
  if (plan == "slip") out.plan = Plan::slip;
  if (plan == "slip_load") out.plan = Plan::slip_load;
  const bool full = out.plan == Plan::full;
  const auto variant = [&](bool on, const char* called) {
    if (on) out.variants.emplace_back(called);
    return on;
  };
  const bool scatter = family == "null_preparation" || (family == "effect" && full && dice.chance(0.15));
  if (scatter) {
    variant(true, "preparation");
    out.noise.ln_k_scatter = 0.06;
    out.noise.phi_scatter = 0.8 * 0.017453292519943295;
    if (full) out.layout.extra_replicates = 24;
    if (full) out.layout.shared_preparation = variant(dice.chance(0.2), "shared_preparation");
  }
  if (family == "null_numeric") {
    out.numerics.cells = 100 + dice.below(201);
    out.noise.quantised = true;
    if (variant(dice.chance(0.3), "ar1")) out.noise.autocorrelation = 0.3;
  }
  if (family == "wrong_noise") {
    out.noise.stated_factor = dice.chance(0.5) ? 0.5 : 2.0;
    if (full) out.layout.extra_replicates = 24;
  }
  if (family == "outliers") out.noise.outlier_share = 0.02;
  if (family == "poor") {
    out.layout.only = 3;
    out.noise.sd *= 3.0;
  }
  if (family == "effect" || family == "sensor") {
    if (!scatter && variant(dice.chance(0.1), "ar1")) out.noise.autocorrelation = 0.3;
    out.noise.quantised = variant(dice.chance(0.1), "quantised");
    out.layout.sorted = full && variant(dice.chance(0.05), "order_not_randomised");
    out.columns.rim = variant(dice.chance(0.1), "rim_slip");
    if (variant(dice.chance(0.1), "other_slip_radius")) out.columns.slip_radius = 0.135;
    out.layout.withheld_block = full && !out.layout.sorted && dice.chance(1.0 / 3.0);
  }
  return out;
}

// Preparation of each batch and the sensors' noise, in order of the runs.
std::vector<Eigen::Vector3d> noisy(const Draw& draw, const Wheel& wheel, const Soil& soil, const Amplitudes& x,
                                   std::vector<PlannedRun> runs, std::vector<int>& outliers, Dice& dice) {
  std::map<int, std::pair<double, double>> prepared;
  for (PlannedRun& p : runs) {
    if (draw.noise.ln_k_scatter <= 0) break;
    auto found = prepared.find(p.batch);
    if (found == prepared.end())
      found = prepared
                  .emplace(p.batch,
                           std::pair{draw.noise.ln_k_scatter * dice.normal(), draw.noise.phi_scatter * dice.normal()})
                  .first;
    p.run.ln_k_shift = found->second.first;
    p.run.phi_shift = found->second.second;
  }
  std::vector<Condition> conditions;
  for (const PlannedRun& p : runs) conditions.push_back(p.run);
  std::vector<Eigen::Vector3d> y = simulate_all(wheel, soil, x, conditions, draw.numerics);
  const double rho = draw.noise.autocorrelation, fresh = std::sqrt(1.0 - rho * rho);
  const Eigen::Vector3d grid{0.5, 0.05, 0.0005};
  Eigen::Vector3d error = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < y.size(); ++i) {
    for (Eigen::Index c = 0; c < 3; ++c) {
      const double draw_now = dice.normal();
      error[c] = i == 0 ? draw_now : rho * error[c] + fresh * draw_now;
    }
    y[i] += error.cwiseProduct(draw.noise.sd);
    if (draw.noise.outlier_share > 0 && dice.chance(draw.noise.outlier_share)) {
      const int c = dice.below(3);
      y[i][c] += (dice.chance(0.5) ? 1.0 : -1.0) * dice.uniform(6.0, 12.0) * draw.noise.sd[c];
      outliers.push_back(runs[i].order);
    }
    if (draw.noise.quantised) y[i] = (y[i].cwiseQuotient(grid)).array().round().matrix().cwiseProduct(grid);
  }
  return y;
}

SoilVector shifted(SoilVector u, std::vector<std::string>& names, Dice& dice) {
  static const char* const called[] = {"k", "n", "phi"};
  static const Eigen::Index place[] = {0, 1, 3};
  const int which = dice.below(3);
  u[place[which]] = (dice.chance(0.5) ? 1.0 : -1.0) * dice.uniform(4.0, 5.5);
  names.emplace_back(called[which]);
  return u;
}

// rms over channels in sd of withheld (y - prediction).
double rms(const std::vector<Eigen::Vector3d>& a, const std::vector<Eigen::Vector3d>& b, const Eigen::Vector3d& sd) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).cwiseQuotient(sd).squaredNorm();
  return std::sqrt(sum / (3.0 * static_cast<double>(a.size())));
}

// What the model that knows the truth gains on the withheld block, both fitted to the noisy training rows.
json gain_of(const Wheel& wheel, const Priors& priors, const SoilVector& truth, const Amplitudes& x,
             const std::vector<PlannedRun>& runs, const std::vector<Eigen::Vector3d>& y,
             const std::vector<Observation>& training, const NoiseModel& noise) {
  std::vector<Condition> block;
  std::vector<Eigen::Vector3d> seen;
  for (std::size_t i = 0; i < runs.size(); ++i)
    if (runs[i].withheld) {
      block.push_back(runs[i].run);
      seen.push_back(y[i]);
    }
  if (block.empty()) return nullptr;
  const Refit plain = refit(wheel, priors, grouped(training, uses_none), truth);
  const Refit full = refit(wheel, priors, grouped(training, x.uses()), truth, x);
  const std::vector<Eigen::Vector3d> exact = simulate_all(wheel, soil_of(priors, truth), x, block);
  const std::vector<Eigen::Vector3d> nominal = simulate_all(wheel, soil_of(priors, plain.u), {}, block);
  const std::vector<Eigen::Vector3d> knowing = simulate_all(wheel, soil_of(priors, full.u), x, block);
  json rows = json::array();
  for (std::size_t i = 0; i < block.size(); ++i)
    rows.push_back({{"slip", block[i].slip},
                    {"load_N", block[i].load},
                    {"omega_rad_s", block[i].omega},
                    {"pass", block[i].pass},
                    {"drawbar_N", exact[i][0]},
                    {"torque_Nm", exact[i][1]},
                    {"sinkage_m", exact[i][2]}});
  return {{"withheld", {fmt::format("load_N={:g}", kWithheldLoad)}},
          {"rmse_ratio", rms(seen, knowing, noise.sd) / rms(seen, nominal, noise.sd)},
          {"rmse_ratio_noise_free", rms(exact, knowing, noise.sd) / rms(exact, nominal, noise.sd)},
          {"truth", rows}};
}

// d of one of two effects where soil and the other effect are refitted.
double beside(const Wheel& wheel, const Priors& priors, const SoilVector& truth, const std::vector<Observation>& clean,
              Amplitudes x, Id other) {
  for (const Effect& e : effects())
    if (e.id != other) x[e.id] = 0;
  return std::sqrt(refit(wheel, priors, clean, truth, x, other).chi2);
}

json names_of(const std::vector<Id>& ids) {
  json out = json::array();
  for (const Id id : ids) out.push_back(std::string(effect(id).name));
  return out;
}

}  // namespace

std::vector<std::pair<std::string, int>> mix_of(const std::string& plan) {
  if (plan == "full")
    return {{"null_plain", 100}, {"null_preparation", 100}, {"null_numeric", 100}, {"effect", 210},
            {"sensor", 60},      {"outside", 80},           {"pair", 60},          {"wrong_noise", 35},
            {"outliers", 35},    {"parameter", 10},         {"poor", 10}};
  if (plan == "slip" || plan == "slip_load") return {{"null_plain", 10}, {"effect", 65}, {"sensor", 25}};
  if (plan == "confounded") return {{"confounded", 100}};
  throw std::invalid_argument(fmt::format("no plan is called '{}': slip, slip_load, full, confounded", plan));
}

std::vector<std::string> families(const GenerateOptions& options) {
  if (!options.family.empty()) return std::vector<std::string>(static_cast<std::size_t>(options.sets), options.family);
  const auto mix = mix_of(options.plan);
  int total = 0, given = 0;
  for (const auto& [name, weight] : mix) total += weight;
  std::vector<std::string> out;
  std::vector<std::pair<int, std::string>> rest;
  for (const auto& [name, weight] : mix) {
    const int share = options.sets * weight / total;
    out.insert(out.end(), static_cast<std::size_t>(share), name);
    rest.emplace_back(-(options.sets * weight % total), name);
    given += share;
  }
  std::stable_sort(rest.begin(), rest.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  for (std::size_t i = 0; given < options.sets; ++i, ++given) out.push_back(rest[i].second);
  Dice dice(seed_of(options.seed, 0));
  dice.shuffle(out);
  return out;
}

MadeSet make_set(const GenerateOptions& options, const std::string& family, int index) {
  Dice dice(seed_of(options.seed + "/" + options.plan, index));
  const Wheel wheel;
  const Priors priors;
  for (int attempt = 0; attempt < kDraws; ++attempt) try {
      Draw draw = draw_variants(options.plan, family, dice);
      std::vector<std::string> moved;
      SoilVector truth = draw_soil(priors, dice);
      if (family == "parameter") truth = shifted(truth, moved, dice);
      const Soil soil = soil_of(priors, truth);
      const std::vector<PlannedRun> runs = plan_runs(draw.plan, draw.layout, dice);
      const Fingerprint fingerprint(wheel, priors, truth, runs, draw.noise);
      Amplitudes x;
      std::vector<HiddenEffect> hidden;
      if (!is_null(family) && family != "parameter") {
        const std::vector<Id> ids = candidates(family, draw.plan);
        const double wanted = family == "pair" ? (dice.chance(0.5) ? 6.0 : 10.0) : draw_d(dice);
        const std::size_t count = family == "pair" ? 2 : 1;
        for (int tries = 0; hidden.size() < count && tries < 12; ++tries) {
          const Effect& e = effect(ids[static_cast<std::size_t>(dice.below(static_cast<int>(ids.size())))]);
          if (!hidden.empty() && hidden.front().id == e.id) continue;
          const double sign = e.signs == 2 ? (dice.chance(0.5) ? 1.0 : -1.0) : e.signs;
          if (family == "poor") {
            hidden.push_back({e.id, sign * 0.3 * e.typical});
            continue;
          }
          if (const auto found = tune(fingerprint, e.id, sign, wanted)) hidden.push_back(*found);
        }
        if (hidden.size() < count) continue;
        for (const HiddenEffect& h : hidden) x[h.id] = h.x;
      }
      std::vector<Id> together;
      std::vector<Observation> clean = fingerprint.observe(x);
      if (hidden.size() == 1 && in_library(hidden.front().id) && family != "poor")
        together = exact_class(wheel, clean, soil, hidden.front().id, hidden.front().x);
      if (family == "confounded" && together.size() < 2) continue;

      std::vector<int> outliers;
      const std::vector<Eigen::Vector3d> y = noisy(draw, wheel, soil, x, runs, outliers, dice);
      std::vector<Observation> training = clean;
      for (std::size_t i = 0, at = 0; i < runs.size(); ++i)
        if (!runs[i].withheld) training[at++].y = y[i];

      MadeSet out;
      const Eigen::Vector3d stated = draw.noise.sd * draw.noise.stated_factor;
      out.csv = csv_text(runs, y, stated, draw.columns, wheel);
      out.case_yaml = case_text(wheel, priors);
      if (draw.layout.withheld_block) out.withhold.push_back(fmt::format("load_N={:g}", kWithheldLoad));
      json& a = out.answer;
      a = {{"set", fmt::format("set_{:04d}", index)},
           {"family", family},
           {"plan", std::string(name(draw.plan))},
           {"variants", draw.variants},
           {"runs", runs.size()},
           {"noise_sd", {draw.noise.sd[0], draw.noise.sd[1], draw.noise.sd[2]}},
           {"outlier_orders", outliers},
           {"stated_factor", draw.noise.stated_factor},
           {"moved_parameters", moved},
           {"exact_class", names_of(together)},
           {"preparation", {draw.noise.ln_k_scatter, draw.noise.phi_scatter}},
           {"soil",
            {{"k", soil.k},
             {"n", soil.n},
             {"c", soil.c},
             {"phi", soil.phi},
             {"K", soil.K},
             {"a0", soil.a0},
             {"a1", soil.a1}}}};
      a["effects"] = json::array();
      for (const HiddenEffect& h : hidden) {
        const Effect& e = effect(h.id);
        a["effects"].push_back({{"id", std::string(e.name)},
                                {"x", h.x},
                                {"value", reported(h.id, h.x)},
                                {"unit", std::string(e.unit)},
                                {"d", h.d},
                                {"at_bound", h.at_bound},
                                {"variables", e.variables},
                                {"acts_through", e.acts_through},
                                {"in_library", in_library(h.id)}});
      }
      if (family == "pair")
        for (std::size_t i = 0; i < 2; ++i)
          a["effects"][i]["d_beside"] = beside(wheel, priors, truth, clean, x, hidden[1 - i].id);
      if (family == "null_numeric") {
        std::vector<Condition> conditions;
        for (const Observation& o : clean) conditions.push_back(o.run);
        const std::vector<Eigen::Vector3d> coarse = simulate_all(wheel, soil, {}, conditions, draw.numerics);
        for (std::size_t i = 0; i < clean.size(); ++i) clean[i].y = coarse[i];
        a["mismatch"] = {{"cells", draw.numerics.cells}, {"d", unabsorbed(wheel, priors, clean, truth)}};
      }
      const bool single = hidden.size() == 1 && in_library(hidden.front().id) && family != "poor";
      if (options.with_oracle && single) {
        const OracleAnswer o = oracle(wheel, priors, training, truth, x);
        a["oracle"] = {
            {"top", o.top}, {"ln_over_next", o.ln_over_next}, {"names", o.would_name && together.size() < 2}};
        a["gain"] = gain_of(wheel, priors, truth, x, runs, y, training, draw.noise);
      }
      if (options.with_oracle && family == "pair") {
        const PairAnswer o = pair_oracle(wheel, priors, training, truth, x);
        a["oracle"] = {{"top", o.top}, {"ln_over_next", o.ln_over_next}, {"first", o.first}, {"names", o.would_name}};
      }
      return out;
    } catch (const std::runtime_error&) {
      continue;  // a draw without a wheel somewhere: drawn again
    }
  throw std::runtime_error(fmt::format("set {} of family {}: nothing physical in {} draws", index, family, kDraws));
}

void generate(const GenerateOptions& options) {
  if (options.sets < 1) throw std::invalid_argument("--n must be 1 or more");
  const std::string sealed = options.answers.empty() ? options.out + "_answers/answers.json" : options.answers;
  const std::vector<std::string> all = families(options);
  json answers = {{"plan", options.plan}, {"seed", options.seed}, {"n", options.sets}, {"sets", json::array()}};
  json manifest = {{"plan", options.plan}, {"n", options.sets}, {"seed", options.seed}, {"sets", json::array()}};
  // Sets do not know of each other: any number of threads gives the same bytes.
  std::vector<MadeSet> made_sets(all.size());
  std::vector<std::exception_ptr> failures(all.size());
  std::atomic<int> next{1}, done{0};
  std::mutex talk;
  const auto work = [&] {
    for (int index = next++; index <= options.sets; index = next++) {
      const auto at = static_cast<std::size_t>(index - 1);
      try {
        made_sets[at] = make_set(options, all[at], index);
      } catch (...) {
        failures[at] = std::current_exception();
      }
      const int finished = ++done;
      const std::lock_guard lock(talk);
      if (finished % 10 == 0 || finished == options.sets)
        std::cerr << fmt::format("generated {} of {}\n", finished, options.sets);
    }
  };
  std::vector<std::thread> pool;
  for (unsigned i = 0; i < std::max(1u, std::thread::hardware_concurrency()); ++i) pool.emplace_back(work);
  for (std::thread& t : pool) t.join();
  for (const std::exception_ptr& failure : failures)
    if (failure) std::rethrow_exception(failure);
  for (int index = 1; index <= options.sets; ++index) {
    const MadeSet& made = made_sets[static_cast<std::size_t>(index - 1)];
    const std::string folder = fmt::format("{}/set_{:04d}", options.out, index);
    write_text(folder + "/data.csv", made.csv);
    write_text(folder + "/case.yaml", made.case_yaml);
    std::string lines;
    for (const std::string& w : made.withhold) lines += w + "\n";
    if (!lines.empty()) write_text(folder + "/withhold.txt", lines);
    manifest["sets"].push_back({{"set", fmt::format("set_{:04d}", index)}, {"data", digest(made.csv)}});
    answers["sets"].push_back(made.answer);
  }
  const std::string text = answers.dump(1) + "\n";
  manifest["answers_digest"] = digest(text);
  write_text(sealed, text);
  write_text(options.out + "/manifest.json", manifest.dump(1) + "\n");
}

}  // namespace blind
