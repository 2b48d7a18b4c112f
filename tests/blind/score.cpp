#include "score.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <stdexcept>

#include "decides.h"
#include "effects.h"
#include "seal.h"
#include "wilson.h"

namespace blind {
namespace {

using nlohmann::json;

struct View {
  const Scored& s;
  std::string family() const { return s.answer.at("family"); }
  std::string plan() const { return s.answer.at("plan"); }
  bool null() const { return family().rfind("null", 0) == 0; }
  std::set<std::string> truth() const {
    std::set<std::string> out;
    for (const json& e : s.answer.at("effects")) out.insert(e.at("id").get<std::string>());
    return out;
  }
  double d() const {
    double out = 1e9;
    for (const json& e : s.answer.at("effects")) out = std::min(out, e.at("d").get<double>());
    return out;
  }
  // Pairs whose effects each leave 6 or more when the other one is fitted too.
  bool apart() const {
    for (const json& e : s.answer.at("effects"))
      if (e.value("d_beside", 0.0) < 6) return false;
    return true;
  }
  bool outside() const { return family() == "outside"; }
  // One effect of the library that a refit cannot absorb.
  bool single() const { return s.answer.at("effects").size() == 1 && !outside() && family() != "poor"; }
  std::set<std::string> exact() const { return s.answer.at("exact_class").get<std::set<std::string>>(); }
  bool confounded() const { return exact().size() > 1; }
  bool named() const { return s.said.verdict == "named"; }
  bool right() const { return named() && s.said.cause == truth(); }
  bool top_right() const { return s.said.top == *truth().begin() || (confounded() && exact().contains(s.said.top)); }
};

using Filter = std::function<bool(const View&)>;

Tally count(const std::vector<Scored>& sets, const Filter& among, const Filter& hit) {
  Tally out;
  for (const Scored& s : sets) {
    const View v{s};
    if (s.said.present && among(v)) out.add(hit(v));
  }
  return out;
}

Bar rate_bar(std::string name, double low, double high, const Tally& t) {
  const auto [from, to] = wilson(t);
  return {std::move(name), low, high, t.n, t.rate(), from, to};
}

Bar median_bar(std::string name, double low, double high, const std::vector<double>& values) {
  const Median m = median(values);
  return {std::move(name), low, high, static_cast<int>(values.size()), m.value, m.low, m.high};
}

Filter between(double low, double high, const Filter& other) {
  return [=](const View& v) { return other(v) && v.d() >= low && v.d() < high; };
}

bool quiet(const View& v) { return v.s.said.verdict == "adequate" || v.s.said.verdict == "undecidable"; }
bool clean(const View& v) { return v.family() == "effect" || v.family() == "sensor"; }
bool plain_single(const View& v) { return v.single() && clean(v) && !v.confounded(); }
bool of_plan(const View& v, const char* plan) { return v.plan() == plan; }

// Value inside the interval that was stated for it; nothing without an interval.
std::optional<bool> covered(const View& v) {
  const json& e = v.s.answer.at("effects").at(0);
  const std::string id = e.at("id");
  const auto found = v.s.said.parameters.find(id);
  if (found == v.s.said.parameters.end() || !found->second.contains("ci90")) return {};
  const json& ci = found->second.at("ci90");
  if (!ci.is_array() || ci.size() != 2 || !ci.at(0).is_number() || !ci.at(1).is_number()) return {};
  const std::string unit = found->second.value("unit", std::string(e.at("unit")));
  const Id which = effect(id).id;
  const double a = from_reported(which, ci.at(0), unit), b = from_reported(which, ci.at(1), unit), x = e.at("x");
  return std::min(a, b) <= x && x <= std::max(a, b);
}

bool meets(const std::set<std::string>& said, const json& right) {
  for (const json& r : right)
    if (said.contains(r.get<std::string>())) return true;
  return false;
}

std::vector<double> gains(const std::vector<Scored>& sets) {
  std::vector<double> out;
  for (const Scored& s : sets) {
    if (!s.said.present || !s.said.gain_ratio || !s.answer.contains("gain") || s.answer.at("gain").is_null()) continue;
    const double oracle = 1.0 - s.answer.at("gain").at("rmse_ratio").get<double>();
    if (oracle > 0.05) out.push_back((1.0 - *s.said.gain_ratio) / oracle);
  }
  return out;
}

struct PairRates {
  const char* name;
  Tally exact, first, in_class, oracle_first, oracle_names;
};
/// Pairs of the engine beside the oracle: named, put first among all accounts, both in the class that was given.
std::vector<PairRates> pair_rates(const std::vector<Scored>& sets) {
  std::vector<PairRates> out{{"d 6 each", {}, {}, {}, {}, {}},
                             {"d 10 each", {}, {}, {}, {}, {}},
                             {"both d >= 6 beside the other", {}, {}, {}, {}, {}}};
  for (const Scored& s : sets) {
    const View v{s};
    if (!s.said.present || v.family() != "pair" || !s.answer.contains("oracle")) continue;
    const std::set<std::string> truth = v.truth();
    const bool among = std::all_of(truth.begin(), truth.end(), [&](const std::string& id) {
      return std::find(s.said.klass.begin(), s.said.klass.end(), id) != s.said.klass.end();
    });
    for (std::size_t i = 0; i < out.size(); ++i) {
      if (i == 2 ? !v.apart() : (v.d() < 7.7) != (i == 0)) continue;
      out[i].exact.add(v.right());
      out[i].first.add(ids_of(json(s.said.top)) == truth);
      out[i].in_class.add(v.right() || (s.said.verdict == "class" && among));
      out[i].oracle_first.add(s.answer.at("oracle").at("first").get<bool>());
      out[i].oracle_names.add(s.answer.at("oracle").at("first").get<bool>() &&
                              s.answer.at("oracle").at("names").get<bool>());
    }
  }
  return out;
}

}  // namespace

std::vector<Bar> bars(const std::vector<Scored>& sets) {
  std::vector<Bar> out;
  for (const char* family : {"null_plain", "null_preparation", "null_numeric"})
    out.push_back(rate_bar(
        fmt::format("false alarm, {}", family), 0, 0.01,
        count(
            sets, [=](const View& v) { return v.family() == family; }, [](const View& v) { return !quiet(v); })));
  const Filter full = [](const View& v) { return plain_single(v) && of_plan(v, "full"); };
  const Filter top = [](const View&v) { return v.top_right(); }, right = [](const View&v) { return v.right(); };
  out.push_back(rate_bar("top-1, d 6-8", 0.90, 1, count(sets, between(6, 8, full), top)));
  out.push_back(rate_bar("top-1, d 8-15", 0.95, 1, count(sets, between(8, 15, full), top)));
  out.push_back(rate_bar("top-1, d > 15", 0.99, 1, count(sets, between(15, 1e9, full), top)));
  const Filter any_named = [](const View& v) {
    return v.named() && v.family() != "poor" && v.family() != "outliers" && v.family() != "wrong_noise" &&
           of_plan(v, "full");
  };
  out.push_back(rate_bar("right when named", 0.98, 1, count(sets, any_named, right)));
  out.push_back(rate_bar("right when named, slip sweep", 0.95, 1,
                         count(
                             sets, [](const View& v) { return v.named() && of_plan(v, "slip"); }, right)));
  out.push_back(rate_bar("named and right, d 8-10", 0.82, 1, count(sets, between(8, 10, full), right)));
  out.push_back(rate_bar("named and right, d > 10", 0.95, 1, count(sets, between(10, 1e9, full), right)));
  out.push_back(rate_bar(
      "one name in an exactly confounded class", 0, 0.01,
      count(
          sets, [](const View& v) { return v.single() && v.confounded(); }, [](const View& v) { return v.named(); })));
  const Filter outside = [](const View&v) { return v.outside(); },
               unknown = [](const View&v) { return v.s.said.verdict == "unknown"; };
  out.push_back(rate_bar("unknown, d 8-10", 0.65, 1, count(sets, between(8, 10, outside), unknown)));
  out.push_back(rate_bar("unknown, d 10-15", 0.88, 1, count(sets, between(10, 15, outside), unknown)));
  out.push_back(rate_bar("unknown, d > 15", 0.98, 1, count(sets, between(15, 1e9, outside), unknown)));
  out.push_back(rate_bar(
      "variable named when unknown", 0.92, 1,
      count(
          sets, [](const View& v) { return v.outside() && v.s.said.verdict == "unknown"; },
          [](const View& v) { return meets(v.s.said.variable, v.s.answer.at("effects").at(0).at("variables")); })));
  const Filter pair = [](const View& v) { return v.family() == "pair"; };
  out.push_back(rate_bar("pair exact, d 6 each", 0.78, 1, count(sets, between(4.5, 7.7, pair), right)));
  out.push_back(rate_bar("pair exact, d 10 each", 0.90, 1, count(sets, between(7.7, 13, pair), right)));
  const Filter apart = [=](const View& v) { return pair(v) && v.apart(); };
  out.push_back(rate_bar("pair exact, both d >= 6 beside the other", 0.78, 1, count(sets, apart, right)));
  out.push_back(rate_bar("90 % intervals cover", 0.87, 0.93,
                         count(
                             sets, [](const View& v) { return v.right() && v.single() && covered(v).has_value(); },
                             [](const View& v) { return covered(v).value(); })));
  out.push_back(median_bar("gain recovered, median", 0.95, 1e9, gains(sets)));
  for (const char* family : {"outliers", "wrong_noise"})
    out.push_back(rate_bar(fmt::format("right when named, {}", family), 0.97, 1,
                           count(
                               sets, [=](const View& v) { return v.named() && v.family() == family; }, right)));
  std::vector<double> rank, total;
  for (const Scored& s : sets) {
    if (s.said.rank_seconds) rank.push_back(*s.said.rank_seconds);
    if (s.said.total_seconds || s.said.wall_seconds)
      total.push_back(s.said.total_seconds ? *s.said.total_seconds : *s.said.wall_seconds);
  }
  out.push_back(median_bar("refit and ranking, s, median", 0, 0.5, rank));
  out.push_back(median_bar("everything, s, median", 0, 5.0, total));
  return out;
}

std::string details(const std::vector<Scored>& sets) {
  std::string out = fmt::format("\n{:<26}{:>5}{:>10}{:>10}{:>8}{:>8}{:>9}{:>12}{:>8}{:>8}\n", "family (plan)", "n",
                                "adequate", "parameter", "named", "class", "unknown", "undecidable", "right", "absent");
  std::map<std::string, std::vector<const Scored*>> by_family;
  for (const Scored& s : sets) by_family[fmt::format("{} ({})", View{s}.family(), View{s}.plan())].push_back(&s);
  for (const auto& [family, members] : by_family) {
    std::map<std::string, int> said;
    int right = 0, absent = 0;
    for (const Scored* s : members) {
      absent += s->said.present ? 0 : 1;
      ++said[s->said.verdict];
      right += View{*s}.right() ? 1 : 0;
    }
    out += fmt::format("{:<26}{:>5}{:>10}{:>10}{:>8}{:>8}{:>9}{:>12}{:>8}{:>8}\n", family, members.size(),
                       said["adequate"], said["parameter"], said["named"], said["class"], said["unknown"],
                       said["undecidable"], right, absent);
  }
  out += fmt::format("\n{:<26}{:>6}{:>9}{:>9}{:>8}{:>14}{:>14}\n", "single effects by d", "n", "top-1", "oracle",
                     "ratio", "named, right", "oracle names");
  for (const auto& [low, high] :
       std::vector<std::pair<double, double>>{{3, 4.5}, {4.5, 6}, {6, 8}, {8, 10}, {10, 15}, {15, 1e9}}) {
    Tally top, oracle, named, would;
    for (const Scored& s : sets) {
      const View v{s};
      if (!s.said.present || !plain_single(v) || v.d() < low || v.d() >= high || !s.answer.contains("oracle")) continue;
      const bool best = s.answer.at("oracle").at("top") == *v.truth().begin();
      top.add(v.top_right());
      oracle.add(best);
      named.add(v.right());
      would.add(best && s.answer.at("oracle").at("names").get<bool>());
    }
    out += fmt::format("{:<26}{:>6}{:>9.3f}{:>9.3f}{:>8.3f}{:>14.3f}{:>14.3f}\n",
                       high < 1e8 ? fmt::format("d {:g} to {:g}", low, high) : fmt::format("d over {:g}", low), top.n,
                       top.rate(), oracle.rate(), oracle.yes > 0 ? static_cast<double>(top.yes) / oracle.yes : 0.0,
                       named.rate(), would.rate());
  }
  out += fmt::format("\n{:<26}{:>6}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}\n", "pairs", "n", "exact", "first", "in class",
                     "oracle", "oracle", "exact/");
  out +=
      fmt::format("{:<26}{:>6}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}\n", "", "", "named", "", "", "first", "names", "oracle");
  for (const PairRates& p : pair_rates(sets))
    out += fmt::format("{:<26}{:>6}{:>9.3f}{:>9.3f}{:>9.3f}{:>9.3f}{:>9.3f}{:>9.3f}\n", p.name, p.exact.n,
                       p.exact.rate(), p.first.rate(), p.in_class.rate(), p.oracle_first.rate(), p.oracle_names.rate(),
                       p.oracle_names.yes > 0 ? static_cast<double>(p.exact.yes) / p.oracle_names.yes : 0.0);
  out += "\nsingle effects not put first (d >= 8):\n";
  for (const Scored& s : sets) {
    const View v{s};
    if (s.said.present && v.single() && v.d() >= 8 && !v.top_right())
      out += fmt::format("  {} {} {} d {:.1f}: {} {}\n", s.answer.at("set").get<std::string>(), v.family(),
                         *v.truth().begin(), v.d(), s.said.verdict, s.said.top);
  }
  return out;
}

namespace {

struct Experiments {
  Tally as_stated, runs_only, with_four;
  int not_simulated = 0;
};

/// The first recommendation for every class that holds the truth: the number of runs it asks for (12 at most), or its bench check.
Experiments experiments_of(const std::vector<Scored>& sets) {
  Experiments out;
  for (const Scored& s : sets) {
    const View v{s};
    if (!s.said.present || s.said.verdict != "class" || !v.single()) continue;
    const std::string truth = *v.truth().begin();
    std::string rival;
    bool inside = false;
    for (const std::string& id : s.said.klass) {
      if (id == truth)
        inside = true;
      else if (rival.empty())
        rival = id;
    }
    if (!inside || rival.empty()) continue;
    if (s.said.experiments.empty()) {
      out.as_stated.add(false);
      continue;
    }
    const json& first = s.said.experiments.at(0);
    if (first.contains("decides") && first.at("decides").is_array())
      for (const json& id : first.at("decides"))
        if (id.is_string() && id.get<std::string>() != truth &&
            std::find(s.said.klass.begin(), s.said.klass.end(), id.get<std::string>()) != s.said.klass.end())
          rival = id.get<std::string>();
    std::optional<double> length, four;
    try {
      const std::string csv = read_text(s.folder + "/" + s.answer.at("set").get<std::string>() + "/data.csv");
      if (first.contains("bench_effect"))
        length = bench_separation(s.answer, csv, rival, first.at("bench_effect").get<std::string>(),
                                  std::clamp(first.value("runs", 4), 4, 16));
      else {
        const int runs = std::clamp(first.value("runs", kDecidingRuns), 1, 12);
        four = separation(s.answer, csv, rival, first.value("condition", json()));
        if (four) length = *four * std::sqrt(static_cast<double>(runs) / kDecidingRuns);
      }
    } catch (const std::invalid_argument&) {
      length.reset();  // a rival that is not an effect, such as a parameter
    }
    if (!length) {
      ++out.not_simulated;
      continue;
    }
    out.as_stated.add(*length > kDecidingLength);
    if (four) out.with_four.add(*four > kDecidingLength), out.runs_only.add(*length > kDecidingLength);
  }
  return out;
}

}  // namespace

namespace {

std::vector<std::string> listed(const std::string& text) {
  std::vector<std::string> out(1);
  for (const char c : text)
    if (c == ',')
      out.emplace_back();
    else
      out.back() += c;
  return out;
}

/// One folder of sets with its answers, both as they were sealed.
json add_sealed(const std::string& sets, const std::string& answers, const std::string& results,
                std::vector<Scored>& all) {
  const std::string sealed = read_text(answers);
  const json manifest = json::parse(read_text(sets + "/manifest.json"));
  if (manifest.at("answers_digest") != digest(sealed))
    throw std::runtime_error(fmt::format("{} are not the answers of {}: the seal {} is broken", answers, sets,
                                         manifest.at("answers_digest").get<std::string>()));
  for (const json& s : manifest.at("sets")) {
    const std::string folder = sets + "/" + s.at("set").get<std::string>();
    if (s.at("data") != digest(read_text(folder + "/data.csv")))
      throw std::runtime_error(fmt::format("{}/data.csv was changed", folder));
  }
  const json truth = json::parse(sealed);
  for (const json& a : truth.at("sets"))
    all.push_back({a, read_said(results + "/" + a.at("set").get<std::string>()), sets});
  return manifest;
}

}  // namespace

std::string score(const std::string& sets, const std::string& answers, const std::string& results,
                  const std::string& json_file) {
  const auto folders = listed(sets), sealed = listed(answers), said = listed(results);
  if (folders.size() != sealed.size() || folders.size() != said.size())
    throw std::runtime_error("as many folders of sets as of answers and results");
  std::vector<Scored> all;
  std::string plans, seeds;
  for (std::size_t i = 0; i < folders.size(); ++i) {
    const json manifest = add_sealed(folders[i], sealed[i], said[i], all);
    plans += (i > 0 ? ", " : "") + manifest.at("plan").get<std::string>();
    seeds += (i > 0 ? ", " : "") + manifest.at("seed").get<std::string>();
  }
  std::vector<Bar> table = bars(all);
  const Experiments experiments = experiments_of(all);
  table.push_back(rate_bar("recommended experiment decides", 0.90, 1, experiments.as_stated));
  table.push_back(rate_bar("  runs on soil alone", 0.90, 1, experiments.runs_only));
  table.push_back(rate_bar("  runs on soil alone, never more than four", 0.90, 1, experiments.with_four));
  std::string out = fmt::format("plan {}, seed '{}', {} sets\n\n{:<44}{:>6}{:>10}  {:<18}{:<16}\n", plans, seeds,
                                all.size(), "bar", "n", "figure", "90 % interval", "wanted");
  json rows = json::array();
  for (const Bar& b : table) {
    const std::string wanted = b.high > 1e8 || (b.high == 1 && b.low > 0) ? fmt::format(">= {:g}", b.low)
                               : b.low == 0                               ? fmt::format("<= {:g}", b.high)
                                                                          : fmt::format("{:g} to {:g}", b.low, b.high);
    const char* verdict = b.n == 0 ? "no sets" : b.met() ? "met" : "MISSED";
    const bool few = b.n > 0 && b.n < 200 && ((b.low >= 0.98 && b.high == 1) || b.high <= 0.02);
    out += fmt::format("{:<44}{:>6}{:>10.4f}  {:<18}{:<16}{}{}\n", b.name, b.n, b.figure,
                       fmt::format("[{:.4f}, {:.4f}]", b.from, b.to), wanted, verdict, few ? " (under 200 sets)" : "");
    rows.push_back({{"bar", b.name},
                    {"n", b.n},
                    {"figure", b.figure},
                    {"interval90", {b.from, b.to}},
                    {"wanted", {b.low, b.high}},
                    {"met", b.n > 0 ? json(b.met()) : json()}});
  }
  if (experiments.not_simulated > 0)
    out += fmt::format("({} recommended experiments concern no effect or have no wheel: not simulated)\n",
                       experiments.not_simulated);
  int absent = 0;
  for (const Scored& s : all) absent += s.said.present ? 0 : 1;
  if (absent > 0)
    out += fmt::format("{} of {} sets have no diagnosis.json: they are in no figure above\n", absent, all.size());
  out += details(all);
  json pairs = json::array();
  for (const PairRates& p : pair_rates(all))
    pairs.push_back({{"pairs", p.name},
                     {"n", p.exact.n},
                     {"exact", p.exact.rate()},
                     {"first", p.first.rate()},
                     {"in_class", p.in_class.rate()},
                     {"oracle_first", p.oracle_first.rate()},
                     {"oracle_names", p.oracle_names.rate()}});
  if (!json_file.empty())
    write_text(
        json_file,
        json({{"plans", plans}, {"seeds", seeds}, {"sets", all.size()}, {"bars", rows}, {"pairs", pairs}}).dump(1) +
            "\n");
  return out;
}

}  // namespace blind
