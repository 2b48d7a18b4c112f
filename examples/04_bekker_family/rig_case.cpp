#include "rig_case.h"

#include <fmt/core.h>

#include <fstream>

#include "grouser/models.h"
#include "store.h"

namespace family {

namespace fs = std::filesystem;

namespace {

/// The rig file with the files of the library under `library`.
std::string yaml(const RigInput& c, const std::string& library) {
  std::string out = fmt::format("rig: {} on {}, {}, slip {}\n", c.wheel, c.soil, c.model, c.slip);
  out += fmt::format("wheel: {}/wheels/{}.yaml\n", library, c.wheel);
  out += fmt::format("terrain:\n  model: {}\n  soil: {}/soils/{}.yaml\n", c.model, library, c.soil);
  if (!c.options.empty()) out += fmt::format("  options: {{{}: {{{}}}}}\n", c.model, c.options);
  if (!c.effects.empty()) out += fmt::format("  effects: {{{}: {{{}}}}}\n", c.model, c.effects);
  if (!c.ground.empty()) out += "ground: " + c.ground + "\n";
  out += fmt::format("{}\n{}\nslips: [{}]\nslip_definition: rim\n", c.load, c.speed, c.slip);
  if (!c.slip_radius.empty()) out += "slip_radius: " + c.slip_radius + "\n";
  out += fmt::format("settle: {}\nramp: {}\ndistance: {} m\naverage_over: {}\ntime_step: {}\noutput: {{rate: {}}}\n",
                     c.settle, c.ramp, c.distance, c.average_over, c.time_step, c.rate);
  return out;
}

}  // namespace

std::string hash_of(const RigInput& c) {
  return hash_of(yaml(c, "") + content("examples/wheels/" + c.wheel + ".yaml") +
                 content("examples/soils/" + c.soil + ".yaml"));
}

RigResult run(const RigInput& c, const fs::path& work) {
  fs::remove_all(work);
  fs::create_directories(work);
  const fs::path file = work / "rig.yaml";
  std::ofstream(file) << yaml(c, fs::absolute("examples").string());
  grouser::vehicle::RigOptions o;
  o.out = work / "out";
  const auto summary = grouser::vehicle::run_rig(file, grouser::all_models(), o);
  return {summary.rows.at(0), o.out / "case_000" / "run.h5"};
}

int main_of(int argc, char** argv, void (*study)(const Arguments&)) {
  Arguments a;
  if (argc < 3 || !fs::exists("examples/soils")) {
    fmt::print(stderr, "usage, in the root of the repository: {} RESULTS WORK [--again]\n", argv[0]);
    return 2;
  }
  a.results = argv[1];
  a.work = argv[2];
  a.again = argc > 3 && std::string(argv[3]) == "--again";
  try {
    fs::create_directories(a.results);
    study(a);
    return 0;
  } catch (const std::exception& e) {
    fmt::print(stderr, "\n{}: {}\n", argv[0], e.what());
    return 1;
  }
}

}  // namespace family
