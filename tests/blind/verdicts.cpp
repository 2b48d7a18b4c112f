#include "verdicts.h"

#include <fmt/core.h>

#include <array>
#include <filesystem>
#include <stdexcept>

#include "seal.h"

namespace blind {
namespace {

using nlohmann::json;

constexpr std::array<std::string_view, 6> kVerdicts{"adequate", "parameter", "named",
                                                    "class",    "unknown",   "undecidable"};

std::optional<double> number(const json& from, const char* key) {
  if (from.is_object() && from.contains(key) && from.at(key).is_number()) return from.at(key).get<double>();
  return {};
}

std::set<std::string> words(const json& from) {
  std::set<std::string> out;
  if (from.is_string()) out.insert(from.get<std::string>());
  if (from.is_array())
    for (const json& w : from)
      if (w.is_string()) out.insert(w.get<std::string>());
  return out;
}

}  // namespace

std::set<std::string> ids_of(const json& cause) {
  std::set<std::string> out;
  for (const std::string& text : words(cause)) {
    std::string id;
    for (const char c : text + "+") {
      if (c == '+') {
        if (!id.empty()) out.insert(id);
        id.clear();
      } else if (c != ' ') {
        id += c;
      }
    }
  }
  return out;
}

Said said_of(const json& d) {
  Said out;
  out.present = true;
  out.verdict = d.value("verdict", "");
  if (std::find(kVerdicts.begin(), kVerdicts.end(), out.verdict) == kVerdicts.end())
    throw std::runtime_error(
        fmt::format("verdict '{}' is none of adequate, parameter, named, class, unknown, undecidable", out.verdict));
  if (d.contains("cause")) out.cause = ids_of(d.at("cause"));
  if (d.contains("class")) {
    const std::set<std::string> members = words(d.at("class"));
    out.klass.assign(members.begin(), members.end());
  }
  double best = -1;
  if (d.contains("posterior") && d.at("posterior").is_object())
    for (const auto& [id, p] : d.at("posterior").items())
      if (id != "none" && id != "unknown" && p.is_number() && p.get<double>() > best) {
        best = p.get<double>();
        out.top = id;
      }
  if (out.verdict == "named" && !out.cause.empty()) {
    out.top.clear();
    for (const std::string& id : out.cause) out.top += (out.top.empty() ? "" : "+") + id;
  }
  if (d.contains("parameters") && d.at("parameters").is_object())
    for (const auto& [id, p] : d.at("parameters").items()) out.parameters[id] = p;
  if (d.contains("unknown") && d.at("unknown").is_object()) {
    out.variable = words(d.at("unknown").value("variable", json()));
    out.acts_through = words(d.at("unknown").value("acts_through", json()));
  }
  if (d.contains("gain")) out.gain_ratio = number(d.at("gain"), "rmse_ratio");
  if (d.contains("next_experiment") && d.at("next_experiment").is_array()) out.experiments = d.at("next_experiment");
  if (d.contains("timing")) {
    out.rank_seconds = number(d.at("timing"), "rank_s");
    out.total_seconds = number(d.at("timing"), "total_s");
  }
  return out;
}

Said read_said(const std::string& folder) {
  Said out;
  if (std::filesystem::exists(folder + "/diagnosis.json")) {
    try {
      out = said_of(json::parse(read_text(folder + "/diagnosis.json")));
    } catch (const std::exception& e) {
      throw std::runtime_error(fmt::format("{}/diagnosis.json: {}", folder, e.what()));
    }
  }
  if (std::filesystem::exists(folder + "/run.json"))
    out.wall_seconds = number(json::parse(read_text(folder + "/run.json")), "wall_s");
  return out;
}

}  // namespace blind
