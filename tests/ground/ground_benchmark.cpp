// Nanoseconds per point of height() and heights() for every shipped ground: the best and the spread of several passes.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <vector>

#include "grouser/terrain/loaders.h"

namespace {

using Clock = std::chrono::steady_clock;

template <class F>
std::vector<double> passes(int points, F f) {
  std::vector<double> ns;
  for (int i = 0; i < 15; ++i) {
    const auto begin = Clock::now();
    f();
    ns.push_back(std::chrono::duration<double, std::nano>(Clock::now() - begin).count() / points);
  }
  std::sort(ns.begin(), ns.end());
  return ns;
}

}  // namespace

int main() {
  std::vector<std::filesystem::path> files;
  for (const auto& e : std::filesystem::directory_iterator(GROUSER_SOURCE_DIR "/examples/grounds"))
    if (e.path().extension() == ".yaml") files.push_back(e.path());
  std::sort(files.begin(), files.end());
  std::printf("%-26s %18s %18s\n", "ground", "height() ns", "heights() ns");
  double sum = 0;
  for (const auto& file : files) {
    const grouser::GroundPtr g = grouser::load_ground_file(file, 1);
    // Lines of 100 points, 5 mm apart, as a contact search asks for them along a drive of 8 m.
    constexpr int lines = 2000, n = 100;
    std::vector<double> z(n);
    const auto single = passes(lines * n, [&] {
      for (int l = 0; l < lines; ++l)
        for (int i = 0; i < n; ++i) sum += g->height(1 + 0.004 * l + 0.005 * i, 0.21);
    });
    const auto line = passes(lines * n, [&] {
      for (int l = 0; l < lines; ++l) {
        g->heights(1 + 0.004 * l, 0.21, 0.005, 0, n, z.data());
        sum += z[static_cast<std::size_t>(l % n)];
      }
    });
    std::printf("%-26s %7.1f (+%4.1f) %9.1f (+%4.1f)\n", file.stem().c_str(), single[0],
                single[single.size() / 2] - single[0], line[0], line[line.size() / 2] - line[0]);
  }
  std::printf("(best, and how far the median lies above it; checksum %.6f)\n", sum);
}
