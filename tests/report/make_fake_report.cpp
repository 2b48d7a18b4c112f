#include <cstdio>

#include "fake_run.h"
#include "report.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "make_fake_report FOLDER: writes one.html, two.html and rig.html with invented results\n");
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  grouser::test::write_fake_run(folder / "soil", {});
  grouser::test::write_fake_run(folder / "rigid", {.terrain = "rigid", .sinkage = 0.0004});
  grouser::test::write_fake_rig(folder / "rig");
  grouser::write_report({folder / "soil"}, folder / "one.html");
  grouser::write_report({folder / "rigid", folder / "soil"}, folder / "two.html");
  grouser::write_report({folder / "rig"}, folder / "rig.html");
  return 0;
}
