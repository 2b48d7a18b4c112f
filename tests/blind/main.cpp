// blind: makes sets with a hidden cause, runs the diagnosis on them, scores what it said.
#include <fmt/core.h>

#include <cstdio>
#include <exception>
#include <map>
#include <stdexcept>
#include <string>

#include "drive.h"
#include "generate.h"
#include "score.h"

namespace {

constexpr const char* kUse =
    "blind generate --plan slip|slip_load|full|confounded --n N --seed TEXT --out DIR [--answers FILE] [--family NAME] "
    "[--oracle no]\n"
    "blind run      --sets DIR --grouser COMMAND --results DIR [--jobs N] [--limit N] [--timeout SECONDS]\n"
    "blind score    --sets DIR[,DIR] --answers FILE[,FILE] --results DIR[,DIR] [--json FILE]\n";

std::map<std::string, std::string> options(int count, char** words, const std::map<std::string, bool>& known) {
  std::map<std::string, std::string> out;
  for (int i = 2; i < count; i += 2) {
    const std::string key = words[i];
    if (!known.contains(key)) throw std::invalid_argument(fmt::format("unknown option '{}'\n{}", key, kUse));
    if (i + 1 >= count) throw std::invalid_argument(fmt::format("{} lacks its value\n{}", key, kUse));
    out[key] = words[i + 1];
  }
  for (const auto& [key, required] : known)
    if (required && !out.contains(key)) throw std::invalid_argument(fmt::format("{} is missing\n{}", key, kUse));
  return out;
}

int whole(const std::map<std::string, std::string>& from, const std::string& key, int otherwise) {
  const auto found = from.find(key);
  if (found == from.end()) return otherwise;
  std::size_t used = 0;
  const int value = std::stoi(found->second, &used);
  if (used != found->second.size())
    throw std::invalid_argument(fmt::format("{} takes a whole number, not '{}'", key, found->second));
  return value;
}

int act(int count, char** words) {
  const std::string verb = count > 1 ? words[1] : "";
  if (verb == "generate") {
    const auto o = options(count, words,
                           {{"--plan", true},
                            {"--n", true},
                            {"--seed", true},
                            {"--out", true},
                            {"--answers", false},
                            {"--family", false},
                            {"--oracle", false}});
    blind::GenerateOptions g;
    g.plan = o.at("--plan");
    g.sets = whole(o, "--n", 0);
    g.seed = o.at("--seed");
    g.out = o.at("--out");
    if (o.contains("--answers")) g.answers = o.at("--answers");
    if (o.contains("--family")) g.family = o.at("--family");
    g.with_oracle = !o.contains("--oracle") || o.at("--oracle") != "no";
    blind::generate(g);
    return 0;
  }
  if (verb == "run") {
    const auto o = options(count, words,
                           {{"--sets", true},
                            {"--grouser", true},
                            {"--results", true},
                            {"--jobs", false},
                            {"--limit", false},
                            {"--timeout", false}});
    blind::DriveOptions d;
    d.sets = o.at("--sets");
    d.command = o.at("--grouser");
    d.results = o.at("--results");
    d.jobs = whole(o, "--jobs", 0);
    d.limit = whole(o, "--limit", 0);
    d.timeout = whole(o, "--timeout", 120);
    return blind::drive(d);
  }
  if (verb == "score") {
    const auto o =
        options(count, words, {{"--sets", true}, {"--answers", true}, {"--results", true}, {"--json", false}});
    const std::string file = o.contains("--json") ? o.at("--json") : "";
    std::fputs(blind::score(o.at("--sets"), o.at("--answers"), o.at("--results"), file).c_str(), stdout);
    return 0;
  }
  throw std::invalid_argument(fmt::format("blind: what to do?\n{}", kUse));
}

}  // namespace

int main(int count, char** words) {
  try {
    return act(count, words);
  } catch (const std::invalid_argument& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 2;
  } catch (const std::exception& e) {
    fmt::print(stderr, "blind: {}\n", e.what());
    return 1;
  }
}
