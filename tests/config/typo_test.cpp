// Property: a key with a typo never passes, whatever the typo.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <random>
#include <regex>
#include <sstream>

#include "grouser/terrain/loaders.h"

namespace grouser {
namespace {

std::string read_all(const std::string& file) {
  std::ifstream in(file);
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

std::string with_typo(std::string key, std::mt19937& rng) {
  const auto pick = [&](std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(rng); };
  const std::size_t i = pick(key.size());
  const char letter = static_cast<char>('a' + pick(26));
  switch (pick(4)) {
    case 0:
      key.insert(i, 1, letter);
      break;
    case 1:
      key[i] = letter;
      break;
    case 2:
      if (key.size() > 1) key.erase(i, 1);
      break;
    default:
      if (i + 1 < key.size()) std::swap(key[i], key[i + 1]);
  }
  return key;
}

template <class Load>
void typos_are_caught(const std::string& file, Load load) {
  const std::string text = read_all(file);
  ASSERT_FALSE(text.empty()) << file;
  const std::regex key_pattern("([A-Za-z_0-9]+): ?");
  std::vector<std::pair<std::size_t, std::string>> keys;
  for (std::sregex_iterator it(text.begin(), text.end(), key_pattern), end; it != end; ++it) {
    const auto at = static_cast<std::size_t>(it->position());
    const std::size_t line = text.rfind('\n', at) + 1;
    // Only what stands where a key can stand: line start, '{' or ','; not inside the quoted texts.
    const std::string before = text.substr(line, at - line);
    const bool quoted = std::count(before.begin(), before.end(), '"') % 2 == 1 || before.find('#') != std::string::npos;
    const bool starts = before.find_first_not_of(' ') == std::string::npos || before.back() == '{' ||
                        before.substr(before.size() - 2) == ", ";
    if (!quoted && starts) keys.emplace_back(at, it->str(1));
  }
  ASSERT_GT(keys.size(), 4U);
  std::mt19937 rng(20240607);
  for (int trial = 0; trial < 400; ++trial) {
    const auto& [at, key] = keys[static_cast<std::size_t>(trial) % keys.size()];
    const std::string bad = with_typo(key, rng);
    if (bad == key) continue;
    std::string changed = text;
    changed.replace(at, key.size(), bad);
    const ConfigDocument d = ConfigDocument::from_text(changed, "typo.yaml", GROUSER_SOURCE_DIR "/examples/wheels");
    load(d.root());
    EXPECT_FALSE(d.diagnostics().empty()) << "'" << key << "' as '" << bad << "' passed in " << file;
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
    bool named = false;
    for (const Diagnostic& x : d.diagnostics())
      named = named || x.line == line || x.message.find(key) != std::string::npos;
    EXPECT_TRUE(named) << "'" << bad << "' for '" << key << "' in line " << line << ": " << d.diagnostics()[0].text();
  }
}

// Damaged files end in diagnostics, never in another exception or a crash.
TEST(Typos, DamagedBytesOnlyGiveDiagnostics) {
  const std::string soil = read_all(GROUSER_SOURCE_DIR "/examples/soils/mojave_martian_simulant.yaml");
  const std::string wheel = read_all(GROUSER_SOURCE_DIR "/examples/wheels/mer_wheel.yaml");
  std::mt19937 rng(7);
  const auto pick = [&](std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(rng); };
  const std::string signs =
      "{}[]:,-&*!|>'\"%@`#?\n\t \0\x80\xff"
      "0n";
  for (int trial = 0; trial < 1000; ++trial) {
    std::string text = trial % 2 == 0 ? soil : wheel;
    for (std::size_t k = 1 + pick(4); k > 0; --k) text[pick(text.size())] = signs[pick(signs.size())];
    if (trial % 5 == 0) text.resize(pick(text.size()));
    const ConfigDocument d = ConfigDocument::from_text(text, "damaged.yaml");
    EXPECT_NO_THROW(trial % 2 == 0 ? static_cast<void>(load_soil(d.root()))
                                   : static_cast<void>(load_running_gear(d.root())))
        << text;
  }
}

TEST(Typos, AreAlwaysCaughtInSoilFiles) {
  for (const char* f : {"mojave_martian_simulant", "dry_sand_wong_loose", "krc_fine_grain", "hard_ground"})
    typos_are_caught(std::string(GROUSER_SOURCE_DIR "/examples/soils/") + f + ".yaml",
                     [](const ConfigNode& r) { load_soil(r); });
}

TEST(Typos, AreAlwaysCaughtInWheelFiles) {
  for (const char* f : {"mer_wheel", "wheel_l", "mit_wheel"})
    typos_are_caught(std::string(GROUSER_SOURCE_DIR "/examples/wheels/") + f + ".yaml",
                     [](const ConfigNode& r) { load_running_gear(r); });
}

}  // namespace
}  // namespace grouser
