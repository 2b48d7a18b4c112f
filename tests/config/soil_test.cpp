// The shipped soils against the printed tables, and the errors of soil files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "config_support.h"
#include "grouser/terrain/loaders.h"

namespace grouser {
namespace {

using ::testing::ElementsAre;
using testing::messages;

const std::filesystem::path folder = GROUSER_SOURCE_DIR "/examples/soils";

Soil shipped(const std::string& name) { return load_soil_file(folder / (name + ".yaml")); }

TEST(Soils, AllShippedFilesLoadWithNameAndSource) {
  int count = 0;
  for (const auto& e : std::filesystem::directory_iterator(folder)) {
    if (e.path().extension() != ".yaml") continue;
    ++count;
    SCOPED_TRACE(e.path());
    Soil s;
    ASSERT_NO_THROW(s = load_soil_file(e.path()));
    EXPECT_FALSE(s.name.empty());
    EXPECT_FALSE(s.source.empty());
    if (!s.bekker) continue;
    // Bearing soils: at 20 mm under a 100 mm wheel no soil carries less than 100 Pa or more than 10 MPa.
    const double p = s.bekker->pressure.modulus(0.1) * std::pow(0.02, s.bekker->pressure.n);
    EXPECT_GT(p, 100);
    EXPECT_LT(p, 1e7);
  }
  EXPECT_EQ(count, 35);
}

struct Row {
  const char* file;
  double c, phi, n, K, kc, kphi;
};

TEST(Soils, Table22AsPrinted) {
  for (const Row& r :
       {Row{"dry_sand", 1000, 0.52, 1.1, 0.025, 900, 1523400}, Row{"sandy_loam", 1700, 0.51, 0.7, 0.025, 5300, 1515000},
        Row{"clayey_soil", 4140, 0.23, 0.5, 0.01, 13200, 692200}}) {
    SCOPED_TRACE(r.file);
    const BekkerSoil b = *shipped(r.file).bekker;
    EXPECT_EQ(b.pressure.law, PressureSinkage::Law::kc_kphi);
    EXPECT_DOUBLE_EQ(b.shear.cohesion, r.c);
    EXPECT_DOUBLE_EQ(b.shear.friction_angle, r.phi);
    EXPECT_DOUBLE_EQ(b.pressure.n, r.n);
    EXPECT_DOUBLE_EQ(b.shear.K, r.K);
    EXPECT_DOUBLE_EQ(b.pressure.kc, r.kc);
    EXPECT_DOUBLE_EQ(b.pressure.kphi, r.kphi);
    EXPECT_EQ(b.pressure.reference_width, 0);
  }
}

TEST(Soils, Table21WithTheUnloadingSlopeOfWong) {
  const BekkerSoil b = *shipped("dry_sand_wong_loose").bekker;
  EXPECT_DOUBLE_EQ(b.pressure.kc, -660);
  EXPECT_DOUBLE_EQ(b.pressure.kphi, 754130);
  EXPECT_DOUBLE_EQ(b.pressure.n, 0.91);
  EXPECT_DOUBLE_EQ(b.shear.K, 0.005);
  EXPECT_EQ(b.shear.cohesion, 0);
  EXPECT_DOUBLE_EQ(b.shear.friction_angle, 0.478);
  ASSERT_TRUE(b.repetitive);
  EXPECT_EQ(b.repetitive->ko, 0);
  EXPECT_DOUBLE_EQ(b.repetitive->Au, 503e6);
}

TEST(Soils, Tables41And46AsPrinted) {
  const Soil s = shipped("mojave_martian_simulant");
  const BekkerSoil& b = *s.bekker;
  EXPECT_EQ(b.pressure.law, PressureSinkage::Law::k_b);
  EXPECT_DOUBLE_EQ(b.shear.cohesion, 139.280);
  EXPECT_DOUBLE_EQ(b.shear.friction_angle, 0.606);
  EXPECT_DOUBLE_EQ(b.shear.K, 5.151e-4);
  EXPECT_DOUBLE_EQ(b.pressure.k, 2.541e5);
  EXPECT_DOUBLE_EQ(b.pressure.n, 1.387);
  EXPECT_DOUBLE_EQ(b.pressure.reference_width, 0.05);
  EXPECT_DOUBLE_EQ(b.angles.a0, 0.18);
  EXPECT_DOUBLE_EQ(b.angles.a1, 0.32);
  EXPECT_EQ(b.angles.b0, 0);
  EXPECT_EQ(b.angles.b1, 0);
  EXPECT_DOUBLE_EQ(s.bulk_density, 1600);
  // k / 0.05^1.387 worked out with a desk calculator: 1.6200e7.
  EXPECT_NEAR(b.pressure.modulus(0.16), 1.6200e7, 2e3);
}

TEST(Soils, Table48AsPrinted) {
  const BekkerSoil b = *shipped("mojave_martian_simulant_dem_fit").bekker;
  EXPECT_DOUBLE_EQ(b.shear.cohesion, 96.240);
  EXPECT_DOUBLE_EQ(b.shear.friction_angle, 0.606);
  EXPECT_DOUBLE_EQ(b.shear.K, 4.534e-3);
  EXPECT_DOUBLE_EQ(b.pressure.k, 2.305e4);
  EXPECT_DOUBLE_EQ(b.pressure.n, 0.418);
  EXPECT_DOUBLE_EQ(b.angles.a0, 0.09);
  EXPECT_DOUBLE_EQ(b.angles.a1, 0.90);
}

TEST(Soils, AssumedValuesOfShippedSoilsAreListed) {
  const ConfigDocument d = ConfigDocument::from_file(folder / "dry_sand_lll.yaml");
  load_soil(d.root());
  d.check();
  std::vector<std::string> keys;
  for (const Assumption& a : d.assumptions()) keys.push_back(a.key);
  EXPECT_THAT(keys, ElementsAre("bekker.shear.K", "bekker.contact_angles.a0", "bekker.contact_angles.a1",
                                "bekker.contact_angles.b0", "bekker.contact_angles.b1"));
}

TEST(Soils, DefaultsThatAFileLeavesOpenAreListedToo) {
  const ConfigDocument d = ConfigDocument::from_text(
      "soil: s\nsource: t\nbekker:\n  pressure: {law: k_b, k: 100 kPa, n: 1}\n  shear: {type: B, cohesion: 0 kPa, "
      "friction_angle: 30 deg, Kw: 20 mm}\n",
      "s.yaml");
  const Soil s = load_soil(d.root());
  d.check();
  EXPECT_DOUBLE_EQ(s.bekker->pressure.reference_width, 0.05);
  EXPECT_EQ(s.bekker->shear.type, ShearLaw::Type::B);
  ASSERT_EQ(d.assumptions().size(), 2U);
  EXPECT_EQ(d.assumptions()[0].key, "bekker.pressure.reference_width");
  EXPECT_EQ(d.assumptions()[1].key, "bekker.contact_angles");
}

TEST(Soils, ModulusTakesTheReferenceWidthOfTheFile) {
  PressureSinkage p;
  p.kc = 1000;
  p.kphi = 50000;
  EXPECT_DOUBLE_EQ(p.modulus(0.1), 60000);  // 1000 / 0.1 + 50000
  p.reference_width = 0.05;
  EXPECT_DOUBLE_EQ(p.modulus(0.1), 70000);  // 1000 / 0.05 + 50000, whatever the wheel
  PressureSinkage q;
  q.law = PressureSinkage::Law::k_b;
  q.k = 100;
  q.n = 2;
  EXPECT_DOUBLE_EQ(q.modulus(0.1), 10000);  // 100 / 0.01
}

std::string soil_text(const std::string& pressure, const std::string& shear) {
  return "soil: s\nsource: t\nbekker:\n  pressure: {" + pressure + "}\n  shear: {" + shear +
         "}\n  contact_angles: {a0: 0.18, a1: 0.32}\n";
}

const std::string good_pressure = "law: kc_kphi, kc: 1 kN/m^(n+1), kphi: 900 kN/m^(n+2), n: 1, reference_width: wheel";
const std::string good_shear = "type: A, cohesion: 1 kPa, friction_angle: 30 deg, K: 25 mm";
const auto load = [](const ConfigNode& r) { load_soil(r); };

TEST(Soils, PhysicalNonsenseIsRefusedByName) {
  EXPECT_THAT(messages(soil_text(good_pressure, good_shear), load), ::testing::IsEmpty());
  EXPECT_THAT(
      messages(soil_text(good_pressure, "type: A, cohesion: -1 kPa, friction_angle: 90 deg, K: 0 mm"), load),
      ElementsAre(
          "f.yaml:5:30: bekker.shear.cohesion: '-1 kPa' is out of range; allowed is 0 kPa to 1e+06 kPa",
          "f.yaml:5:54: bekker.shear.friction_angle: '90 deg' is out of range; allowed is at least 0 deg and less than "
          "90 deg",
          "f.yaml:5:65: bekker.shear.K: '0 mm' is out of range; allowed is 0.001 mm to 1000 mm"));
  EXPECT_THAT(messages(soil_text("law: k_b, k: 1 kPa, n: 5", good_shear), load),
              ElementsAre("f.yaml:4:37: bekker.pressure.n: '5' is out of range; allowed is 0.05 to 4"));
  EXPECT_THAT(messages(soil_text("law: kc_kphi, kc: -60 kN/m^(n+1), kphi: 900 kN/m^(n+2), n: 1, reference_width: 50 mm",
                                 good_shear),
                       load),
              ElementsAre("f.yaml:4:3: bekker.pressure: the modulus kc/b + kphi is not positive at the reference width "
                          "b = 50 mm; check the "
                          "signs of kc and kphi or take a wider reference"));
  EXPECT_THAT(messages(soil_text("law: kc_kphi, kc: -60 kN/m^(n+1), kphi: 900 kN/m^(n+2), n: 1, reference_width: wheel",
                                 good_shear),
                       load),
              ElementsAre("f.yaml:4:3: bekker.pressure: kc is negative: the modulus kc/b + kphi is not positive for "
                          "wheels narrower than "
                          "66.6667 mm; state the plate's width as reference_width"));
}

TEST(Soils, ParametersOfTheOtherLawAreRefused) {
  EXPECT_THAT(messages(soil_text("law: k_b, k: 1 kPa, kc: 1 kN/m^2, n: 1", good_shear), load),
              ElementsAre("f.yaml:4:38: bekker.pressure.kc: belongs to 'law: kc_kphi'; with 'law: k_b' give k"));
  EXPECT_THAT(messages(soil_text(good_pressure, good_shear + ", Kr: 0.5"), load),
              ElementsAre("f.yaml:5:75: bekker.shear.Kr: belongs to shear type C, not to type A"));
}

TEST(Soils, SoilWithoutParametersIsRefused) {
  EXPECT_THAT(messages("soil: s\nsource: t\n", load),
              ElementsAre("f.yaml:1:1: the soil has no model parameters; give a section 'bekker:', 'rigid:' or 'dem:'"));
  EXPECT_THAT(messages("soil: s\nsource: t\nbekker:\n", load),
              ElementsAre("f.yaml:3:1: missing key 'pressure' in bekker; for example 'pressure: {...}'",
                          "f.yaml:3:1: missing key 'shear' in bekker; for example 'shear: {...}'"));
}

}  // namespace
}  // namespace grouser
