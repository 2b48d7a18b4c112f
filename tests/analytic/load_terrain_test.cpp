#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "grouser/models.h"
#include "grouser/terrain/terrain_loader.h"

namespace grouser {
namespace {

class LoadTerrain : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) / testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::create_directories(folder_);
    write("sand.yaml", R"(soil: sand
source: test
bekker:
  pressure: {law: k_b, k: 254.1 kPa, n: 1.387, reference_width: 50 mm}
  shear: {type: A, cohesion: 139.28 Pa, friction_angle: 0.606 rad, K: 0.5151 mm}
dem:
  diameter: [20 mm, 25 mm]
  density: 3.1 g/cm^3
  young_modulus: 1 MPa
  poisson_ratio: 0.35
  friction: 0.6
  rolling: {law: constant, coefficient: 0.2}
  restitution: 0.4
  wall: {friction: 0.6, restitution: 0.4}
)");
    write("rock.yaml", "soil: rock\nsource: test\nrigid: {stiffness: 100 kN/m}\n");
  }
  std::filesystem::path write(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  std::string errors_of(const std::string& text) {
    try {
      load_terrain(write("terrain.yaml", text));
    } catch (const ConfigError& e) {
      return e.what();
    }
    return "no error";
  }
  std::filesystem::path folder_;
};

TEST_F(LoadTerrain, BuildsEveryRegisteredModelWithItsDefaults) {
  for (const ModelInfo& m : all_models().models()) {
    const auto terrain = load_terrain(write("t.yaml", "terrain: " + m.id + "\nsoil: sand.yaml\n"));
    EXPECT_EQ(terrain->id(), m.id);
  }
}

TEST_F(LoadTerrain, AnnotatedDefaultsAreAcceptedAsOptions) {
  for (const ModelInfo& m : all_models().models()) {
    std::string options;
    std::istringstream lines(m.annotated_defaults);
    for (std::string line; std::getline(lines, line);) options += "  " + line + "\n";
    EXPECT_NO_THROW(load_terrain(write("t.yaml", "terrain: " + m.id + "\nsoil: sand.yaml\noptions:\n" + options)))
        << m.id;
  }
}

TEST_F(LoadTerrain, OptionsAndEffectsReachTheModel) {
  const auto t = load_terrain(write("t.yaml", R"(terrain: bekker.steady
soil: sand.yaml
options: {points: 16, reference_width: wheel}
effects: {vertical_damping: 0.5 s/m}
)"));
  ASSERT_EQ(t->effects().at(0).id, "vertical_damping");
  EXPECT_EQ(t->effects()[0].amplitude, 0.5);
}

TEST_F(LoadTerrain, UnknownModelIsNamedWithItsPlaceAndTheNearestOne) {
  const std::string e = errors_of("terrain: bekker.stedy\nsoil: sand.yaml\n");
  EXPECT_NE(e.find("terrain.yaml:1:10"), std::string::npos) << e;
  EXPECT_NE(e.find("bekker.steady"), std::string::npos) << e;
}

TEST_F(LoadTerrain, SoilWithoutTheSectionIsNamed) {
  const std::string e = errors_of("terrain: bekker.steady\nsoil: rock.yaml\n");
  EXPECT_NE(e.find("terrain.yaml:2:7"), std::string::npos) << e;
  EXPECT_NE(e.find("rock.yaml: soil 'rock' has no 'bekker:' section"), std::string::npos) << e;
}

TEST_F(LoadTerrain, AllErrorsComeAtOnce) {
  const std::string e = errors_of(R"(terrain: bekker.steady
soil: sand.yaml
options: {strips: 99, pionts: 8}
effects: {vertical_damping: 40 s/m}
colour: red
)");
  for (const char* part : {"strips", "pionts", "points", "vertical_damping", "colour"})
    EXPECT_NE(e.find(part), std::string::npos) << part << "\n" << e;
}

TEST_F(LoadTerrain, ScenarioOverrideSwapsTheModelAndItsOptionsOnly) {
  write("scenario.yaml", R"(terrain:
  model: bekker.steady
  soil: sand.yaml
  options: {bekker.steady: {strips: 1}, rigid: {friction: 0.3}}
  effects: {bekker.steady: {vertical_damping: 1 s/m}}
)");
  const ConfigDocument doc = ConfigDocument::from_file(folder_ / "scenario.yaml");
  const auto a = make_terrain(all_models(), doc.root().map("terrain"), flat_ground(), 9.81, std::nullopt, &doc);
  const auto b = make_terrain(all_models(), doc.root().map("terrain"), flat_ground(), 9.81, "rigid", &doc);
  doc.check();
  EXPECT_EQ(a->id(), "bekker.steady");
  EXPECT_EQ(b->id(), "rigid");
  EXPECT_THROW(make_terrain(all_models(), doc.root().map("terrain"), flat_ground(), 9.81, "rigit", &doc), ConfigError);
}

}  // namespace
}  // namespace grouser
