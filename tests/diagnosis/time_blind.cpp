// Counts verdicts over sets with something hidden.   time_blind [sets of each kind] [first seed]
#include <fmt/core.h>
#include <fmt/ranges.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <map>

#include "blind/wilson.h"
#include "grouser/diagnosis/time_series.h"
#include "time_generator.h"

namespace {

namespace fs = std::filesystem;
using namespace grouser::diagnosis;

struct Kind {
  hidden::What what;
  double d;
  bool one_speed = false;
  bool scatter_known = false;
};

struct Count {
  std::map<std::string, int> verdicts;
  blind::Tally right, wrong_name, first, covered;
  std::vector<double> seconds, sizes;
};

}  // namespace

int main(int argc, char** argv) {
  const int sets = argc > 1 ? std::atoi(argv[1]) : 10;
  const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  const std::string only = argc > 3 ? argv[3] : "";
  const fs::path folder = fs::temp_directory_path() / fmt::format("grouser_time_blind_{}", std::time(nullptr));
  fs::create_directories(folder);
  using hidden::What;
  std::vector<Kind> kinds{
      {What::nothing, 0}, {What::soil, 0}, {What::scattered, 0, false, true}, {What::scattered, 0, false, false}};
  for (const double d : {30.0, 100.0, 300.0})
    for (const What w : {What::relaxation, What::filter, What::delay}) kinds.push_back({w, d});
  for (const double d : {8.0, 15.0, 30.0}) kinds.push_back({What::ripple, d});
  kinds.push_back({What::relaxation_and_ripple, 15});
  for (const What w : {What::relaxation, What::filter}) kinds.push_back({w, 100, true});
  for (const double d : {30.0, 100.0, 300.0})
    for (const What w : {What::two_scales, What::one_sensor, What::overshoot}) kinds.push_back({w, d});
  fmt::print("{:<28}{:>5}   median  right [90 %]          first  wrong names  covered  verdicts\n", "hidden", "d");
  for (const Kind& kind : kinds) {
    if (!only.empty() && std::string(hidden::name_of(kind.what)) != only) continue;
    Count n;
    for (int i = 0; i < sets; ++i) {
      hidden::Plan plan;
      if (kind.one_speed) plan.travel = {0.05, 0.05};
      const hidden::Set set =
          hidden::make(kind.what, kind.d, seed * 1000003 + static_cast<std::uint64_t>(i) * 97, plan);
      std::ofstream(folder / "set.csv") << set.csv;
      std::ofstream(folder / "case.yaml") << hidden::case_text(kind.scatter_known);
      const TimeCase c = read_time_case(folder / "case.yaml");
      const std::clock_t begin = std::clock();
      const TimeDiagnosis t = diagnose_time(c, read_time_table(folder / "set.csv", c), {});
      n.seconds.push_back(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
      const Diagnosis& d = t.d;
      n.sizes.push_back(set.size);
      ++n.verdicts[d.verdict == "named"   ? "named " + d.cause
                   : d.verdict == "class" ? fmt::format("class {}", fmt::join(d.members, "|"))
                                          : d.verdict];
      const std::string right = hidden::right_name(kind.what);
      const bool named = d.verdict == "named", quiet = d.verdict == "adequate" || d.verdict == "parameter";
      bool good = false;
      if (right.empty())
        good = kind.d == 0 ? quiet : d.verdict == "unknown";
      else if (kind.one_speed)
        good = d.verdict == "class" && d.members.size() == 2;
      else
        good = named && d.cause == right;
      n.right.add(good);
      n.wrong_name.add(named && d.cause != right);
      n.first.add(!right.empty() && !d.ranking.empty() && d.ranking[0].id == right);
      if (named && d.cause == right && kind.what != What::relaxation_and_ripple) {
        const Interval& q = d.parameters.begin()->second;
        n.covered.add(q.low <= set.size && set.size <= q.high);
      }
    }
    const auto [low, high] = blind::wilson(n.right);
    std::string verdicts;
    for (const auto& [v, k] : n.verdicts) verdicts += fmt::format("{}{} {}", verdicts.empty() ? "" : ", ", k, v);
    double sum = 0;
    for (const double s : n.seconds) sum += s;
    fmt::print(
        "{:<28}{:>5} {:>8.3g}  {:>3}/{:<3} [{:.2f}, {:.2f}]  {:>5.2f}  {:>11}  {:>3}/{:<3}  {}  ({:.2f} s each)\n",
        std::string(hidden::name_of(kind.what)) + (kind.one_speed       ? ", one speed"
                                                   : kind.scatter_known ? ", stated"
                                                                        : ""),
        kind.d, blind::median(n.sizes).value, n.right.yes, n.right.n, low, high, n.first.rate(), n.wrong_name.yes,
        n.covered.yes, n.covered.n, verdicts, sum / sets);
    std::fflush(stdout);
  }
  fs::remove_all(folder);
}
