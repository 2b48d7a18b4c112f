#include "diagnose_design.h"

#include <fmt/core.h>
#include <fmt/ranges.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "figure_page.h"
#include "grouser/diagnosis/design.h"
#include "grouser/models.h"
#include "grouser/terrain/config.h"
#include "grouser/terrain/recorder.h"

namespace grouser::app {

namespace fs = std::filesystem;

namespace {

using namespace diagnosis;
using Json = nlohmann::ordered_json;

Json number(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }

Json design_json(const Design& d) {
  Json j{{"sentence", d.sentence}, {"runs", d.runs}, {"alike_limit", alike_limit}, {"alike_pairs", d.alike_pairs}};
  for (const DesignEffect& e : d.effects)
    j["effects"].push_back({{"id", e.id},
                            {"unit", e.unit},
                            {"typical", number(e.typical)},
                            {"distance_of_typical", number(e.distance)},
                            {"smallest_seen", number(e.smallest)},
                            {"within_bounds", e.within_bounds}});
  j["likeness"] = d.likeness;
  j["clusters"] = d.clusters;
  j["add"] = Json::array();
  for (const DesignRun& r : d.add)
    j["add"].push_back({{"condition", r.condition}, {"repeats", r.repeats}, {"alike_pairs_left", r.alike_pairs}});
  j["notes"] = d.notes;
  return j;
}

std::string shown(const DesignRun& r) {
  std::string out;
  for (const auto& [name, x] : r.condition) out += fmt::format("{}{} {:.3g}", out.empty() ? "" : ", ", name, x);
  return out;
}

report::FigurePage design_page(const Design& d) {
  report::FigurePage page{"What this plan could tell apart", d.sentence, {}};
  report::Plot map{"Which effects look alike",
                   "number of the effect in the table",
                   "number of the effect in the table",
                   "A point for each pair: |cos| of the two fingerprints that a refit of the soil leaves. Pairs above "
                   "0.95 cannot be "
                   "told apart by runs like these.",
                   {},
                   false,
                   false};
  const struct {
    const char* name;
    double low, high;
  } bands[] = {{"above 0.95", alike_limit, 2}, {"0.8 to 0.95", 0.8, alike_limit}, {"0.6 to 0.8", 0.6, 0.8}};
  for (const auto& band : bands) {
    report::Series s{band.name, report::Series::Style::points, {}, {}, {}, static_cast<int>(map.series.size())};
    for (std::size_t a = 0; a < d.likeness.size(); ++a)
      for (std::size_t b = 0; b < d.likeness.size(); ++b)
        if (a != b && d.likeness[a][b] > band.low && d.likeness[a][b] <= band.high)
          s.x.push_back(static_cast<double>(a + 1)), s.y.push_back(static_cast<double>(b + 1));
    if (!s.x.empty()) map.series.push_back(std::move(s));
  }
  if (!map.series.empty()) page.items.push_back(std::move(map));
  report::FigureTable alike{"Cannot be told apart", {"effects"}, {}};
  for (const auto& c : d.clusters) alike.rows.push_back({fmt::format("{}", fmt::join(c, ", "))});
  if (!alike.rows.empty()) page.items.push_back(std::move(alike));
  report::FigureTable add{"Best runs to add", {"run, four repeats", "pairs that then still look alike"}, {}};
  for (const DesignRun& r : d.add) add.rows.push_back({shown(r), fmt::format("{}", r.alike_pairs)});
  if (!add.rows.empty()) page.items.push_back(std::move(add));
  report::FigureTable effects{"Smallest size that would be seen",
                              {"number", "effect", "seen from", "ordinary size", "distance of that [noise sd]", "unit"},
                              {}};
  for (std::size_t i = 0; i < d.effects.size(); ++i) {
    const DesignEffect& e = d.effects[i];
    effects.rows.push_back({fmt::format("{}", i + 1), e.id,
                            e.within_bounds ? fmt::format("{:.3g}", e.smallest) : "not within physical bounds",
                            fmt::format("{:.3g}", e.typical), fmt::format("{:.3g}", e.distance), e.unit});
  }
  page.items.push_back(std::move(effects));
  return page;
}

}  // namespace

void run_design(const fs::path& case_file, const std::string& plan, fs::path out, bool overwrite) {
  if (out.empty()) out = fs::path("runs") / ("design-" + case_file.stem().string());
  if (fs::exists(out / "design.json") && !overwrite)
    throw ConfigError(out.string(), 0, 0, "holds an earlier design; use --overwrite, or another folder with --out");
  const DiagnosisCase c = read_case(case_file, &all_models());
  const bool file = plan.size() > 4 && plan.substr(plan.size() - 4) == ".csv";
  const Design d = judge_design(c, file ? read_plan(plan, c) : grid_plan(plan));
  std::error_code failed;
  fs::create_directories(out, failed);
  std::ofstream json(out / "design.json");
  json << design_json(d).dump(2) << "\n";
  if (failed || !json.flush()) throw ResultsError(out.string() + ": cannot be written; choose another output folder");
  report::write_figure_page(design_page(d), out / "report.html");
  fmt::print("{}\n", d.sentence);
  for (const auto& cluster : d.clusters) fmt::print("  alike: {}\n", fmt::join(cluster, ", "));
  for (const DesignRun& r : d.add) fmt::print("  add: {} x {} ({} pairs left)\n", r.repeats, shown(r), r.alike_pairs);
  fmt::print("report: {}\n", (out / "report.html").string());
}

}  // namespace grouser::app
